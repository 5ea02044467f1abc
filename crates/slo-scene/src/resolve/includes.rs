//! `include`: the elements of other files.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet};
use std::io::Read;

use super::elements::LANGUAGE;
use crate::assets::{cannot_open, path_from};
use crate::attributes::INCLUDE;
use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Span};
use crate::files::{ContentHash, Files, HashingReader, OpenError};
use crate::format::parse;
use crate::format::syntax::{Entry, Form, Item, Tree, Word};
use crate::scene_text::scene_text;

/// Most files within one another.
const MOST_DEEP: usize = 16;

/// Most files that a scene includes.
const MOST_FILES: usize = 1000;

/// Longest text of an included file, in bytes: meshes have files of their own.
const LONGEST_TEXT: u64 = 1 << 28;

/// The texts of included files, which trees refer to.
#[derive(Default)]
pub(super) struct Texts(OnceCell<Box<Link>>);

struct Link {
    text: String,
    next: OnceCell<Box<Link>>,
}

impl Texts {
    fn keep(&self, text: String) -> &str {
        let mut end = &self.0;
        while let Some(link) = end.get() {
            end = &link.next;
        }
        &end.get_or_init(|| Box::new(Link { text, next: OnceCell::new() })).text
    }
}

/// The syntax trees of a scene.
pub(super) struct Trees<'a> {
    pub(super) main: Tree<'a>,
    /// Those of included files, by the places of their paths.
    included: HashMap<Span, Tree<'a>>,
    /// Folders of included files, seen from that of the scene.
    pub(super) folders: HashMap<SourceId, String>,
    /// Whether elements are lost: the end of a text, or a file that can't be included.
    pub(super) is_truncated: bool,
}

impl<'a> Trees<'a> {
    /// Parses a text and all that it includes; adds the bytes of files to `hash`.
    pub(super) fn read(
        text: &'a str,
        source: SourceId,
        texts: &'a Texts,
        files: &Files,
        hash: &mut ContentHash,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let main = parse(text, source, &*LANGUAGE, diagnostics);
        let name = diagnostics.source(source).name.clone();
        let (folder, name) = name.split_at(name.rfind(['/', '\\']).map_or(0, |i| i + 1));
        let trees = Self {
            is_truncated: main.truncated,
            main,
            included: HashMap::new(),
            folders: HashMap::new(),
        };
        let chain = vec![name.to_owned()];
        let mut reader = Reader {
            trees,
            texts,
            files,
            hash,
            diagnostics,
            folder: folder.to_owned(),
            main: text,
            chain,
            known: HashSet::new(),
        };
        let items = includes(&reader.trees.main);
        reader.include_all(&items);
        reader.trees
    }

    /// The tree of the file that an item includes; `None` if it was included before, or can't be.
    pub(super) fn of<'t>(&'t self, item: &Item<'a>) -> Option<&'t Tree<'a>> {
        match item.form {
            Form::Value(path) => self.included.get(&path.span),
            _ => None,
        }
    }
}

/// What a text includes, in order.
fn includes<'a>(tree: &Tree<'a>) -> Vec<(Word<'a>, Asked<'a>)> {
    let items = tree.entries.iter().filter_map(|entry| match entry {
        Entry::Item(item) if item.keyword.text == INCLUDE => Some(item),
        _ => None,
    });
    let asked = |item: &Item<'a>| match &item.form {
        Form::Value(path) => Asked::File(*path),
        Form::Element(_, block) | Form::Block(block) => Asked::Block(block.open),
        Form::Nothing => Asked::Nothing,
        Form::Broken => Asked::Broken,
    };
    items.map(|item| (item.keyword, asked(item))).collect()
}

/// What stands behind `include`.
enum Asked<'a> {
    File(Word<'a>),
    Block(Span),
    Nothing,
    /// Something that was reported.
    Broken,
}

