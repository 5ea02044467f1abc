//! The account of a sample: its rays, what they hit, and the light that each of them brought.
//!
//! An account is kept by the [machine](super::machine) on request. Every ray then has a slot of its own,
//! which all stages pass on to what they make of the ray, so the light that is added to a slot is the
//! light of that ray.

use glam::Vec3;
use slo_accel::math::columns::{Column, Vec3s};
use slo_picture::film::Fixed;

use super::batch::{Batch, Labels, Past, Sent, marks};
use super::chosen::Chosen;
use super::stages::hits::Hits;
use super::work::SampleSum;
use crate::frame::FrameScene;

/// Most rays of an account. Later rays are counted only, and their light belongs to the ray before.
const MOST_RAYS: usize = 1 << 20;

/// All rays of some samples, and their light.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// The rays: first the camera rays, one for each sample, and each ray behind the one that it
    /// comes from.
    pub rays: Vec<AccountRay>,
    /// Light that was added to the samples.
    pub gains: Vec<Gain>,
    /// How many more rays there were than an account holds.
    pub unlisted: u64,
    /// Number of the first light that is shaded where rays to it arrive.
    first_shaded: u32,
}

/// A ray of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccountRay {
    /// The ray whose hit sent it; `None` for camera rays.
    pub before: Option<u32>,
    /// What sent it where.
    pub leg: Leg,
    /// Number of bounces before it.
    pub depth: u32,
    /// Its time, from 0 to 1 over the shutter.
    pub time: f32,
    /// Where it starts, in render space.
    pub origin: Vec3,
    /// Its direction; of a ray to a lamp with a place, the way to the end.
    pub direction: Vec3,
    /// Factor of the radiance that arrives along it; of a connection, the light that it brings
    /// unless something blocks it.
    pub weight: Vec3,
    /// What it hit first; `None` if it hit nothing, or is a connection.
    pub hit: Option<AccountHit>,
}

/// What a ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccountHit {
    /// Number of the object of the frame; see [`FrameScene::things`].
    pub thing: u32,
    /// Distance, in lengths of the ray's direction.
    pub distance: f32,
}

/// What sent a ray on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// The camera.
    Camera,
    /// A diffuse lobe.
    Diffuse,
    /// A rough lobe that is not diffuse.
    Glossy,
    /// A perfect mirror or pane.
    Sharp,
    /// A lobe of a Phong material under `DISTRIBUTED`: perfect or rough.
    Phong,
    /// Nothing: the ray goes on behind something that lets it pass.
    Behind,
    /// The question for the light of a lamp: its number among the lights of the frame.
    ToLight(u32),
}

/// Light that was added to a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// The ray that brought it, or at whose hit it was found.
    pub ray: u32,
    /// What it is.
    pub source: Source,
    /// Weighted radiance, RGB, as the film adds it.
    pub light: SampleSum,
}

/// What the light of a [`Gain`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Source {
    /// A ray hit a lamp, or went to the sky or the background.
    Arrived,
    /// The surface that a ray hit emits it.
    Emitted,
    /// Ambient light of a Phong material.
    Ambient,
    /// A lamp was asked, and nothing blocked its light.
    Asked,
    /// Photons brought it to where the ray hit.
    Photons,
}

impl Account {
    /// Begins with `count` camera rays.
    pub(super) fn begin(&mut self, count: usize, first_shaded: u32) {
        *self = Self { first_shaded, ..Self::default() };
        let camera = AccountRay {
            before: None,
            leg: Leg::Camera,
            depth: 0,
            time: 0.0,
            origin: Vec3::ZERO,
            direction: Vec3::ZERO,
            weight: Vec3::ONE,
            hit: None,
        };
        self.rays.resize(count, camera);
    }

