//! A GPU that has been opened.

use std::sync::Arc;

use slo_accel::study::Layout;
use slo_accel::{Triangle, Uploaded};
use wgpu::{DeviceDescriptor, Features};

use crate::adapter::{self, Adapter};
use crate::failure::Failure;
use crate::packed::Packed;
use crate::resident::Resident;
use crate::shared::Shared;

/// Rounds of a program's loop after which the CPU traces a ray. Software ends loops silently after
/// 65,535, of which the loops before the main one may take 5120.
const ROUNDS_OF_SOFTWARE: u32 = 60_000;

/// The same for hardware, whose drivers end programs that run for seconds.
const ROUNDS_OF_HARDWARE: u32 = 1 << 18;

/// A GPU, ready to take structures. Any number of threads may ask it.
#[derive(Clone, Debug)]
pub struct Gpu {
    shared: Arc<Shared>,
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
        let shared = Shared::new(known, (device, queue), failure, most_rounds);
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
