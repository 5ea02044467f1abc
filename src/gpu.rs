//! The GPU for `GPU_BVH`, `GPU_KD` and `GPU_GRID`, if the program is built with the feature `gpu`.

#[cfg(feature = "gpu")]
mod offered {
    use std::env;
    use std::sync::{Arc, OnceLock};

    use slo_accel::Device;
    use slo_gpu::Gpu;

    /// Names the adapter, or a part of its name.
    const CHOICE: &str = "SLO_RT_GPU";

    static OPENED: OnceLock<Gpu> = OnceLock::new();

    /// Opens the GPU; frames ask for it once.
    pub(super) fn open() -> Result<Arc<dyn Device>, String> {
        let wanted = env::var(CHOICE).ok();
        let gpu = Gpu::open(wanted.as_deref().map(str::trim).filter(|name| !name.is_empty()))?;
        Ok(Arc::new(OPENED.get_or_init(|| gpu).clone()))
    }

    pub(super) fn opened() -> Option<&'static Gpu> {
        OPENED.get()
    }
}

/// Offers the GPU to all frames that ask for one.
pub(crate) fn offer() {
    #[cfg(feature = "gpu")]
    slo_render::frame::offer_device(offered::open);
}

/// Returns name and driver of the GPU, if a frame uses it.
pub(crate) fn name() -> Option<String> {
    #[cfg(feature = "gpu")]
    return offered::opened().map(|gpu| gpu.adapter().to_string());
    #[cfg(not(feature = "gpu"))]
    None
}

/// Returns why the GPU has failed, if it has.
pub(crate) fn failure() -> Option<&'static str> {
    #[cfg(feature = "gpu")]
    return offered::opened().and_then(|gpu| gpu.failure());
    #[cfg(not(feature = "gpu"))]
    None
}
