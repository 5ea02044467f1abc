//! What becomes of the light of a group: `NAME=FACTOR` or `NAME=R,G,B`.

use super::numbers::real;

/// A group of lights, and what its light is multiplied by.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gain {
    pub(crate) group: String,
    /// Red, green, blue.
    pub(crate) factors: [f64; 3],
}

impl std::fmt::Display for Gain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { group, factors: [r, g, b] } = self;
        if r == g && g == b { write!(f, "{group}={r}") } else { write!(f, "{group}={r},{g},{b}") }
    }
}

/// Parses `--group`.
pub(crate) fn gain(text: &str) -> Result<Gain, String> {
    let expected =
        || "expected a group and a factor or a colour, such as key=0.5 or key=1,0.8,0.6".to_owned();
    let (group, factors) = text.rsplit_once('=').ok_or_else(expected)?;
    let factor = |text: &str| real(text).filter(|factor| (0.0..=1e9).contains(factor));
    let factors: Option<Vec<f64>> = factors.split(',').map(factor).collect();
    let factors = match factors.as_deref() {
        Some([all]) => [*all; 3],
        Some([r, g, b]) => [*r, *g, *b],
        _ => return Err(expected()),
    };
    if group.is_empty() {
        return Err(expected());
    }
    Ok(Gain { group: group.to_owned(), factors })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_and_colours() {
        for (text, group, factors, shown) in [
            ("key=0.5", "key", [0.5; 3], "key=0.5"),
            ("rest=0", "rest", [0.0; 3], "rest=0"),
            ("a=b=150%", "a=b", [1.5; 3], "a=b=1.5"),
            ("sky=1, .8,0.6", "sky", [1.0, 0.8, 0.6], "sky=1,0.8,0.6"),
        ] {
            let found = gain(text).unwrap();
            assert_eq!((&*found.group, found.factors), (group, factors), "{text}");
            assert_eq!(found.to_string(), shown);
        }
        for bad in ["key", "=1", "key=", "key=x", "key=1,2", "key=-1", "key=1,2,3,4", "key=inf"] {
            assert!(gain(bad).unwrap_err().contains("key=0.5"), "{bad}");
        }
    }
}
