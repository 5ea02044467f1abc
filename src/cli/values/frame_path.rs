//! Paths that name a frame.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

/// A path in which a run of `#` stands for the number of the frame, with at least as many digits.
/// The longest run counts; among equally long runs, the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FramePath(String);

impl FromStr for FramePath {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

impl FramePath {
    /// Returns the beginning and the length of the run that stands for the frame.
    fn run(&self) -> Option<(usize, usize)> {
        let starts = self.0.match_indices('#').map(|(at, _)| at);
        let starts = starts.filter(|&at| !self.0[..at].ends_with('#'));
        let length = |at: usize| self.0[at..].len() - self.0[at..].trim_start_matches('#').len();
        starts.map(|at| (at, length(at))).max_by_key(|&(_, length)| length)
    }

    /// Whether each frame has a path of its own.
    pub(crate) fn tells_frames(&self) -> bool {
        self.0.contains('#')
    }

    /// Returns the path of a frame.
    pub(crate) fn of(&self, frame: i64) -> PathBuf {
        let Some((start, digits)) = self.run() else { return PathBuf::from(&self.0) };
        let (before, after) = (&self.0[..start], &self.0[start + digits..]);
        let sign = if frame < 0 { "-" } else { "" };
        format!("{before}{sign}{:0digits$}{after}", frame.unsigned_abs()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_stand_for_the_frame() {
        let check = |path: &str, frame: i64, expected: &str| {
            let path: FramePath = path.parse().unwrap();
            assert_eq!(path.of(frame), PathBuf::from(expected));
        };
        check("a/b_####.png", 15, "a/b_0015.png");
        check("b_##.png", -12345, "b_-12345.png");
        check("#.png", 0, "0.png");
        check("b.png", 7, "b.png");
        check("take##_####.png", 15, "take##_0015.png");
        check("####/take#.png", 15, "0015/take#.png");
        check("šach##/b_##.png", 15, "šach##/b_15.png");
    }
}
