//! Values for tests.

use std::path::PathBuf;

use super::job::{Existing, Job};
use super::overrides::Overrides;
use crate::cli::values::{Maps, Order, ProgressForm};
use slo_accel::Isa;
use slo_scene::{Camera, Film, SceneDescription, Settings};

/// Makes a scene with nothing in it.
pub(crate) fn empty_scene() -> SceneDescription {
    let mut film = Film::default();
    (film.width, film.height) = (32, 18);
    film.prefix = "empty_".into();
    SceneDescription {
        settings: Settings::default(),
        camera: Camera { fps: 25.0, film, segments: Vec::new() },
        lights: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        objects: Vec::new(),
        copies: Vec::new(),
        spaces: Vec::new(),
        content_hash: [0; 32],
    }
}

/// Makes the job of a command line without arguments.
pub(crate) fn job() -> Job {
    Job {
        scene: None,
        indir: None,
        allow_outside: false,
        frames: None,
        order: Order::default(),
        share: None,
        region: None,
        part: None,
        outdir: PathBuf::new(),
        info: false,
        existing: Existing::default(),
        checkpoint: None,
        keep_state: false,
        maps: Maps::default(),
        guide_file: None,
        display_server: None,
        time: None,
        total_time: None,
        steps: None,
        dry_run: false,
        watch: false,
        progress: ProgressForm::default(),
        overrides: Overrides::default(),
        threads: None,
        cache: None,
        isa: Isa::Portable,
    }
}
