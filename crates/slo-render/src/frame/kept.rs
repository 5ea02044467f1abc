//! Structures, built or taken from a cache.

use std::sync::Arc;

use super::device;
use super::error::FrameError;
use super::remains::Remains;
use slo_accel::study::{Parameters, Traversal};
use slo_accel::{Accelerator, BuildOptions, Isa, Primitives, Sections, Structure};
use slo_scene::cache::{Cache, Entry, Key, hash_of};
use slo_scene::{SceneDescription, Settings};

/// Structures over fewer primitives are built as fast as they are found.
const LEAST: usize = 1 << 16;

/// What the building of a frame may start from. Of it, only `stays` and `apart` change the picture, in the
/// last bits of its numbers.
#[derive(Clone, Debug, Default)]
pub struct Aids {
    /// What another frame of the same scene left.
    pub before: Option<Remains>,
    /// Whether render space stays that of the other frame as long as the camera is near: structures then
    /// fit wherever the camera goes.
    pub stays: bool,
    /// Name of an object or a lamp that has a structure of its own, so that those of others fit when it
    /// moves.
    pub apart: Option<String>,
    /// A cache of structures.
    pub cache: Option<Arc<Cache>>,
    /// Parameters of structures to study.
    pub parameters: Parameters,
}

impl From<Remains> for Aids {
    fn from(before: Remains) -> Self {
        Self { before: Some(before), ..Self::default() }
    }
}

/// Sections of a file of a cache.
struct Kept<'a>(&'a Entry);

impl Sections for Kept<'_> {
    fn length(&self, section: usize) -> Option<usize> {
        self.0.length(section)
    }

    fn read(&self, section: usize, to: &mut [u8]) -> bool {
        self.0.read(section, to)
    }
}

/// Returns how much more rays may cost in a structure that is fitted to triangles which have moved, and not
/// built. Few samples are traced faster than a structure is built: building a triangle takes about as long
/// as tracing a sample with its rays.
pub(super) fn most_growth(scene: &SceneDescription, triangles: usize) -> Option<f64> {
    /// With more growth, rays soon take longer than building would have taken.
    const MOST: f64 = 1.4;
    /// With less growth, hardly any structure would be fitted.
    const LEAST: f64 = 1.005;
    let film = &scene.camera.film;
    let pixels = f64::from(film.width) * f64::from(film.height);
    let samples = pixels * scene.settings.camera_samples() as f64;
    let growth = 1.0 + triangles as f64 / samples.max(1.0);
    (growth >= LEAST).then_some(growth.min(MOST))
}

/// Returns the structure that the settings ask for: `before`, fitted to where its primitives are now, if
/// rays may [cost as much more](most_growth); otherwise as [`structure`] does.
pub(super) fn structure_like(
    before: Option<&Structure>,
    primitives: Primitives,
    scene: &SceneDescription,
    isa: Isa,
    (cache, parameters): (Option<&Cache>, Parameters),
) -> Result<Structure, FrameError> {
    let settings = &scene.settings;
    let fitted = match (before, most_growth(scene, primitives.triangles.len())) {
        (Some(before), Some(growth)) => {
            before.refitted(primitives, growth, options(settings, isa, parameters))
        }
        _ => Err(primitives),
    };
    fitted.or_else(|primitives| structure(primitives, settings, isa, (cache, parameters)))
}

/// Returns the structure that the settings ask for: from the cache, or built and put there, or built and
/// given to a GPU.
pub(super) fn structure(
    primitives: Primitives,
    settings: &Settings,
    isa: Isa,
    (cache, parameters): (Option<&Cache>, Parameters),
) -> Result<Structure, FrameError> {
    if settings.accelerator.needs_gpu() {
        return on_gpu(primitives, settings, isa, parameters);
    }
    let options = options(settings, isa, parameters);
    let accelerator = accelerator(settings.accelerator);
    let build = |primitives| Structure::build(accelerator, primitives, options);
    let pays = accelerator == Accelerator::Bvh && primitives.len() >= LEAST;
    let Some(cache) = cache.filter(|_| pays) else {
        return Ok(build(primitives));
    };
    let key = key(&primitives, accelerator, options);
    let mut given = Some(primitives);
    let found = cache.get(&key, |entry| {
        match Structure::restore(accelerator, given.take()?, options, &Kept(entry)) {
            Ok(structure) => Some(structure),
            Err(back) => {
                given = Some(back);
                None
            }
        }
    });
    Ok(found.unwrap_or_else(|| {
        let built = build(given.unwrap_or_default());
        if let Some(sections) = built.kept() {
            let sections: Vec<&[u8]> = sections.iter().map(|section| &**section).collect();
            cache.put(&key, &sections);
        }
        built
    }))
}

fn options(settings: &Settings, isa: Isa, parameters: Parameters) -> BuildOptions {
    BuildOptions::new(isa).with_spatial_splits(settings.spatial_splits).with_parameters(parameters)
}

