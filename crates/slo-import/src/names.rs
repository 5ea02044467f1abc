//! Names for elements and files.

use std::collections::HashSet;

/// Gives names that no other thing has.
#[derive(Debug, Default)]
pub(crate) struct Names(HashSet<String>);

impl Names {
    /// Returns a name like the one wanted that nothing else has. It is a single word: letters, digits and
    /// `_`, so that it can name a file on every system.
    pub(crate) fn new_name(&mut self, wanted: &str, otherwise: &str) -> String {
        let mut name: String = wanted
            .chars()
            .map(|c| if c.is_alphanumeric() { c } else { '_' })
            .take(60)
            .collect::<String>()
            .trim_matches('_')
            .to_owned();
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            let rest = std::mem::take(&mut name);
            name = if rest.is_empty() { otherwise.into() } else { format!("{otherwise}_{rest}") };
        }
        let (stem, mut number) = (name.clone(), 1);
        // Some systems do not tell capitals apart in the names of files.
        while !self.0.insert(name.to_lowercase()) {
            number += 1;
            name = format!("{stem}_{number}");
        }
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_words_that_stand_once() {
        let mut names = Names::default();
        let mut name = |wanted| names.new_name(wanted, "mesh");
        assert_eq!(name("Red wood.001"), "Red_wood_001");
        assert_eq!(name("red wood.001"), "red_wood_001_2");
        assert_eq!(name(""), "mesh");
        assert_eq!(name("../.."), "mesh_2");
        assert_eq!(name("3"), "mesh_3");
        assert_eq!(name("plošné světlo"), "plošné_světlo");
    }
}
