//! Whether the samples of one picture are the first samples of another.

use slo_scene::settings::{Effect, Entries};
use slo_scene::{Film, Settings};

use super::read::{Members, members, restore_settings, steps_of};
use crate::film::LEAST_FOR_NOISE;

/// Members beside the settings that say nothing about what a sample brings.
const OTHERS: [&str; 2] = ["steps", "layers"];

/// Whether a film that was exposed for recipe `old`, wholly or in part, can be exposed further for recipe
/// `new` and ends with the same sums as a film that was exposed for `new` from the beginning.
///
/// Both are JSON. Nothing continues a text that is not JSON.
pub fn continues(old: &str, new: &str) -> bool {
    let (Some(old), Some(new)) = (members(old), members(new)) else { return false };
    old == new || same_samples(&old, &new) && goes_on(&old, &new).unwrap_or(false)
}

/// Whether two recipes, as JSON, are of pictures whose samples are the same, however many each takes.
pub fn has_same_samples(one: &str, other: &str) -> bool {
    let (Some(one), Some(other)) = (members(one), members(other)) else { return false };
    same_samples(&one, &other)
}

fn same_samples(old: &Members, new: &Members) -> bool {
    let samples = |recipe: &Members| {
        let mut recipe = recipe.clone();
        recipe.retain(|key, _| !is_of_plan::<Settings>(key) && !is_of_plan::<Film>(key));
        recipe.retain(|key, _| !OTHERS.contains(&&**key));
        recipe
    };
    samples(old) == samples(new)
}

/// Whether a member is a setting that says how many samples are taken, or how they are shown, and nothing
/// about what a sample is.
fn is_of_plan<S: Entries>(key: &str) -> bool {
    let is_it = |effect| matches!(effect, Effect::Count | Effect::Display);
    S::ENTRIES.iter().any(|entry| entry.name == key && is_it(entry.effect))
}

/// Whether both are shown in the same way: errors are measured as they are shown.
fn same_display(old: &Members, new: &Members) -> bool {
    fn same<S: Entries>(old: &Members, new: &Members) -> bool {
        let mut shown = S::ENTRIES.iter().filter(|entry| entry.effect == Effect::Display);
        shown.all(|entry| old.get(entry.name) == new.get(entry.name))
    }
    same::<Settings>(old, new) && same::<Film>(old, new)
}

/// What decides how many samples a pixel takes.
struct Plan {
    settings: Settings,
    /// Camera samples of a pixel.
    least: u64,
    most: u64,
    steps: Option<crate::film::Steps>,
}

impl Plan {
    /// `None` if a setting can't be.
    fn of(recipe: &Members) -> Option<Self> {
        let mut settings = Settings::default();
        restore_settings(&mut settings, &[Effect::Count], recipe)?;
        let dof = u64::from(settings.dof_samples);
        let least = u64::from(settings.image_min_samples) * dof;
        let steps = match recipe.get("steps") {
            None => None,
            Some(_) => Some(steps_of(&recipe.clone().into())?),
        };
        Some(Self { least, most: settings.camera_samples(), settings, steps })
    }

    fn is_uniform(&self) -> bool {
        self.least >= self.most
    }

    /// The first samples of a block, which the rule of `noise` can't do without.
    fn least_for_noise(&self) -> u64 {
        // Where least is most it stands for the least of this rule.
        if self.is_uniform() { self.most.min(LEAST_FOR_NOISE.into()) } else { self.least }
    }
}

