//! The GPU of the process, which the program may offer. It is opened when a frame first needs it.

use std::sync::{Arc, OnceLock};

use slo_accel::Device;
use slo_scene::Accelerator;

use super::error::FrameError;

/// Opens a GPU, or tells why there is none, in words for the user.
pub type OpenDevice = fn() -> Result<Arc<dyn Device>, String>;

static OFFER: OnceLock<OpenDevice> = OnceLock::new();
static DEVICE: OnceLock<Result<Arc<dyn Device>, String>> = OnceLock::new();

/// Offers a GPU to all frames whose settings ask for one. The first offer counts.
pub fn offer_device(open: OpenDevice) {
    // Programs have no other.
    let _ = OFFER.set(open);
}

/// Whether a GPU has been offered.
pub fn offers_device() -> bool {
    OFFER.get().is_some()
}

/// Opens the GPU, if it has not been opened.
///
/// # Errors
/// There is none, or it can't be used.
pub fn check_device(accelerator: Accelerator) -> Result<(), FrameError> {
    get()
        .map(|_| ())
        .map_err(|reason| FrameError::Device { accelerator: accelerator.name(), reason })
}

/// Returns the GPU, opened.
pub(super) fn get() -> Result<&'static dyn Device, String> {
    let open = OFFER.get().ok_or(
        "this program has no support for GPUs; build it with `cargo build --release --features gpu`",
    )?;
    let opened = DEVICE.get_or_init(open);
    opened.as_deref().map_err(Clone::clone)
}
