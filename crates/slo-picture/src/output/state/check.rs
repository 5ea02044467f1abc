//! Whether the numbers of a state are possible: anybody can write a file with a right checksum.

use std::ops::Range;

use serde_json::Value;

use slo_scene::settings::{Effect, MOST_PIXELS};
use slo_scene::{Layer, LayerNames, Settings};

use crate::film::{
    Area, Features, FirstHitLayers, FirstHits, Fixed, Pixel, Spread, Steps, Subject, TILE, Wide,
    base_end,
};
use crate::output::recipe::{layers_of, restore_settings, steps_of};

/// Largest mean of a pixel's samples, in multiples of the largest contribution.
const MOST_CONTRIBUTIONS: u64 = 1024;
/// The largest contribution, in units of a sum.
const LARGEST_CONTRIBUTION: u64 = 1 << 48;
/// Larger sums of features leave no room for more samples.
const LARGEST_FEATURE: u64 = 1 << 62;
/// Samples of a pixel in the states of other versions, which are not read further.
const MOST_SAMPLES: u32 = (1 << 22) - 1;

/// What must hold for each pixel of a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Bounds {
    /// All samples of a pixel in the finished picture.
    all: u32,
    /// The numbers of the samples that this state holds.
    samples: Range<u32>,
    /// Whether they are a share of all.
    is_share: bool,
    /// Whether every pixel that was sampled has all of them.
    is_full: bool,
}

impl Bounds {
    /// The bounds of a state of `subject`. If its recipe belongs to another version, nobody can use it,
    /// and only its size is checked.
    ///
    /// # Errors
    /// What is impossible.
    pub(super) fn of(subject: &Subject, is_complete: bool) -> Result<Self, &'static str> {
        let recipe: Value =
            serde_json::from_str(&subject.recipe).map_err(|_| "its recipe can't be read")?;
        let most = Area::whole(MOST_PIXELS, MOST_PIXELS);
        if !most.holds(&subject.area) || !subject.area.holds(&subject.region) {
            return Err("its area is impossible");
        }
        if recipe["version"] != env!("CARGO_PKG_VERSION") {
            return Ok(Self {
                all: MOST_SAMPLES,
                samples: 0..MOST_SAMPLES,
                is_share: subject.samples.is_some(),
                is_full: false,
            });
        }
        let plan = Plan::of(&recipe).ok_or("its recipe does not fit this version")?;
        plan.check(subject)?;
        let all = plan.samples;
        let samples = subject.samples.clone().unwrap_or(0..all);
        if samples.is_empty() || samples.end > all {
            return Err("its samples are not among its recipe's samples");
        }
        let is_full = is_complete && plan.rule == Rule::Uniform;
        Ok(Self { all, samples, is_share: subject.samples.is_some(), is_full })
    }

    /// Checks the number of a pixel's samples.
    ///
    /// # Errors
    /// What is impossible.
    pub(super) fn check_count(&self, samples: u32) -> Result<(), &'static str> {
        let most = self.samples.len() as u32;
        match samples {
            0 => Ok(()),
            _ if samples > most => Err("a pixel has more samples than were asked for"),
            _ if samples < most && self.is_full => Err("a pixel has fewer samples than the others"),
            _ => Ok(()),
        }
    }

    /// Checks the sums of a pixel with samples.
    ///
    /// # Errors
    /// What is impossible.
    pub(super) fn check_pixel(
        &self,
        pixel: &Pixel,
        spread: Option<&Spread>,
        features: Option<&Features>,
        lights: &[[Fixed; 3]],
    ) -> Result<(), &'static str> {
        let Pixel { sum, base, samples } = *pixel;
        let in_base = self.in_base(samples);
        let largest = u64::from(samples).saturating_mul(MOST_CONTRIBUTIONS * LARGEST_CONTRIBUTION);
        let mut sums = [sum, base].into_iter().chain(lights.iter().copied()).flatten();
        let features = features.map(|features| [features.albedo, features.normal]);
        let mut features = features.into_iter().flatten().flatten();
        if !sums.all(|sum| sum.units() <= largest)
            || !features.all(|sum| sum.units().unsigned_abs() <= largest.min(LARGEST_FEATURE))
        {
            return Err("its sums are larger than rendered ones");
        }
        let is_base = match in_base {
            0 => base == [Fixed::ZERO; 3],
            all if all == samples => base == sum,
            _ => true,
        };
        if !is_base {
            return Err("its sums contradict each other");
        }
        match spread {
            Some(spread) if !(0..3).all(|c| is_between(pixel, in_base, spread, c)) => {
                Err("its sums do not fit its samples")
            }
            _ => Ok(()),
        }
    }

    /// How many of the first `samples` belong to the base.
    fn in_base(&self, samples: u32) -> u32 {
        let end = if self.is_share { base_end(self.all) } else { base_end(samples) };
        end.saturating_sub(self.samples.start).min(samples)
    }
}

