//! The queues of one thread, and the order in which they are worked off.

use glam::Vec3;

use super::bounces::{Lobes, most_camera_rays};
use super::camera_rays::{CameraRays, Place};
use super::chosen::Chosen;
use super::features::FeatureSums;
use super::light_choice::LightChoice;
use super::lights::tries;
use super::points::Points;
use super::queue::{Batch, Habit, Labels, RayQueue, Sent, ShadowKind};
use super::sums::Sums;
use super::{Statistics, Traced, Work};
use crate::frame::{
    FrameScene, Look, NO_MATERIAL, SurfaceScratch, Surfaces, WorldHits, WorldScratch,
};
use crate::sampling::batch::SetPoints;
use crate::sampling::{PixelSeed, Purpose};
use crate::shading::AnyLight as Light;
use slo_accel::math::columns::{BATCH, Column, Vec3s};
use slo_accel::{Coherence, Lanewise, NO_HIT};
use slo_scene::ShadowMode;

/// Working memory of one thread: allocated once, used for tile after tile.
#[derive(Debug, Default)]
pub struct Wave {
    /// Rays by the number of bounces behind them; none wait at the first place, which is the
    /// camera's.
    pub(super) bounces: Vec<RayQueue>,
    camera_habit: Habit,
    /// Rays to lights, by [`ShadowKind`].
    pub(super) shadows: [RayQueue; 2],
    /// Seed of the pixel of each slot.
    seeds: Vec<PixelSeed>,
    counts: Statistics,
    sums: Box<Sums>,
    pub(super) features: FeatureSums,
    camera_rays: Box<CameraRays>,
    batch: Box<Batch>,
    /// What the rays of the batch see, as words of [`Look`].
    looks: Box<Looks>,
    ended: Box<Ended>,
    found: WorldHits,
    blocked: Vec<bool>,
    scratch: WorldScratch,
    surface_scratch: Box<SurfaceScratch>,
    pub(super) points: Box<Points>,
    /// Where rays to lights pass through.
    passed: Box<Surfaces>,
    pub(super) lobes: Box<Lobes>,
    pub(super) set: Box<SetPoints>,
    pub(super) choice: Box<LightChoice>,
    pub(super) sent: Box<Sent>,
    pub(super) next: Box<Labels>,
    pub(super) chosen: Chosen,
}

impl Wave {
    /// Traces camera samples to the end; `with_features`: notes what is seen of surfaces too. `None` if
    /// it was told to give up, which it asks about between batches.
    pub fn trace(
        &mut self,
        frame: &FrameScene,
        work: &[Work],
        with_features: bool,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Traced<'_>> {
        self.counts = Statistics::default();
        self.seeds.clear();
        self.seeds.extend(work.iter().map(|w| frame.sampler.pixel(w.x, w.y)));
        if with_features {
            self.seeds.extend_from_within(..);
        }
        self.sums.reset(self.seeds.len());
        self.features.reset(if with_features { work.len() } else { 0 });
        let is_done = self.trace_all(frame, work, gives_up);
        if is_done.is_none() {
            self.bounces.clear();
            self.shadows = Default::default();
            return None;
        }
        self.sums.fold(work.len());
        let Self { sums, features, counts, .. } = self;
        Some(Traced { sums: sums.get(), features: features.get(), statistics: *counts })
    }

    fn trace_all(
        &mut self,
        frame: &FrameScene,
        work: &[Work],
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let most = most_camera_rays(&frame.settings);
        let mut place = Place::default();
        loop {
            let Self { camera_rays, seeds, batch, .. } = self;
            camera_rays.fill(frame, work, seeds, &mut place, most, batch);
            if self.batch.rays.is_empty() {
                break;
            }
            self.counts.camera_rays += self.batch.rays.len() as u64;
            self.trace_batch(frame, 0, gives_up)?;
            self.work_off(frame, BATCH, gives_up)?;
        }
        self.work_off(frame, 1, gives_up)
    }

