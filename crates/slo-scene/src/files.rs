//! Where the bytes of meshes and textures come from, and which of them a scene may read.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use crate::cache::Cache;
use crate::known_files::{KnownFiles, Stamp};
use crate::names::closest;

/// The files that a scene may name.
#[derive(Clone, Debug)]
pub struct Files {
    origin: Origin,
    cache: Option<Arc<Cache>>,
    opened: Option<Opened>,
    known: Option<KnownFiles>,
    drafts: Drafts,
}

/// Files that are not on disk yet.
#[derive(Clone, Debug, Default)]
pub struct Drafts(Arc<BTreeMap<String, Draft>>);

/// The content of a file that is not on disk yet.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The content.
    pub bytes: Arc<[u8]>,
    /// Another number for every other content of the same length.
    pub version: u64,
}

impl FromIterator<(String, Draft)> for Drafts {
    /// Files by their paths, as the scene writes them.
    fn from_iter<I: IntoIterator<Item = (String, Draft)>>(files: I) -> Self {
        Self(Arc::new(files.into_iter().collect()))
    }
}

/// Notes which files on disk were asked for, whether they exist or not.
#[derive(Clone, Debug, Default)]
pub struct Opened(Arc<Mutex<BTreeSet<PathBuf>>>);

impl Opened {
    /// The files so far, by their full paths.
    pub fn paths(&self) -> Vec<PathBuf> {
        let paths = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        paths.iter().cloned().collect()
    }

    fn note(&self, path: &Path) {
        let mut paths = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if !paths.contains(path) {
            paths.insert(path.to_owned());
        }
    }
}

#[derive(Clone, Debug)]
enum Origin {
    Disk { folder: PathBuf, root: PathBuf, allow_outside: bool },
    BuiltIn { folder: String, table: Table },
    Memory { folder: String, files: Arc<[(String, Arc<[u8]>)]> },
}

type Table = &'static [(&'static str, &'static [u8])];

/// Why a file can't be read.
#[derive(Debug)]
#[non_exhaustive]
pub enum OpenError {
    /// The path has the wrong separators; with what to write instead.
    Spelling(String),
    /// The path leaves the input folder.
    Outside,
    /// There is no such file; perhaps one of a similar name.
    Missing(Option<String>),
    /// The system refuses.
    Unreadable(io::Error),
}

impl OpenError {
    /// What to say about the file at a path.
    pub fn about(&self, path: &str) -> String {
        match self {
            Self::Spelling(better) => {
                format!("a path is written with `/` on every system: write `{better}`")
            }
            Self::Outside => format!("`{path}` leaves the input folder"),
            Self::Missing(Some(near)) => format!("there is no `{path}`; did you mean `{near}`?"),
            Self::Missing(None) => format!("there is no `{path}`"),
            Self::Unreadable(error) => format!("can't read `{path}`: {error}"),
        }
    }
}

impl Files {
    /// Files on disk: paths start from `folder`, which holds the scene, and must stay within
    /// `root`, unless `allow_outside`.
    pub fn on_disk(folder: &Path, root: &Path, allow_outside: bool) -> Self {
        let (folder, root) = (absolute(folder), absolute(root));
        let origin = Origin::Disk { folder, root, allow_outside };
        Self { origin, cache: None, opened: None, known: None, drafts: Drafts::default() }
    }

    /// Files compiled into the program: pairs of path and content, paths with `/` and from the
    /// root of the table; those in the scene start from `folder`, which may be empty.
    pub fn built_in(folder: &str, table: Table) -> Self {
        let origin = Origin::BuiltIn { folder: folder.to_owned(), table };
        Self { origin, cache: None, opened: None, known: None, drafts: Drafts::default() }
    }

