//! Meshes and textures: each file is read once, however many elements name it.

use std::collections::{HashMap, HashSet};
use std::io::Read;
use std::sync::Arc;

use crate::attributes::FARTHEST;
use crate::diagnostics::{Diagnostic, Diagnostics, Source, Span};
use crate::files::{ContentHash, Files, HashingReader, OpenError};
use crate::format::syntax::Word;
use crate::format::{FileError, written};
use crate::mesh::{self, LoadedMesh, Mesh};
use crate::placements::Placements;
use crate::texture::{self, Texture};

/// Most spaces in front of the excerpt of a long line, which make its column number right.
const MOST_PADDING: usize = 100_000;

/// The files of a scene.
pub(crate) struct Assets<'f> {
    files: &'f Files,
    /// Folder of the scene as the user gave it, with a `/`; for messages.
    folder: String,
    pub(crate) hash: ContentHash,
    textures: HashMap<String, Option<Arc<Texture>>>,
    meshes: HashMap<(Vec<String>, bool), Option<Arc<Mesh>>>,
    placements: HashMap<(String, usize), Option<Arc<Placements>>>,
    /// Paths of files that can't be loaded, which were reported.
    failed: HashSet<String>,
    /// Paths of meshes without uvs that have not been reported yet.
    without_uvs: HashSet<String>,
}

impl<'f> Assets<'f> {
    /// No file is read yet.
    pub(crate) fn new(files: &'f Files, text_name: &str, hash: ContentHash) -> Self {
        let end = text_name.rfind(['/', '\\']).map_or(0, |i| i + 1);
        let folder = text_name[..end].to_owned();
        Self {
            files,
            folder,
            hash,
            textures: HashMap::new(),
            meshes: HashMap::new(),
            placements: HashMap::new(),
            failed: HashSet::new(),
            without_uvs: HashSet::new(),
        }
    }