    /// Traces batches until no queue holds `least` rays or more; `None` if told to give up.
    ///
    /// While more rays are to come the deepest full queue goes first, which bounds what waits; at
    /// the end, where all are below a batch, the shallowest goes first, since it fills the others.
    fn work_off(
        &mut self,
        frame: &FrameScene,
        least: usize,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        use ShadowKind::{FromDeeper, FromPrimary};
        loop {
            if gives_up() {
                return None;
            }
            let shadows =
                |least| [FromPrimary, FromDeeper].into_iter().find(|&k| self.waiting(k) >= least);
            let deepest = self.bounces.iter().rposition(|queue| queue.len() >= BATCH);
            let shallowest = || self.bounces.iter().position(|queue| queue.len() >= least);
            if let Some(kind) = shadows(BATCH) {
                self.trace_shadows(frame, kind);
            } else if let Some(depth) = deepest.or_else(shallowest) {
                self.bounces[depth].take_batch(&mut self.batch);
                self.counts.bounce_rays += self.batch.rays.len() as u64;
                self.trace_batch(frame, depth as u32, gives_up)?;
            } else if let Some(kind) = shadows(least) {
                self.trace_shadows(frame, kind);
            } else {
                return Some(());
            }
        }
    }

    pub(super) fn waiting(&self, kind: ShadowKind) -> usize {
        self.shadows[kind as usize].len()
    }

    /// Traces the batch, adds what its rays bring, and queues the rays that its hits send out; `None`
    /// if told to give up.
    fn trace_batch(
        &mut self,
        frame: &FrameScene,
        depth: u32,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let Self { batch, found, scratch, camera_habit, bounces, .. } = self;
        let habit = match depth {
            0 => camera_habit,
            _ => &mut bounces[depth as usize].habit,
        };
        let (rays, time, expected) = (&batch.rays, &batch.labels.time, habit.expected());
        habit.learn(expected, frame.world.intersect(rays, time, expected, found, scratch));
        self.sort_hits(frame, depth);
        self.find_points(frame);
        let Self { sums, ended, points, .. } = self;
        let mut refused = sums.add(frame.isa, &ended.brings, &ended.slot, ended.len);
        if frame.material_table.has_ambient {
            let (slot, len) = (&points.labels.slot, points.surfaces.len);
            refused += sums.add(frame.isa, &points.ambient, slot, len);
        }
        self.counts.refused_contributions += refused;
        if self.features.are_wanted() {
            let Self { features, batch, looks, points, .. } = self;
            features.add(frame, batch, &looks.0, points);
        }
        let glossy = self.find_lobes(frame, depth);
        self.ask_lights(frame, glossy, depth, gives_up)?;
        if glossy {
            self.bounce(frame, depth, gives_up)?;
        }
        Some(())
    }

    /// Notes what rays bring that end, and the hits that are to be shaded.
    fn sort_hits(&mut self, frame: &FrameScene, depth: u32) {
        let background = Vec3::from(frame.settings.background);
        let Self { batch, found, looks, chosen, ended, points, .. } = self;
        let len = batch.rays.len().min(BATCH);
        frame.find_looks(found, &mut looks.0);
        chosen.set(frame.isa, len, |i| Look::is_material(looks.0[i]));
        points.surfaces.len = chosen.len();
        chosen.copy(&NUMBERS, &mut points.surfaces.ray[..chosen.len()]);
        chosen.copy(&looks.0, &mut points.surfaces.material[..chosen.len()]);
        ended.len = 0;
        for i in chosen.others(len) {
            let (color, share) = match Look::of_word(looks.0[i]) {
                Look::Light(light) => {
                    let light = &frame.lights[light as usize];
                    let way = batch.rays.direction(i) * found.hits.t[i];
                    (light.color, lobe_share(frame, light, way, batch.density[i], depth))
                }
                _ => (background, 1.0),
            };
            ended.push(batch.weight.get(i) * color * share, batch.labels.slot[i]);
        }
    }

    /// Finds everything about the hits that are to be shaded: those that were chosen.
    fn find_points(&mut self, frame: &FrameScene) {
        let Self { batch, found, points, surface_scratch, seeds, chosen, .. } = self;
        let (rays, time) = (&batch.rays, &batch.labels.time);
        frame.find_surfaces(rays, time, found, &mut points.surfaces, surface_scratch);
        points.gather(frame, batch, chosen, seeds);
    }

