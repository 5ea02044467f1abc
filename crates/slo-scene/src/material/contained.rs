//! Materials that contain others: in which order they can be looked at, and what is true of one
//! with all that it contains.

use super::Material;
use super::id::MaterialId;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::format::written;

/// How many mixes may lie within one another.
pub const MOST_MIXES: usize = 64;

/// How many materials of a circle an error shows.
const MOST_SHOWN: usize = 6;

/// Why materials can't be put in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tangle {
    /// Each contains the next, and the last contains the first.
    Circle(Vec<MaterialId>),
    /// So many mixes lie within this one that they are more than [`MOST_MIXES`].
    TooDeep(MaterialId),
}

/// What is true of a material with all that it contains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Whole {
    /// It shows an image, or an image bends its normals.
    pub(crate) has_images: bool,
    /// An image bends its normals.
    pub(crate) bends_normals: bool,
}

/// The materials in an order in which each follows those that it contains. Takes time in
/// proportion to their number.
///
/// # Errors
/// A material contains itself, or mixes are nested too deeply; the first such fault.
pub fn inside_out(materials: &[Material]) -> Result<Vec<MaterialId>, Tangle> {
    let mut walk = Walk::new(materials);
    (0..materials.len()).for_each(|root| walk.visit(root));
    match walk.tangles.into_iter().next() {
        Some(tangle) => Err(tangle),
        None => Ok(walk.order),
    }
}

/// What is true of each material with all that it contains.
pub(crate) fn wholes(materials: &[Material]) -> Vec<Whole> {
    let mut wholes: Vec<Whole> = materials.iter().map(alone).collect();
    // Circles are reported elsewhere; their materials count for themselves.
    for of in inside_out(materials).unwrap_or_default() {
        let of = of.0 as usize;
        for part in materials[of].kind.parts().into_iter().flatten() {
            let Some(part) = wholes.get(part.0 as usize).copied() else { continue };
            let whole = &mut wholes[of];
            whole.has_images |= part.has_images;
            whole.bends_normals |= part.bends_normals;
        }
    }
    wholes
}

/// What is true of a material without what it contains.
fn alone(material: &Material) -> Whole {
    let mut has_images = false;
    material.kind.for_images(&mut |_| has_images = true);
    let bends_normals = material.kind.bends_normals();
    Whole { has_images, bends_normals }
}

/// Reports materials that contain themselves, and mixes that are nested too deeply; `heads` are the
/// places that the materials are defined at.
pub(crate) fn check_contained(
    materials: &[Material],
    heads: &[Span],
    diagnostics: &mut Diagnostics,
) {
    let mut walk = Walk::new(materials);
    (0..materials.len()).for_each(|root| walk.visit(root));
    let name = |id: &MaterialId| written(&materials[id.0 as usize].name).into_owned();
    let head = |id: &MaterialId| heads[id.0 as usize];
    for tangle in &walk.tangles {
        diagnostics.push(match tangle {
            Tangle::Circle(circle) => contains_itself(circle, &name, &head),
            Tangle::TooDeep(id) => {
                let message = format!("mixes are nested more than {MOST_MIXES} deep");
                let label = format!("so many lie within `{}`", name(id));
                Diagnostic::error(message).at(head(id), label)
            }
        });
    }
}

/// The error about a circle.
fn contains_itself(
    circle: &[MaterialId],
    name: &dyn Fn(&MaterialId) -> String,
    head: &dyn Fn(&MaterialId) -> Span,
) -> Diagnostic {
    let first = &circle[0];
    let next = |i: usize| match circle.get(i + 1) {
        Some(next) => format!("mixes `{}`", name(next)),
        None if i == 0 => "mixes itself".to_owned(),
        None => format!("mixes `{}` again", name(first)),
    };
    let error = Diagnostic::error(format!("material `{}` contains itself", name(first)));
    let mut error = error.at(head(first), next(0));
    for (i, part) in circle.iter().enumerate().skip(1).take(MOST_SHOWN - 1) {
        error = error.also(head(part), next(i));
    }
    if let [_, _, ..] = circle {
        let shown = circle.iter().take(MOST_SHOWN).map(name).collect::<Vec<_>>().join(" -> ");
        let cut = if circle.len() > MOST_SHOWN { " -> ..." } else { "" };
        error = error.help(format!("the chain is {shown}{cut} -> {}", name(first)));
    }
    error
}

/// A walk through materials and what they contain, without recursion.
struct Walk<'m> {
    materials: &'m [Material],
    /// What is known of each.
    states: Vec<State>,
    order: Vec<MaterialId>,
    tangles: Vec<Tangle>,
    /// Materials of circles that were found.
    in_circles: Vec<bool>,
}

/// What a walk knows of a material.
#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    /// What it contains is being looked at.
    Open,
    /// How many mixes lie within one another in it, itself included.
    Done(usize),
}

impl<'m> Walk<'m> {
    fn new(materials: &'m [Material]) -> Self {
        let count = materials.len();
        let (states, in_circles) = (vec![State::New; count], vec![false; count]);
        let order = Vec::with_capacity(count);
        Self { materials, states, order, tangles: Vec::new(), in_circles }
    }

    /// Puts a material and all that it contains in order.
    fn visit(&mut self, root: usize) {
        // The materials that are open, and how many parts of each have been looked at.
        let mut path: Vec<(usize, usize)> = Vec::new();
        if self.states[root] == State::New {
            self.states[root] = State::Open;
            path.push((root, 0));
        }
        while let Some((of, seen)) = path.last_mut() {
            let (of, part) = (*of, self.part(*of, *seen));
            *seen += 1;
            let Some(part) = part else {
                self.close(of);
                path.pop();
                continue;
            };
            match self.states.get(part) {
                Some(State::New) => {
                    self.states[part] = State::Open;
                    path.push((part, 0));
                }
                Some(State::Open) => self.note_circle(&path, part),
                Some(State::Done(_)) | None => {}
            }
        }
    }

    /// A part of a material.
    fn part(&self, of: usize, index: usize) -> Option<usize> {
        let part = *self.materials[of].kind.parts()?.get(index)?;
        Some(part.0 as usize)
    }

    /// All parts of a material are in order.
    fn close(&mut self, of: usize) {
        let depth_of = |part: MaterialId| match self.states.get(part.0 as usize) {
            Some(State::Done(depth)) => *depth,
            _ => 0,
        };
        let parts = self.materials[of].kind.parts();
        let depth =
            parts.map_or(0, |parts| 1 + parts.map(depth_of).into_iter().fold(0, usize::max));
        if depth == MOST_MIXES + 1 {
            self.tangles.push(Tangle::TooDeep(MaterialId(of as u32)));
        }
        self.states[of] = State::Done(depth);
        self.order.push(MaterialId(of as u32));
    }

    /// Notes a circle that begins and ends in `first`, unless one that touches it is known.
    fn note_circle(&mut self, path: &[(usize, usize)], first: usize) {
        let start = path.iter().rposition(|(of, _)| *of == first).unwrap_or(0);
        let circle: Vec<usize> = path[start..].iter().map(|(of, _)| *of).collect();
        if circle.iter().any(|of| self.in_circles[*of]) {
            return;
        }
        circle.iter().for_each(|of| self.in_circles[*of] = true);
        let circle = circle.into_iter().map(|of| MaterialId(of as u32)).collect();
        self.tangles.push(Tangle::Circle(circle));
    }
}