/// Whether every pixel takes in `new` at least the samples that it took in `old`.
fn goes_on(old: &Members, new: &Members) -> Option<bool> {
    let same_display = same_display(old, new);
    let (old, new) = (Plan::of(old)?, Plan::of(new)?);
    if old.most > new.most {
        return Some(false);
    }
    match (old.steps, new.steps) {
        (Some(before), Some(after)) => return Some(before <= after && same_display),
        (None, None) => {}
        (Some(_), None) | (None, Some(_)) => return Some(false),
    }
    let (one, other) = (&old.settings, &new.settings);
    Some(match (one.noise, other.noise) {
        (Some(before), Some(after)) => {
            old.least_for_noise() == new.least_for_noise() && before >= after && same_display
        }
        (None, None) => match (old.is_uniform(), new.is_uniform()) {
            (true, true) => true,
            (false, false) => {
                old.least == new.least
                    && one.contrast == other.contrast
                    && one.image_contrast_limit >= other.image_contrast_limit
            }
            (true, false) | (false, true) => false,
        },
        (Some(_), None) | (None, Some(_)) => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recipe with `least` to `most` samples and further members.
    fn recipe(least: u32, most: u32, more: &str) -> String {
        format!(
            "{{ \"seed\": 1, \"imageSamples\": {most}, \"imageMinSamples\": {least}, \
             \"dofSamples\": 2, \"contrastType\": \"WEBER\", \"imageContrastLimit\": 0.1, \
             \"output\": \"PNG_IMAGE\", \"encoding\": \"RAW\"{more} }}"
        )
    }

    #[track_caller]
    fn check(old: &str, new: &str, expected: bool) {
        assert_eq!(continues(old, new), expected, "{old}\n{new}");
    }

    #[test]
    fn more_samples_go_on() {
        let uniform = recipe(64, 64, "");
        check(&uniform, &uniform, true);
        check(&uniform, &recipe(256, 256, ""), true);
        check(&recipe(256, 256, ""), &uniform, false);
        check(&uniform, &recipe(128, 128, "").replace("RAW", "SRGB"), true);
        let looks = ", \"exposure\": -2.0, \"toneMap\": \"AGX\"";
        check(&uniform, &recipe(64, 64, looks), true);
        check(&recipe(64, 64, looks), &uniform, true);
        check(&uniform, &uniform.replace("\"seed\": 1", "\"seed\": 2"), false);
        check(&uniform, &recipe(16, 64, ""), false);
        check(&recipe(16, 64, ""), &recipe(64, 64, ""), false);
    }

    #[test]
    fn layers_say_nothing_about_samples() {
        let layers = |names: &str| recipe(64, 64, &format!(", \"layers\": {names}"));
        check(&layers("[\"albedo\"]"), &layers("[\"albedo\", \"normal\"]"), true);
        check(&layers("[\"albedo\"]"), &recipe(64, 64, ""), true);
    }

    #[test]
    fn stricter_rules_go_on() {
        let contrast = recipe(4, 64, "");
        check(&contrast, &recipe(4, 128, ""), true);
        check(&contrast, &recipe(8, 64, ""), false);
        check(&contrast, &contrast.replace("0.1", "0.05"), true);
        check(&contrast, &contrast.replace("0.1", "0.2"), false);
        check(&contrast, &contrast.replace("WEBER", "MICHELSON"), false);
        let noise = recipe(64, 64, ", \"noise\": 0.02");
        check(&noise, &recipe(128, 128, ", \"noise\": 0.01"), true);
        check(&noise, &recipe(64, 64, ", \"noise\": 0.03"), false);
        check(&noise, &noise.replace("RAW", "SRGB"), false);
        check(&noise, &noise.replace("\"RAW\"", "\"RAW\", \"exposure\": 1.0"), false);
        check(&noise, &recipe(64, 64, ""), false);
        check(&recipe(64, 64, ""), &noise, false);
    }

    #[test]
    fn noise_begins_with_the_samples_of_its_rule() {
        // Twice as many in all, by `dofSamples`.
        let at = |samples: u32| recipe(samples, samples, ", \"noise\": 0.02");
        let half = LEAST_FOR_NOISE / 2;
        check(&at(half), &at(64), true);
        check(&at(half - 1), &at(64), false);
    }

    #[test]
    fn further_steps_go_on() {
        let at = |steps: &str| recipe(64, 64, &format!(", \"steps\": {steps}"));
        check(&at("[3, 5]"), &at("[3, 6]"), true);
        check(&at("[3, 5]"), &at("[4, 0]"), true);
        check(&at("[3, 5]"), &at("[3, 4]"), false);
        check(&at("[3, 5]"), &at("[4, 0]").replace("RAW", "SRGB"), false);
        check(&at("[3, 5]"), &recipe(64, 64, ""), false);
        check(&recipe(64, 64, ""), &at("[3, 5]"), false);
    }

    #[test]
    fn what_is_no_recipe_goes_on_to_nothing() {
        let uniform = recipe(64, 64, "");
        for bad in ["", "[]", "{}", "{ \"imageSamples\": 1 }"] {
            check(bad, &uniform, false);
            check(&uniform, bad, false);
        }
        check("{}", "{}", true);
    }
}