    /// Traces a batch of rays to lights. Leaves the points as they are, since their hits may be about
    /// to send others.
    pub(super) fn trace_shadows(&mut self, frame: &FrameScene, kind: ShadowKind) {
        self.shadows[kind as usize].take_batch(&mut self.batch);
        self.counts.shadow_rays += self.batch.rays.len() as u64;
        let expected = self.shadows[kind as usize].habit.expected();
        let found = match frame.settings.shadow {
            ShadowMode::Opaque => self.trace_opaque_shadows(frame, expected),
            ShadowMode::Transparent => self.trace_transparent_shadows(frame, expected, kind),
        };
        self.shadows[kind as usize].habit.learn(expected, found);
        let Self { sums, batch, .. } = self;
        self.counts.refused_contributions +=
            sums.add(frame.isa, &batch.weight, &batch.labels.slot, batch.rays.len());
    }

    /// Leaves nothing of the light of blocked rays; comes back with how alike the rays were.
    fn trace_opaque_shadows(&mut self, frame: &FrameScene, expected: Coherence) -> Coherence {
        let Self { batch, blocked, scratch, .. } = self;
        let (rays, time) = (&batch.rays, &batch.labels.time);
        let coherence = frame.world.occluded(rays, time, expected, blocked, scratch);
        frame.isa.run(Darken { blocked, light: &mut batch.weight });
        coherence
    }

    /// Leaves nothing of the light of rays that hit; one that meets a refractive object goes on
    /// behind it, weaker. Comes back with how alike the rays were.
    fn trace_transparent_shadows(
        &mut self,
        frame: &FrameScene,
        expected: Coherence,
        kind: ShadowKind,
    ) -> Coherence {
        let Self { batch, found, scratch, passed: surfaces, surface_scratch, .. } = self;
        let Self { sent, next, chosen, .. } = self;
        let (rays, time) = (&batch.rays, &batch.labels.time);
        let coherence = frame.world.intersect(rays, time, expected, found, scratch);
        surfaces.len = 0;
        for i in 0..batch.rays.len().min(BATCH) {
            let primitive = found.hits.primitive[i];
            if primitive == NO_HIT {
                continue;
            }
            let light = batch.weight.get(i);
            batch.weight.set(i, Vec3::ZERO);
            if let Some(passed) = frame.light_passed(primitive, found.instance[i]) {
                sent.weight.set(surfaces.len, light * passed);
                surfaces.push(i, NO_MATERIAL);
            }
        }
        let (rays, time) = (&batch.rays, &batch.labels.time);
        frame.find_surfaces(rays, time, found, surfaces, surface_scratch);
        for i in 0..surfaces.len.min(BATCH) {
            let ray = surfaces.ray[i] as usize;
            let (origin, direction) = (rays.origin(ray), rays.direction(ray));
            let from = surfaces.leave(i, direction);
            // The rest of the way ends where it ended before.
            sent.origin.set(i, from);
            sent.direction.set(i, origin + direction * rays.t_max[ray] - from);
            sent.t_max[i] = 1.0;
            next.time[i] = time[ray];
            next.slot[i] = batch.labels.slot[ray];
        }
        chosen.set(frame.isa, surfaces.len, |_| true);
        self.shadows[kind as usize].append(sent, next, chosen);
        coherence
    }

    /// The first `D` random numbers of ray `i` of `count` from every point, `depth` bounces behind
    /// the camera.
    pub(super) fn draw<const D: usize>(
        &mut self,
        frame: &FrameScene,
        depth: u32,
        purpose: Purpose,
        [i, count]: [u32; 2],
    ) {
        let names = self.points.names(&frame.settings, depth, purpose, [i, count]);
        self.set.take::<D>(&frame.sampler, frame.isa, &names);
    }

    /// Makes sure that there is a queue for rays with `depth` bounces behind them.
    pub(super) fn queue_at(&mut self, depth: usize) {
        if self.bounces.len() <= depth {
            self.bounces.resize_with(depth + 1, RayQueue::default);
        }
    }
}

/// Makes the light of blocked rays 0.
struct Darken<'a> {
    blocked: &'a [bool],
    light: &'a mut Vec3s,
}

impl Lanewise for Darken<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Vec3s { x, y, z } = self.light;
        for column in [x, y, z] {
            for (light, &blocked) in column.iter_mut().zip(self.blocked) {
                *light = if blocked { 0.0 } else { *light };
            }
        }
    }
}

/// Numbers of the rays of a batch.
static NUMBERS: Column<u32> = {
    let mut numbers = [0; BATCH];
    let mut i = 0;
    while i < BATCH {
        numbers[i] = i as u32;
        i += 1;
    }
    numbers
};