    /// Lists the chosen rays of lobes, which have `depth` bounces before them, and gives each a slot of
    /// its own. `past` is what rays of paths remember.
    pub(super) fn list_lobes(
        &mut self,
        depth: u32,
        sent: &Sent,
        labels: &Labels,
        past: Option<&Past>,
        chosen: &Chosen,
    ) -> Column<u32> {
        let first_shaded = self.first_shaded;
        self.list(sent, labels, chosen, |before, i| {
            let marks = past.map(|past| past.marks[i]);
            let leg = match marks {
                _ if before.depth == depth => Leg::Behind,
                None => Leg::Phong,
                Some(marks) if marks::asked(marks) > 0 => {
                    Leg::ToLight(first_shaded + marks::asked(marks) - 1)
                }
                Some(marks) if marks & marks::DIFFUSE != 0 => Leg::Diffuse,
                Some(marks) if marks & marks::SHARP != 0 => Leg::Sharp,
                Some(_) => Leg::Glossy,
            };
            (leg, depth)
        })
    }

    /// Lists the chosen connections to lights and gives each a slot of its own.
    pub(super) fn list_connections(
        &mut self,
        sent: &Sent,
        labels: &Labels,
        chosen: &Chosen,
        light: impl Fn(usize) -> u32,
    ) -> Column<u32> {
        self.list(sent, labels, chosen, |before, i| (Leg::ToLight(light(i)), before.depth + 1))
    }

    /// Lists the chosen connections that go on behind what they hit.
    pub(super) fn list_passing(
        &mut self,
        sent: &Sent,
        labels: &Labels,
        chosen: &Chosen,
    ) -> Column<u32> {
        self.list(sent, labels, chosen, |before, _| (Leg::Behind, before.depth))
    }

    fn list(
        &mut self,
        sent: &Sent,
        labels: &Labels,
        chosen: &Chosen,
        name: impl Fn(&AccountRay, usize) -> (Leg, u32),
    ) -> Column<u32> {
        let mut slots = labels.slot;
        for i in chosen.entries() {
            let before = slots[i];
            let Some(of) = self.rays.get(before as usize) else { continue };
            if self.rays.len() >= MOST_RAYS {
                self.unlisted += 1;
                continue;
            }
            let (leg, depth) = name(of, i);
            slots[i] = self.rays.len() as u32;
            self.rays.push(AccountRay {
                before: Some(before),
                leg,
                depth,
                time: labels.time[i],
                origin: sent.origin.get(i),
                direction: sent.direction.get(i),
                weight: sent.weight.get(i),
                hit: None,
            });
        }
        slots
    }

    /// Notes what the rays of a batch hit.
    pub(super) fn note_hits(&mut self, frame: &FrameScene, batch: &Batch, hits: &Hits) {
        for i in 0..batch.len() {
            let Some(ray) = self.rays.get_mut(batch.labels.slot[i] as usize) else { continue };
            ray.hit = hits.thing(frame, i).map(|(thing, distance)| AccountHit { thing, distance });
            if ray.leg == Leg::Camera {
                ray.time = batch.labels.time[i];
                (ray.origin, ray.direction) = (batch.rays.origin(i), batch.rays.direction(i));
            }
        }
    }

    /// Notes light that is added to the sums of slots.
    pub(super) fn note_light(
        &mut self,
        source: Source,
        light: &Vec3s,
        slot: &Column<u32>,
        len: usize,
    ) {
        for (i, &ray) in slot.iter().enumerate().take(len) {
            let light = light.get(i).to_array().map(Fixed::clamped);
            if light != [Fixed::ZERO; 3] {
                self.gains.push(Gain { ray, source, light });
            }
        }
    }

    /// The legs of the way from the camera to a ray, in order: numbers of rays.
    pub fn way(&self, ray: u32) -> Vec<u32> {
        let before = |ray: &u32| self.rays.get(*ray as usize)?.before;
        let mut way: Vec<u32> = std::iter::successors(Some(ray), before).collect();
        way.reverse();
        way
    }

    /// The sum of all light.
    pub fn sum(&self) -> SampleSum {
        let mut sum = SampleSum::default();
        for gain in &self.gains {
            sum.iter_mut().zip(gain.light).for_each(|(sum, more)| *sum += more);
        }
        sum
    }
}
