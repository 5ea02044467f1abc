//! Helpers that render pictures from scene texts.

use std::path::Path;

use slo_accel::Isa;
use slo_picture::film::{Area, FileLayer, Film, Image};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, Statistics, render};
use slo_scene::{Files, Layer, SceneDescription, load};

struct Unwatched;

impl Observer for Unwatched {
    fn advanced(&self, _share: f64) {}
}

/// Loads a scene that has no errors. Its files lie among the test scenes of `slo-scene`.
#[track_caller]
pub(crate) fn describe(text: &str) -> SceneDescription {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../slo-scene/tests/scenes");
    let loaded = load("test", text, &Files::on_disk(&folder, &folder, false));
    loaded.scene.unwrap_or_else(|| panic!("{:#?}\n{text}", loaded.diagnostics))
}

/// Renders frame 0 of a scene.
pub(crate) fn expose(scene: &SceneDescription, isa: Isa) -> Film {
    expose_frame(scene, &FrameScene::build(scene, 0, isa).expect("the frame can be built"))
}

/// Renders a frame of a scene.
pub(crate) fn expose_frame(scene: &SceneDescription, frame: &FrameScene) -> Film {
    expose_counted(scene, frame).0
}

/// Renders a frame of a scene, and counts its rays.
pub(crate) fn expose_counted(scene: &SceneDescription, frame: &FrameScene) -> (Film, Statistics) {
    let (plan, picture) = (Plan::new(scene), &scene.camera.film);
    let area = Area::whole(picture.width, picture.height);
    let film = Film::new(area, plan.needs_spreads()).expect("small enough");
    let film = film.with_layers(&picture.layers, &scene.layer_names()).expect("small enough");
    let exposed = render(frame, &plan, film, &Unwatched);
    assert!(exposed.is_complete);
    assert_eq!(exposed.statistics.refused_contributions, 0);
    (exposed.film, exposed.statistics)
}

/// View and sampling of a test scene. x is to the right, y into the picture, z up. Pictures have 64
/// x 64 pixels.
#[derive(Clone)]
pub(crate) struct Shot {
    /// Control points of the camera's path.
    pub(crate) from: Vec<[f64; 3]>,
    /// Control points of the target's path.
    pub(crate) to: Vec<[f64; 3]>,
    /// Upward direction.
    pub(crate) sky: [f64; 3],
    /// Half height of the view at distance 1.
    pub(crate) fov: f64,
    /// Distance of the plane in focus.
    pub(crate) dof: f64,
    /// Lens radius.
    pub(crate) lens: f64,
    /// Seconds that the shutter is open; scene time 0 to 1 takes 1 s.
    pub(crate) blur: f64,
    /// Samples per pixel.
    pub(crate) samples: u32,
    /// Limit of the recursion, in bounces.
    pub(crate) recursion: u32,
    /// More settings.
    pub(crate) settings: String,
    /// Whether no ray is left out for its small weight, so that sums are exact.
    pub(crate) plain: bool,
}

impl Default for Shot {
    fn default() -> Self {
        Self {
            from: vec![[0.0, -10.0, 0.0]],
            to: vec![[0.0; 3]],
            sky: [0.0, 0.0, 1.0],
            fov: 0.5,
            dof: 10.0,
            lens: 0.0,
            blur: 0.0,
            samples: 64,
            recursion: 3,
            settings: String::new(),
            plain: false,
        }
    }
}

impl Shot {
    /// Returns the text of a scene with this view.
    pub(crate) fn of(&self, elements: &str) -> String {
        let Self { fov, dof, lens, blur, samples, recursion, settings, .. } = self;
        let path = |name: &str, points: &[[f64; 3]]| {
            points.iter().map(|p| format!("{name} {} ", vector(*p))).collect::<String>()
        };
        let (from, to) = (path("addPosition", &self.from), path("addTarget", &self.to));
        let sky = vector(self.sky);
        format!(
            "settings s {{ imageSamples {samples} recursion {recursion} {settings} }}
             Camera c {{
                 fps 1
                 Film f {{ width 64 height 64 prefix test output PNG_IMAGE }}
                 CamSegment seg {{
                     videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
                     {from} {to} skyStart {sky}
                     fovStart {fov} dofStart {dof} lensRadiusStart {lens} blurDuration {blur}
                 }}
             }}
             {elements}"
        )
    }

    /// Renders a scene with this view.
    pub(crate) fn take(&self, elements: &str) -> Picture {
        Picture(self.film(&describe(&self.of(elements))).image())
    }

    /// Like `take`, with the layers of albedo and normals.
    pub(crate) fn take_layers(&self, elements: &str) -> [Picture; 3] {
        let mut scene = describe(&self.of(elements));
        scene.camera.film.layers = vec![Layer::Albedo, Layer::Normal];
        let film = self.film(&scene);
        let layer = |layer| Picture(film.layer_of(film.area(), layer));
        [Picture(film.image()), layer(&FileLayer::Albedo), layer(&FileLayer::Normal)]
    }

    /// Like `take`, with the light of two groups of lamps, named `a` and `b`.
    pub(crate) fn take_groups(&self, elements: &str) -> [Picture; 3] {
        let mut scene = describe(&self.of(elements));
        scene.camera.film.layers = vec![Layer::Lights];
        let film = self.film(&scene);
        let group =
            |name: &str| Picture(film.layer_of(film.area(), &FileLayer::Light(name.into())));
        [Picture(film.image()), group("a"), group("b")]
    }

