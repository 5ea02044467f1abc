//! What materials look like with all that they are mixed from.

use crate::attributes::Element;
use crate::description::mix_order;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::material::{Material, MaterialKind};

/// Most materials of a chain that a message shows.
const MOST_SHOWN: usize = 6;

/// Properties of the materials of a scene, each with its parts. Empty if a material is broken.
#[derive(Default)]
pub(super) struct Looks {
    /// Whether the material shows an image.
    has_image: Vec<bool>,
    /// Whether the material is a lamp.
    emits: Vec<bool>,
}

impl Looks {
    /// Reports a material that is mixed from itself. `elements` are those of all materials.
    pub(super) fn of(
        materials: &[Material],
        elements: &[Element<'_, '_>],
        diagnostics: &mut Diagnostics,
    ) -> Self {
        if materials.len() != elements.len() {
            return Self::default();
        }
        match mix_order(materials) {
            Ok(order) => Self {
                has_image: through_mixes(materials, &order, |kind| kind.image().is_some()),
                emits: through_mixes(materials, &order, emits),
            },
            Err(circle) => {
                report_circle(&circle, elements, diagnostics);
                Self::default()
            }
        }
    }

    /// Whether a material shows an image.
    pub(super) fn has_image(&self, material: usize) -> bool {
        self.has_image.get(material).is_some_and(|has_image| *has_image)
    }

    /// Whether a material is known to be no lamp.
    pub(super) fn is_no_lamp(&self, material: usize) -> bool {
        self.emits.get(material).is_some_and(|emits| !emits)
    }
}

/// Whether a material is a lamp by itself.
fn emits(kind: &MaterialKind) -> bool {
    !matches!(kind, MaterialKind::Phong(_)) && kind.glows()
}

/// Which materials have a property: those that have it by themselves, and all that are mixed from
/// them.
pub(super) fn through_mixes(
    materials: &[Material],
    order: &[usize],
    has: impl Fn(&MaterialKind) -> bool,
) -> Vec<bool> {
    let mut all = vec![false; materials.len()];
    for &index in order {
        let kind = &materials[index].kind;
        let of_part = match kind {
            MaterialKind::Mix(mix) => [mix.first, mix.second].iter().any(|m| all[m.0 as usize]),
            _ => false,
        };
        all[index] = of_part || has(kind);
    }
    all
}

/// The error about materials of which each is mixed from the next, and the last from the first.
fn report_circle(circle: &[usize], elements: &[Element<'_, '_>], diagnostics: &mut Diagnostics) {
    let name = |at: usize| elements[circle[at % circle.len()]].name.text;
    let mut error = Diagnostic::error(format!("material `{}` is mixed from itself", name(0)));
    for at in 0..circle.len().min(MOST_SHOWN) {
        let left = circle.len() - at - 1;
        let label = if at + 1 == MOST_SHOWN && left > 0 {
            format!("takes `{}`, and so on, over {left} more", name(at + 1))
        } else {
            format!("takes `{}`", name(at + 1))
        };
        let span = elements[circle[at]].head();
        error = if at == 0 { error.at(span, label) } else { error.also(span, label) };
    }
    diagnostics.push(error);
}
