//! Summary of a rendering, in one or a few lines.

use std::fmt::Write;
use std::time::Duration;

use super::done::{Done, Place, Size, Times};
use crate::cli::base::{Terminal, counted, human, megabytes};
use slo_accel::Isa;
use slo_render::render::{PhotonCounts, Statistics};
use slo_scene::Accelerator;
use slo_scene::cache::Uses;
use slo_scene::{SceneDescription, Settings};

/// Measurements of one run.
#[derive(Clone, Debug)]
pub(super) struct Summary {
    /// Number of frames that were rendered.
    pub(super) frames: usize,
    times: Times,
    /// Times of what was done beside rendering.
    beside: Times,
    /// Why frames were not built ahead.
    refused: Option<String>,
    /// Uses of the cache, if there is one.
    pub(super) cache: Option<Uses>,
    statistics: Statistics,
    /// Size of the last frame.
    size: Size,
    /// Pixels that are brighter than the film can say, of all frames.
    full_pixels: usize,
    /// Largest error of a frame.
    error: Option<f64>,
    isa: Isa,
}

impl Summary {
    /// Starts the summary of a run that has loaded its scene.
    pub(super) fn new(loading: Duration, isa: Isa) -> Self {
        let times = Times { loading, ..Times::default() };
        let (statistics, size) = (Statistics::default(), Size::default());
        let (beside, refused) = (Times::default(), None);
        Self {
            frames: 0,
            times,
            beside,
            refused,
            cache: None,
            statistics,
            size,
            full_pixels: 0,
            error: None,
            isa,
        }
    }

    /// Adds time spent waiting for pictures to be written.
    pub(super) fn waited(&mut self, time: Duration) {
        self.times.writing += time;
    }

    /// Adds time spent building frames beside rendering, and why this was not always done.
    pub(super) fn built_ahead(&mut self, time: Duration, refused: Option<String>) {
        self.beside.building += time;
        self.refused = refused;
    }

    /// Adds a frame.
    pub(super) fn add(&mut self, done: &Done, place: Place) {
        self.frames += 1;
        let mut times = done.times;
        if place == Place::Beside {
            self.beside.writing += times.writing;
            times.writing = Duration::ZERO;
        }
        self.times.add(&times);
        self.statistics += done.statistics;
        self.size = done.size;
        self.full_pixels += done.full_pixels;
        self.error = self.error.into_iter().chain(done.outcome.error).reduce(f64::max);
    }

    /// Prints the summary.
    pub(super) fn tell(&self, scene: &SceneDescription, terminal: Terminal) {
        let refused = self.statistics.refused_contributions;
        if refused > 0 {
            let samples = counted(refused, "sample");
            terminal.warn(match refused {
                1 => format!("{samples} was too bright for the film and was clamped, or was no number and was left out"),
                _ => format!("{samples} were too bright for the film and were clamped, or were no numbers and were left out"),
            });
        }
        if self.full_pixels > 0 {
            terminal.warn(too_bright(self.full_pixels));
        }
        let what = match self.frames {
            1 => "rendered".into(),
            frames => format!("{frames} frames rendered"),
        };
        let rates = line(self.times.rendering, &self.statistics, peak_memory());
        let error = self.error.map_or_else(String::new, |error| format!("; error {error:.2e}"));
        let time = human(self.times.total());
        terminal.note(format_args!("{what} in {time}{error}; {rates}"));
        for detail in self.details(scene) {
            terminal.detail(detail);
        }
    }

    fn details(&self, scene: &SceneDescription) -> Vec<String> {
        let Statistics { camera_rays, shadow_rays, bounce_rays, .. } = self.statistics;
        let Times { loading, building, photons: tracing, rendering, writing } = self.times;
        let film = &scene.camera.film;
        let pixels = f64::from(film.width) * f64::from(film.height) * self.frames as f64;
        let Settings { accelerator, spatial_splits, .. } = scene.settings;
        let has_spatial_splits = spatial_splits && accelerator == Accelerator::Bvh;
        let beside = self.beside;
        let is_beside = beside.total() > Duration::ZERO;
        let beside = is_beside.then(|| {
            let [building, writing] = [beside.building, beside.writing].map(human);
            format!("beside rendering: building {building}, writing {writing}")
        });
        let refused = self.refused.as_ref();
        let refused = refused.map(|why| format!("not all frames were built ahead: {why}"));
        let tracing = match tracing {
            Duration::ZERO => String::new(),
            _ => format!("photons {}, ", human(tracing)),
        };
        let phases = format!(
            "loading {}, building {}, {tracing}rendering {}, writing {}",
            human(loading),
            human(building),
            human(rendering),
            human(writing)
        );
        let gpu = crate::gpu::name().map(|name| format!(" on {name}"));
        let rest = [
            format!(
                "{}, {}; structures {}",
                counted(self.size.primitives, "primitive"),
                counted(self.size.moving_objects, "moving object"),
                megabytes(self.size.structures)
            ),
            format!(
                "rays: {camera_rays} camera ({:.2} per pixel), {shadow_rays} shadow, \
                 {bounce_rays} bounce",
                camera_rays as f64 / pixels.max(1.0)
            ),
            format!(
                "{}, {} instructions, {} structure{}{}",
                counted(rayon::current_num_threads(), "thread"),
                self.isa,
                scene.settings.accelerator,
                if has_spatial_splits { " with spatial splits" } else { "" },
                gpu.unwrap_or_default()
            ),
        ];
        let photons = photons(&self.statistics.photons);
        let cache =
            self.cache.map(|Uses { found, made }| format!("cache: {found} found, {made} written"));
        [phases]
            .into_iter()
            .chain(beside)
            .chain(refused)
            .chain(cache)
            .chain(rest)
            .chain(photons)
            .collect()
    }
}

