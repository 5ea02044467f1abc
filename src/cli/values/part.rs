//! Parts of pictures, and what they divide.

use clap::ValueEnum;

use super::numbers::whole;
use slo_render::render::Part;

/// `--part-by`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PartBy {
    #[default]
    Pixels,
    Samples,
}

impl PartBy {
    /// Returns the word for file names.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Pixels => "pixels",
            Self::Samples => "samples",
        }
    }
}

/// Parses `K/N`, or `K-of-N` as in file names.
pub(crate) fn part(text: &str) -> Result<Part, String> {
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    let numbers = text.split_once('/').or_else(|| text.split_once("-of-"));
    let numbers = numbers.and_then(|(k, n)| Some((number(k)?, number(n)?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Part { number, of }),
        _ => Err("expected a number from 1 to N and the count N of parts, such as 3/10".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts() {
        for text in ["3/10", "3 / 10", "3-of-10"] {
            assert_eq!(part(text), Ok(Part { number: 3, of: 10 }));
        }
        for bad in ["", "3", "0/3", "4/3", "1/0", "-1/3", "1/2/3"] {
            assert!(part(bad).is_err(), "{bad}");
        }
    }
}
