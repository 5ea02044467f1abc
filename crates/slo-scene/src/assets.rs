//! Meshes and textures: each file is read once, however many elements name it.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::io::Read;
use std::sync::Arc;

use crate::attributes::FARTHEST;
use crate::cache::Cache;
use crate::diagnostics::{Diagnostic, Diagnostics, Source, SourceId, Span};
use crate::files::{ContentHash, Files, HashingReader, OpenError, hash_whole, is_absolute};
use crate::format::syntax::Word;
use crate::format::{FileError, written};
use crate::known_files::{self, Note};
use crate::memory;
use crate::mesh::{self, LoadedMesh, Mesh, kept};
use crate::placements::Placements;
use crate::settings::Axes;
use crate::texture::{self, Texture};

/// Most spaces in front of the excerpt of a long line, which make its column number right.
const MOST_PADDING: usize = 100_000;

/// What a scene makes of the files of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// Whether there are normals.
    pub(crate) smooth: bool,
    /// Which way is up in the files.
    pub(crate) axes: Axes,
    /// Longest side of the whole, if it is not that of the files.
    pub(crate) size: Option<f64>,
}

impl Standing {
    /// The same for all that is equal.
    fn key(self) -> (bool, Axes, Option<u64>) {
        (self.smooth, self.axes, self.size.map(f64::to_bits))
    }
}

/// The paths of a mesh, and what the scene makes of them.
type MeshKey = (Vec<String>, (bool, Axes, Option<u64>));

/// The files of a scene.
pub(crate) struct Assets<'f> {
    files: &'f Files,
    /// Folder of the scene as the user gave it, with a `/`; for messages.
    folder: String,
    /// Folders of included files, seen from that of the scene.
    folders: HashMap<SourceId, String>,
    pub(crate) hash: ContentHash,
    textures: HashMap<String, Option<Arc<Texture>>>,
    placements: HashMap<(String, usize), Option<Arc<Placements>>>,
    meshes: HashMap<MeshKey, Option<Arc<Mesh>>>,
    /// Paths of files that can't be loaded, which were reported.
    failed: HashSet<String>,
    /// What reading the files of a mesh or an image brings, if somebody remembers it.
    notes: Vec<Note>,
    /// Paths of meshes without uvs that have not been reported yet.
    without_uvs: HashSet<String>,
}

impl<'f> Assets<'f> {
    /// No file is read yet.
    pub(crate) fn new(
        files: &'f Files,
        text_name: &str,
        folders: HashMap<SourceId, String>,
        hash: ContentHash,
    ) -> Self {
        let end = text_name.rfind(['/', '\\']).map_or(0, |i| i + 1);
        let folder = text_name[..end].to_owned();
        Self {
            files,
            folder,
            folders,
            hash,
            textures: HashMap::new(),
            meshes: HashMap::new(),
            placements: HashMap::new(),
            failed: HashSet::new(),
            notes: Vec::new(),
            without_uvs: HashSet::new(),
        }
    }

