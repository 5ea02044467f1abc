//! Names for elements and files.

use std::collections::HashMap;

/// Gives names that no other thing has.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// All names in lower case, since some systems do not tell capitals apart in the names of files.
    /// Beside each is the number up to which it is taken with a number behind it.
    taken: HashMap<String, u32>,
}

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
        let stem = name.to_lowercase();
        let Some(&known) = self.taken.get(&stem) else {
            self.taken.insert(stem, 1);
            return name;
        };
        let mut number = known + 1;
        while self.taken.contains_key(&format!("{stem}_{number}")) {
            number += 1;
        }
        self.taken.insert(format!("{stem}_{number}"), 1);
        self.taken.insert(stem, number);
        format!("{name}_{number}")
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
        assert_eq!(name(""), "mesh_4");
        assert_eq!(name("Mesh"), "Mesh_5");
        assert_eq!(name("plošné světlo"), "plošné_světlo");
    }
}
