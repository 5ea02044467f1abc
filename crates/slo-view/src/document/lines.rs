//! Differences between texts, line by line.

use std::ops::Range;

/// Most lines, on each side, that are compared one by one; more that differ count as one block.
const MOST: usize = 2000;

/// Lines that have been replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Hunk {
    /// Number of the first line in the old text, from 1.
    pub(crate) line: usize,
    pub(crate) old: Vec<String>,
    pub(crate) new: Vec<String>,
}

/// Returns the lines that differ between two texts.
pub(crate) fn differences(old: &str, new: &str) -> Vec<Hunk> {
    let [old, new] = [old, new].map(|text| text.split_inclusive('\n').collect::<Vec<_>>());
    let hunk = |(a, b): (Range<usize>, Range<usize>)| Hunk {
        line: a.start + 1,
        old: old[a].iter().map(|line| (*line).to_owned()).collect(),
        new: new[b].iter().map(|line| (*line).to_owned()).collect(),
    };
    changes(&old, &new).into_iter().map(hunk).collect()
}

/// Returns a text with the changes of two others; `None` if they change the same lines in different ways.
pub(crate) fn merged(base: &str, ours: &str, theirs: &str) -> Option<String> {
    let [base, ours, theirs] =
        [base, ours, theirs].map(|text| text.split_inclusive('\n').collect::<Vec<_>>());
    let replacements = |new: &[&str]| -> Vec<(Range<usize>, String)> {
        changes(&base, new).into_iter().map(|(a, b)| (a, new[b].concat())).collect()
    };
    let mut all = replacements(&ours);
    all.extend(replacements(&theirs));
    all.sort_by_key(|(range, _)| (range.start, range.end));
    all.dedup();
    let mut result = String::new();
    let mut at = 0;
    let mut before: Option<Range<usize>> = None;
    for (range, new) in all {
        // Changes that touch may belong together.
        if before.is_some_and(|before| range.start <= before.end) {
            return None;
        }
        result.push_str(&base[at..range.start].concat());
        result.push_str(&new);
        at = range.end;
        before = Some(range);
    }
    result.push_str(&base[at..].concat());
    Some(result)
}

/// Returns the ranges of lines that differ, in both texts.
fn changes(old: &[&str], new: &[&str]) -> Vec<(Range<usize>, Range<usize>)> {
    let start = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let pairs = old[start..].iter().rev().zip(new[start..].iter().rev());
    let end = pairs.take_while(|(a, b)| a == b).count();
    let (a, b) = (&old[start..old.len() - end], &new[start..new.len() - end]);
    if a.is_empty() && b.is_empty() {
        return Vec::new();
    }
    if a.len() > MOST || b.len() > MOST {
        return vec![(start..start + a.len(), start..start + b.len())];
    }
    // The longest common sequence: `longest[i][j]` is its length for what begins at i and j.
    let width = b.len() + 1;
    let mut longest = vec![0u16; (a.len() + 1) * width];
    for i in (0..a.len()).rev() {
        for j in (0..b.len()).rev() {
            longest[i * width + j] = if a[i] == b[j] {
                longest[(i + 1) * width + j + 1] + 1
            } else {
                longest[(i + 1) * width + j].max(longest[i * width + j + 1])
            };
        }
    }
    let mut found: Vec<(Range<usize>, Range<usize>)> = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        if i < a.len() && j < b.len() && a[i] == b[j] {
            (i, j) = (i + 1, j + 1);
            continue;
        }
        let (from_i, from_j) = (i, j);
        while (i < a.len() || j < b.len()) && !(i < a.len() && j < b.len() && a[i] == b[j]) {
            let skips_old = j == b.len()
                || (i < a.len() && longest[(i + 1) * width + j] >= longest[i * width + j + 1]);
            if skips_old { i += 1 } else { j += 1 }
        }
        found.push((start + from_i..start + i, start + from_j..start + j));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(old: &str, new: &str, expected: &[(usize, &str, &str)]) {
        let found: Vec<_> = differences(old, new)
            .into_iter()
            .map(|hunk| (hunk.line, hunk.old.concat(), hunk.new.concat()))
            .collect();
        let expected: Vec<_> = expected
            .iter()
            .map(|(line, old, new)| (*line, (*old).to_owned(), (*new).to_owned()))
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn lines_that_differ() {
        check("a\nb\nc\n", "a\nb\nc\n", &[]);
        check("a\nb\nc\n", "a\nx\nc\n", &[(2, "b\n", "x\n")]);
        check("a\nb\nc\nd\n", "x\nb\nc\ny\n", &[(1, "a\n", "x\n"), (4, "d\n", "y\n")]);
        check("a\nb\n", "a\nn\nb\n", &[(2, "", "n\n")]);
        check("a\nb\nc", "a\nc", &[(2, "b\n", "")]);
        check("", "a", &[(1, "", "a")]);
    }

    #[test]
    fn changes_of_both_are_merged() {
        let base = "a\nb\nc\nd\ne\n";
        assert_eq!(
            merged(base, "x\nb\nc\nd\ne\n", "a\nb\nc\nd\n").as_deref(),
            Some("x\nb\nc\nd\n")
        );
        assert_eq!(merged(base, base, "z").as_deref(), Some("z"));
        assert_eq!(merged(base, "a\nx\nc\nd\ne\n", "a\ny\nc\nd\ne\n"), None);
        assert_eq!(merged(base, "a\nx\nc\nd\ne\n", "a\nb\ny\nd\ne\n"), None);
        let same = "a\nx\nc\nd\ne\n";
        assert_eq!(merged(base, same, same).as_deref(), Some(same));
    }
}