    /// Files in memory: paths with `/` and their contents; those in the scene start from `folder`, which
    /// may be empty.
    pub fn in_memory(folder: &str, files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(path, content)| (path, content.into())).collect();
        let origin = Origin::Memory { folder: folder.to_owned(), files };
        Self { origin, cache: None, opened: None, known: None, drafts: Drafts::default() }
    }

    /// The same files, with a cache of what was worked out from them.
    #[must_use]
    pub fn with_cache(self, cache: Option<Arc<Cache>>) -> Self {
        Self { cache, ..self }
    }

    /// The same files; those on disk that are asked for are noted in `opened`.
    #[must_use]
    pub fn noted_in(self, opened: Opened) -> Self {
        Self { opened: Some(opened), ..self }
    }

    /// The same files, and some that are not on disk yet: they stand in front of those that are.
    #[must_use]
    pub fn with_drafts(self, drafts: Drafts) -> Self {
        Self { drafts, ..self }
    }

    /// The same files, with what was made of them before.
    #[must_use]
    pub fn with_known(self, known: KnownFiles) -> Self {
        Self { known: Some(known), ..self }
    }

    /// What was made of files before.
    pub(crate) fn known(&self) -> Option<&KnownFiles> {
        self.known.as_ref()
    }

    /// The time and the length of the file at a path as a scene writes it; `None` if they can't be told.
    pub(crate) fn stamp(&self, path: &str) -> Option<Stamp> {
        if let Some(Draft { bytes, version }) = self.drafts.0.get(path) {
            let time = SystemTime::UNIX_EPOCH.checked_add(Duration::from_nanos(*version));
            return Some((time?, bytes.len() as u64));
        }
        match &self.origin {
            Origin::Disk { folder, .. } => {
                let data = resolve(folder, path).metadata().ok()?;
                Some((data.modified().ok()?, data.len()))
            }
            // They never change.
            Origin::BuiltIn { .. } | Origin::Memory { .. } => Some((SystemTime::UNIX_EPOCH, 0)),
        }
    }

    /// Notes a file that is not read again, because it is known.
    pub(crate) fn note(&self, path: &str) {
        if self.drafts.0.contains_key(path) {
            return;
        }
        if let (Origin::Disk { folder, .. }, Some(opened)) = (&self.origin, &self.opened) {
            opened.note(&resolve(folder, path));
        }
    }

    /// The cache of what was worked out from files.
    pub(crate) fn cache(&self) -> Option<&Cache> {
        self.cache.as_deref()
    }

    /// The length of the file on disk at a path as a scene writes it; `None` if it can't be told.
    pub(crate) fn length(&self, path: &str) -> Option<u64> {
        if self.drafts.0.contains_key(path) {
            return None;
        }
        match &self.origin {
            Origin::Disk { folder, .. } => Some(resolve(folder, path).metadata().ok()?.len()),
            Origin::BuiltIn { .. } | Origin::Memory { .. } => None,
        }
    }

    /// The content of the file at a path as a scene writes it.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn open(&self, path: &str) -> Result<Box<dyn Read>, OpenError> {
        if path.contains('\\') {
            return Err(OpenError::Spelling(path.replace('\\', "/")));
        }
        if let Some(draft) = self.drafts.0.get(path) {
            return Ok(Box::new(io::Cursor::new(draft.bytes.clone())));
        }
        match &self.origin {
            Origin::Disk { folder, root, allow_outside } => {
                let full = resolve(folder, path);
                if *allow_outside || (full.starts_with(root) && !is_absolute(path)) {
                    if let Some(opened) = &self.opened {
                        opened.note(&full);
                    }
                    open_on_disk(&full, path)
                } else {
                    Err(OpenError::Outside)
                }
            }
            Origin::BuiltIn { folder, table } => {
                let place = find(table.iter().map(|file| file.0), folder, path)?;
                Ok(Box::new(table[place].1))
            }
            Origin::Memory { folder, files } => {
                let place = find(files.iter().map(|file| file.0.as_str()), folder, path)?;
                Ok(Box::new(io::Cursor::new(files[place].1.clone())))
            }
        }
    }
}

/// Whether a path is absolute on any system.
pub(crate) fn is_absolute(path: &str) -> bool {
    path.starts_with('/') || path.as_bytes().get(1) == Some(&b':')
}

