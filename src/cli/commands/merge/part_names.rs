//! Names of parts, and which parts are missing.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

/// The name of a part, such as `table_00015.pixels-1-of-3.part`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PartName<'a> {
    /// The name of the picture, without its extension.
    stem: &'a str,
    /// What the parts divide: pixels or samples.
    by: &'a str,
    /// Number of the part, from 1 on.
    number: u32,
    of: u32,
}

impl<'a> PartName<'a> {
    /// Parses a file's name. Returns `None` if it is not the name of a part.
    fn of(name: &'a str) -> Option<Self> {
        let (stem, part) = name.strip_suffix(".part")?.rsplit_once('.')?;
        let (by, part) = part.split_once('-')?;
        let (number, of) = part.split_once("-of-")?;
        let (number, of) = (number.parse().ok()?, of.parse().ok()?);
        let is_one = ["pixels", "samples"].contains(&by) && (1..=of).contains(&number);
        is_one.then_some(Self { stem, by, number, of })
    }
}

/// Says which parts are missing beside the named ones. Returns `None` if none is missing.
pub(super) fn missing<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut sets: BTreeMap<_, BTreeSet<u32>> = BTreeMap::new();
    for name in names.into_iter().filter_map(PartName::of) {
        sets.entry((name.stem, name.by, name.of)).or_default().insert(name.number);
    }
    let is_one = sets.len() == 1;
    let told = sets.iter().filter_map(|(&(stem, by, of), there)| {
        let of_which = if is_one { String::new() } else { format!(" of `{stem}` by {by}") };
        let (parts, are) = listed(&gaps(there, of))?;
        Some(format!("{parts} of {of}{of_which} {are} missing"))
    });
    Some(told.collect::<Vec<_>>().join("; ")).filter(|told| !told.is_empty())
}

/// Returns the numbers from 1 to `of` that are missing in `there`.
fn gaps(there: &BTreeSet<u32>, of: u32) -> Vec<RangeInclusive<u32>> {
    let mut next = 1;
    let mut gaps = Vec::new();
    for &number in there {
        if number > next {
            gaps.push(next..=number - 1);
        }
        next = number.saturating_add(1);
    }
    if next <= of && !there.contains(&of) {
        gaps.push(next..=of);
    }
    gaps
}

/// Lists part numbers in words, and chooses the verb for one or several. Returns `None` if there
/// are none.
fn listed(ranges: &[RangeInclusive<u32>]) -> Option<(String, &'static str)> {
    const MOST: usize = 8;
    let range = |range: &RangeInclusive<u32>| match (*range.start(), *range.end()) {
        (first, last) if first == last => vec![first.to_string()],
        (first, last) if first + 1 == last => vec![first.to_string(), last.to_string()],
        (first, last) => vec![format!("{first} to {last}")],
    };
    let mut words: Vec<String> = ranges.iter().flat_map(range).collect();
    if words.len() > MOST {
        words.truncate(MOST);
        words.push("others".into());
    }
    let is_one = matches!(ranges, [range] if range.start() == range.end());
    let last = words.pop()?;
    let text = if words.is_empty() { last } else { format!("{} and {last}", words.join(", ")) };
    Some(if is_one { (format!("part {text}"), "is") } else { (format!("parts {text}"), "are") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_parts() {
        let name = PartName::of("a.b_00015.pixels-1-of-3.part");
        let expected = PartName { stem: "a.b_00015", by: "pixels", number: 1, of: 3 };
        assert_eq!(name, Some(expected));
        for bad in [
            "a.part",
            "a.pixels-0-of-3.part",
            "a.pixels-4-of-3.part",
            "a.pixels-1-of-3",
            "a.tiles-1-of-3.part",
            "a.pixels-1-of-x.part",
        ] {
            assert_eq!(PartName::of(bad), None, "{bad}");
        }
    }

    #[test]
    fn missing_parts_are_named() {
        let check = |there: &[u32], of: u32, expected: Option<&str>| {
            let names: Vec<_> =
                there.iter().map(|k| format!("a.pixels-{k}-of-{of}.part")).collect();
            assert_eq!(missing(names.iter().map(|name| &**name)).as_deref(), expected);
        };
        check(&[1, 3], 3, Some("part 2 of 3 is missing"));
        check(&[1], 3, Some("parts 2 and 3 of 3 are missing"));
        check(&[2], 3, Some("parts 1 and 3 of 3 are missing"));
        check(&[5], 10, Some("parts 1 to 4 and 6 to 10 of 10 are missing"));
        check(&[2, 4], 7, Some("parts 1, 3 and 5 to 7 of 7 are missing"));
        check(&[1], u32::MAX, Some("parts 2 to 4294967295 of 4294967295 are missing"));
        check(&[u32::MAX], u32::MAX, Some("parts 1 to 4294967294 of 4294967295 are missing"));
        check(&[1, 2, 3], 3, None);
        let odd: Vec<u32> = (1..40).filter(|number| number % 2 == 1).collect();
        check(&odd, 39, Some("parts 2, 4, 6, 8, 10, 12, 14, 16 and others of 39 are missing"));
        assert_eq!(missing(["a.part"]), None);
        let told = missing(["a.pixels-1-of-2.part", "b.samples-2-of-2.part"]).unwrap();
        assert_eq!(
            told,
            "part 2 of 2 of `a` by pixels is missing; part 1 of 2 of `b` by samples is missing"
        );
    }
}
