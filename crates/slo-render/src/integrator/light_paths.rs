//! Light paths: photons, from lamps through sharp lobes to rough ones; under `PHOTON_MAP` also on from
//! there.

use std::ops::Range;

use super::batch::Batch;
use super::machine::{Integrator, Machine};
use super::photon_pass::PhotonPass;
use super::stages::bsdfs::Bsdfs;
use super::stages::departure::{Departure, Flux};
use super::stages::deposit::Deposits;
use super::stages::hits::Hits;
use super::stages::landing::Landing;
use super::stages::passing::Passing;
use super::stages::photon_bounce::PhotonBounce;
use super::stages::points::Points;
use super::work::Job;
use crate::frame::FrameScene;
use crate::photons::{Deposit, Photon};
use crate::sampling::PixelSeed;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
struct LightPaths {
    flux: Flux,
    departure: Departure,
    batch: Box<Batch>,
    hits: Box<Hits>,
    points: Box<Points>,
    passing: Box<Passing>,
    bsdfs: Box<Bsdfs>,
    landing: Box<Landing>,
    deposits: Box<Deposits>,
    bounce: Box<PhotonBounce>,
}

/// Traces the light paths of one thread.
#[derive(Debug, Default)]
pub struct PhotonTracer {
    machine: Machine,
    paths: LightPaths,
}

