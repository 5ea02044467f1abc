//! What the samples of a pixel add up to.

use std::collections::BTreeMap;
use std::fmt;

use super::way::{Names, Step};
use crate::integrator::{Account, AccountRay, Gain, Source};

/// Weights of red, green and blue in the luminance (Rec. 709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// All that is known of a pixel.
#[derive(Debug, Default)]
pub struct Tally {
    /// Number of samples.
    pub samples: u32,
    /// Sum of the samples.
    sum: [f64; 3],
    /// Sums over the samples of the luminance and of its square.
    luminance: f64,
    squares: f64,
    /// Sums by lamp, by kind of way, by the object that is seen, and by the object that is lit.
    by: [BTreeMap<String, Part>; 4],
    /// Ways by their words.
    ways: BTreeMap<String, Bright>,
    most: usize,
    /// Number of rays.
    pub rays: u64,
    /// Number of rays that brought light.
    pub bringing: u64,
    /// Rays that were too many to be listed.
    pub unlisted: u64,
}

/// A part of the light, over all samples.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    sum: [f64; 3],
    luminance: f64,
    /// Sum of the products of its luminance and that of the whole sample.
    product: f64,
    /// Its luminance in the present sample.
    now: f64,
}

/// Most ways that are told apart. Light that comes by others is part of all sums, but is not listed.
const MOST_WAYS: usize = 100_000;

/// A way that light took, in one sample or several.
#[derive(Clone, Debug)]
pub struct Bright {
    /// The sample in which it brought most.
    pub sample: u32,
    /// How often light came this way, in all samples.
    pub times: u64,
    /// Luminance of all of this light.
    pub sum: f64,
    /// How the light was found.
    pub source: Source,
    /// The light that it brought there.
    pub light: [f64; 3],
    /// Luminance of that light.
    pub luminance: f64,
    /// The rays of that sample, from the camera on.
    pub steps: Vec<Step>,
}

/// The way of the light, from the camera on.
impl fmt::Display for Bright {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.steps.iter().enumerate() {
            let arrow = if i == 0 { "" } else { " > " };
            write!(f, "{arrow}{step}")?;
        }
        f.write_str(match self.source {
            Source::Asked => "",
            Source::Arrived if self.steps.last().is_some_and(|step| step.object.is_none()) => {
                " > sky"
            }
            Source::Arrived => " (lamp)",
            Source::Emitted => " (emits)",
            Source::Ambient => " (ambient)",
            Source::Photons => " (photons)",
        })
    }
}

/// A part of the mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// What the part is of.
    pub name: String,
    /// Radiance, RGB.
    pub mean: [f64; 3],
    /// Its part of the luminance.
    pub share: f64,
    /// Its part of the variance of the samples' luminance; less than 0 if it evens the rest out.
    pub noise: f64,
}

impl Tally {
    /// Nothing yet; lists the `most` brightest ways.
    pub fn new(most: usize) -> Self {
        Self { most, ..Self::default() }
    }

    /// Adds a sample.
    pub fn add(&mut self, sample: u32, account: &Account, names: &Names<'_>) {
        self.samples += 1;
        self.rays += account.rays.len() as u64 + account.unlisted;
        self.unlisted += account.unlisted;
        let mut brought = vec![false; account.rays.len()];
        let mut whole = 0.0;
        for gain in &account.gains {
            let light = gain.light.map(|light| light.to_f64());
            let luminance = luminance(light);
            whole += luminance;
            brought[gain.ray as usize] = true;
            add(&mut self.sum, light);
            let named = names.name(account, gain);
            for (parts, name) in
                self.by.iter_mut().zip([named.light, named.kind, named.seen, named.lit])
            {
                let part = parts.entry(name).or_default();
                add(&mut part.sum, light);
                part.luminance += luminance;
                part.now += luminance;
            }
            if self.most > 0 {
                self.note(sample, gain, light, names.steps(account, gain.ray));
            }
        }
        self.bringing += brought.iter().filter(|brought| **brought).count() as u64;
        self.luminance += whole;
        self.squares += whole * whole;
        for part in self.by.iter_mut().flat_map(BTreeMap::values_mut) {
            part.product += std::mem::take(&mut part.now) * whole;
        }
    }

