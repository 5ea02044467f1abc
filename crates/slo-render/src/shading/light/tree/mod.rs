//! A tree of lights: chooses one of many in proportion to an estimate of the light that a hit
//! receives from it.
//!
//! A node has up to 16 children. The choice walks down from the root by one random number, which is
//! rescaled at each node. The children of a node always come in the same order, so numbers that are
//! well distributed give choices that are.
//!
//! Source: A. Conty Estevez and C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting" (2018), without their splitting.

mod build;
mod few;
mod node;
mod sums;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::bounds::LightBounds;
use super::receiver;
use few::{ChooseFew, FEW};
use node::Node;
use slo_accel::math::columns::{BATCH, Column, Vec3s};
use slo_accel::{Isa, Lanewise};
use sums::Sums;
use sums::WIDTH;

/// Number of a light that does not exist: none may bring light.
pub const NO_LIGHT: u32 = u32::MAX;

/// Chooses one of many lights for a hit.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// The first is the root. There are none if there are no lights.
    nodes: Vec<Node>,
    /// For each light, the way down to it: the number of a child for each node, 4 bits each, that
    /// of the root in the lowest.
    paths: Vec<u64>,
}

/// A light chosen for a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Its number; [`NO_LIGHT`] if no light can reach the hit.
    pub light: u32,
    /// The probability of the choice.
    pub chance: f32,
    /// The random number, rescaled after the choice to be uniform in `[0, 1)` again.
    pub rest: f32,
}

/// Lights chosen for a batch of hits, in columns.
#[derive(Debug)]
pub struct Choices {
    /// See [`Chosen::light`].
    pub light: Column<u32>,
    /// See [`Chosen::chance`].
    pub chance: Column<f32>,
    /// See [`Chosen::rest`].
    pub rest: Column<f32>,
}

impl Default for Choices {
    fn default() -> Self {
        Self { light: [NO_LIGHT; BATCH], chance: [0.0; BATCH], rest: [0.0; BATCH] }
    }
}

impl LightTree {
    /// Chooses a light for a hit at `from` by a random number `u` in `[0, 1)`. `normal` is the
    /// packed geometric normal on the side that receives light, or
    /// [`receiver::ANY`]. A light that is alone is always chosen.
    #[inline(always)]
    pub fn choose(&self, from: Vec3, normal: u32, u: f32) -> Chosen {
        if let [_] = self.paths[..] {
            return Chosen { light: 0, chance: 1.0, rest: u };
        }
        let normal = receiver::unpack(normal);
        let (mut at, mut chance, mut rest) = (0, 1.0, u);
        let none = Chosen { light: NO_LIGHT, chance: 0.0, rest: u };
        loop {
            let Some(node) = self.nodes.get(at as usize) else { return none };
            let Some(parts) = node.parts(from, normal, at == 0) else { return none };
            let sums = Sums::new(parts);
            let (child, left) = sums.find(rest);
            chance *= sums.chance(child);
            rest = left;
            match node.light(child) {
                Some(light) => return Chosen { light, chance, rest },
                None => at = node.child(child),
            }
        }
    }

    /// Returns the probability with which [`choose`](Self::choose) chooses a light, with the same
    /// bits.
    #[inline(always)]
    pub fn chance(&self, light: u32, from: Vec3, normal: u32) -> f32 {
        let normal = receiver::unpack(normal);
        let Some(&path) = self.paths.get(light as usize) else { return 0.0 };
        if self.paths.len() == 1 {
            return 1.0;
        }
        let (mut at, mut chance, mut path) = (0, 1.0, path);
        loop {
            let node = &self.nodes[at as usize];
            let Some(parts) = node.parts(from, normal, at == 0) else { return 0.0 };
            let child = path as usize % WIDTH;
            chance *= Sums::new(parts).chance(child);
            if node.light(child).is_some() {
                return chance;
            }
            at = node.child(child);
            path /= WIDTH as u64;
        }
    }

    /// Chooses a light for each of `len` hits; see [`choose`](Self::choose).
    pub fn choose_all(
        &self,
        isa: Isa,
        len: usize,
        from: &Vec3s,
        normal: &Column<u32>,
        u: &Column<f32>,
        to: &mut Choices,
    ) {
        let len = len.min(BATCH);
        if let Some(root) = self.root_of_few() {
            isa.run(ChooseFew { root, len, from, normal, u, to });
        } else {
            isa.run(ChooseAll { tree: self, len, from, normal, u, to });
        }
    }

    /// Finds the chance of one light for each of `len` hits; see [`chance`](Self::chance). It is 0
    /// for numbers that no light has.
    pub fn chance_all(
        &self,
        isa: Isa,
        len: usize,
        light: &Column<u32>,
        from: &Vec3s,
        normal: &Column<u32>,
        to: &mut Column<f32>,
    ) {
        isa.run(ChanceAll { tree: self, len: len.min(BATCH), light, from, normal, to });
    }

    /// Returns the root if its children are a few lights.
    fn root_of_few(&self) -> Option<&Node> {
        let is_few = (2..=FEW).contains(&self.paths.len());
        self.nodes.first().filter(|_| is_few && self.nodes.len() == 1)
    }

    /// Returns the number of lights.
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Whether there are no lights.
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Returns the bytes that it takes.
    pub fn memory(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.paths[..])
    }
}

struct ChooseAll<'a> {
    tree: &'a LightTree,
    len: usize,
    from: &'a Vec3s,
    normal: &'a Column<u32>,
    u: &'a Column<f32>,
    to: &'a mut Choices,
}

impl Lanewise for ChooseAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { tree, len, from, normal, u, to } = self;
        for i in 0..len {
            let chosen = tree.choose(from.get(i), normal[i], u[i]);
            to.light[i] = chosen.light;
            to.chance[i] = chosen.chance;
            to.rest[i] = chosen.rest;
        }
    }
}

struct ChanceAll<'a> {
    tree: &'a LightTree,
    len: usize,
    light: &'a Column<u32>,
    from: &'a Vec3s,
    normal: &'a Column<u32>,
    to: &'a mut Column<f32>,
}

impl Lanewise for ChanceAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { tree, len, light, from, normal, to } = self;
        for i in 0..len {
            to[i] = tree.chance(light[i], from.get(i), normal[i]);
        }
    }
}

impl LightTree {
    /// Builds the tree of lights, whose numbers are their places in the list.
    pub fn new(lights: &[LightBounds]) -> Self {
        build::build(lights)
    }
}
