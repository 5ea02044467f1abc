//! The integrators of one thread.

use slo_picture::film::Features;
use slo_scene::Integrator as Kind;

use super::account::Account;
use super::distributed::Distributed;
use super::machine::Machine;
use super::path::Path;
use super::photon_map::PhotonMapping;
use super::work::{Beside, Job, Traced, Work};
use crate::frame::FrameScene;

/// Working memory of one thread, allocated once and used for tile after tile. An integrator gets its
/// own when it is first needed.
#[derive(Debug, Default)]
pub struct Tracer {
    machine: Machine,
    distributed: Option<Distributed>,
    path: Option<Path>,
    photon_map: Option<PhotonMapping>,
    keeps_account: bool,
}

impl Tracer {
    /// Traces camera samples completely. Between batches it asks `gives_up`; it returns `None` if the
    /// answer is yes.
    pub fn trace(
        &mut self,
        frame: &FrameScene,
        work: &[Work],
        beside: Beside<'_>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Traced<'_>> {
        let (maps, light, guide) = (beside.maps, beside.light, frame.field());
        let job = Job { maps, light, guide, ..Job::new(frame, work, gives_up) };
        let Self { machine, distributed, path, photon_map, keeps_account } = self;
        let copies = if beside.features { 2 } else { 1 };
        let groups = if frame.is_physical { beside.light_groups } else { 0 };
        machine.begin(&frame.sampler, work, copies * (groups + 1));
        machine.count(frame, work);
        if *keeps_account {
            machine.keep_account(frame);
        }
        let feature_slots = if beside.features { work.len() } else { 0 };
        let stride = if groups > 0 { copies * work.len() } else { 0 };
        let (places, ids) = (beside.places, beside.ids);
        let (features, first_hits): (&[Features], _) =
            if frame.settings.integrator == Kind::PhotonMap {
                let photon_map = photon_map.get_or_insert_default();
                photon_map.restart(feature_slots, stride);
                photon_map.vertices.first_hits.reset(places, ids, work.len());
                machine.run(photon_map, &job)?;
                (photon_map.vertices.features(), &photon_map.vertices.first_hits)
            } else if frame.is_physical {
                let path = path.get_or_insert_default();
                path.vertices.restart(feature_slots, stride);
                path.vertices.first_hits.reset(places, ids, work.len());
                machine.run(path, &job)?;
                (path.vertices.features(), &path.vertices.first_hits)
            } else {
                let distributed = distributed.get_or_insert_default();
                distributed.restart(feature_slots);
                distributed.first_hits.reset(places, ids, work.len());
                machine.run(distributed, &job)?;
                (distributed.features(), &distributed.first_hits)
            };
        let (sums, groups, statistics) = machine.finish(work.len(), groups);
        let (places, seen) = first_hits.get();
        Some(Traced { sums, features, groups, places, seen, statistics })
    }

    /// Traces one camera sample and keeps an account of it. `beside` holds the photons that it uses.
    /// Returns `None` if `gives_up` says to give up.
    pub fn account(
        &mut self,
        frame: &FrameScene,
        work: Work,
        beside: Beside<'_>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Box<Account>> {
        self.keeps_account = true;
        let work = Work { count: 1, ..work };
        let Beside { maps, light, .. } = beside;
        let beside = Beside { maps, light, ..Beside::default() };
        let traced = self.trace(frame, &[work], beside, gives_up).map(|_| ());
        self.keeps_account = false;
        let account = self.machine.take_account();
        traced.and(account)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use slo_accel::Isa;
    use slo_accel::math::columns::BATCH;
    use slo_scene::{Files, load};

    use super::*;

    /// A glossy floor that reflects `lights` lights.
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
    fn queues_stay_bounded_however_many_rays_a_hit_sends() {
        for settings in [
            "softShadowSamples 300",
            "softShadowSamples 300 shadow TRANSPARENT",
            "diffuseReflectionSamples 4000",
        ] {
            let (frame, mut tracer) = (frame(settings, 1), Tracer::default());
            let work = if settings.starts_with("diffuse") { &work()[..2048] } else { &work() };
            let traced = tracer.trace(&frame, work, Beside::default(), &|| false).unwrap();
            let counts = traced.statistics;
            assert!(counts.shadow_rays + counts.bounce_rays > 100_000, "{settings}: {counts:?}");
            let (paths, connections) = tracer.machine.rooms();
            assert!(paths.iter().all(|&room| room <= 1100 * BATCH), "{settings}: {paths:?}");
            assert!(
                connections.iter().all(|&room| room <= 64 * BATCH),
                "{settings}: {connections:?}"
            );
        }
    }

    #[test]
    fn work_can_be_given_up_between_lights() {
        for settings in ["", "lightSamplingType SAMPLE_ONE_AT_TIME"] {
            let (frame, mut tracer) = (frame(settings, 500), Tracer::default());
            let asked = Cell::new(0);
            let gives_up = || {
                asked.set(asked.get() + 1);
                asked.get() >= 10
            };
            assert!(tracer.trace(&frame, &work(), Beside::default(), &gives_up).is_none());
            assert_eq!(asked.get(), 10, "{settings}");
            assert!(tracer.machine.finish(0, 0).2.shadow_rays < 20 * BATCH as u64, "{settings}");
            assert_eq!(tracer.machine.rooms(), (vec![], vec![0, 0]));
            // The same memory serves further work.
            let traced = tracer.trace(&frame, &work()[..64], Beside::default(), &|| false).unwrap();
            assert_eq!(traced.sums.len(), 64);
        }
    }
}