    /// The image at a path; `None` if it can't be loaded, which is reported once.
    pub(crate) fn texture(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Texture>> {
        let full = self.full(path);
        if let Some(known) = self.textures.get(&full) {
            return known.clone();
        }
        let files = self.files.known();
        let known = files.and_then(|files| files.texture(&full));
        if let Some(known) = known.filter(|known| self.are_as_noted(&known.notes)) {
            self.recall("texture", &[path], &known.notes, diagnostics);
            self.textures.insert(full, Some(known.thing.clone()));
            return Some(known.thing);
        }
        self.begin_note(path);
        let loaded = self.read(path, diagnostics, |reader| texture::load(path.text, reader));
        let loaded = loaded.map(|loaded| {
            self.warn("texture", path, &loaded.warnings, diagnostics);
            Arc::new(loaded.texture)
        });
        let note = self.notes.pop();
        if let (Some(files), Some(texture), Some(note)) = (files, &loaded, note) {
            files.keep_texture(full.clone(), texture.clone(), note);
        }
        self.textures.insert(full, loaded.clone());
        loaded
    }

    /// What is noted from now on is about this file.
    fn begin_note(&mut self, path: Word<'_>) {
        if self.files.known().is_some() {
            let full = self.full(path);
            let stamp = self.files.stamp(&full);
            self.notes.push(Note::new(full, stamp));
        }
    }

    /// Whether files are as they were when these notes were made.
    fn are_as_noted(&self, notes: &[Note]) -> bool {
        let is_same =
            |note: &Note| note.stamp.is_some() && note.stamp == self.files.stamp(&note.path);
        notes.iter().all(is_same)
    }

    /// Does what reading files would do, but for their content.
    fn recall(
        &mut self,
        kind: &str,
        paths: &[Word<'_>],
        notes: &[Note],
        diagnostics: &mut Diagnostics,
    ) {
        for (path, note) in paths.iter().zip(notes) {
            self.files.note(&note.path);
            if let Some(hash) = &note.hash {
                self.hash.add(hash);
            }
            self.warn(kind, *path, &note.warnings, diagnostics);
            if note.lacks_uvs {
                self.without_uvs.insert(note.path.clone());
            }
        }
    }

    /// Passes warnings about a file on.
    fn warn(
        &mut self,
        kind: &str,
        path: Word<'_>,
        warnings: &[String],
        diagnostics: &mut Diagnostics,
    ) {
        for warning in warnings {
            let message = format!("{kind} `{}`: {warning}", path.text);
            diagnostics.push(Diagnostic::warning(message).at(path.span, ""));
        }
        if let Some(note) = self.notes.last_mut() {
            note.warnings.extend_from_slice(warnings);
        }
    }

    /// Adds a file that was read to the hash of all.
    fn add_hash(&mut self, hash: &blake3::Hasher) {
        self.hash.add(hash);
        if let Some(note) = self.notes.last_mut() {
            note.hash = Some(hash.clone());
        }
    }

    /// The mesh that one or more files make together; `None` if one of them can't be loaded.
    pub(crate) fn mesh(
        &mut self,
        paths: &[Word<'_>],
        standing: Standing,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Mesh>> {
        let key = (paths.iter().map(|p| self.full(*p)).collect(), standing.key());
        if let Some(known) = self.meshes.get(&key) {
            return known.clone();
        }
        let files = self.files.known();
        let known_key: known_files::MeshKey = (key.0.clone(), key.1, scale.to_bits());
        let known = files.and_then(|files| files.mesh(&known_key));
        if let Some(known) = known.filter(|known| self.are_as_noted(&known.notes)) {
            self.recall("mesh", paths, &known.notes, diagnostics);
            self.meshes.insert(key, Some(known.thing.clone()));
            return Some(known.thing);
        }
        let part = |path: &Word<'_>| {
            self.begin_note(*path);
            self.mesh_file(*path, standing, scale, diagnostics)
        };
        let parts: Vec<_> = paths.iter().map(part).collect();
        let notes = std::mem::take(&mut self.notes);
        let whole = self.sum(paths, parts, diagnostics);
        let whole = whole.and_then(|mut mesh| {
            mesh.stand_up(standing.axes);
            if let Some(size) = standing.size {
                mesh.fit(size);
                check_reach(&mesh, *paths.first()?, diagnostics)?;
            }
            Some(Arc::new(mesh))
        });
        if let (Some(files), Some(mesh)) = (files, &whole) {
            files.keep_mesh(known_key, mesh.clone(), notes);
        }
        self.meshes.insert(key, whole.clone());
        whole
    }

    /// The first shape of a mesh, at a path that stands in the text at a place; `None` if it can't be
    /// loaded, which is reported once.
    pub(crate) fn first_shape(
        &mut self,
        (path, span): (&str, Span),
        standing: Standing,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<Mesh>> {
        let path = Word { text: path, span };
        let needs = ("mesh", mesh::BYTES_OF_BYTE, "give it fewer triangles");
        self.check_memory(path, needs, diagnostics)?;
        let mut mesh = self.loaded_mesh(path, diagnostics, |path, reader| {
            mesh::load_shape(path, reader, standing.smooth, scale)
        })?;
        check_reach(&mesh, path, diagnostics)?;
        mesh.stand_up(standing.axes);
        Some(Arc::new(mesh))
    }

    /// A path that stands in the text at a place, seen from the folder of the scene.
    pub(crate) fn full_path(&self, (path, span): (&str, Span)) -> String {
        self.full(Word { text: path, span })
    }

    /// Whether a file is there, at a path that stands in the text at a place. If not, this is
    /// reported once. Its content is not read.
    pub(crate) fn is_there(
        &mut self,
        (path, span): (&str, Span),
        diagnostics: &mut Diagnostics,
    ) -> bool {
        let word = Word { text: path, span };
        let full = self.full(word);
        if self.failed.contains(&full) {
            return false;
        }
        let opened = self.files.open(&full);
        let Err(error) = opened else { return true };
        let is_in_main = !self.folders.contains_key(&span.source);
        diagnostics.push(cannot_open(word, &error, is_in_main));
        self.failed.insert(full);
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
        let key = (self.full(path), kinds);
        if let Some(known) = self.placements.get(&key) {
            return known.clone();
        }
        let load = |reader: &mut dyn Read| mesh::load_placements(path.text, reader, scale, kinds);
        let needs = ("placements", mesh::BYTES_OF_PLACED_BYTE, "give fewer");
        let has_room = self.check_memory(path, needs, diagnostics);
        let loaded = has_room.and_then(|()| self.read(path, diagnostics, load).map(Arc::new));
        self.placements.insert(key, loaded.clone());
        loaded
    }

    /// The path of a file, seen from the folder of the scene.
    fn full(&self, path: Word<'_>) -> String {
        let folder = self.folders.get(&path.span.source);
        path_from(folder.map(String::as_str), path.text).into_owned()
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
        Standing { smooth, size, .. }: Standing,
        scale: f64,
        diagnostics: &mut Diagnostics,
    ) -> Option<Mesh> {
        let needs = ("mesh", mesh::BYTES_OF_BYTE, "give it fewer triangles");
        self.check_memory(path, needs, diagnostics)?;
        let load = |path: &str, reader: &mut dyn Read| mesh::load(path, reader, smooth, scale);
        let mesh = match self.cached(path) {
            None => self.loaded_mesh(path, diagnostics, load)?,
            Some((cache, file)) => {
                let hash = file.finalize();
                let key = kept::key(&hash, &mesh::extension(path.text), smooth, scale);
                let loaded = match kept::get(cache, &key, smooth) {
                    Some(loaded) => {
                        self.add_hash(&file);
                        loaded
                    }
                    None => {
                        let load = |reader: &mut dyn Read| load(path.text, reader);
                        let (loaded, read) = self.read_hashed(path, diagnostics, load)?;
                        // The file may have changed meanwhile.
                        if read == Some(hash) {
                            kept::put(cache, &key, &loaded);
                        }
                        loaded
                    }
                };
                self.known(path, loaded, diagnostics)
            }
        };
        if size.is_none() {
            check_reach(&mesh, path, diagnostics)?;
        }
        Some(mesh)
    }

    /// Refuses a file that is so large that there is not enough memory for what is in it, by the bytes
    /// that each of its bytes takes.
    fn check_memory(
        &self,
        path: Word<'_>,
        (what, bytes, help): (&str, u64, &str),
        diagnostics: &mut Diagnostics,
    ) -> Option<()> {
        let length = self.files.length(&self.full(path)).unwrap_or(0);
        let needs = length.saturating_mul(bytes);
        let refusal = memory::check(needs).err();
        let Some(refusal) = refusal else { return Some(()) };
        let needs = if what == "mesh" { "needs" } else { "need" };
        let message = format!("{what} `{}` {needs} {refusal}", path.text);
        let error = Diagnostic::error(message).at(path.span, "");
        diagnostics.push(error.help(help));
        None
    }

    /// Returns the cache, and the hash of a file that is large enough for it. If the file can't be read,
    /// reading it again says why.
    fn cached(&self, path: Word<'_>) -> Option<(&'f Cache, blake3::Hasher)> {
        let (files, full) = (self.files, self.full(path));
        let cache = files.cache()?;
        if self.failed.contains(&full) || files.length(&full)? < kept::LEAST_BYTES {
            return None;
        }
        let mut reader = files.open(&full).ok()?;
        Some((cache, hash_whole(&mut reader).ok()?))
    }

    fn loaded_mesh(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&str, &mut dyn Read) -> Result<LoadedMesh, FileError>,
    ) -> Option<Mesh> {
        let loaded = self.read(path, diagnostics, |reader| load(path.text, reader))?;
        Some(self.known(path, loaded, diagnostics))
    }

    /// Takes note of a mesh that was loaded, and passes its warnings on.
    fn known(&mut self, path: Word<'_>, loaded: LoadedMesh, diagnostics: &mut Diagnostics) -> Mesh {
        self.warn("mesh", path, &loaded.warnings, diagnostics);
        if loaded.mesh.uvs.is_empty() {
            self.without_uvs.insert(self.full(path));
            if let Some(note) = self.notes.last_mut() {
                note.lacks_uvs = true;
            }
        }
        loaded.mesh
    }

    /// Warns once for each mesh that has a texture but no uvs.
    pub(crate) fn warn_without_uvs(&mut self, paths: &[Word<'_>], diagnostics: &mut Diagnostics) {
        for path in paths {
            if self.without_uvs.remove(&self.full(*path)) {
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
        self.read_hashed(path, diagnostics, load).map(|(loaded, _)| loaded)
    }

    /// The same; also returns the hash of the file, if it could be read to its end.
    fn read_hashed<T>(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&mut dyn Read) -> Result<T, FileError>,
    ) -> Option<(T, Option<blake3::Hash>)> {
        let full = self.full(path);
        if self.failed.contains(&full) {
            return None;
        }
        let loaded = self.try_read(path, diagnostics, load);
        if loaded.is_none() {
            self.failed.insert(full);
        }
        loaded
    }

    fn try_read<T>(
        &mut self,
        path: Word<'_>,
        diagnostics: &mut Diagnostics,
        load: impl FnOnce(&mut dyn Read) -> Result<T, FileError>,
    ) -> Option<(T, Option<blake3::Hash>)> {
        let is_in_main = !self.folders.contains_key(&path.span.source);
        let reader = self.files.open(&self.full(path));
        let reader =
            reader.map_err(|e| diagnostics.push(cannot_open(path, &e, is_in_main))).ok()?;
        let mut reader = HashingReader::new(reader);
        let loaded = load(&mut reader);
        let loaded = loaded.map_err(|e| self.report_content(path, e, diagnostics)).ok()?;
        match reader.finish() {
            Ok(hash) => {
                self.add_hash(&hash);
                Some((loaded, Some(hash.finalize())))
            }
            Err(e) => {
                diagnostics.push(cannot_open(path, &OpenError::Unreadable(e), is_in_main));
                Some((loaded, None))
            }
        }
    }

    /// Reports what is wrong inside a file, with the line of the file if there is one.
    fn report_content(&self, path: Word<'_>, e: FileError, diagnostics: &mut Diagnostics) {
        let mut diagnostic = if e.line > 0 {
            let span = self.excerpt(&self.full(path), &e, diagnostics);
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
            included_at: None,
        });
        let start = cut + e.span_start;
        Span { source, start, end: start + e.span_len }
    }
}

/// Reports a mesh that is too large for the arithmetic of the renderer.
fn check_reach(mesh: &Mesh, path: Word<'_>, diagnostics: &mut Diagnostics) -> Option<()> {
    let farthest = mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    if farthest <= FARTHEST {
        return Some(());
    }
    let message = format!("mesh `{}` has vertices farther out than {FARTHEST:e}", path.text);
    let label = "too large for the arithmetic of the renderer";
    diagnostics.push(Diagnostic::error(message).at(path.span, label));
    None
}

/// The path that a path leads to from the folder of an included file, without `.` and, where it can be,
/// `..`; `None`: the folder of the scene.
pub(crate) fn path_from<'p>(folder: Option<&str>, path: &'p str) -> Cow<'p, str> {
    let Some(folder) = folder.filter(|_| !is_absolute(path)) else { return path.into() };
    let root = if folder.starts_with('/') { "/" } else { "" };
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(path.split('/')) {
        match (part, parts.last()) {
            ("" | ".", _) => {}
            ("..", Some(last)) if *last != ".." => drop(parts.pop()),
            _ => parts.push(part),
        }
    }
    format!("{root}{}", parts.join("/")).into()
}

/// The error about a path that can't be opened; `is_in_main`: the scene names it, not a file that it
/// includes.
pub(crate) fn cannot_open(path: Word<'_>, e: &OpenError, is_in_main: bool) -> Diagnostic {
    let name = path.text;
    match e {
        OpenError::Spelling(_) => Diagnostic::error("a path is written with `/` on every system")
            .at(path.span, "")
            .help(format!("write `{}`", name.replace('\\', "/"))),
        OpenError::Outside => Diagnostic::error(format!("`{name}` leaves the input folder"))
            .at(path.span, "")
            .help("give `--indir` a folder that holds this file too, or give `--allow-outside`"),
        OpenError::Missing(near) => {
            let near = near.as_deref().map(|near| match is_in_main {
                true => near.to_owned(),
                false => {
                    let folder = name.rfind('/').map_or("", |i| &name[..=i]);
                    format!("{folder}{}", near.rsplit('/').next().unwrap_or(near))
                }
            });
            let diagnostic = Diagnostic::error(match near {
                Some(near) => {
                    format!("file `{name}` not found, did you mean `{}`?", written(&near))
                }
                None => format!("file `{name}` not found"),
            });
            let label = match is_in_main {
                true => "paths start from the folder of the scene",
                false => "paths start from the folder of the file that they stand in",
            };
            diagnostic.at(path.span, label).missing_input()
        }
        OpenError::Unreadable(e) => Diagnostic::error(format!("file `{name}` can't be read: {e}"))
            .at(path.span, "")
            .missing_input(),
    }
}
