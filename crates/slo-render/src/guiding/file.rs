//! A field as bytes, for machines that render the same frame and need not learn it again.

use std::fmt;

use glam::Vec3;

use super::field::{Field, Guide, NOWHERE};
use super::places::{Grid, Node};
use super::quads::Quad;

/// What a file begins with.
const MAGIC: &[u8; 16] = b"slo-rt guide 1\r\n";

/// Length of the key of what a field was learned from.
pub const KEY: usize = 32;

/// Why bytes are not the field of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldError {
    /// They are something else.
    NotAField,
    /// They are the field of another scene, frame or version.
    OfAnotherFrame,
    /// They are damaged.
    Damaged,
}

impl fmt::Display for FieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotAField => "it is not a guide file of slo-rt",
            Self::OfAnotherFrame => {
                "it belongs to another scene, frame or version, or to other settings"
            }
            Self::Damaged => "it is damaged",
        })
    }
}

impl std::error::Error for FieldError {}

impl Field {
    /// Returns the field as bytes: magic bytes, the key of what it was learned from, the numbers
    /// (little-endian), and a hash of all of these.
    pub fn to_bytes(&self, key: &[u8; KEY]) -> Vec<u8> {
        let Self { grid, nodes, guides, quads } = self;
        let mut bytes = [&MAGIC[..], key].concat();
        for x in grid.least.to_array().into_iter().chain(grid.scale.to_array()) {
            bytes.extend(x.to_le_bytes());
        }
        for len in [nodes.len(), guides.len(), quads.len()] {
            bytes.extend((len as u32).to_le_bytes());
        }
        for node in nodes {
            bytes.extend(node.split.to_le_bytes());
            bytes.extend(node.next.to_le_bytes());
        }
        for guide in guides {
            bytes.extend(guide.root.to_le_bytes());
            bytes.extend(guide.share);
        }
        for quad in quads {
            for number in quad.share.iter().chain(&quad.child) {
                bytes.extend(number.to_le_bytes());
            }
        }
        let hash = blake3::hash(&bytes);
        bytes.extend(hash.as_bytes());
        bytes
    }

    /// Restores a field from the result of [`to_bytes`](Self::to_bytes) with the same key.
    ///
    /// # Errors
    /// The bytes are something else, or have another key, or are damaged.
    pub fn from_bytes(bytes: &[u8], key: &[u8; KEY]) -> Result<Self, FieldError> {
        if !bytes.starts_with(MAGIC) {
            return Err(FieldError::NotAField);
        }
        let (content, hash) = bytes.split_last_chunk::<KEY>().ok_or(FieldError::Damaged)?;
        if blake3::hash(content) != *hash {
            return Err(FieldError::Damaged);
        }
        let rest = content[MAGIC.len()..].strip_prefix(key).ok_or(FieldError::OfAnotherFrame)?;
        Reader(rest).field().filter(Self::is_sound).ok_or(FieldError::Damaged)
    }

    /// Whether all paths through the field end: children come after their parents.
    fn is_sound(&self) -> bool {
        let Self { nodes, guides, quads, .. } = self;
        let is_node = |(at, node): (usize, &Node)| {
            node.axis() == 3
                || (node.number() as usize > at && node.number() as usize + 1 < nodes.len())
        };
        let is_guide = |guide: &Guide| guide.root == NOWHERE || (guide.root as usize) < quads.len();
        nodes.iter().enumerate().all(is_node) && guides.iter().all(is_guide)
    }
}

/// What is left to read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*taken)
    }

    fn vector(&mut self) -> Option<Vec3> {
        let mut number = || Some(f32::from_le_bytes(self.take()?));
        Some(Vec3::new(number()?, number()?, number()?))
    }

    fn count(&mut self) -> Option<usize> {
        Some(u32::from_le_bytes(self.take()?) as usize)
    }

    fn numbers(&mut self) -> Option<[u16; 4]> {
        let mut number = || Some(u16::from_le_bytes(self.take()?));
        Some([number()?, number()?, number()?, number()?])
    }

    fn field(mut self) -> Option<Field> {
        let grid = Grid { least: self.vector()?, scale: self.vector()? };
        let [nodes, guides, quads] = [self.count()?, self.count()?, self.count()?];
        let size = nodes.checked_mul(8)?.checked_add(guides.checked_mul(6)?)?;
        if size.checked_add(quads.checked_mul(16)?)? != self.0.len() {
            return None;
        }
        let node = |reader: &mut Self| {
            let [split, next] = [reader.take()?, reader.take()?].map(u32::from_le_bytes);
            Some(Node { split, next })
        };
        let guide = |reader: &mut Self| {
            Some(Guide { root: u32::from_le_bytes(reader.take()?), share: reader.take()? })
        };
        let quad =
            |reader: &mut Self| Some(Quad { share: reader.numbers()?, child: reader.numbers()? });
        Some(Field {
            grid,
            nodes: (0..nodes).map(|_| node(&mut self)).collect::<Option<_>>()?,
            guides: (0..guides).map(|_| guide(&mut self)).collect::<Option<_>>()?,
            quads: (0..quads).map(|_| quad(&mut self)).collect::<Option<_>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guiding::quads::tests::random;

    fn field() -> Field {
        Field {
            grid: Grid { least: Vec3::new(-1.0, 2.0, 3.0), scale: Vec3::splat(1e5) },
            nodes: vec![Node::divided(1, 77, 1), Node::leaf(0), Node::leaf(1)],
            guides: vec![
                Guide { root: 0, share: [0, 128] },
                Guide { root: NOWHERE, share: [0; 2] },
            ],
            quads: random(3),
        }
    }

    #[test]
    fn fields_come_back_and_others_are_refused() {
        let (field, key) = (field(), [7; KEY]);
        let bytes = field.to_bytes(&key);
        assert_eq!(Field::from_bytes(&bytes, &key), Ok(field.clone()));
        assert_eq!(Field::from_bytes(&bytes, &[8; KEY]), Err(FieldError::OfAnotherFrame));
        assert_eq!(Field::from_bytes(b"slo_mesh 1", &key), Err(FieldError::NotAField));
        for len in [16, 40, 60, bytes.len() - 1] {
            assert_eq!(Field::from_bytes(&bytes[..len], &key), Err(FieldError::Damaged));
        }
        for at in [20, 100, bytes.len() - 40] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 4;
            assert_eq!(Field::from_bytes(&damaged, &key), Err(FieldError::Damaged));
        }
    }

    #[test]
    fn a_tree_without_an_end_is_refused() {
        let (mut field, key) = (field(), [7; KEY]);
        field.nodes[0] = Node::divided(0, 5, 0);
        let bytes = field.to_bytes(&key);
        assert_eq!(Field::from_bytes(&bytes, &key), Err(FieldError::Damaged));
    }
}
