//! Frames as studios write them: `1-100x5,120,-5--1`.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use super::numbers::whole;

/// Maximum number of frames in one run. More are a typing mistake.
const MOST: u128 = 1_000_000;

/// Frames in the order in which they were asked for, each once.
///
/// The grammar follows Python's fileseq: terms between commas, each a frame `a`, a range `a-b`
/// that may descend, or a range with a step. `a-bxN` is every Nth frame of the range, and `a-byN`
/// all others. `a-b:N` is every Nth, then every N-1st, and so on to every one, without
/// repetitions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Frames {
    /// Never empty.
    pub(crate) numbers: Vec<i64>,
    /// Whether a range or a list was asked for, even if it has only one frame.
    pub(crate) is_sequence: bool,
}

impl Frames {
    /// Makes the single frame `number`.
    pub(crate) fn single(number: i64) -> Self {
        Self { numbers: vec![number], is_sequence: false }
    }

    /// Collects all frames of some ranges, which do not overlap.
    ///
    /// # Errors
    /// There are no frames, or too many, in words for the user.
    pub(crate) fn of_ranges(ranges: Vec<RangeInclusive<i64>>) -> Result<Self, String> {
        let span = |range: &RangeInclusive<i64>| {
            if range.is_empty() { 0 } else { range.end().abs_diff(*range.start()) as u128 + 1 }
        };
        match ranges.iter().map(span).sum::<u128>() {
            0 => Err("the scene's camera has no frames".into()),
            count if count > MOST => {
                Err(format!("the scene has {count} frames; one run renders at most {MOST}"))
            }
            _ => Ok(Self { numbers: ranges.into_iter().flatten().collect(), is_sequence: true }),
        }
    }

    /// Parses frames as typed.
    ///
    /// # Errors
    /// What was expected, in words for the user.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let terms: Vec<Term> =
            text.split(',').map(|term| Term::parse(term.trim())).collect::<Result<_, _>>()?;
        let count: u128 = terms.iter().map(Term::span).sum();
        if count > MOST {
            return Err(format!("{count} frames are too many; one run renders at most {MOST}"));
        }
        let mut seen = HashSet::new();
        let mut numbers: Vec<i64> = terms.iter().flat_map(Term::numbers).collect();
        numbers.retain(|&number| seen.insert(number));
        if numbers.is_empty() {
            return Err("no frame is left: `y1` leaves out all of them".into());
        }
        let is_sequence = !matches!(terms[..], [Term { end: None, .. }]);
        Ok(Self { numbers, is_sequence })
    }
}

/// `--frame`
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FrameChoice {
    /// All frames that the scene has.
    All,
    These(Frames),
}

impl FrameChoice {
    /// Whether a range or a list was asked for, even if it has only one frame.
    pub(crate) fn is_sequence(&self) -> bool {
        match self {
            Self::All => true,
            Self::These(frames) => frames.is_sequence,
        }
    }

    /// Whether there may be more than one frame.
    pub(crate) fn is_several(&self) -> bool {
        match self {
            Self::All => true,
            Self::These(frames) => frames.numbers.len() > 1,
        }
    }
}

/// Parses frames, or `all`.
pub(crate) fn frames(text: &str) -> Result<FrameChoice, String> {
    match text.trim().eq_ignore_ascii_case("all") {
        true => Ok(FrameChoice::All),
        false => Frames::parse(text).map(FrameChoice::These),
    }
}

/// A term between two commas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Term {
    start: i64,
    end: Option<i64>,
    step: Step,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Every(u64),
    AllBut(u64),
    Staggered(u64),
}

const EXPECTED: &str = "write frames such as 15, 1-100, 1-100x5, 1-100y5 or 1-100:5, separated by \
                        commas, or all";

impl Term {
    fn parse(text: &str) -> Result<Self, String> {
        let wrong = |what: String| format!("{what}; {EXPECTED}");
        let (start, rest) = integer(text)?;
        if rest.is_empty() {
            return Ok(Self { start, end: None, step: Step::Every(1) });
        }
        let Some(rest) = rest.strip_prefix('-') else {
            return Err(wrong(format!("`{rest}` can't follow `{start}`")));
        };
        let (end, rest) = integer(rest)?;
        let Some(kind) = rest.chars().next() else {
            return Ok(Self { start, end: Some(end), step: Step::Every(1) });
        };
        let make = match kind {
            'x' => Step::Every,
            'y' => Step::AllBut,
            ':' => Step::Staggered,
            _ => return Err(wrong(format!("`{rest}` can't follow `{start}-{end}`"))),
        };
        let (by, rest) = integer(&rest[1..])?;
        let descends = end < start;
        if !rest.is_empty() || by == 0 || (by < 0 && !descends) {
            return Err(wrong(format!("a step is a whole number of at least 1, not `{by}{rest}`")));
        }
        Ok(Self { start, end: Some(end), step: make(by.unsigned_abs()) })
    }

    /// Returns the number of frames from start to end, regardless of the step.
    fn span(&self) -> u128 {
        let end = self.end.unwrap_or(self.start);
        i128::from(end).abs_diff(i128::from(self.start)) + 1
    }

    fn numbers(&self) -> Vec<i64> {
        let end = self.end.unwrap_or(self.start);
        let offsets = 0..self.start.abs_diff(end) + 1;
        let at = |offset: u64| {
            if end < self.start {
                self.start.wrapping_sub_unsigned(offset)
            } else {
                self.start.wrapping_add_unsigned(offset)
            }
        };
        match self.step {
            Step::Every(n) => offsets.filter(|o| o.is_multiple_of(n)).map(at).collect(),
            Step::AllBut(n) => offsets.filter(|o| !o.is_multiple_of(n)).map(at).collect(),
            Step::Staggered(n) => staggered(offsets.end, n).into_iter().map(at).collect(),
        }
    }
}

