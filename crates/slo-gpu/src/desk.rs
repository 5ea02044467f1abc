//! The buffers in which a batch of rays goes to the GPU, and its answers come back.

use wgpu::{Buffer, BufferUsages, Device};

/// Words of a ray and of an answer, as kernels/rays.wgsl has them.
pub(crate) const WORDS: usize = 12;

/// Bytes of a `Query`.
const QUERY: u64 = 160;

/// Buffers of a batch: one thread uses them at a time.
#[derive(Debug)]
pub(crate) struct Desk {
    pub(crate) query: Buffer,
    pub(crate) rays: Buffer,
    pub(crate) answers: Buffer,
    pub(crate) read_back: Buffer,
}

impl Desk {
    pub(crate) fn new(device: &Device, rays: usize) -> Self {
        let buffer = |size: u64, usage: BufferUsages| {
            let (label, mapped_at_creation) = (None, false);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let size = (rays * WORDS * 4) as u64;
        Self {
            query: buffer(QUERY, BufferUsages::UNIFORM | BufferUsages::COPY_DST),
            rays: buffer(size, BufferUsages::STORAGE | BufferUsages::COPY_DST),
            answers: buffer(size, BufferUsages::STORAGE | BufferUsages::COPY_SRC),
            read_back: buffer(size, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    /// Number of rays for which there is room.
    pub(crate) fn room(&self) -> usize {
        self.rays.size() as usize / (WORDS * 4)
    }
}