    /// Adds light to its way: all light whose way has the same words came by one way.
    fn note(&mut self, sample: u32, gain: &Gain, light: [f64; 3], steps: Vec<Step>) {
        let (luminance, source) = (luminance(light), gain.source);
        let way = Bright { sample, times: 1, sum: luminance, source, light, luminance, steps };
        let words = way.to_string();
        let has_room = self.ways.len() < MOST_WAYS;
        if let Some(known) = self.ways.get_mut(&words) {
            let (times, sum) = (known.times + 1, known.sum + luminance);
            if luminance > known.luminance {
                *known = way;
            }
            (known.times, known.sum) = (times, sum);
        } else if has_room {
            self.ways.insert(words, way);
        }
    }

    /// The brightest ways, brightest first.
    pub fn brightest(&self) -> Vec<&Bright> {
        let mut ways: Vec<&Bright> = self.ways.values().filter(|way| way.sum > 0.0).collect();
        ways.sort_by(|a, b| b.sum.total_cmp(&a.sum));
        ways.truncate(self.most);
        ways
    }

    fn count(&self) -> f64 {
        f64::from(self.samples.max(1))
    }

    /// The pixel: radiance, RGB.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|sum| sum / self.count())
    }

    /// Luminance of the pixel.
    pub fn luminance(&self) -> f64 {
        self.luminance / self.count()
    }

    /// Estimates the standard error of the luminance as if samples were independent; `None` of a
    /// single sample. Samples of one pixel are stratified, so the true error is less.
    pub fn standard_error(&self) -> Option<f64> {
        let variance = self.variance() / (self.count() - 1.0);
        (self.samples > 1).then(|| variance.max(0.0).sqrt())
    }

    /// Variance of the samples' luminance.
    fn variance(&self) -> f64 {
        self.squares / self.count() - self.luminance() * self.luminance()
    }

    /// The parts by lamp.
    pub fn lights(&self) -> Vec<Share> {
        self.parts(0)
    }

    /// The parts by kind of way.
    pub fn ways(&self) -> Vec<Share> {
        self.parts(1)
    }

    /// The parts by the object that the camera sees.
    pub fn seen(&self) -> Vec<Share> {
        self.parts(2)
    }

    /// The parts by the object that the light falls on first.
    pub fn lit(&self) -> Vec<Share> {
        self.parts(3)
    }

    /// The parts of one kind, the largest first.
    fn parts(&self, kind: usize) -> Vec<Share> {
        let (count, mean, variance) = (self.count(), self.luminance(), self.variance());
        let share = |(name, part): (&String, &Part)| {
            let covariance = part.product / count - part.luminance / count * mean;
            Share {
                name: name.clone(),
                mean: part.sum.map(|sum| sum / count),
                share: if mean > 0.0 { part.luminance / count / mean } else { 0.0 },
                noise: if variance > 1e-12 * mean * mean { covariance / variance } else { 0.0 },
            }
        };
        let mut shares: Vec<Share> = self.by[kind].iter().map(share).collect();
        shares.sort_by(|a, b| b.share.total_cmp(&a.share));
        shares
    }
}

/// The rays of one sample, with the light that each brought.
pub fn rays_of(account: &Account) -> impl Iterator<Item = (&AccountRay, Vec<&Gain>)> {
    let mut gains: BTreeMap<u32, Vec<&Gain>> = BTreeMap::new();
    for gain in &account.gains {
        gains.entry(gain.ray).or_default().push(gain);
    }
    let rays = (0u32..).zip(&account.rays);
    rays.map(move |(number, ray)| (ray, gains.remove(&number).unwrap_or_default()))
}

/// Luminance of a radiance (Rec. 709).
pub fn luminance(light: [f64; 3]) -> f64 {
    light.iter().zip(LUMINANCE).map(|(light, weight)| light * weight).sum()
}

fn add(to: &mut [f64; 3], more: [f64; 3]) {
    to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
}