/// The file that a path of a scene leads to from a folder, without `.` and `..`.
fn resolve(folder: &Path, path: &str) -> PathBuf {
    if is_absolute(path) {
        return normal(Path::new(path));
    }
    // Part by part: Windows knows no `/` in the long form of paths.
    let full =
        path.split('/').filter(|part| !part.is_empty()).fold(folder.to_owned(), |f, p| f.join(p));
    normal(&full)
}

/// The path from the root of the file system, without links if it exists.
fn absolute(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let absolute = path.canonicalize().or_else(|_| std::path::absolute(path));
    normal(&absolute.unwrap_or_else(|_| path.to_owned()))
}

/// The path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                normal.pop();
            }
            other => normal.push(other),
        }
    }
    normal
}

fn open_on_disk(full: &Path, path: &str) -> Result<Box<dyn Read>, OpenError> {
    // Asked before opening: opening a pipe that nobody writes to would wait for ever.
    let opened = full.metadata().and_then(|data| match refusal(&data.file_type()) {
        Some(refusal) => Err(refusal),
        None => File::open(full),
    });
    match opened {
        Ok(file) => Ok(Box::new(io::BufReader::with_capacity(1 << 16, file))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            Err(OpenError::Missing(neighbour(full, path)))
        }
        Err(e) => Err(OpenError::Unreadable(e)),
    }
}

/// Why a path leads to something other than a file.
fn refusal(kind: &FileType) -> Option<io::Error> {
    if kind.is_dir() {
        return Some(io::Error::from(io::ErrorKind::IsADirectory));
    }
    (!kind.is_file()).then(|| io::Error::other("it is a pipe or a device, not a regular file"))
}

/// The path with its last part replaced by the most similar name in that folder.
fn neighbour(full: &Path, path: &str) -> Option<String> {
    let entries = full.parent()?.read_dir().ok()?.take(1000);
    let files = entries.flatten().filter(|e| e.file_type().is_ok_and(|t| !t.is_dir()));
    let mut names: Vec<String> = files.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort_unstable();
    let name = similar(full.file_name()?.to_str()?, &names)?;
    let folder = path.rfind('/').map_or("", |i| &path[..=i]);
    Some(format!("{folder}{name}"))
}

/// The name that differs only in its extension, or else the most similar one with that extension.
fn similar<'n>(name: &str, names: &'n [String]) -> Option<&'n str> {
    let split = |name: &str| {
        let name = name.to_lowercase();
        let (stem, extension) = name.rsplit_once('.').unwrap_or((&name, ""));
        (stem.to_owned(), extension.to_owned())
    };
    let (stem, extension) = split(name);
    let parts: Vec<_> = names.iter().map(|name| split(name)).collect();
    let same = parts.iter().position(|part| part.0 == stem);
    let near = || {
        let stems = parts.iter().filter(|part| part.1 == extension).map(|part| part.0.as_str());
        let near = closest(&stem, stems)?;
        parts.iter().position(|part| part.0 == near && part.1 == extension)
    };
    Some(&names[same.or_else(near)?])
}

/// Which of the paths from the root of all files a path from a folder leads to.
fn find<'n>(
    names: impl Iterator<Item = &'n str> + Clone,
    folder: &str,
    path: &str,
) -> Result<usize, OpenError> {
    if is_absolute(path) {
        return Err(OpenError::Outside);
    }
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop().ok_or(OpenError::Outside)?;
            }
            name => parts.push(name),
        }
    }
    let full = parts.join("/");
    names
        .clone()
        .position(|name| name == full)
        .ok_or_else(|| OpenError::Missing(closest(&full, names).map(str::to_owned)))
}

/// Hash over a scene's text and the files that it loads, in order.
#[derive(Clone, Debug)]
pub(crate) struct ContentHash(blake3::Hasher);

impl ContentHash {
    /// Begins with the text.
    pub(crate) fn new(text: &[u8]) -> Self {
        let mut whole = blake3::Hasher::new();
        whole.update(blake3::hash(text).as_bytes());
        Self(whole)
    }

