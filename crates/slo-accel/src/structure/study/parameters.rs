//! How structures are built and traversed: one list of parameters for all of them.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

/// Parameters of structures. Each structure reads those that it knows; what is not given has the
/// structure's own default. No parameter changes a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Parameters {
    /// `GRID`: cells per object.
    pub density: Option<f32>,
    /// `GRID`: cells along the shortest side, divided by the fourth root of the number of objects.
    pub shortest: Option<f32>,
    /// `GRID`: cells along x, y and z.
    pub cells: Option<[u32; 3]>,
    /// `GRID`, `OCTREE`, `KD`: whether an object is tested only once by a ray.
    pub mailbox: bool,
    /// Trees: the greatest depth of a leaf; that of the root is 0.
    pub depth: Option<u32>,
    /// Trees: nodes with as many objects, or fewer, are leaves.
    pub leaf: Option<u32>,
    /// `OCTREE`: where nodes are cut.
    pub planes: Planes,
    /// `RTREE`: children of a node.
    pub capacity: Option<u32>,
    /// `KD`: what a ray does to reach the nodes that it has put off.
    pub traversal: Traversal,
    /// `KD`: entries of a short stack.
    pub stack: Option<u32>,
}

/// Where the nodes of an octree are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Planes {
    /// In the middle.
    #[default]
    Middle,
    /// Along each axis, where the surface area heuristic expects the least cost, between the middle
    /// and the mean of the objects.
    Cost,
}

/// How a ray reaches the nodes of a kd-tree that it has put off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Traversal {
    /// They wait on a stack.
    #[default]
    Stack,
    /// It starts again at the root.
    Restart,
    /// It starts again at the deepest node that holds all that is left.
    PushDown,
    /// They wait on a stack of few entries, 4 if not given; as `PushDown` if it has lost some.
    ShortStack,
}

impl Parameters {
    /// Names of the parameters in text.
    pub const NAMES: [&'static str; 10] = [
        "density",
        "shortest",
        "cells",
        "mailbox",
        "depth",
        "leaf",
        "planes",
        "capacity",
        "traversal",
        "stack",
    ];
}

impl Planes {
    /// All choices, each with its name in text.
    pub const NAMES: [(&'static str, Self); 2] = [("middle", Self::Middle), ("cost", Self::Cost)];
}

impl Traversal {
    /// All traversals, each with its name in text.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("stack", Self::Stack),
        ("restart", Self::Restart),
        ("push-down", Self::PushDown),
        ("short-stack", Self::ShortStack),
    ];
}

/// Reads parameters, such as `density=3,mailbox=1` or `cells=46x46x3`.
impl FromStr for Parameters {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parameters = Self::default();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| format!("`{part}` has no value, such as in `{part}=1`"))?;
            parameters.set(name.trim(), value.trim())?;
        }
        Ok(parameters)
    }
}

impl Parameters {
    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        let whole = |least: u32, most: u32| {
            let number = value.parse().ok().filter(|number| (least..=most).contains(number));
            let expected = || format!("{name}: expected a whole number from {least} to {most}");
            number.map(Some).ok_or_else(expected)
        };
        let real = || {
            let number = value.parse().ok().filter(|number: &f32| (1e-3..=1e3).contains(number));
            let expected = || format!("{name}: expected a number from 0.001 to 1000");
            number.map(Some).ok_or_else(expected)
        };
        match name {
            "density" => self.density = real()?,
            "shortest" => self.shortest = real()?,
            "cells" => self.cells = Some(cells(value)?),
            "mailbox" => self.mailbox = whole(0, 1)? == Some(1),
            "depth" => self.depth = whole(0, 63)?,
            "leaf" => self.leaf = whole(0, 1 << 20)?,
            "capacity" => self.capacity = whole(2, 1 << 16)?,
            "stack" => self.stack = whole(1, 1 << 10)?,
            "planes" => self.planes = one_of(name, value, &Planes::NAMES)?,
            "traversal" => self.traversal = one_of(name, value, &Traversal::NAMES)?,
            _ => {
                let near = Self::NAMES.into_iter().find(|known| is_near(known, name));
                let near =
                    near.map_or_else(String::new, |near| format!(", did you mean `{near}`?"));
                let known = Self::NAMES.join(", ");
                return Err(format!("unknown parameter `{name}`{near} (there are {known})"));
            }
        }
        Ok(())
    }
}

