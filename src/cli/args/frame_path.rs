//! Paths that name a frame.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

/// A path in which a run of `#` stands for the number of the frame, with at least as many digits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct FramePath(String);

impl FromStr for FramePath {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

impl FramePath {
    /// Whether each frame has a path of its own.
    pub(in crate::cli) fn tells_frames(&self) -> bool {
        self.0.contains('#')
    }

    /// The path of a frame.
    pub(in crate::cli) fn of(&self, frame: i64) -> PathBuf {
        let Some(start) = self.0.find('#') else { return PathBuf::from(&self.0) };
        let (before, rest) = self.0.split_at(start);
        let after = rest.trim_start_matches('#');
        let digits = rest.len() - after.len();
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
    }
}