    /// Adds a file that was read to its end.
    pub(crate) fn add(&mut self, file: &blake3::Hasher) {
        self.0.update(file.finalize().as_bytes());
    }

    pub(crate) fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}

/// Passes bytes on and hashes them.
pub(crate) struct HashingReader<R> {
    inner: R,
    hasher: blake3::Hasher,
}

impl<R: Read> HashingReader<R> {
    pub(crate) fn new(inner: R) -> Self {
        Self { inner, hasher: blake3::Hasher::new() }
    }

    /// The hash of the whole file, including what its loader left unread.
    pub(crate) fn finish(mut self) -> io::Result<blake3::Hasher> {
        io::copy(&mut self, &mut io::sink())?;
        Ok(self.hasher)
    }
}

/// Hashes all bytes of a file, on all threads of the current pool.
///
/// # Errors
/// The file can't be read.
pub(crate) fn hash_whole(mut reader: impl Read) -> io::Result<blake3::Hasher> {
    /// Bytes that are read at once: many, so that there is something for each thread.
    const PIECE: usize = 8 << 20;
    let mut hasher = blake3::Hasher::new();
    let mut piece = Vec::with_capacity(PIECE);
    loop {
        piece.clear();
        if reader.by_ref().take(PIECE as u64).read_to_end(&mut piece)? == 0 {
            return Ok(hasher);
        }
        hasher.update_rayon(&piece);
    }
}

