//! A GPU that has been opened.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use slo_accel::study::Layout;
use slo_accel::{Triangle, Uploaded};
use wgpu::{BufferUsages, ComputePipeline, DeviceDescriptor, Features};

use crate::adapter::{self, Adapter};
use crate::failure::Failure;
use crate::packed::Packed;
use crate::program::Kind;
use crate::resident::{Desk, Resident};

/// Rounds of a program's loop after which the CPU traces a ray. Software ends loops silently after
/// 65,535, of which the loops before the main one may take 5120.
const ROUNDS_OF_SOFTWARE: u32 = 60_000;

/// The same for hardware, whose drivers end programs that run for seconds.
const ROUNDS_OF_HARDWARE: u32 = 1 << 18;

/// A GPU, ready to take structures. Any number of threads may ask it.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) shared: Arc<Shared>,
}

/// What structures on a GPU share.
#[derive(Debug)]
pub(crate) struct Shared {
    adapter: Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) failure: Failure,
    pub(crate) most_rounds: u32,
    programs: Mutex<HashMap<(Kind, u32), ComputePipeline>>,
    /// Buffers that no call uses now.
    desks: Mutex<Vec<Desk>>,
}

impl Gpu {
    /// Opens the first of the [`adapters`](crate::adapters), or the first whose name holds a text.
    ///
    /// # Errors
    /// If there is none, or it lacks what is needed: why, in words for the user.
    pub fn open(name: Option<&str>) -> Result<Self, String> {
        let adapter = adapter::choose(name)?;
        let known = Adapter::of(&adapter);
        let asked = DeviceDescriptor {
            required_features: Features::SHADER_F64,
            required_limits: adapter.limits(),
            ..DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&asked));
        let (device, queue) =
            opened.map_err(|error| format!("{known} can't be opened: {error}"))?;
        let failure = Failure::default();
        let noted = failure.clone();
        device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| noted.note(error.to_string())));
        let noted = failure.clone();
        device.set_device_lost_callback(move |_, reason| {
            noted.note(format!("it was lost: {reason}"))
        });
        let most_rounds = if known.is_software { ROUNDS_OF_SOFTWARE } else { ROUNDS_OF_HARDWARE };
        let (programs, desks) = Default::default();
        let adapter = known;
        let shared = Shared { adapter, device, queue, failure, most_rounds, programs, desks };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Which adapter it is.
    pub fn adapter(&self) -> &Adapter {
        &self.shared.adapter
    }

    /// Why the GPU cannot be used any more, if it has failed. All rays are then traced by the CPU.
    pub fn failure(&self) -> Option<&str> {
        self.shared.failure.get()
    }
}

impl slo_accel::Device for Gpu {
    fn upload(
        &self,
        layout: &Layout<'_>,
        triangles: &[Triangle],
    ) -> Result<Box<dyn Uploaded>, String> {
        let named = |error: String| format!("{}: {error}", self.shared.adapter.name);
        let packed = Packed::new(layout).map_err(named)?;
        let resident = Resident::new(self.shared.clone(), &packed, triangles).map_err(named)?;
        Ok(Box::new(resident))
    }
}

impl Shared {
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
        let fits = desks.iter().position(|desk| desk.rays() >= rays);
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