    /// Renders frame 0 of a scene.
    pub(crate) fn film(&self, scene: &SceneDescription) -> Film {
        let frame = FrameScene::build(scene, 0, Isa::best()).expect("the frame can be built");
        let frame = if self.plain { frame.plain() } else { frame };
        expose_frame(scene, &frame)
    }
}

/// A vector block.
pub(crate) fn vector(v: [f64; 3]) -> String {
    format!("{{ {} {} {} }}", v[0], v[1], v[2])
}

/// A material with these `phong_info` attributes.
pub(crate) fn material(name: &str, phong: &str) -> String {
    format!(
        "phong_info {name}_info {{ {phong} }} material_phong {name} {{ phong_info {name}_info }}\n"
    )
}

/// A material that shows one colour, whatever the light.
pub(crate) fn glow(name: &str, color: [f64; 3]) -> String {
    material(name, &format!("ambient {}", vector(color)))
}

/// A rectangle with three consecutive corners; `more` holds further attributes.
pub(crate) fn rectangle(name: &str, material: &str, corners: [[f64; 3]; 3], more: &str) -> String {
    let [a, b, c] = corners.map(vector);
    format!(
        "rectangle {name} {{ material {material} vertex0 {a} vertex1 {b} vertex2 {c} {more} }}\n"
    )
}

/// A rectangle at depth `y` that faces a camera looking along y.
pub(crate) fn panel(name: &str, material: &str, x: [f64; 2], y: f64, z: [f64; 2]) -> String {
    rectangle(name, material, panel_corners(x, y, z), "")
}

/// The corners of a [`panel`].
pub(crate) fn panel_corners(x: [f64; 2], y: f64, z: [f64; 2]) -> [[f64; 3]; 3] {
    [[x[0], y, z[0]], [x[1], y, z[0]], [x[1], y, z[1]]]
}

/// A key frame with only a pivot.
pub(crate) fn pivot_at(time: f64, pivot: [f64; 3]) -> String {
    format!("addKframe {{ time {time} key {{ pivot {} }} }}", vector(pivot))
}

/// A rendered picture.
pub(crate) struct Picture(pub(crate) Image);

impl Picture {
    /// Returns the pixel in column `x` of row `y`, counted from the top.
    pub(crate) fn at(&self, x: usize, y: usize) -> [f64; 3] {
        self.0.rgb[y * self.0.width as usize + x].map(f64::from)
    }

    /// Returns one channel of every pixel of a row.
    pub(crate) fn row(&self, y: usize, channel: usize) -> Vec<f64> {
        (0..self.0.width as usize).map(|x| self.at(x, y)[channel]).collect()
    }

    /// Returns the mean of some rows in one channel, for each column.
    pub(crate) fn columns(&self, rows: std::ops::Range<usize>, channel: usize) -> Vec<f64> {
        let n = rows.len() as f64;
        (0..self.0.width as usize)
            .map(|x| rows.clone().map(|y| self.at(x, y)[channel]).sum::<f64>() / n)
            .collect()
    }

    /// Returns the sum of one channel over all pixels.
    pub(crate) fn sum(&self, channel: usize) -> f64 {
        self.0.rgb.iter().map(|p| f64::from(p[channel])).sum()
    }

    /// Asserts that every pixel has this colour, within `tolerance` for each channel.
    #[track_caller]
    pub(crate) fn assert_is(&self, color: [f64; 3], tolerance: f64) {
        for (i, pixel) in self.0.rgb.iter().enumerate() {
            let near = |c: usize| (f64::from(pixel[c]) - color[c]).abs() <= tolerance;
            assert!(
                (0..3).all(near),
                "pixel {}, {}: {pixel:?}, expected {color:?}",
                i % 64,
                i / 64
            );
        }
    }
}

impl Picture {
    /// Checks the mean of the whole picture, to a relative tolerance.
    #[track_caller]
    pub(crate) fn assert_mean(&self, color: [f64; 3], tolerance: f64) {
        let count = self.0.rgb.len() as f64;
        let mean = [0, 1, 2]
            .map(|c| self.0.rgb.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>() / count);
        let near = |c: usize| (mean[c] - color[c]).abs() <= tolerance * color[c];
        assert!((0..3).all(near), "the mean is {mean:?}, expected {color:?}");
    }
}

/// Mean of `f` over the pixel in column `x` of row `y`, sampled at 8 x 8 points. `f` takes film
/// coordinates from -1 to 1, y upward.
pub(crate) fn over_pixel(x: usize, y: usize, f: impl Fn(f64, f64) -> f64) -> f64 {
    let place = |pixel: usize, k: u32| (pixel as f64 + (f64::from(k) + 0.5) / 8.0) / 32.0 - 1.0;
    let sum: f64 = (0..64).map(|k| f(place(x, k % 8), -place(y, k / 8))).sum();
    sum / 64.0
}

/// Asserts that two rows of numbers agree within `tolerance` everywhere.
#[track_caller]
pub(crate) fn assert_profile(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= tolerance,
            "{a} at {i}, expected {b}\n{found:.3?}\n{expected:.3?}"
        );
    }
}