impl<R: Read> Read for HashingReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.hasher.update(&buffer[..n]);
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: Table = &[("scenes/a.txt", b"a"), ("meshes/pawn.slo", b"pawn"), ("top", b"top")];

    /// What comes of opening a path.
    fn outcome(files: &Files, path: &str) -> String {
        match files.open(path) {
            Ok(mut reader) => {
                let mut content = String::new();
                reader.read_to_string(&mut content).unwrap();
                content
            }
            Err(OpenError::Spelling(better)) => format!("write {better}"),
            Err(OpenError::Outside) => "outside".to_owned(),
            Err(OpenError::Missing(None)) => "missing".to_owned(),
            Err(OpenError::Missing(Some(near))) => format!("missing, {near}?"),
            Err(OpenError::Unreadable(_)) => "unreadable".to_owned(),
        }
    }

    #[test]
    fn files_without_a_disk() {
        let owned = TABLE.iter().map(|(path, content)| ((*path).to_owned(), content.to_vec()));
        for files in [Files::built_in("scenes", TABLE), Files::in_memory("scenes", owned)] {
            check_files_without_a_disk(&files);
        }
    }

    fn check_files_without_a_disk(files: &Files) {
        let cases = [
            ("a.txt", "a"),
            ("./a.txt", "a"),
            ("../meshes/pawn.slo", "pawn"),
            ("..//top", "top"),
            ("../../top", "outside"),
            ("/top", "outside"),
            ("..\\top", "write ../top"),
            ("../meshes/pwan.slo", "missing, meshes/pawn.slo?"),
            ("nothing", "missing"),
        ];
        for (path, expected) in cases {
            assert_eq!(outcome(files, path), expected, "{path}");
        }
    }

    #[test]
    fn files_on_disk() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("input/scenes");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(root.path().join("outside.slo"), "outside it is").unwrap();
        std::fs::write(root.path().join("input/wood.png"), "wood").unwrap();
        std::fs::write(folder.join("rook.slo"), "rook").unwrap();
        let within = Files::on_disk(&folder, &root.path().join("input"), false);
        let cases = [
            ("rook.slo", "rook"),
            ("../wood.png", "wood"),
            ("../scenes/../wood.png", "wood"),
            ("../../input/wood.png", "wood"),
            ("../../outside.slo", "outside"),
            ("../../missing.slo", "outside"),
            ("rock.slo", "missing, rook.slo?"),
            ("../Wood.png", "missing, ../wood.png?"),
            ("nowhere/a.slo", "missing"),
            ("..", "unreadable"),
            ("..\\wood.png", "write ../wood.png"),
        ];
        for (path, expected) in cases {
            assert_eq!(outcome(&within, path), expected, "{path}");
        }
        let anywhere = Files::on_disk(&folder, &root.path().join("input"), true);
        assert_eq!(outcome(&anywhere, "../../outside.slo"), "outside it is");
    }

    #[test]
    #[cfg(unix)]
    fn pipes_and_devices_are_not_waited_for() {
        let root = tempfile::tempdir().unwrap();
        let made = std::process::Command::new("mkfifo").arg(root.path().join("a.obj")).status();
        assert!(made.unwrap().success());
        let files = Files::on_disk(root.path(), root.path(), true);
        for path in ["a.obj", "/dev/zero"] {
            match files.open(path) {
                Err(OpenError::Unreadable(e)) => assert!(e.to_string().contains("a pipe"), "{e}"),
                _ => panic!("{path} was opened"),
            }
        }
    }

    #[test]
    fn similar_names_are_those_that_may_be_meant() {
        let names = ["cube.obj", "wood.png", "kinds.slo", "Rook.SLO"].map(str::to_owned);
        let cases = [
            ("cube.slo", Some("cube.obj")),
            ("cube", Some("cube.obj")),
            ("rook.slo", Some("Rook.SLO")),
            ("kind.slo", Some("kinds.slo")),
            ("food.png", Some("wood.png")),
            ("king.png", None),
            ("a.png", None),
        ];
        for (name, expected) in cases {
            assert_eq!(similar(name, &names), expected, "{name}");
        }
    }

    #[test]
    fn folders_are_not_suggested() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("table.slo")).unwrap();
        assert_eq!(
            outcome(&Files::on_disk(root.path(), root.path(), false), "tabel.slo"),
            "missing"
        );
    }

    #[test]
    fn drafts_stand_in_front_of_the_disk() {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("a.slo"), "old").unwrap();
        let draft = |text: &str, version| Draft { bytes: text.as_bytes().into(), version };
        let opened = Opened::default();
        let files = Files::on_disk(root.path(), root.path(), false).noted_in(opened.clone());
        let drafts = [("b.slo".to_owned(), draft("new", 1)), ("a.slo".to_owned(), draft("x", 1))];
        let with = files.clone().with_drafts(drafts.into_iter().collect());
        assert_eq!((outcome(&with, "a.slo"), outcome(&with, "b.slo")), ("x".into(), "new".into()));
        with.note("b.slo");
        assert!(opened.paths().is_empty() && with.length("b.slo").is_none());
        let again = files
            .clone()
            .with_drafts([("b.slo".to_owned(), draft("nwe", 2))].into_iter().collect());
        assert_ne!(with.stamp("b.slo"), again.stamp("b.slo"));
        assert_eq!(
            (outcome(&files, "a.slo"), outcome(&files, "c")),
            ("old".into(), "missing".into())
        );
    }

    #[test]
    fn absolute_paths_are_outside_even_if_they_lead_inside() {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("a"), "a").unwrap();
        let path = root.path().join("a");
        let path = path.to_str().unwrap().replace('\\', "/");
        assert_eq!(outcome(&Files::on_disk(root.path(), root.path(), false), &path), "outside");
        assert_eq!(outcome(&Files::on_disk(root.path(), root.path(), true), &path), "a");
    }

    #[test]
    fn hash_covers_text_files_and_their_order() {
        let hash = |text: &str, files: &[&[u8]]| {
            let mut hash = ContentHash::new(text.as_bytes());
            for content in files {
                let mut reader = HashingReader::new(*content);
                let _ = reader.read(&mut [0; 2]).unwrap(); // the rest counts all the same
                hash.add(&reader.finish().unwrap());
            }
            hash.finish()
        };
        let all = [
            hash("text", &[]),
            hash("Text", &[]),
            hash("text", &[b"one"]),
            hash("text", &[b"ont"]),
            hash("text", &[b"one", b"two"]),
            hash("text", &[b"two", b"one"]),
            hash("text", &[b"onetwo"]),
            hash("textone", &[b"two"]),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| b != a), "{i}");
        }
        assert_eq!(all[2], hash("text", &[b"one"]));
    }
}
