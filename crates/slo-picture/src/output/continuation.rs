//! Whether the samples of one picture are the first samples of another.

use serde_json::{Map, Value};

use crate::film::LEAST_FOR_NOISE;

/// Members of a recipe that say how many samples are taken, or how they are shown, and nothing
/// about what a sample is.
const OF_THE_PLAN: [&str; 10] = [
    "steps",
    "imageSamples",
    "imageMinSamples",
    "dofSamples",
    "contrastType",
    "imageContrastLimit",
    "noise",
    "output",
    "encoding",
    "layers",
];

/// Whether a film that was exposed for recipe `old`, wholly or in part, can go on to recipe `new`
/// and end with the same sums as one that was exposed for `new` from the beginning.
///
/// Both are JSON; what is none goes on to nothing.
pub fn continues(old: &str, new: &str) -> bool {
    let parse = |text: &str| serde_json::from_str::<Map<String, Value>>(text).ok();
    let (Some(old), Some(new)) = (parse(old), parse(new)) else { return false };
    old == new || same_samples(&old, &new) && goes_on(&old, &new).unwrap_or(false)
}

/// Whether two recipes, as JSON, are of pictures whose samples are the same, however many each takes.
pub fn has_same_samples(one: &str, other: &str) -> bool {
    let parse = |text: &str| serde_json::from_str::<Map<String, Value>>(text).ok();
    let (Some(one), Some(other)) = (parse(one), parse(other)) else { return false };
    same_samples(&one, &other)
}

fn same_samples(old: &Map<String, Value>, new: &Map<String, Value>) -> bool {
    let others = |recipe: &Map<String, Value>| {
        let mut recipe = recipe.clone();
        recipe.retain(|key, _| !OF_THE_PLAN.contains(&&**key));
        recipe
    };
    others(old) == others(new)
}

/// Whether every pixel takes in `new` at least the samples that it took in `old`.
fn goes_on(old: &Map<String, Value>, new: &Map<String, Value>) -> Option<bool> {
    let number = |recipe: &Map<String, Value>, key: &str| recipe.get(key)?.as_f64();
    let counts = |recipe: &Map<String, Value>| {
        let dof = number(recipe, "dofSamples")?;
        let of = |key: &str| number(recipe, key).map(|samples| samples * dof);
        Some((of("imageMinSamples")?, of("imageSamples")?))
    };
    let ((old_least, old_most), (new_least, new_most)) = (counts(old)?, counts(new)?);
    let same = |key: &str| old.get(key) == new.get(key);
    let stricter = |key: &str| Some(number(old, key)? >= number(new, key)?);
    let is_uniform = |least: f64, most: f64| least >= most;
    let steps = |recipe: &Map<String, Value>| {
        let numbers = recipe.get("steps")?.as_array()?;
        Some((numbers.first()?.as_u64()?, numbers.get(1)?.as_u64()?))
    };
    match (steps(old), steps(new)) {
        (Some(before), Some(after)) => {
            let shown = same("output") && same("encoding");
            return Some(before <= after && old_most <= new_most && shown);
        }
        (None, None) => {}
        _ => return Some(false),
    }
    Some(match (old.get("noise"), new.get("noise")) {
        (Some(_), Some(_)) => {
            // Where least is most it stands for the least of this rule.
            let rule = f64::from(LEAST_FOR_NOISE);
            let least = |least: f64, most: f64| if least >= most { most.min(rule) } else { least };
            least(old_least, old_most) == least(new_least, new_most)
                && old_most <= new_most
                && stricter("noise")?
                && same("output")
                && same("encoding")
        }
        (None, None) if is_uniform(old_least, old_most) && is_uniform(new_least, new_most) => {
            old_most <= new_most
        }
        (None, None) => {
            !is_uniform(old_least, old_most)
                && !is_uniform(new_least, new_most)
                && old_least == new_least
                && old_most <= new_most
                && same("contrastType")
                && stricter("imageContrastLimit")?
        }
        _ => false,
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
