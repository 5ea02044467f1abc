//! The programs: their text, and their compilation.

use wgpu::{
    ComputePipeline, ComputePipelineDescriptor, Device, ShaderModuleDescriptor, ShaderSource,
};

const RAYS: &str = include_str!("kernels/rays.wgsl");
const GRID: &str = include_str!("kernels/grid.wgsl");
const KD: &str = include_str!("kernels/kd.wgsl");
const HIERARCHY: &str = include_str!("kernels/hierarchy.wgsl");

/// Rays of a workgroup, as the programs say.
pub(crate) const GROUP: u32 = 64;

/// Which structure a program traverses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    Grid,
    Kd,
    Hierarchy,
}

impl Kind {
    /// The text of the program, with a stack of so many entries.
    fn text(self, stack: u32) -> String {
        let own = match self {
            Self::Grid => GRID,
            Self::Kd => KD,
            Self::Hierarchy => HIERARCHY,
        };
        format!("const STACK: u32 = {stack}u;\n{RAYS}\n{own}")
    }

    /// Compiles the program.
    pub(crate) fn compile(self, device: &Device, stack: u32) -> ComputePipeline {
        let source = ShaderSource::Wgsl(self.text(stack).into());
        let module = device.create_shader_module(ShaderModuleDescriptor { label: None, source });
        device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("trace"),
            compilation_options: Default::default(),
            cache: None,
        })
    }
}