/// Builds the structure that a GPU is to traverse.
fn on_gpu(
    primitives: Primitives,
    settings: &Settings,
    isa: Isa,
    mut parameters: Parameters,
) -> Result<Structure, FrameError> {
    if parameters.traversal == Traversal::Stack {
        parameters.traversal = Traversal::ShortStack;
    }
    let options = BuildOptions::new(isa).with_parameters(parameters);
    let built = device::get().and_then(|device| {
        Structure::build_on(device, accelerator(settings.accelerator), primitives, options)
    });
    let accelerator = settings.accelerator.name();
    built.map_err(|reason| FrameError::Device { accelerator, reason })
}

/// Returns the key of a structure. Instruction sets build the same one.
fn key(primitives: &Primitives, accelerator: Accelerator, options: BuildOptions) -> Key {
    let triangles = hash_of(Structure::bytes_of_triangles(primitives));
    let mut words = format!("{accelerator} {}", options.spatial_splits);
    for curved in &primitives.curved {
        words += &format!(" {curved:?}");
    }
    Key::new("structure", Structure::KEPT, &[&triangles, words.as_bytes()])
}

/// Converts the scene's name of a structure.
fn accelerator(name: slo_scene::Accelerator) -> Accelerator {
    match name {
        slo_scene::Accelerator::KdTree => Accelerator::KdTree,
        slo_scene::Accelerator::Bvh => Accelerator::Bvh,
        slo_scene::Accelerator::Cwbvh => Accelerator::Cwbvh,
        slo_scene::Accelerator::None => Accelerator::None,
        slo_scene::Accelerator::Grid | slo_scene::Accelerator::GpuGrid => Accelerator::Grid,
        slo_scene::Accelerator::Octree => Accelerator::Octree,
        slo_scene::Accelerator::Median => Accelerator::Median,
        slo_scene::Accelerator::RTree => Accelerator::RTree,
        slo_scene::Accelerator::Binary | slo_scene::Accelerator::GpuBvh => Accelerator::Binary,
        slo_scene::Accelerator::Kd | slo_scene::Accelerator::GpuKd => Accelerator::Kd,
        slo_scene::Accelerator::Boxes => Accelerator::Boxes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_accel::glam::Vec3;

    fn grid(height: f32) -> Primitives {
        let corner = |x: usize, y: usize| {
            Vec3::new(x as f32, y as f32, height * ((x * 7 + y * 5) % 11) as f32)
        };
        let cells = (0..200).flat_map(|x| (0..200).map(move |y| (x, y)));
        let triangles = cells.flat_map(|(x, y)| {
            let [a, b] = [corner(x, y), corner(x + 1, y + 1)];
            [[a, corner(x + 1, y), b], [a, b, corner(x, y + 1)]]
        });
        triangles.collect::<Vec<_>>().into()
    }

    #[test]
    fn structures_are_fitted_where_few_samples_would_be_slower() {
        let text = "settings s { imageSamples 4 } Camera c { fps 1
            Film f { width 100 height 100 prefix a_ output PNG_IMAGE }
            CamSegment only { videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
                addPosition { 0 -5 1 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart 0.4 } }";
        let loaded = slo_scene::load("scene.txt", text, &slo_scene::Files::built_in("", &[]));
        let scene = loaded.scene.expect("it has no error");
        assert_eq!(most_growth(&scene, 4_000), Some(1.1));
        assert_eq!(most_growth(&scene, 4_000_000), Some(1.4));
        assert_eq!(most_growth(&scene, 100), None);
    }

    #[test]
    fn a_gpu_that_nobody_offers_is_an_error() {
        let mut settings = Settings::default();
        settings.accelerator = slo_scene::Accelerator::GpuBvh;
        let usual = Parameters::default();
        let error = structure(grid(0.1), &settings, Isa::best(), (None, usual)).unwrap_err();
        assert!(error.to_string().starts_with("accelerator GPU_BVH: this program has no support"));
    }

    #[test]
    fn structures_are_built_once_for_all_instruction_sets() {
        let folder = tempfile::tempdir().expect("a folder");
        let open = || Cache::new(folder.path(), 1 << 30, |warning| panic!("{warning}"));
        let settings = Settings::default();
        fn of(
            primitives: Primitives,
            settings: &Settings,
            isa: Isa,
            cache: Option<&Cache>,
        ) -> Structure {
            structure(primitives, settings, isa, (cache, Parameters::default()))
                .expect("no GPU is asked for")
        }
        let built = of(grid(0.1), &settings, Isa::best(), None);
        let expected = built.kept().expect("it can be kept");
        for (round, isa) in Isa::available().into_iter().chain([Isa::best()]).enumerate() {
            let cache = open();
            let found = of(grid(0.1), &settings, isa, Some(&cache));
            assert!(found.kept().expect("it can be kept") == expected, "{isa}");
            let uses = cache.uses();
            assert_eq!((uses.made, uses.found), if round == 0 { (1, 0) } else { (0, 1) });
        }
        let cache = open();
        of(grid(0.2), &settings, Isa::best(), Some(&cache));
        let mut split = settings.clone();
        split.spatial_splits = true;
        of(grid(0.1), &split, Isa::best(), Some(&cache));
        of(Primitives::default(), &settings, Isa::best(), Some(&cache));
        let uses = cache.uses();
        assert_eq!((uses.made, uses.found), (2, 0));
    }
}
