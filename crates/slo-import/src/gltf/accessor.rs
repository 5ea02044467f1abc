//! Numbers in buffers.

use gltf::accessor::{Accessor, DataType, sparse::IndexType};
use gltf::buffer::View;

use super::buffers::{Bytes, Left};
use crate::error::ImportError;
use crate::files::Source;

/// Most elements of an accessor without bytes of its own, which a short file could make as large as it
/// likes.
const MOST_ZEROS: usize = 1 << 24;

/// The buffers of a file.
#[derive(Clone, Copy)]
pub(super) struct Buffers<'a> {
    pub(super) source: &'a Source,
    pub(super) bytes: &'a [Bytes],
    pub(super) left: &'a Left,
}

impl<'a> Buffers<'a> {
    /// The bytes of a view.
    pub(super) fn view(&self, view: &View<'_>) -> Result<&'a [u8], ImportError> {
        let end = view.offset().checked_add(view.length());
        let bytes = self.bytes.get(view.buffer().index()).zip(end);
        bytes.and_then(|(bytes, end)| bytes.get(view.offset()..end)).ok_or_else(|| {
            self.source.bad(format!("buffer view {} lies outside of its buffer", view.index()))
        })
    }

    /// Reads vectors of `N` numbers; whole numbers that are normalised become 0 to 1, or -1 to 1.
    pub(super) fn read<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        self.check_width(accessor, N)?;
        let (kind, normalised) = (accessor.data_type(), accessor.normalized());
        self.elements(accessor, [0.0; N], |bytes| {
            std::array::from_fn(|i| to_float(kind, normalised, &bytes[i * kind.size()..]))
        })
    }

    /// Reads whole numbers, as indices are.
    pub(super) fn read_whole<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[u32; N]>, ImportError> {
        self.check_width(accessor, N)?;
        let kind = accessor.data_type();
        self.elements(accessor, [0; N], |bytes| {
            std::array::from_fn(|i| to_whole(kind, &bytes[i * kind.size()..]))
        })
    }

    fn check_width(&self, accessor: &Accessor<'_>, width: usize) -> Result<(), ImportError> {
        let found = accessor.dimensions().multiplicity();
        if found == width {
            return Ok(());
        }
        let message =
            format!("accessor {} has {found} numbers instead of {width}", accessor.index());
        Err(self.source.bad(message))
    }

    fn elements<T: Copy>(
        &self,
        accessor: &Accessor<'_>,
        zero: T,
        of: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, ImportError> {
        let bad =
            || self.source.bad(format!("accessor {} lies outside of its bytes", accessor.index()));
        let (count, size) = (accessor.count(), accessor.size());
        self.left.take(self.source, count.saturating_mul(size_of::<T>()))?;
        let mut elements = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size);
                let bytes = self.view(&view)?;
                let span = || stride.checked_mul(count.checked_sub(1)?)?.checked_add(size);
                let end = span().and_then(|span| accessor.offset().checked_add(span));
                let bytes = bytes.get(accessor.offset()..end.ok_or_else(bad)?).ok_or_else(bad)?;
                (0..count).map(|i| of(&bytes[i * stride..])).collect()
            }
            None if count <= MOST_ZEROS => vec![zero; count],
            None => return Err(bad()),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let places = self.view(&indices.view())?.get(indices.offset()..).ok_or_else(bad)?;
            let bytes = self.view(&values.view())?.get(values.offset()..).ok_or_else(bad)?;
            let width = match indices.index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            for i in 0..sparse.count() {
                let place = i
                    .checked_mul(width)
                    .and_then(|at| places.get(at..at + width))
                    .ok_or_else(bad)?;
                let place = place.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
                let value =
                    i.checked_mul(size).and_then(|at| bytes.get(at..at + size)).ok_or_else(bad)?;
                *elements.get_mut(place).ok_or_else(bad)? = of(value);
            }
        }
        Ok(elements)
    }
}

/// The first number of some bytes, which are long enough.
fn to_float(kind: DataType, normalised: bool, bytes: &[u8]) -> f32 {
    let scale = |value: f32, most: f32| if normalised { (value / most).max(-1.0) } else { value };
    match kind {
        DataType::I8 => scale(f32::from(i8::from_le_bytes([bytes[0]])), 127.0),
        DataType::U8 => scale(f32::from(bytes[0]), 255.0),
        DataType::I16 => scale(f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        DataType::U16 => scale(f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        DataType::U32 => to_whole(kind, bytes) as f32,
        DataType::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

fn to_whole(kind: DataType, bytes: &[u8]) -> u32 {
    match kind {
        DataType::I8 | DataType::U8 => u32::from(bytes[0]),
        DataType::I16 | DataType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        DataType::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        DataType::F32 => to_float(kind, false, bytes) as u32,
    }
}
