//! One state of the picture, with what is known of it.

use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use slo_picture::film::Image;

use super::overlay::Map;

/// One state of the picture.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    /// Radiance; of a coarse picture, fewer pixels than `size`.
    pub(crate) image: Arc<Image>,
    /// Size of the picture.
    pub(crate) size: [u32; 2],
    /// Number of the change that the picture shows.
    pub(crate) picture: u64,
    /// Time since the change that the picture shows.
    pub(crate) since: Duration,
    /// Camera samples per pixel; `None` for a coarse picture.
    pub(crate) samples: Option<f64>,
    /// Estimated error, see [`Outcome`](slo_picture::output::Outcome).
    pub(crate) error: Option<f64>,
    /// Rays of cameras, to lights, and of bounces.
    pub(crate) rays: [u64; 3],
    /// Seconds that these rays took.
    pub(crate) seconds: f64,
    /// What is laid over it.
    pub(crate) map: Option<Arc<Map>>,
    /// Whether it has all of its samples.
    pub(crate) is_done: bool,
}

impl Shot {
    /// What the page shows of it, besides the pixels.
    pub(crate) fn facts(&self) -> Value {
        let per_second = |rays: u64| rays as f64 / self.seconds.max(1e-6);
        json!({
            "width": self.size[0],
            "height": self.size[1],
            "pixels": [self.image.width, self.image.height],
            "picture": self.picture,
            "ms": self.since.as_secs_f64() * 1e3,
            "samples": self.samples,
            "error": self.error,
            "seconds": self.seconds,
            "map": self.map.as_ref().map(|map| map.legend()),
            "rays": self.rays.map(per_second),
            "done": self.is_done,
        })
    }
}