impl PhotonTracer {
    /// Traces light paths of a pass, by their numbers. Returns the photons with their times, in an
    /// order that depends on the range alone; `None` if `gives_up` says to give up.
    pub fn trace(
        &mut self,
        frame: &FrameScene,
        pass: PhotonPass,
        range: Range<u32>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Vec<(f32, Photon)>> {
        let done = self.run(frame, Flux::Pass(pass), range, gives_up);
        let found = self.paths.landing.take();
        done.map(|()| found)
    }

    /// Traces light paths of `PHOTON_MAP`, by their numbers. Returns the photons in the order of their
    /// light paths; `None` if `gives_up` says to give up.
    pub fn deposits(
        &mut self,
        frame: &FrameScene,
        flux: Flux,
        range: Range<u32>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Vec<Deposit>> {
        let only_missing = flux == Flux::Everywhere && !frame.settings.gather;
        self.paths.deposits.restart(only_missing);
        let done = self.run(frame, flux, range, gives_up);
        let found = self.paths.deposits.take();
        done.map(|()| found)
    }

    fn run(
        &mut self,
        frame: &FrameScene,
        flux: Flux,
        range: Range<u32>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let job = Job::new(frame, &[], gives_up);
        let Self { machine, paths } = self;
        let kind = match flux {
            Flux::Pass(_) => 0,
            Flux::Everywhere => 8,
            Flux::Caustics => 16,
        };
        let seed = frame.photon_sampler.pixel(u32::MAX - kind, u32::MAX);
        machine.begin_light_paths(seed, frame.lights.len());
        paths.flux = flux;
        paths.departure.restart(flux, range, seed);
        machine.run(paths, &job)
    }
}

/// The numbers of hits are those of paths after so many bounces more: those of the first two belong
/// to the departure.
const NAMED: u32 = 2;

impl Integrator for LightPaths {
    fn start(&mut self, job: &Job<'_>, _: &[PixelSeed]) -> Option<u32> {
        self.departure.fill(job.frame, &mut self.batch).then_some(0)
    }

    fn batch(&mut self) -> &mut Batch {
        &mut self.batch
    }

    /// Traces the batch, stores its photons, and queues the rays that go on.
    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let frame = job.frame;
        let Self { flux, batch, hits, points, passing, bsdfs, .. } = self;
        let Self { landing, deposits, bounce, .. } = self;
        machine.find_hits(job, batch, hits, depth);
        // Only the camera passes through lamps that it does not see.
        if frame.has_passable_lamps(depth + 1) {
            passing.lamps(frame, batch, hits, depth + 1);
            passing.queue(machine, depth);
        }
        let table = &frame.material_table;
        points.find(frame, batch, hits, machine.seeds());
        points.choose_materials(frame, &frame.photon_sampler, depth + NAMED);
        bsdfs.look_up(frame, points);
        if table.absorbs {
            bsdfs.absorb(batch, points);
        }
        if table.images.any_passes() {
            bsdfs.let_pass(points);
            passing.surfaces(frame, batch, points);
            passing.queue(machine, depth);
        }
        bsdfs.find(frame, points, true);
        let rough = flux.follows_rough();
        match flux {
            Flux::Pass(pass) if depth > 0 => {
                landing.store(frame, (batch, hits), points, bsdfs, (depth, pass.slabs()));
            }
            Flux::Pass(_) => {}
            Flux::Everywhere | Flux::Caustics => {
                if rough || depth > 0 {
                    deposits.store(frame, batch, points, bsdfs);
                }
            }
        }
        if depth < frame.settings.recursion() {
            bounce.send(frame, batch, points, bsdfs, (depth + NAMED, rough));
            if depth == 0 && rough && frame.has_shaded_lights() {
                bounce.kindle(frame, batch, hits, points, bsdfs);
            }
            let PhotonBounce { sent, labels, past, chosen, .. } = &**bounce;
            machine.extend_path(depth + 1, sent, labels, past, chosen);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use slo_accel::Isa;
    use slo_scene::{Files, load};

    use super::*;
    use crate::photons::{FluxMap, Nearest, Rule};

    fn frame(elements: &str) -> FrameScene {
        let text = format!(
            "settings s {{ integrator PATH photons 1 imageSamples 1 recursion 30 }}
             Camera c {{ fps 25 Film f {{ width 64 height 64 }}
                 CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 0 -3.9 0 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
             material_principled wall {{ base_color {{ .5 .5 .5 }} ior 1 specular_ior_level 0 }}
             material_principled glass {{ base_color {{ 1 1 1 }} roughness 0 transmission 1 }}
             material_principled mirror {{ base_color {{ 1 1 1 }} roughness 0 metallic 1 }}
             box room {{ vertex0 {{ -4 -4 -4 }} vertex1 {{ 4 -4 -4 }} vertex2 {{ 4 4 -4 }} height 8 material wall }}
             {elements}"
        );
        build(&text)
    }

    fn build(text: &str) -> FrameScene {
        let loaded = load("scene.txt", text.as_bytes(), &Files::built_in("", &[]));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        FrameScene::build(&scene, 0, Isa::best()).unwrap()
    }

    fn photons(frame: &FrameScene, paths: u32) -> Vec<(f32, Photon)> {
        let pass = PhotonPass { paths, ..PhotonPass::new(frame, 0) };
        PhotonTracer::default().trace(frame, pass, 0..paths, &|| false).unwrap()
    }

    /// Light of power 8 pi that meets a ball of radius 0.5 in a distance of 2.
    #[test]
    fn all_light_that_meets_something_sharp_is_stored_once() {
        let share = 0.5 * (1.0 - (1.0f64 - 0.25 * 0.25).sqrt());
        for lamp in [
            "lamp_point l { power { 8 8 8 } position { 2 0 0 } }",
            "lamp_point l { power { 8 8 8 } position { 2 0 0 } radius .001 }",
        ] {
            for material in ["mirror", "glass"] {
                let ball =
                    format!("sphere b {{ center {{ 0 0 0 }} radius .5 material {material} }}");
                let frame = frame(&format!("{lamp} {ball}"));
                let found = photons(&frame, 1 << 16);
                let power: f64 = found.iter().map(|(_, p)| f64::from(p.power.x)).sum();
                let power = power / f64::from(1 << 16);
                let expected = 8.0 * share;
                assert!(
                    (power / expected - 1.0).abs() < 0.01,
                    "{lamp}, {material}: {power}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn light_of_the_sky_does_not_pass_walls() {
        // The room is as large as everything that rays can hit.
        for lamp in [
            "lamp_sun l { irradiance { 3 3 3 } direction { .2 .3 -1 } }",
            "lamp_sun l { irradiance { 3 3 3 } direction { 0 0 -1 } angle_deg 0 }",
            "environment l { radiance { 1 1 1 } }",
        ] {
            let ball = "sphere b { center { 0 0 0 } radius .5 material mirror }";
            let frame = frame(&format!("{lamp} {ball}"));
            assert!(photons(&frame, 1 << 12).is_empty(), "{lamp}");
        }
    }

    #[test]
    fn a_glossy_ground_leaves_photons_for_small_things() {
        let text = "settings s { integrator PATH photons 1 imageSamples 1 }
            Camera c { fps 25 Film f { width 64 height 64 }
                CamSegment a { videoStart 0 videoEnd 1 addPosition { 0 -6 3 } addTarget { 0 0 0 } fovStart .3 } }
            material_principled ground { roughness .3 }
            material_principled glass { base_color { 1 1 1 } roughness 0 transmission 1 }
            lamp_sun l { irradiance { 3 3 3 } direction { 0 .3 -1 } }
            plane g { normal { 0 0 1 } position { 0 0 0 } material ground }
            sphere b { center { 0 0 1 } radius .5 material glass }";
        let frame = build(text);
        let found = photons(&frame, 1 << 12);
        assert!(found.len() > 1 << 10, "{} of 4096 light paths", found.len());
    }

    /// A lamp of 100 W in the middle of a sphere of radius 2, with an albedo of one half.
    fn sphere(settings: &str) -> FrameScene {
        let text = format!(
            "settings s {{ integrator PHOTON_MAP imageSamples 1 {settings} }}
             Camera c {{ fps 25 Film f {{ width 64 height 64 }}
                 CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 0 -1 0 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
             material_principled wall {{ base_color {{ .5 .5 .5 }} ior 1 specular_ior_level 0 }}
             sphere s {{ center {{ 0 0 0 }} radius 2 material wall }}
             lamp_point l {{ power {{ 100 100 100 }} position {{ 0 0 0 }} }}"
        );
        build(&text)
    }

    const PATHS: u32 = 1 << 15;

    fn all_photons(frame: &FrameScene) -> Vec<Deposit> {
        PhotonTracer::default().deposits(frame, Flux::Everywhere, 0..PATHS, &|| false).unwrap()
    }

    fn flux(deposits: &[Deposit]) -> f64 {
        deposits.iter().map(|deposit| f64::from(deposit.power.x)).sum::<f64>() / f64::from(PATHS)
    }

    #[test]
    fn flux_is_a_geometric_series() {
        let all = all_photons(&sphere(""));
        assert!((flux(&all) / 200.0 - 1.0).abs() < 0.01, "{}", flux(&all));
        // What comes from the lamp at once is left out where rays to lamps bring it.
        let indirect = all_photons(&sphere("gather 0"));
        assert!((flux(&indirect) / 100.0 - 1.0).abs() < 0.02, "{}", flux(&indirect));
        // Roulette keeps the power.
        let powers = all.iter().map(|deposit| deposit.power.x);
        assert!(powers.into_iter().all(|power| (power - 100.0).abs() < 0.01));
    }

    #[test]
    fn irradiance_in_a_sphere_is_that_of_the_formula_for_any_number_of_photons() {
        let frame = sphere("recursion 0 generatorType PSEUDO");
        let all = all_photons(&frame);
        assert_eq!(all.len(), PATHS as usize, "every photon arrives once");
        let map = FluxMap::new(&all, PATHS as f32, None, 200);
        let expected = 100.0 / (4.0 * std::f32::consts::PI * 4.0);
        for nearest in [3, 20, 200] {
            for cone in [false, true] {
                let (mut sum, mut found) = (0.0, Nearest::default());
                let points = (0..map.len()).step_by(8);
                let count = points.len() as f32;
                for i in points {
                    let (point, normal, _) = map.photon(i);
                    // The camera is the origin of render space.
                    let inward = (Vec3::Y - point) * 0.5;
                    assert!((normal - inward).length() < 1e-3, "{normal} at {point}");
                    let rule = Rule { nearest, cone, ends: true };
                    let light = map.irradiance(point, normal, rule, i as u32, &mut found).light;
                    assert!(light.is_finite() && light != Vec3::ZERO);
                    sum += light.x;
                }
                let mean = sum / count;
                assert!((mean / expected - 1.0).abs() < 0.06, "{nearest}, {cone}: {mean}");
            }
        }
    }
}
