//! Removes noise with Open Image Denoise. Knows no files but the library's.
//!
//! The library is loaded on demand; the program is built without it, and nothing else needs it. It gets
//! the colours and, if there are any, the layers about surfaces. Layers with few samples are noisy where
//! the lens or motion blurs them, so each layer is denoised first.

mod library;

use std::path::Path;

use crate::film::{FileLayer, Image};
use library::Device;
use slo_scene::memory;

/// Open Image Denoise, loaded, on the processor.
#[derive(Debug)]
pub struct Denoiser {
    device: Device,
}

/// A picture with noise.
#[derive(Clone, Copy, Debug)]
pub struct Noisy<'a> {
    /// Colours.
    pub image: &'a Image,
    /// Whether they are linear radiance without an upper end; otherwise they are values from 0 to 1 as
    /// the screen shows them.
    pub is_linear: bool,
    /// Layers of the same size.
    pub layers: &'a [(FileLayer, Image)],
}

impl Denoiser {
    /// Loads the library at `path`, or where the system finds it. `threads`: how many it uses; `None`:
    /// all.
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

    /// Returns the picture without its noise, in the same kind of values.
    ///
    /// # Errors
    /// What the library says; layers of another size than the picture; there is no memory for the results.
    pub fn denoise(&self, noisy: &Noisy) -> Result<Image, String> {
        let usable = noisy.usable();
        let images = 1 + usable.len() as u64;
        let needs = noisy.image.rgb.len() as u64 * images * size_of::<[f32; 3]>() as u64;
        memory::check(needs).map_err(|refusal| format!("its results need {refusal}"))?;
        let guides = usable
            .into_iter()
            .map(|(layer, image)| Ok((layer.name(), self.prefiltered(layer, image)?)))
            .collect::<Result<Vec<_>, String>>()?;
        let guides = guides.iter().map(|(name, image)| (&**name, image));
        let images: Vec<_> = std::iter::once(("color", noisy.image)).chain(guides).collect();
        let range = if noisy.is_linear { "hdr" } else { "srgb" };
        self.device.filter(&images, &[range, "cleanAux"])
    }

    fn prefiltered(&self, layer: &FileLayer, image: &Image) -> Result<Image, String> {
        self.device.filter(&[(&layer.name(), image)], &[])
    }
}

impl<'a> Noisy<'a> {
    /// The layers that help: normals help only beside the albedo, and groups of lights do not.
    pub fn usable(&self) -> Vec<(&'a FileLayer, &'a Image)> {
        let has_albedo = self.layers.iter().any(|(layer, _)| *layer == FileLayer::Albedo);
        let of_surfaces =
            |layer: &FileLayer| matches!(layer, FileLayer::Albedo | FileLayer::Normal);
        let usable = self.layers.iter().filter(|(layer, _)| has_albedo && of_surfaces(layer));
        usable.map(|(layer, image)| (layer, image)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_help_beside_the_albedo_only() {
        let image = Image { width: 1, height: 1, rgb: vec![[0.5; 3]] };
        let light = FileLayer::Light("key".into());
        let layers = [FileLayer::Albedo, FileLayer::Normal, light];
        let layers = layers.map(|layer| (layer, image.clone()));
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