struct Reader<'a, 'd> {
    trees: Trees<'a>,
    texts: &'a Texts,
    files: &'d Files,
    hash: &'d mut ContentHash,
    diagnostics: &'d mut Diagnostics,
    /// Folder of the scene, as the user gave it.
    folder: String,
    /// The text of the scene.
    main: &'a str,
    /// Paths of the files that include one another, the scene first.
    chain: Vec<String>,
    /// Paths of all files that were included.
    known: HashSet<String>,
}

impl<'a> Reader<'a, '_> {
    fn include_all(&mut self, items: &[(Word<'a>, Asked<'a>)]) {
        for (keyword, asked) in items {
            let is_read = match asked {
                Asked::File(path) => self.include(*path),
                Asked::Block(open) => {
                    let error = Diagnostic::error("`include` takes a path").at(*open, "found `{`");
                    self.report(error.help("write `include PATH`"))
                }
                Asked::Nothing => {
                    let error = Diagnostic::error("`include` has no path").at(keyword.span, "");
                    self.report(error.help("write `include PATH`"))
                }
                Asked::Broken => None,
            };
            self.trees.is_truncated |= is_read.is_none();
        }
    }

    fn report(&mut self, error: Diagnostic) -> Option<()> {
        self.diagnostics.push(error);
        None
    }

    /// Adds the tree of a file, unless there is one. `None`: it can't be included, which is reported.
    fn include(&mut self, path: Word<'a>) -> Option<()> {
        let folder = self.trees.folders.get(&path.span.source).map_or("", String::as_str);
        let full = path_from(Some(folder), path.text).into_owned();
        if self.chain.iter().skip(1).any(|file| *file == full) {
            return self.ring(path);
        }
        if self.known.contains(&full) {
            return Some(());
        }
        if self.chain.len() > MOST_DEEP || self.known.len() == MOST_FILES {
            let message = match self.known.len() {
                MOST_FILES => format!("a scene includes at most {MOST_FILES} files"),
                _ => format!("files include one another more than {MOST_DEEP} deep"),
            };
            return self.report(Diagnostic::error(message).at(path.span, "this is not read"));
        }
        let bytes = self.bytes(path, &full)?;
        let name = format!("{}{full}", self.folder);
        let at = Some(path.span);
        let (source, text) = scene_text(name, &bytes, at, self.diagnostics)?;
        // The scene has no path of its own if it comes from a pipe.
        if self.chain[0] == full && text == self.main {
            return self.ring(path);
        }
        let text = self.texts.keep(text.into_owned());
        let tree = parse(text, source, &*LANGUAGE, self.diagnostics);
        self.trees.is_truncated |= tree.truncated;
        let end = full.rfind('/').map_or(0, |i| i + 1);
        self.trees.folders.insert(source, full[..end].to_owned());
        self.known.insert(full.clone());
        let items = includes(&tree);
        self.trees.included.insert(path.span, tree);
        self.chain.push(full);
        self.include_all(&items);
        self.chain.pop();
        Some(())
    }

    fn ring(&mut self, path: Word<'_>) -> Option<()> {
        let message = format!("`{}` includes itself", path.text);
        self.report(Diagnostic::error(message).at(path.span, "this leads back to it"))
    }

    fn bytes(&mut self, path: Word<'_>, full: &str) -> Option<Vec<u8>> {
        let is_in_main = !self.trees.folders.contains_key(&path.span.source);
        let opened = self.files.open(full);
        let mut reader = match opened {
            Ok(reader) => HashingReader::new(reader),
            Err(e) => return self.report(cannot_open(path, &e, is_in_main)).map(|()| Vec::new()),
        };
        let mut bytes = Vec::new();
        let read = reader.by_ref().take(LONGEST_TEXT + 1).read_to_end(&mut bytes);
        if bytes.len() as u64 > LONGEST_TEXT {
            let message = format!("`{}` is not a scene text: it is longer than 256 MiB", path.text);
            self.report(Diagnostic::error(message).at(path.span, ""))?;
        }
        match read.and_then(|_| reader.finish()) {
            Ok(hash) => self.hash.add(&hash),
            Err(e) => {
                let error = cannot_open(path, &OpenError::Unreadable(e), is_in_main);
                self.report(error)?;
            }
        }
        Some(bytes)
    }
}
