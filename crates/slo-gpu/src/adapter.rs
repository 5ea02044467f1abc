//! The adapters of a machine: GPUs, and software that stands for one.

use std::fmt;

use wgpu::{Backends, DeviceType, Features, Instance, InstanceDescriptor};

/// An adapter that programs may run on.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Adapter {
    /// Its name.
    pub name: String,
    /// Name and version of its driver.
    pub driver: String,
    /// Whether it is software that runs on the CPU.
    pub is_software: bool,
    /// Whether it has numbers of 64 bits, without which no program of this crate runs.
    pub has_f64: bool,
}

impl Adapter {
    pub(crate) fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            driver: format!("{} {}", info.driver, info.driver_info),
            name: info.name,
            is_software: info.device_type == DeviceType::Cpu,
            has_f64: adapter.features().contains(Features::SHADER_F64),
        }
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}", self.name, self.driver.trim())?;
        f.write_str(if self.is_software { ", software" } else { "" })?;
        f.write_str(if self.has_f64 { ")" } else { ", no 64-bit numbers)" })
    }
}

/// Lists the adapters that Vulkan finds, the one first that is used if none is asked for: discrete GPUs,
/// then others, then software.
pub fn adapters() -> Vec<Adapter> {
    found().iter().map(Adapter::of).collect()
}

fn found() -> Vec<wgpu::Adapter> {
    let mut instance = InstanceDescriptor::new_without_display_handle_from_env();
    instance.backends = Backends::VULKAN;
    let instance = Instance::new(instance);
    let mut found = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
    found.sort_by_key(|adapter| {
        let rank = match adapter.get_info().device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        };
        (!Adapter::of(adapter).has_f64, rank)
    });
    found
}

/// Returns the first adapter, or the first whose name holds a text, in upper or lower case.
pub(crate) fn choose(name: Option<&str>) -> Result<wgpu::Adapter, String> {
    let mut found = found();
    if found.is_empty() {
        return Err("no GPU: Vulkan finds no adapter; install a Vulkan driver, or Mesa's lavapipe, which is \
                    one in software (Debian: mesa-vulkan-drivers)"
            .to_owned());
    }
    let wanted = name.unwrap_or_default().to_lowercase();
    let matches =
        |adapter: &wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&wanted);
    let Some(place) = found.iter().position(matches) else {
        let all: Vec<String> = found.iter().map(|one| Adapter::of(one).to_string()).collect();
        return Err(format!("no GPU is named `{wanted}`; there are {}", all.join(", ")));
    };
    let adapter = found.swap_remove(place);
    let known = Adapter::of(&adapter);
    if !known.has_f64 {
        return Err(format!("{known} lacks what is needed: Vulkan's shaderFloat64"));
    }
    Ok(adapter)
}
