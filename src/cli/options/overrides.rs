//! Settings of the scene that the command line replaces.

use crate::cli::args::{LookArgs, SettingArgs};
use slo_scene::{Layer, SceneDescription};

/// Maximum number of camera samples per pixel if noise, time or steps decide and `--samples` is
/// not given.
const MOST_FOR_NOISE: u32 = 4096;

/// Settings of the scene that the command line replaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overrides {
    pub(crate) prefix: Option<String>,
    /// Layers of EXR pictures; if empty, the film's layers stay.
    pub(crate) layers: Vec<Layer>,
    pub(crate) settings: SettingArgs,
    /// Whether time or steps decide the number of samples, not the scene.
    pub(crate) is_stepwise: bool,
}

impl Overrides {
    /// Replaces the settings of the scene that the command line names.
    ///
    /// `samples` counts all camera samples of a pixel: the product of `imageSamples` and
    /// `dofSamples`.
    pub(crate) fn apply(&self, scene: &mut SceneDescription) {
        // Every option is named here, so that a new one can't be forgotten.
        let SettingArgs {
            format,
            look,
            size,
            samples,
            noise,
            integrator,
            photons,
            seed,
            accelerator,
            accelerator_options: _,
            spatial_splits,
        } = self.settings;
        let film = &mut scene.camera.film;
        film.prefix = self.prefix.clone().unwrap_or_else(|| film.prefix.clone());
        if let Some(size) = size {
            let size = size.of(film.width, film.height);
            (film.width, film.height) = (size.width, size.height);
        }
        film.output = format.map_or(film.output, |name| name.0);
        let LookArgs { exposure, tone_map, encoding } = look;
        film.exposure = exposure.unwrap_or(film.exposure);
        film.tone_map = tone_map.map_or(film.tone_map, |name| name.0);
        film.encoding = encoding.map(|name| name.0).or(film.encoding);
        if !self.layers.is_empty() {
            film.layers.clone_from(&self.layers);
            film.layers.sort_unstable();
            film.layers.dedup();
        }
        let settings = &mut scene.settings;
        settings.noise = noise.or(settings.noise);
        let open = (noise.is_some() || self.is_stepwise).then_some(MOST_FOR_NOISE);
        if let Some(samples) = samples.or(open) {
            settings.set_camera_samples(samples);
        }
        settings.integrator = integrator.map_or(settings.integrator, |name| name.0);
        settings.photons = photons.unwrap_or(settings.photons);
        settings.seed = seed.unwrap_or(settings.seed);
        settings.accelerator = accelerator.map_or(settings.accelerator, |name| name.0);
        settings.spatial_splits |= spatial_splits;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::options::empty_scene;
    use crate::cli::values::{
        AcceleratorName, EncodingName, FormatName, IntegratorName, SizeChoice, ToneMapName,
    };
    use slo_scene::{
        Accelerator, Encoding, Integrator, LightSampling, Look, OutputFormat, ToneMap,
    };

    fn with(settings: SettingArgs) -> Overrides {
        Overrides { settings, ..Overrides::default() }
    }

    fn check_samples(scene: (u32, u32, u32), samples: u32, expected: (u32, u32, u32)) {
        let mut description = empty_scene();
        let settings = &mut description.settings;
        (settings.image_min_samples, settings.image_samples, settings.dof_samples) = scene;
        with(SettingArgs { samples: Some(samples), ..SettingArgs::default() })
            .apply(&mut description);
        let settings = &description.settings;
        let result = (settings.image_min_samples, settings.image_samples, settings.dof_samples);
        assert_eq!(result, expected, "--samples {samples} over {scene:?}");
    }

    #[test]
    fn samples_are_all_camera_samples() {
        check_samples((16, 16, 6), 4, (4, 4, 1));
        check_samples((16, 16, 1), 64, (64, 64, 1));
        check_samples((32, 256, 2), 128, (32, 128, 1));
        check_samples((32, 256, 2), 8, (8, 8, 1));
    }

    #[test]
    fn without_options_the_scene_stays() {
        let mut scene = empty_scene();
        Overrides::default().apply(&mut scene);
        assert_eq!(scene.settings, empty_scene().settings);
        assert_eq!(scene.camera.film, empty_scene().camera.film);
    }

    #[test]
    fn options_replace_what_the_scene_says() {
        let mut scene = empty_scene();
        let settings = SettingArgs {
            size: Some(SizeChoice::Share(0.5)),
            photons: Some(0.5),
            seed: Some(7),
            accelerator: Some(AcceleratorName(Accelerator::None)),
            spatial_splits: true,
            format: Some(FormatName(OutputFormat::Exr)),
            look: LookArgs {
                exposure: Some(-1.5),
                tone_map: Some(ToneMapName(ToneMap::Agx)),
                encoding: Some(EncodingName(Encoding::Srgb)),
            },
            ..SettingArgs::default()
        };
        let overrides = Overrides {
            prefix: Some("p".into()),
            layers: vec![Layer::Normal, Layer::Albedo, Layer::Normal],
            ..with(settings)
        };
        overrides.apply(&mut scene);
        let film = &scene.camera.film;
        assert_eq!((film.width, film.height, &*film.prefix), (16, 9, "p"));
        assert_eq!((film.output, &film.layers[..]), (OutputFormat::Exr, &Layer::ALL[..2]));
        let look = Look { exposure: -1.5, tone_map: ToneMap::Agx, encoding: Encoding::Srgb };
        assert_eq!(film.look(&scene.settings), look);
        assert_eq!((scene.settings.seed, scene.settings.accelerator), (7, Accelerator::None));
        assert!(scene.settings.spatial_splits);
        assert_eq!(scene.settings.photons, 0.5);
    }

    #[test]
    fn another_integrator_has_its_own_defaults() {
        let path = Some(IntegratorName(Integrator::Path));
        let overrides = with(SettingArgs { integrator: path, ..SettingArgs::default() });
        let mut scene = empty_scene();
        overrides.apply(&mut scene);
        let settings = &scene.settings;
        assert_eq!(settings.integrator, Integrator::Path);
        assert_eq!((settings.recursion(), settings.light_sampling()), (16, LightSampling::One));
        let mut written = empty_scene();
        written.settings.recursion = Some(3);
        written.settings.light_sampling = Some(LightSampling::All);
        overrides.apply(&mut written);
        let settings = &written.settings;
        assert_eq!((settings.recursion(), settings.light_sampling()), (3, LightSampling::All));
    }

    #[test]
    fn a_noise_level_has_samples_enough() {
        let mut scene = empty_scene();
        let noise = SettingArgs { noise: Some(0.01), ..SettingArgs::default() };
        with(noise).apply(&mut scene);
        assert_eq!((scene.settings.noise, scene.settings.image_samples), (Some(0.01), 4096));
        with(SettingArgs { samples: Some(64), ..noise }).apply(&mut scene);
        assert_eq!(scene.settings.image_samples, 64);
    }
}
