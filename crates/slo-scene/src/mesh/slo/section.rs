//! The sections of a `.slo` file.

/// Places that are kept while a file is read.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pinned {
    /// `/*`
    Comment,
    /// The largest vertex index so far.
    LargestVertex,
    /// The largest uv index so far.
    LargestUv,
    /// The first of the sections' names, which follow in the order of [`Section::ALL`].
    Sections,
}

impl Pinned {
    /// How many there are.
    pub(super) const COUNT: usize = Self::Sections as usize + Section::ALL.len();
}

/// What a section holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Section {
    Vertices,
    Faces,
    Uvs,
    FaceUvs,
    Normals,
}

impl Section {
    /// Every section, in the order in which they are written.
    pub(super) const ALL: [Self; 5] =
        [Self::Vertices, Self::Faces, Self::Uvs, Self::FaceUvs, Self::Normals];

    /// Its word in the file.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Faces => "faces",
            Self::Uvs => "uvs",
            Self::FaceUvs => "face_uvs",
            Self::Normals => "normals",
        }
    }

    /// The section of that name.
    pub(super) fn named(word: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|section| section.name().as_bytes() == word)
    }

    /// Name of one of its items.
    pub(super) fn item(self) -> &'static str {
        match self {
            Self::Vertices => "vertex",
            Self::Faces => "face",
            Self::Uvs => "uv",
            Self::FaceUvs => "face",
            Self::Normals => "normal",
        }
    }

    /// Where its name is pinned.
    pub(super) fn pin(self) -> usize {
        Pinned::Sections as usize + self as usize
    }
}