    /// The image at a path; `None` if it can't be loaded, which is reported once.
    pub(crate) fn texture(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Texture>> {
        if let Some(known) = self.textures.get(path.text) {
            return known.clone();
        }
        let loaded = self.read(path, diagnostics, |reader| texture::load(path.text, reader));
        let loaded = loaded.map(|loaded| {
            for warning in loaded.warnings {
                let message = format!("texture `{}`: {warning}", path.text);
                diagnostics.push(Diagnostic::warning(message).at(path.span, ""));
            }
            Arc::new(loaded.texture)
        });
        self.textures.insert(path.text.to_owned(), loaded.clone());
        loaded
    }

    /// The mesh that one or more files make together; `None` if one of them can't be loaded.
    pub(crate) fn mesh(
        &mut self,
        paths: &[Word<'_>],
        smooth: bool,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Mesh>> {
        let key = (paths.iter().map(|p| p.text.to_owned()).collect(), smooth);
        if let Some(known) = self.meshes.get(&key) {
            return known.clone();
        }
        let parts: Vec<_> =
            paths.iter().map(|path| self.mesh_file(*path, smooth, scale, diagnostics)).collect();
        let whole = self.sum(paths, parts, diagnostics).map(Arc::new);
        self.meshes.insert(key, whole.clone());
        whole
    }

    /// The first shape of a mesh, at a path that stands in the text at a place; `None` if it can't be
    /// loaded, which is reported once.
    pub(crate) fn first_shape(
        &mut self,
        (path, span): (&str, Span),
        smooth: bool,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Mesh>> {
        let path = Word { text: path, span };
        self.loaded_mesh(path, diagnostics, |path, reader| {
            mesh::load_shape(path, reader, smooth, scale)
        })
        .map(Arc::new)
    }

    /// Whether a file is there, at a path that stands in the text at a place. If not, this is
    /// reported once. Its content is not read.
    pub(crate) fn is_there(
        &mut self,
        (path, span): (&str, Span),
        diagnostics: &mut Diagnostics,
    ) -> bool {
        if self.failed.contains(path) {
            return false;
        }
        let opened = self.files.open(path);
        let Err(error) = opened else { return true };
        diagnostics.push(cannot_open(Word { text: path, span }, &error));
        self.failed.insert(path.to_owned());
        false
    }

    /// Where files are.
    pub(crate) fn files(&self) -> &'f Files {
        self.files
    }

    /// The placements at a path, of so many `kinds` of originals; `None` if they can't be loaded.
    pub(crate) fn placements(
        &mut self,
        path: Word<'_>,
        scale: f64,
        kinds: usize,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Placements>> {
        let key = (path.text.to_owned(), kinds);
        if let Some(known) = self.placements.get(&key) {
            return known.clone();
        }
        let load = |reader: &mut dyn Read| mesh::load_placements(path.text, reader, scale, kinds);
        let loaded = self.read(path, diagnostics, load).map(Arc::new);
        self.placements.insert(key, loaded.clone());
        loaded
    }

    /// Leaves the meshes to the objects that show them.
    pub(crate) fn release_meshes(&mut self) {
        self.meshes.clear();
    }

    fn sum(
        &self,
        paths: &[Word<'_>],
        parts: Vec<Option<Mesh>>,
        diagnostics: &mut Diagnostics,
    ) -> Option<Mesh> {
        let parts: Vec<Mesh> = parts.into_iter().collect::<Option<_>>()?;
        let mut parts = parts.into_iter().zip(paths);
        let (mut whole, _) = parts.next()?;
        for (part, path) in parts {
            if let Err(e) = whole.append(part) {
                self.report_content(*path, e, diagnostics);
                return None;
            }
        }
        Some(whole)
    }

    fn mesh_file(
        &mut self,
        path: Word<'_>,
        smooth: bool,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Mesh> {
        self.loaded_mesh(path, diagnostics, |path, reader| mesh::load(path, reader, smooth, scale))
    }

    fn loaded_mesh(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&str, &mut dyn Read) -> Result<LoadedMesh, FileError>,
    ) -> Option<Mesh> {
        let loaded = self.read(path, diagnostics, |reader| load(path.text, reader))?;
        for warning in loaded.warnings {
            let message = format!("mesh `{}`: {warning}", path.text);
            diagnostics.push(Diagnostic::warning(message).at(path.span, ""));
        }
        if loaded.mesh.uvs.is_empty() {
            self.without_uvs.insert(path.text.to_owned());
        }
        let farthest =
            loaded.mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        if farthest > FARTHEST {
            let message =
                format!("mesh `{}` has vertices farther out than {FARTHEST:e}", path.text);
            let label = "too large for the arithmetic of the renderer";
            diagnostics.push(Diagnostic::error(message).at(path.span, label));
            return None;
        }
        Some(loaded.mesh)
    }

    /// Warns once for each mesh that has a texture but no uvs.
    pub(crate) fn warn_without_uvs(&mut self, paths: &[Word<'_>], diagnostics: &mut Diagnostics) {
        for path in paths {
            if self.without_uvs.remove(path.text) {
                let message = format!("mesh `{}` has no uvs (texture coordinates)", path.text);
                let label = "its texture shows a single colour, the one at uv 0 0";
                diagnostics.push(Diagnostic::warning(message).at(path.span, label));
            }
        }
    }

    /// Opens a file, loads it and adds its bytes to the hash.
    fn read<T>(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&mut dyn Read) -> Result<T, FileError>,
    ) -> Option<T> {
        if self.failed.contains(path.text) {
            return None;
        }
        let loaded = self.try_read(path, diagnostics, load);
        if loaded.is_none() {
            self.failed.insert(path.text.to_owned());
        }
        loaded
    }

    fn try_read<T>(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&mut dyn Read) -> Result<T, FileError>,
    ) -> Option<T> {
        let reader = self.files.open(path.text);
        let reader = reader.map_err(|e| diagnostics.push(cannot_open(path, &e))).ok()?;
        let mut reader = HashingReader::new(reader);
        let loaded = load(&mut reader);
        let loaded = loaded.map_err(|e| self.report_content(path, e, diagnostics)).ok()?;
        match reader.finish() {
            Ok(hash) => self.hash.add(&hash),
            Err(e) => diagnostics.push(cannot_open(path, &OpenError::Unreadable(e))),
        }
        Some(loaded)
    }

    /// Reports what is wrong inside a file, with the line of the file if there is one.
    fn report_content(&self, path: Word<'_>, e: FileError, diagnostics: &mut Diagnostics) {
        let mut diagnostic = if e.line > 0 {
            let span = self.excerpt(path.text, &e, diagnostics);
            Diagnostic::error(e.message).at(span, e.label).also(path.span, "loaded here")
        } else {
            Diagnostic::error(e.message).at(path.span, e.label)
        };
        diagnostic.help = e.help.map(String::from);
        diagnostics.push(diagnostic);
    }

    /// Adds the excerpt of a file as a source; returns the place of the fault in it.
    fn excerpt(&self, path: &str, e: &FileError, diagnostics: &mut Diagnostics) -> Span {
        let before = e.line_text.get(..e.span_start).map_or(0, |t| t.chars().count());
        let cut = e.column.saturating_sub(1 + before).min(MOST_PADDING);
        let source = diagnostics.add_source(Source {
            name: format!("{}{path}", self.folder),
            text: " ".repeat(cut) + &e.line_text,
            first_line: e.line,
        });
        let start = cut + e.span_start;
        Span { source, start, end: start + e.span_len }
    }
}

fn cannot_open(path: Word<'_>, e: &OpenError) -> Diagnostic {
    let name = path.text;
    match e {
        OpenError::Spelling(better) => {
            Diagnostic::error("a path is written with `/` on every system")
                .at(path.span, "")
                .help(format!("write `{better}`"))
        }
        OpenError::Outside => Diagnostic::error(format!("`{name}` leaves the input folder"))
            .at(path.span, "")
            .help("give `--indir` a folder that holds this file too, or give `--allow-outside`"),
        OpenError::Missing(near) => {
            let diagnostic = Diagnostic::error(match near {
                Some(near) => format!("file `{name}` not found, did you mean `{}`?", written(near)),
                None => format!("file `{name}` not found"),
            });
            diagnostic.at(path.span, "paths start from the folder of the scene").missing_input()
        }
        OpenError::Unreadable(e) => Diagnostic::error(format!("file `{name}` can't be read: {e}"))
            .at(path.span, "")
            .missing_input(),
    }
}