/// Reads one of several words.
fn one_of<T: Copy>(name: &str, value: &str, words: &[(&str, T)]) -> Result<T, String> {
    let found = words.iter().find(|(known, _)| *known == value);
    let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
    found
        .map(|(_, word)| *word)
        .ok_or_else(|| format!("{name}: expected one of {}", known.join(", ")))
}

/// Whether a word may be a misspelt or shortened one.
fn is_near(known: &str, name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let same = known.chars().zip(name.chars()).take_while(|(a, b)| a == b).count();
    same >= 3.min(known.len()) || (same >= 2 && name.len().abs_diff(known.len()) <= 1)
}

/// Reads numbers of cells.
fn cells(value: &str) -> Result<[u32; 3], String> {
    let numbers: Vec<u32> = value
        .split('x')
        .filter_map(|number| number.parse().ok())
        .filter(|number| (1..=1 << 20).contains(number))
        .collect();
    let expected = "cells: expected numbers along x, y and z, such as 46x46x3";
    <[u32; 3]>::try_from(numbers).map_err(|_| expected.to_owned())
}

/// Writes the parameters that are given, as they are read.
impl Display for Parameters {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self {
            density,
            shortest,
            cells,
            mailbox,
            depth,
            leaf,
            planes,
            capacity,
            traversal,
            stack,
        } = self;
        let mut parts = vec![];
        let reals = [("density", density), ("shortest", shortest)];
        parts.extend(reals.iter().filter_map(|(name, x)| Some(format!("{name}={}", (**x)?))));
        parts.extend(cells.map(|[x, y, z]| format!("cells={x}x{y}x{z}")));
        parts.extend(mailbox.then(|| "mailbox=1".to_owned()));
        let wholes = [("depth", depth), ("leaf", leaf), ("capacity", capacity), ("stack", stack)];
        parts.extend(wholes.iter().filter_map(|(name, n)| Some(format!("{name}={}", (**n)?))));
        let known = Planes::NAMES.into_iter().find(|(_, of)| of == planes);
        let known = known.filter(|_| *planes != Planes::default());
        parts.extend(known.map(|(name, _)| format!("planes={name}")));
        let known = Traversal::NAMES.into_iter().find(|(_, of)| of == traversal);
        let known = known.filter(|_| *traversal != Traversal::default());
        parts.extend(known.map(|(name, _)| format!("traversal={name}")));
        f.write_str(&parts.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_read_as_they_are_written() {
        for text in [
            "",
            "density=3,mailbox=1",
            "shortest=0.5,cells=46x46x3,depth=7,leaf=2,capacity=4,stack=9,traversal=short-stack",
            "traversal=restart",
            "depth=6,planes=cost",
        ] {
            assert_eq!(text.parse::<Parameters>().unwrap().to_string(), text);
        }
        assert_eq!(" density = 3 , ".parse::<Parameters>().unwrap().density, Some(3.0));
        let error = |text: &str| text.parse::<Parameters>().unwrap_err();
        assert!(error("densty=3").contains("did you mean `density`?"));
        assert!(error("mail=1").contains("did you mean `mailbox`?"));
        assert!(error("colour=3").contains("unknown parameter `colour` (there are density"));
        assert!(error("mailbox").contains("has no value"));
        assert!(error("density=0").contains("from 0.001 to 1000"));
        assert!(error("depth=64").contains("from 0 to 63"));
        assert!(error("cells=4x4").contains("such as 46x46x3"));
        assert!(error("traversal=jump").contains("push-down"));
        assert_eq!(error("planes=1"), "planes: expected one of middle, cost");
    }
}
