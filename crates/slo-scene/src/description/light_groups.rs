//! Groups of lights, whose light a picture can keep apart.

use std::collections::BTreeSet;

use super::SceneDescription;

/// The named groups of a scene's lights, in the order of their names. Light that belongs to none of them
/// forms the group [`REST`](Self::REST).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups(Vec<String>);

impl LightGroups {
    /// The name of the group of all light that has no name. A light that says so belongs to it too.
    pub const REST: &str = "rest";

    /// Most groups with a name of their own.
    pub const MOST: usize = 256;

    /// Most bytes of a name: it is part of a channel's name in EXR files.
    pub const LONGEST: usize = 240;

    /// The groups with these names, in any order.
    pub fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: BTreeSet<&str> = names.into_iter().filter(|name| *name != Self::REST).collect();
        Self(names.into_iter().map(str::to_owned).collect())
    }

    /// All names but [`REST`](Self::REST), in their order.
    pub fn names(&self) -> &[String] {
        &self.0
    }

    /// Number of groups with a name of their own.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether all light is in the group [`REST`](Self::REST).
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The place of a light's group among the [names](Self::names); `None` for the group
    /// [`REST`](Self::REST), and for names that no light of the scene has.
    pub fn index(&self, group: Option<&str>) -> Option<usize> {
        let group = group?;
        self.0.binary_search_by(|name| (**name).cmp(group)).ok()
    }
}

impl SceneDescription {
    /// The groups of its lights, and of objects that emit light.
    pub fn light_groups(&self) -> LightGroups {
        let lights = self.lights.iter().filter_map(|light| light.group.as_deref());
        let objects = self.objects.iter().filter_map(|object| object.light_group.as_deref());
        LightGroups::new(lights.chain(objects))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_an_order_of_their_own() {
        let groups = LightGroups::new(["rim", "key", "rest", "rim"]);
        assert_eq!(groups.names(), ["key", "rim"]);
        assert_eq!((groups.index(Some("rim")), groups.index(Some("key"))), (Some(1), Some(0)));
        for none in [None, Some("rest"), Some("other")] {
            assert_eq!(groups.index(none), None, "{none:?}");
        }
    }
}
