//! Irradiance at points, gathered by rays: the records of the irradiance cache.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::batch::Batch;
use super::machine::Machine;
use super::photon_map::PhotonMapping;
use super::stages::bsdfs::Bsdfs;
use super::stages::camera_rays::CameraRays;
use super::stages::hemispheres::Probe;
use super::stages::hits::Hits;
use super::stages::points::Points;
use super::work::{Job, Work};
use crate::frame::FrameScene;
use crate::photons::{CacheRecord, Gathered, Grid, PhotonLight};

/// Rays of a round, at most.
const ROUND: u32 = 256;

/// Error, in pixels, at which records need not lie closer together.
const LEAST_PIXELS: f32 = 1.0;

/// Marks of points.
#[derive(Debug)]
struct Marks(Column<u32>);

impl Default for Marks {
    fn default() -> Self {
        Self([0; BATCH])
    }
}

/// Gathers irradiance on one thread.
#[derive(Debug, Default)]
pub struct HemisphereTracer {
    machine: Machine,
    photon_map: PhotonMapping,
    camera_rays: Box<CameraRays>,
    batch: Box<Batch>,
    hits: Box<Hits>,
    points: Box<Points>,
    bsdfs: Box<Bsdfs>,
    is_diffuse: Box<Marks>,
}

impl HemisphereTracer {
    /// Finds the points that camera samples see which have diffuse lobes. `None` stands for others.
    pub fn probes(&mut self, frame: &FrameScene, work: &[Work]) -> Vec<Option<Probe>> {
        let Self { machine, camera_rays, batch, hits, points, bsdfs, is_diffuse, .. } = self;
        let job = Job::new(frame, work, &|| false);
        machine.begin(&frame.sampler, work, 1);
        camera_rays.restart();
        let mut probes = vec![None; work.len()];
        loop {
            camera_rays.fill(&job, machine.seeds(), usize::MAX, batch);
            if batch.len() == 0 {
                return probes;
            }
            if !hits.take_texels(frame, batch, camera_rays) {
                machine.find_hits(&job, batch, hits, 0);
            }
            points.find(frame, batch, hits, machine.seeds());
            points.choose_materials(frame, &frame.sampler, 0);
            bsdfs.look_up(frame, points);
            bsdfs.find(frame, points, true);
            bsdfs.find_diffuse(frame, points, &mut is_diffuse.0);
            for i in (0..points.len()).filter(|&i| is_diffuse.0[i] == 1) {
                let slot = points.labels.slot[i] as usize;
                probes[slot] = Some(points.probe(frame, batch, i, machine.seeds()[slot]));
            }
        }
    }

    /// Gathers the irradiance at points, in rounds, until it changes little. Returns `None` if
    /// `gives_up` says to give up.
    pub fn records(
        &mut self,
        frame: &FrameScene,
        light: &PhotonLight,
        probes: &[Probe],
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Vec<CacheRecord>> {
        let settings = &frame.settings;
        let grid = Grid::of(settings.gather_rays.min(ROUND));
        let rounds = (settings.gather_rays / grid.rays()).max(1);
        let mut rays: Vec<Vec<Vec<Gathered>>> = vec![Vec::new(); probes.len()];
        let mut open: Vec<usize> = (0..probes.len()).collect();
        for round in 0..rounds {
            let asked: Vec<Probe> = open.iter().map(|&i| probes[i]).collect();
            let found = self.round(frame, light, &asked, (grid, round), gives_up)?;
            for (&i, found) in open.iter().zip(found.chunks(grid.rays() as usize)) {
                rays[i].push(found.to_vec());
            }
            open.retain(|&i| changes(&rays[i], settings.gather_limit));
            if open.is_empty() {
                break;
            }
        }
        let record = |(probe, rounds): (&Probe, &Vec<Vec<Gathered>>)| {
            let rounds: Vec<&[Gathered]> = rounds.iter().map(|round| &round[..]).collect();
            let least = LEAST_PIXELS * probe.width / settings.cache_error;
            CacheRecord::new(probe.point, probe.normal, least, grid, &rounds)
        };
        Some(probes.iter().zip(&rays).map(record).collect())
    }

    fn round(
        &mut self,
        frame: &FrameScene,
        light: &PhotonLight,
        probes: &[Probe],
        (grid, round): (Grid, u32),
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Vec<Gathered>> {
        let Self { machine, photon_map, .. } = self;
        let job = Job { light: Some(light), ..Job::new(frame, &[], gives_up) };
        let rays = grid.rays() as usize;
        machine.begin_slots(probes.iter().flat_map(|probe| std::iter::repeat_n(probe.seed, rays)));
        photon_map.restart_hemispheres(probes, grid, round);
        machine.run(photon_map, &job)?;
        let (sums, _, _) = machine.finish(probes.len() * rays, 0);
        let distances = photon_map.distances();
        let gathered = sums.iter().zip(distances).map(|(sum, &distance)| Gathered {
            light: Vec3::from(sum.map(|sum| sum.to_f64() as f32)),
            distance,
        });
        Some(gathered.collect())
    }
}

/// Whether the last round of rays changed the mean by more than a limit.
fn changes(rounds: &[Vec<Gathered>], limit: f32) -> bool {
    let mean = |rounds: &[Vec<Gathered>]| {
        let sum: Vec3 = rounds.iter().flatten().map(|ray| ray.light).sum();
        sum * (1.0 / rounds.len().max(1) as f32)
    };
    let (before, now) = (mean(&rounds[..rounds.len() - 1]), mean(rounds));
    (now - before).abs().element_sum() > limit * now.element_sum()
}
