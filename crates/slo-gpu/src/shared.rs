//! What structures on a GPU share: the device, its programs, and buffers that are in no use.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use wgpu::{BufferUsages, ComputePipeline};

use crate::adapter::Adapter;
use crate::desk::Desk;
use crate::failure::Failure;
use crate::program::Kind;

/// What structures on a GPU share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) adapter: Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) failure: Failure,
    pub(crate) most_rounds: u32,
    programs: Mutex<HashMap<(Kind, u32), ComputePipeline>>,
    /// Buffers that no call uses now.
    desks: Mutex<Vec<Desk>>,
}

impl Shared {
    pub(crate) fn new(
        adapter: Adapter,
        (device, queue): (wgpu::Device, wgpu::Queue),
        failure: Failure,
        most_rounds: u32,
    ) -> Self {
        let (programs, desks) = Default::default();
        Self { adapter, device, queue, failure, most_rounds, programs, desks }
    }

    /// Returns a program, compiled once for each size of the stack.
    pub(crate) fn program(&self, kind: Kind, stack: u32) -> ComputePipeline {
        let mut programs = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
        programs.entry((kind, stack)).or_insert_with(|| kind.compile(&self.device, stack)).clone()
    }

    /// Makes a buffer with contents. What is empty gets a few bytes, since no buffer may be.
    pub(crate) fn buffer(&self, what: &str, words: &[u32]) -> Result<wgpu::Buffer, String> {
        let bytes = bytemuck::cast_slice(words);
        let size = (bytes.len() as u64).max(64);
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if size > most {
            let mib = |bytes: u64| bytes.div_ceil(1 << 20);
            return Err(format!(
                "the {what} need {} MiB in one buffer, of which it allows {}",
                mib(size),
                mib(most)
            ));
        }
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.failure.check()?;
        self.queue.write_buffer(&buffer, 0, bytes);
        self.failure.check()?;
        Ok(buffer)
    }

    /// Takes buffers for so many rays.
    pub(crate) fn desk(&self, rays: usize) -> Result<Desk, String> {
        let mut desks = self.desks.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = desks.iter().position(|desk| desk.room() >= rays);
        if let Some(place) = fits {
            return Ok(desks.swap_remove(place));
        }
        drop(desks);
        let desk = Desk::new(&self.device, rays.next_power_of_two().max(1024));
        self.failure.check().map(|()| desk)
    }

    /// Puts buffers back.
    pub(crate) fn put_back(&self, desk: Desk) {
        self.desks.lock().unwrap_or_else(PoisonError::into_inner).push(desk);
    }
}