/// Checks the sums of what camera rays hit first in a pixel of so many samples.
///
/// # Errors
/// What is impossible.
pub(super) fn check_places(hits: &FirstHits, i: usize, samples: u32) -> Result<(), &'static str> {
    let largest = Wide::clamped(Wide::LIMIT).units().saturating_mul(samples.into());
    match hits.places(i).iter().all(|sum| sum.units().saturating_abs() <= largest) {
        true => Ok(()),
        false => Err("its sums are larger than rendered ones"),
    }
}

/// Whether the sums of a channel lie between those of as many of its smallest and of its largest
/// sample.
fn is_between(pixel: &Pixel, in_base: u32, spread: &Spread, c: usize) -> bool {
    let [least, most] = [spread.least[c], spread.most[c]];
    let times = |sample: Fixed, count: u32| sample.units().saturating_mul(count.into());
    let holds =
        |sum: Fixed, count: u32| (times(least, count)..=times(most, count)).contains(&sum.units());
    least <= most && holds(pixel.sum[c], pixel.samples) && holds(pixel.base[c], in_base)
}

/// What decides how many samples a pixel takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    Uniform,
    Contrast,
    Noise,
}

/// What a recipe says of a film.
struct Plan {
    whole: Area,
    /// Of a pixel, at most.
    samples: u32,
    rule: Rule,
    layers: Vec<Layer>,
}

impl Plan {
    /// `None` if a setting is missing, or can't be.
    fn of(recipe: &Value) -> Option<Self> {
        let members = recipe.as_object()?;
        let (mut film, mut settings) = (slo_scene::Film::default(), Settings::default());
        restore_settings(&mut film, &[Effect::Samples, Effect::Display], members)?;
        restore_settings(&mut settings, &[Effect::Count], members)?;
        settings.are_consistent().then_some(())?;
        let whole = Area::whole(film.width, film.height);
        let tiles = film.width.div_ceil(TILE) * film.height.div_ceil(TILE);
        let has_steps = match recipe.get("steps") {
            None => false,
            Some(_) => {
                let Steps { done, tiles: further } = steps_of(recipe)?;
                (done <= Steps::LAST && further <= tiles).then_some(true)?
            }
        };
        let is_adaptive = settings.image_min_samples < settings.image_samples;
        let rule = match (settings.noise.is_some() || has_steps, is_adaptive) {
            (true, _) => Rule::Noise,
            (false, true) => Rule::Contrast,
            (false, false) => Rule::Uniform,
        };
        let samples = u32::try_from(settings.camera_samples()).ok()?;
        Some(Self { whole, samples, rule, layers: layers_of(recipe)? })
    }

    fn check(&self, subject: &Subject) -> Result<(), &'static str> {
        let Subject { area, region, samples, with_spreads, with_features, .. } = subject;
        let has_surfaces = self.layers.iter().any(|layer| layer.is_of_surfaces());
        let has_lights = self.layers.contains(&Layer::Lights);
        let hits = &subject.first_hits;
        let names = LayerNames {
            objects: hits.objects.clone().unwrap_or_default(),
            materials: hits.materials.clone().unwrap_or_default(),
            ..LayerNames::default()
        };
        if !self.whole.holds(region) || *area != region.in_blocks(&self.whole) {
            return Err("its area does not fit its recipe");
        }
        if *with_spreads != (self.rule == Rule::Contrast)
            || *with_features != has_surfaces
            || subject.light_groups.is_some() != has_lights
            || *hits != FirstHitLayers::of(&self.layers, &names)
            || (samples.is_some() && self.rule != Rule::Uniform)
        {
            return Err("what is in it is not what its recipe asks for");
        }
        Ok(())
    }
}