/// Says how many pixels are brighter than the film can say.
fn too_bright(pixels: usize) -> String {
    let verb = if pixels == 1 { "is" } else { "are" };
    format!("{} {verb} brighter than the film can add up", counted(pixels, "pixel"))
}

/// Says what photons took; nothing if there were none.
fn photons(counts: &PhotonCounts) -> Option<String> {
    let &PhotonCounts { passes, paths, photons, records, memory } = counts;
    if paths == 0 {
        return None;
    }
    let mut line = String::from("photons: ");
    if passes > 0 {
        let _ = write!(line, "{passes} pass{}, ", if passes == 1 { "" } else { "es" });
    }
    let _ = write!(line, "{photons} from {}", counted(paths, "light path"));
    if records > 0 {
        let _ = write!(line, ", {} in the irradiance cache", counted(records, "record"));
    }
    let _ = write!(line, "; {} at a time", megabytes(memory as u64));
    Some(line)
}

fn line(rendering: Duration, rays: &Statistics, peak: Option<u64>) -> String {
    let rate = |rays: u64| rays as f64 / 1e6 / rendering.as_secs_f64().max(1e-6);
    let mut line = format!(
        "Mrays/s: {:.2} camera, {:.2} shadow, {:.2} bounce",
        rate(rays.camera_rays),
        rate(rays.shadow_rays),
        rate(rays.bounce_rays)
    );
    if let Some(peak) = peak {
        let _ = write!(line, "; {} of memory", megabytes(peak));
    }
    line
}

/// Returns the peak memory of this process in bytes, if the system reports it.
fn peak_memory() -> Option<u64> {
    peak_of(&std::fs::read_to_string("/proc/self/status").ok()?)
}

fn peak_of(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rays() -> Statistics {
        Statistics {
            camera_rays: 4_000_000,
            shadow_rays: 8_000_000,
            bounce_rays: 1_000_000,
            ..Statistics::default()
        }
    }

    #[test]
    fn one_line_tells_rates_and_memory() {
        let line = |peak| line(Duration::from_secs(4), &rays(), peak);
        insta::assert_snapshot!(line(Some(210_000_000)), @"Mrays/s: 1.00 camera, 2.00 shadow, 0.25 bounce; 210 MB of memory");
        insta::assert_snapshot!(line(None), @"Mrays/s: 1.00 camera, 2.00 shadow, 0.25 bounce");
    }

    #[test]
    fn one_line_tells_what_photons_took() {
        let light = PhotonCounts {
            passes: 0,
            paths: 81_920,
            photons: 9_712,
            records: 0,
            memory: 3_210_000,
        };
        let told = |counts| photons(&counts).unwrap_or_default();
        insta::assert_snapshot!(told(light), @"photons: 9712 from 81920 light paths; 3.2 MB at a time");
        insta::assert_snapshot!(told(PhotonCounts { records: 412, ..light }), @"photons: 9712 from 81920 light paths, 412 records in the irradiance cache; 3.2 MB at a time");
        insta::assert_snapshot!(told(PhotonCounts { passes: 1, ..light }), @"photons: 1 pass, 9712 from 81920 light paths; 3.2 MB at a time");
        assert_eq!(photons(&PhotonCounts::default()), None);
    }

    #[test]
    fn no_time_is_no_division_by_zero() {
        assert!(!line(Duration::ZERO, &rays(), None).contains("inf"));
    }

    #[test]
    fn pixels_that_are_too_bright_are_counted() {
        insta::assert_snapshot!(too_bright(1), @"1 pixel is brighter than the film can add up");
        insta::assert_snapshot!(too_bright(12), @"12 pixels are brighter than the film can add up");
    }

    #[test]
    fn the_system_tells_the_peak() {
        assert_eq!(peak_of("Name:\tx\nVmHWM:\t    2048 kB\nVmRSS:\t1 kB\n"), Some(2_097_152));
        assert_eq!(peak_of("VmHWM: many\n"), None);
        assert_eq!(peak_of(""), None);
    }
}