/// Orders `0..count` by the first step of n, n - 1, ... 1 that divides the number.
fn staggered(count: u64, n: u64) -> Vec<u64> {
    let mut seen = HashSet::new();
    // Steps larger than the range all give its first frame.
    let steps = (1..=n.min(count)).rev();
    let by = |step: u64| (0..count).step_by(usize::try_from(step).unwrap_or(usize::MAX));
    let mut result = vec![0];
    seen.insert(0);
    for step in steps {
        if seen.len() as u64 == count {
            break;
        }
        result.extend(by(step).filter(|&offset| seen.insert(offset)));
    }
    result
}

/// Returns the number at the beginning of `text`, and what follows it.
fn integer(text: &str) -> Result<(i64, &str), String> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let after = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    let (number, rest) = text.split_at(text.len() - digits.len() + after);
    if after == 0 {
        let found = if text.is_empty() { "nothing".into() } else { format!("`{text}`") };
        return Err(format!("expected a number, but found {found}; {EXPECTED}"));
    }
    let value = number
        .parse()
        .map_err(|_| format!("`{number}` is too large for a frame, such as 15 or 1-100"))?;
    Ok((value, rest))
}

/// Formats frames for people, as in `frame 7` and `frames 1-4, 7`.
pub(crate) fn named(frames: &[i64]) -> String {
    format!("{} {}", if frames.len() == 1 { "frame" } else { "frames" }, shown(frames))
}

/// Formats frames for people, in ascending order: `1-4, 7, 9-10`.
pub(crate) fn shown(frames: &[i64]) -> String {
    let mut sorted = frames.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let runs = sorted.chunk_by(|a, b| a.checked_add(1) == Some(*b)).map(|run| match run {
        [only] => only.to_string(),
        [first, .., last] => format!("{first}-{last}"),
        [] => String::new(),
    });
    runs.collect::<Vec<_>>().join(", ")
}

/// Parses the number of one frame.
pub(crate) fn frame(text: &str) -> Result<i64, String> {
    let text = text.trim();
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    let number = whole(digits).filter(|_| !digits.starts_with('+') || sign == 1);
    let number = number.and_then(|number| i64::try_from(number).ok());
    number.map(|number| sign * number).ok_or_else(|| "expected a whole number, such as 12".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(typed: &str, expected: &[i64]) {
        assert_eq!(Frames::parse(typed).map(|f| f.numbers), Ok(expected.to_vec()), "{typed}");
    }

    #[test]
    fn the_studio_grammar() {
        check("15", &[15]);
        check("-5", &[-5]);
        check("08", &[8]);
        check("1-5", &[1, 2, 3, 4, 5]);
        check("5-1", &[5, 4, 3, 2, 1]);
        check("-5--1", &[-5, -4, -3, -2, -1]);
        check("-2-2", &[-2, -1, 0, 1, 2]);
        check("1-10x3", &[1, 4, 7, 10]);
        check("1-9x3", &[1, 4, 7]);
        check("10-1x3", &[10, 7, 4, 1]);
        check("10-1x-3", &[10, 7, 4, 1]);
        check("1-10y3", &[2, 3, 5, 6, 8, 9]);
        check("1-10:5", &[1, 6, 5, 9, 4, 7, 10, 3, 2, 8]);
        check("1-3:9", &[1, 3, 2]);
        check("1-20x5,120,-5--3", &[1, 6, 11, 16, 120, -5, -4, -3]);
        check("3, 1-4 ,2", &[3, 1, 2, 4]);
        check("9223372036854775806-9223372036854775807", &[i64::MAX - 1, i64::MAX]);
        check("1-3x18446744073709551", &[1]);
    }

    #[test]
    fn what_is_no_frame() {
        for bad in [
            "",
            ",",
            "1,",
            "x",
            "1.5",
            "1-",
            "-",
            "--1",
            "1x2",
            "1-5x",
            "1-5x0",
            "1-5x-1",
            "1-5z2",
            "1-5x2x2",
            "1 2",
            "1-5y1",
            "1..5",
            "99999999999999999999",
            "--quiet",
            "1-9999999",
            "-9223372036854775808-9223372036854775807",
            "#",
            "1-5@2",
        ] {
            assert!(Frames::parse(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn the_frames_of_a_scene() {
        let none = RangeInclusive::new(7, 6);
        let frames = Frames::of_ranges(vec![-1..=1, none.clone(), 8..=9]).unwrap();
        assert_eq!((frames.numbers, frames.is_sequence), (vec![-1, 0, 1, 8, 9], true));
        assert!(Frames::of_ranges(vec![none]).is_err());
        assert!(Frames::of_ranges(vec![i64::MIN..=i64::MAX]).is_err());
    }

    #[test]
    fn a_range_of_one_frame_is_a_sequence() {
        for (typed, expected) in [("5", false), ("-5", false), ("5-5", true), ("5,5", true)] {
            assert_eq!(Frames::parse(typed).unwrap().is_sequence, expected, "{typed}");
        }
    }

    #[test]
    fn runs_are_shown_short() {
        assert_eq!(shown(&[7, 3, 1, 2, 9, 10]), "1-3, 7, 9-10");
        assert_eq!(shown(&[-1, -2]), "-2--1");
        assert_eq!(shown(&[i64::MAX]), i64::MAX.to_string());
        assert_eq!(shown(&[]), "");
        assert_eq!((named(&[7]), named(&[1, 2])), ("frame 7".into(), "frames 1-2".into()));
    }
}