/// See [`Look`].
#[derive(Debug)]
struct Looks(Column<u32>);

impl Default for Looks {
    fn default() -> Self {
        Self([0; BATCH])
    }
}

/// What rays of a batch bring that are not shaded: those to the background and to lights.
#[derive(Debug)]
struct Ended {
    brings: Vec3s,
    slot: Column<u32>,
    len: usize,
}

impl Default for Ended {
    fn default() -> Self {
        Self { brings: Vec3s::default(), slot: [0; BATCH], len: 0 }
    }
}

impl Ended {
    #[inline(always)]
    fn push(&mut self, brings: Vec3, slot: u32) {
        self.brings.set(self.len, brings);
        self.slot[self.len] = slot;
        self.len += 1;
    }
}

/// What a ray of a lobe counts that finds a lamp at the end of `way`, `depth` bounces behind the
/// camera, where rays to the lamp look for the same light, and take the rest of it.
fn lobe_share(frame: &FrameScene, light: &Light, way: Vec3, density: f32, depth: u32) -> f32 {
    if density == 0.0 {
        return 1.0;
    }
    density / (density + tries(frame, light, depth - 1) * light.density(way))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use slo_accel::Isa;
    use slo_scene::{Files, load};

    /// A floor under lights that are seen in it.
    fn frame(settings: &str, lights: usize) -> FrameScene {
        let light = "light_rectangle l { color { 1 1 1 }
            vertex0 { 3 -6 6 } vertex1 { 5 -6 6 } vertex2 { 5 -4 6 } }";
        let text = format!(
            "settings s {{ imageSamples 1 {settings} }}
             Camera c {{ fps 25 Film f {{ width 32 height 32 }}
                 CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 3 -6 3 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
             {}
             phong_info p {{ diffuse {{ .8 .1 .1 }} reflectance .5 diffuse_reflection .5 }}
             material_phong p {{ phong_info p }}
             plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 0 }} material p }}",
            light.repeat(lights)
        );
        let loaded = load("scene.txt", text.as_bytes(), &Files::built_in("", &[]));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        FrameScene::build(&scene, 0, Isa::best()).unwrap()
    }

    fn work() -> Vec<Work> {
        (0..4096).map(|i| Work { x: i % 32, y: i / 32 % 32, first: i / 1024, count: 1 }).collect()
    }

    #[test]
    fn what_waits_is_bounded_however_many_rays_a_hit_sends() {
        for settings in [
            "softShadowSamples 300",
            "softShadowSamples 300 shadow TRANSPARENT",
            "diffuseReflectionSamples 4000",
        ] {
            let (frame, mut wave) = (frame(settings, 1), Wave::default());
            let work = if settings.starts_with("diffuse") { &work()[..2048] } else { &work() };
            let traced = wave.trace(&frame, work, false, &|| false).unwrap();
            let counts = traced.statistics;
            assert!(counts.shadow_rays + counts.bounce_rays > 100_000, "{settings}: {counts:?}");
            let most = |depth: usize| if depth == 0 { 64 * BATCH } else { 1100 * BATCH };
            let rooms = wave.shadows.iter().map(|queue| (0, queue.room()));
            let bounces = wave.bounces.iter().map(|queue| (1, queue.room()));
            for (depth, room) in rooms.chain(bounces) {
                assert!(room <= most(depth), "{settings}: {room}");
            }
        }
    }

    #[test]
    fn giving_up_is_asked_about_between_lights() {
        for settings in ["", "lightSamplingType SAMPLE_ONE_AT_TIME"] {
            let (frame, mut wave) = (frame(settings, 500), Wave::default());
            let asked = Cell::new(0);
            let gives_up = || {
                asked.set(asked.get() + 1);
                asked.get() >= 10
            };
            assert!(wave.trace(&frame, &work(), false, &gives_up).is_none());
            assert_eq!(asked.get(), 10, "{settings}");
            assert!(wave.counts.shadow_rays < 20 * BATCH as u64, "{settings}");
            assert!(wave.shadows.iter().all(|queue| queue.len() == 0));
            // The same memory serves on.
            let traced = wave.trace(&frame, &work()[..64], false, &|| false).unwrap();
            assert_eq!(traced.sums.len(), 64);
        }
    }
}
