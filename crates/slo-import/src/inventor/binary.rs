//! The binary flavour: big-endian, in units of four bytes. Values have no types there, so nodes of unknown
//! classes can't be skipped.

use std::collections::HashMap;
use std::rc::Rc;

use super::DEEPEST;
use super::classes::{Class, Kind};
use super::tree::{Node, Value};
use crate::error::ImportError;
use crate::files::Source;
use crate::model::Notes;
use crate::words::shortened;

/// Flag of a node that has children.
const HAS_CHILDREN: u32 = 2;

/// Flag of a field count that says that the class is described first.
const IS_DESCRIBED: u32 = 1 << 14;

/// Flags of fields: that the value does not count, and that a connection follows.
const IS_IGNORED: u32 = 1;
const IS_CONNECTED: u32 = 2;

/// Reads the nodes of a file.
pub(super) fn read(source: &Source, notes: &mut Notes) -> Result<Vec<Rc<Node>>, ImportError> {
    let end = source.bytes.iter().position(|&byte| byte == b'\n').unwrap_or(source.bytes.len());
    let header = &source.bytes[..end];
    let has_flags = header.starts_with(b"#Inventor V2.1");
    if !has_flags && !header.starts_with(b"#Inventor V2.0") {
        return Err(source.bad("binary files of its version are not read; `ivcat` makes it a text"));
    }
    let at = (end + 1).next_multiple_of(4);
    let mut reader = Reader { source, at, has_flags, names: HashMap::new(), notes, depth: 0 };
    let mut nodes = Vec::new();
    while reader.at < source.bytes.len() {
        nodes.extend(reader.node()?);
    }
    Ok(nodes)
}

struct Reader<'a> {
    source: &'a Source,
    at: usize,
    /// Whether nodes have flags, as they have since version 2.1.
    has_flags: bool,
    names: HashMap<String, Rc<Node>>,
    notes: &'a mut Notes,
    depth: usize,
}

impl Reader<'_> {
    fn bad<T>(&self, message: impl std::fmt::Display) -> Result<T, ImportError> {
        Err(self.source.bad(format!("at byte {}: {message}", self.at)))
    }

    fn bytes(&mut self, count: usize) -> Result<&[u8], ImportError> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.source.bytes.len());
        let Some(end) = end else { return self.bad("the file ends too early") };
        let bytes = &self.source.bytes[self.at..end];
        self.at = end.next_multiple_of(4);
        Ok(bytes)
    }

    fn word(&mut self) -> Result<u32, ImportError> {
        let bytes = self.bytes(4)?;
        Ok(bytes.iter().fold(0, |sum, &byte| sum << 8 | u32::from(byte)))
    }

    fn float(&mut self) -> Result<f64, ImportError> {
        let float = f32::from_bits(self.word()?);
        if float.is_finite() { Ok(f64::from(float)) } else { self.bad("a number is not finite") }
    }

    fn text(&mut self) -> Result<String, ImportError> {
        let length = self.word()? as usize;
        Ok(String::from_utf8_lossy(self.bytes(length)?).into_owned())
    }

    /// The next node; `None` for none, or if nothing has the name that it uses.
    fn node(&mut self) -> Result<Option<Rc<Node>>, ImportError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.bad(format!("nodes are nested more than {DEEPEST} deep"));
        }
        let word = self.text()?;
        let node = match word.as_str() {
            "NULL" => None,
            "USE" => {
                let name = self.text()?;
                let node = self.names.get(&name).cloned();
                if node.is_none() {
                    let name = shortened(&name);
                    self.notes.leave_out(format!("what is called `{name}`, which no node is"));
                }
                node
            }
            "DEF" => {
                let (name, class) = (self.text()?, self.text()?);
                let node = Rc::new(Node { name: Some(name.clone()), ..self.body(class)? });
                self.names.insert(name, Rc::clone(&node));
                Some(node)
            }
            _ => Some(Rc::new(self.body(word)?)),
        };
        self.depth -= 1;
        Ok(node)
    }

    fn body(&mut self, name: String) -> Result<Node, ImportError> {
        let Some(class) = Class::of(&name) else {
            let name = shortened(&name);
            return self.bad(format!("the class `{name}` is not known; `ivcat` makes it a text"));
        };
        let flags = if self.has_flags { self.word()? } else { 0 };
        let has_count = self.has_flags || class.has_fields();
        let count = if has_count { self.word()? } else { 0 };
        if count & IS_DESCRIBED != 0 {
            return self.bad(format!("`{name}` describes its fields; `ivcat` makes it a text"));
        }
        let mut node = Node { class: name, ..Node::default() };
        for _ in 0..count {
            let field = self.text()?;
            let Some((kind, is_many)) = class.field(&field) else {
                let field = shortened(&field);
                return self.bad(format!("`{}` has no field `{field}`", node.class));
            };
            let value = self.value(kind, is_many)?;
            let flags = self.word()?;
            if flags & IS_CONNECTED != 0 {
                self.node()?;
                self.text()?;
            }
            node.fields
                .extend(value.filter(|_| flags & IS_IGNORED == 0).map(|value| (field, value)));
        }
        if class.is_group() || flags & HAS_CHILDREN != 0 {
            for _ in 0..self.word()? {
                node.children.extend(self.node()?);
            }
        }
        Ok(node)
    }

    fn value(&mut self, kind: Kind, is_many: bool) -> Result<Option<Value>, ImportError> {
        let count = if is_many { self.word()? as usize } else { 1 };
        Ok(Some(match kind {
            Kind::Node => return Ok(self.node()?.map(Value::Node)),
            Kind::Floats(width) => self.numbers(count.saturating_mul(width), Self::float)?,
            Kind::Integer => {
                self.numbers(count, |reader| Ok(f64::from(reader.word()?.cast_signed())))?
            }
            Kind::Text => {
                let mut words = Vec::new();
                for _ in 0..count {
                    words.push(self.text()?);
                }
                Value::Words(words)
            }
            Kind::Mask => {
                let mut words = Vec::new();
                loop {
                    let word = self.text()?;
                    if word.is_empty() {
                        break Value::Words(words);
                    }
                    words.push(word);
                }
            }
            Kind::Image => self.image()?,
        }))
    }

    fn numbers(
        &mut self,
        count: usize,
        number: impl Fn(&mut Self) -> Result<f64, ImportError>,
    ) -> Result<Value, ImportError> {
        // A damaged count must not take memory.
        let mut numbers = Vec::with_capacity(count.min(self.source.bytes.len() / 4));
        for _ in 0..count {
            numbers.push(number(self)?);
        }
        Ok(Value::Numbers(numbers))
    }

    /// An image as the text flavour says it: its size, its components, and a number for each pixel.
    fn image(&mut self) -> Result<Value, ImportError> {
        let [width, height, components] = [self.word()?, self.word()?, self.word()?];
        // Version 2.0 writes a whole number for each pixel, as the text flavour does.
        let size = if self.has_flags { components as usize } else { 4 };
        let count = (width as usize).checked_mul(height as usize);
        let Some(count) = count.and_then(|count| count.checked_mul(size)) else {
            return self.bad("an image is too large");
        };
        let pixels = self.bytes(count)?.chunks_exact(size.max(1));
        let pixel =
            |bytes: &[u8]| f64::from(bytes.iter().fold(0_u32, |n, &b| n << 8 | u32::from(b)));
        let pixels: Vec<f64> = pixels.map(pixel).collect();
        let size = [width, height, components].map(f64::from);
        Ok(Value::Numbers(size.into_iter().chain(pixels).collect()))
    }
}
