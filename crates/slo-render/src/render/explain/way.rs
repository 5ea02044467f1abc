//! What a ray's light is called, and the way it came.

use std::fmt;

use crate::frame::{FrameScene, Things};
use crate::integrator::{Account, AccountRay, Gain, Leg, Source};

/// Most legs of the name of a kind of way.
const MOST_LEGS: usize = 6;

/// One ray of a way.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What sent the ray: a word.
    pub leg: &'static str,
    /// The light that the ray asks.
    pub light: Option<String>,
    /// The object that it hit, or the lamp.
    pub object: Option<String>,
    /// The material that it hit.
    pub material: Option<String>,
    /// Its time, from 0 to 1 over the shutter.
    pub time: f32,
    /// Where it hit, in scene space.
    pub position: Option<[f64; 3]>,
    /// Factor of the radiance that arrives along it.
    pub weight: [f32; 3],
}

/// What sent the ray, and what it hit.
impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.leg)?;
        if let Some(light) = &self.light {
            write!(f, " {light}")?;
        }
        if let Some(object) =
            self.object.as_ref().filter(|object| self.light.as_ref() != Some(object))
        {
            let arrow = if self.leg == "camera" { ": " } else { " to " };
            write!(f, "{arrow}{object}")?;
        }
        if let Some(material) = &self.material {
            write!(f, " [{material}]")?;
        }
        Ok(())
    }
}

/// What some light is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    /// The lamp, sky or object that it comes from.
    pub light: String,
    /// The kind of way that it took.
    pub kind: String,
    /// The object that the camera sees first.
    pub seen: String,
    /// The object that scattered it first after it left its source.
    pub lit: String,
}

/// Names of the things of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// The frame.
    pub frame: &'a FrameScene,
    /// Its objects and lights.
    pub things: &'a Things,
}

impl Names<'_> {
    /// The rays from the camera to a ray.
    pub fn steps(&self, account: &Account, ray: u32) -> Vec<Step> {
        let rays = account.way(ray);
        rays.into_iter().map(|ray| self.step(&account.rays[ray as usize])).collect()
    }

    /// One ray.
    pub fn step(&self, ray: &AccountRay) -> Step {
        let thing = ray.hit.and_then(|hit| self.things.objects.get(hit.thing as usize));
        let light = match ray.leg {
            Leg::ToLight(number) => Some(self.light(number)),
            _ => None,
        };
        let position = ray.hit.map(|hit| ray.origin + ray.direction * hit.distance);
        Step {
            leg: leg_word(ray.leg),
            light,
            object: thing.map(|thing| thing.name.clone()),
            material: thing.and_then(|thing| thing.material.clone()),
            time: ray.time,
            position: position.map(|point| self.frame.scene_point(point)),
            weight: ray.weight.to_array(),
        }
    }

    /// What the light of a gain is.
    pub(super) fn name(&self, account: &Account, gain: &Gain) -> Named {
        let rays: Vec<&AccountRay> =
            account.way(gain.ray).into_iter().map(|ray| &account.rays[ray as usize]).collect();
        let object = |ray: &AccountRay| {
            let thing = self.things.objects.get(ray.hit?.thing as usize)?;
            Some(thing.name.clone())
        };
        // What a ray passes does not count as seen or lit.
        let is_passed = |i: usize| rays.get(i + 1).is_some_and(|next| next.leg == Leg::Behind);
        let hits: Vec<(usize, String)> = (0..rays.len())
            .filter(|i| !is_passed(*i))
            .filter_map(|i| object(rays[i]).map(|name| (i, name)))
            .collect();
        let last = rays.len() - 1;
        let at_hit = matches!(gain.source, Source::Ambient | Source::Photons);
        let lit = hits.iter().rev().find(|(i, _)| *i < last || at_hit);
        let nothing = || "nothing".to_owned();
        Named {
            light: self.origin(&rays, gain.source),
            kind: kind(&rays, gain.source),
            seen: hits.first().map_or_else(nothing, |(_, name)| name.clone()),
            lit: lit.map_or_else(|| "seen directly".to_owned(), |(_, name)| name.clone()),
        }
    }

    /// Names where light comes from.
    fn origin(&self, rays: &[&AccountRay], source: Source) -> String {
        let Some(last) = rays.last() else { return String::new() };
        let asked = rays.iter().rev().find_map(|ray| match ray.leg {
            Leg::ToLight(number) => Some(number),
            _ => None,
        });
        let hit = last.hit.and_then(|hit| self.things.objects.get(hit.thing as usize));
        match (source, hit) {
            (Source::Asked, _) => asked.map_or_else(String::new, |number| self.light(number)),
            (Source::Ambient, Some(thing)) => {
                format!("ambient of {}", thing.material.as_deref().unwrap_or_default())
            }
            (Source::Photons, _) => "photons".to_owned(),
            (Source::Arrived | Source::Emitted, Some(thing)) => thing.name.clone(),
            _ => self.skies(last),
        }
    }

    /// The name of a light.
    fn light(&self, number: u32) -> String {
        self.things.lights.get(number as usize).cloned().unwrap_or_default()
    }

    /// Names what a ray sees that hit nothing.
    fn skies(&self, ray: &AccountRay) -> String {
        let skies = self.frame.skies_seen(ray.time, ray.origin, ray.direction);
        let skies: Vec<String> = skies.into_iter().map(|sky| self.light(sky)).collect();
        if skies.is_empty() { "background".to_owned() } else { skies.join(" + ") }
    }
}

/// The word of a source.
pub fn word(source: Source) -> &'static str {
    match source {
        Source::Arrived => "arrived",
        Source::Emitted => "emitted",
        Source::Ambient => "ambient",
        Source::Asked => "asked",
        Source::Photons => "photons",
    }
}

fn leg_word(leg: Leg) -> &'static str {
    match leg {
        Leg::Camera => "camera",
        Leg::Diffuse => "diffuse",
        Leg::Glossy => "glossy",
        Leg::Sharp => "sharp",
        Leg::Phong => "lobe",
        Leg::Behind => "through",
        Leg::ToLight(_) => "to",
    }
}

/// Names the kind of a way: the lobes that the light followed, from the camera on, and how it was found.
fn kind(rays: &[&AccountRay], source: Source) -> String {
    let is_bounce =
        |ray: &&&AccountRay| !matches!(ray.leg, Leg::Camera | Leg::Behind | Leg::ToLight(_));
    let mut words: Vec<&str> = rays.iter().filter(is_bounce).map(|ray| leg_word(ray.leg)).collect();
    let more = words.len().saturating_sub(MOST_LEGS);
    words.truncate(MOST_LEGS);
    let more = if more > 0 { format!("{more} more") } else { String::new() };
    words.extend((!more.is_empty()).then_some(&*more));
    let end = match source {
        Source::Asked => "lamp asked",
        Source::Arrived if words.is_empty() => "seen",
        Source::Arrived => "lamp hit",
        Source::Emitted if rays.last().is_some_and(|ray| matches!(ray.leg, Leg::ToLight(_))) => {
            "emitter asked"
        }
        Source::Emitted => "emission",
        Source::Ambient => "ambient",
        Source::Photons => "photons",
    };
    words.push(end);
    words.join(" > ")
}
