//! slo-rt: a distributed ray tracer for animations.

pub mod cli;

use slo_picture::{compare, denoise, film, output};
use slo_render::frame;
use slo_scene as scene;
use slo_scene::{animation, diagnostics};

mod accel {
    pub(crate) use slo_accel::Isa;
    pub(crate) use slo_scene::Accelerator;
}

mod render {
    pub(crate) use slo_picture::film::Steps;
    pub(crate) use slo_render::render::*;
}
