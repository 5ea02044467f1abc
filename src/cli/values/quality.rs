//! Quality of a picture: samples, seed, noise, steps.

use super::numbers::{count, real, whole};
use slo_picture::film::Steps;

/// Parses a number of samples.
pub(crate) fn samples(text: &str) -> Result<u32, String> {
    count(text, 1..=65_535, "64")
}

/// Parses a seed.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    count(text, 0..=u64::MAX, "7")
}

/// Parses an error limit.
pub(crate) fn noise(text: &str) -> Result<f32, String> {
    let error = real(text).filter(|error| *error > 0.0 && *error <= 1.0);
    match error.map(|error| error as f32) {
        Some(0.0) => Err("it is too close to 0; a usual error is 0.01".into()),
        error => error
            .ok_or_else(|| "expected an error above 0 and at most 1, such as 0.01 or 1%".into()),
    }
}

/// Parses a number of photons per camera sample.
pub(crate) fn photons(text: &str) -> Result<f32, String> {
    let photons = real(text).filter(|photons| (0.0..=100.0).contains(photons));
    photons
        .map(|photons| photons as f32)
        .ok_or_else(|| "expected a number of photons from 0 to 100, such as 0.5".into())
}

/// Parses an exposure in stops.
pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    let text = text.trim();
    let stops = real(text).filter(|stops| stops.abs() <= 32.0 && !text.ends_with('%'));
    stops
        .map(|stops| stops as f32)
        .ok_or_else(|| "expected a number of stops from -32 to 32, such as 1.5 or -2".into())
}

/// Parses a limit of a distance.
pub(crate) fn limit(text: &str) -> Result<f64, String> {
    let limit = real(text).filter(|limit| *limit >= 0.0);
    limit.ok_or_else(|| "expected a limit of 0 or more, such as 0.01 or 1%".into())
}

/// Parses `STEP,TILES`, also in brackets as in a recipe.
pub(crate) fn steps(text: &str) -> Result<Steps, String> {
    let inside = text.trim().strip_prefix('[').and_then(|text| text.strip_suffix(']'));
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    let numbers = inside
        .unwrap_or(text)
        .split_once(',')
        .and_then(|(step, tiles)| Some((number(step)?, number(tiles)?)));
    match numbers {
        Some((done, tiles)) if done <= Steps::LAST => Ok(Steps { done, tiles }),
        _ => Err(format!(
            "expected a step up to {} and a number of tiles, such as 7,120",
            Steps::LAST
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photons_are_a_few_a_sample() {
        for (text, expected) in [("0", 0.0), (".5", 0.5), ("1e2", 100.0), ("50%", 0.5)] {
            assert_eq!(photons(text), Ok(expected), "{text}");
        }
        for bad in ["", "-1", "101", "nan", "inf", "few"] {
            assert!(photons(bad).unwrap_err().contains("from 0 to 100"), "{bad}");
        }
    }

    #[test]
    fn exposures_are_stops() {
        for (text, expected) in [("0", 0.0), ("1.5", 1.5), ("-2", -2.0), ("+.5", 0.5)] {
            assert_eq!(exposure(text), Ok(expected), "{text}");
        }
        for bad in ["", "33", "-33", "50%", "nan", "1 stop"] {
            assert!(exposure(bad).unwrap_err().contains("from -32 to 32"), "{bad}");
        }
    }

    #[test]
    fn steps_are_written_as_in_recipes() {
        for text in ["7,120", "7, 120", "[7, 120]"] {
            assert_eq!(steps(text), Ok(Steps { done: 7, tiles: 120 }));
        }
    }
}
