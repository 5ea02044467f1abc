//! Pictures without their noise, by Open Image Denoise. Knows no files but the library's.
//!
//! The library is looked for when somebody asks for it: nothing else needs it, and the program is
//! built without it. It is told of the colours and, where there are any, of the layers that a
//! renderer knows about surfaces. Layers of few samples are noisy too where the lens or the motion
//! blurs them, so that they are denoised first, each by itself.

mod library;

use std::path::Path;

use crate::film::{Image, Layer};
use library::Device;

/// Open Image Denoise, loaded, on the processor.
#[derive(Debug)]
pub struct Denoiser {
    device: Device,
}

/// What is to be denoised.
#[derive(Clone, Copy, Debug)]
pub struct Noisy<'a> {
    /// Colours.
    pub image: &'a Image,
    /// Whether they are linear radiance without an upper end; otherwise they are from 0 to 1 as the
    /// screen shows them.
    pub is_linear: bool,
    /// Layers of the same size.
    pub layers: &'a [(Layer, Image)],
}

impl Denoiser {
    /// The library at `path`, or where the system finds it, for so many threads (all).
    ///
    /// # Errors
    /// What the system or the library says.
    pub fn load(path: Option<&Path>, threads: Option<u32>) -> Result<Self, String> {
        Ok(Self { device: Device::load(path, threads)? })
    }

    /// Name and version.
    pub fn name(&self) -> String {
        let [major, minor, patch] = self.device.version();
        format!("Open Image Denoise {major}.{minor}.{patch}")
    }

    /// The picture without its noise, in the values that it has.
    ///
    /// # Errors
    /// What the library says; layers of another size.
    pub fn denoise(&self, noisy: &Noisy) -> Result<Image, String> {
        let guides = noisy
            .usable()
            .into_iter()
            .map(|(layer, image)| Ok((layer, self.prefiltered(layer, image)?)))
            .collect::<Result<Vec<_>, String>>()?;
        let guides = guides.iter().map(|(layer, image)| (layer.name(), image));
        let images: Vec<_> = std::iter::once(("color", noisy.image)).chain(guides).collect();
        let range = if noisy.is_linear { "hdr" } else { "srgb" };
        self.device.filter(&images, &[range, "cleanAux"])
    }

    fn prefiltered(&self, layer: Layer, image: &Image) -> Result<Image, String> {
        self.device.filter(&[(layer.name(), image)], &[])
    }
}

impl<'a> Noisy<'a> {
    /// The layers that help: normals do beside the albedo only.
    pub fn usable(&self) -> Vec<(Layer, &'a Image)> {
        let has_albedo = self.layers.iter().any(|(layer, _)| *layer == Layer::Albedo);
        let usable = self.layers.iter().filter(|_| has_albedo);
        usable.map(|(layer, image)| (*layer, image)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_help_beside_the_albedo_only() {
        let image = Image { width: 1, height: 1, rgb: vec![[0.5; 3]] };
        let layers = Layer::ALL.map(|layer| (layer, image.clone()));
        let usable = |layers| Noisy { image: &image, is_linear: true, layers }.usable().len();
        assert_eq!((usable(&layers), usable(&layers[..1]), usable(&layers[1..])), (2, 1, 0));
    }

    #[test]
    fn a_library_that_is_none_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("libOpenImageDenoise.so.2");
        let why = || Denoiser::load(Some(&path), None).unwrap_err();
        let name = path.display().to_string();
        // The name, and more than the name: what the loader says.
        assert!(why().starts_with(&format!("`{name}`: ")), "{}", why());
        assert!(!cfg!(target_os = "linux") || why().contains("No such file"), "{}", why());
        std::fs::write(&path, "no library").unwrap();
        assert!(!cfg!(target_os = "linux") || why().contains("file too short"), "{}", why());
    }
}
