//! Warnings about photons that find nothing.

use crate::description::SceneDescription;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::material::MaterialKind;
use crate::settings::Integrator;

/// Warns of `photons`, which is written at `place`, if it finds nothing, and of the lights that send
/// none. `lights` are the places of all lights.
pub(super) fn check(
    place: Option<Span>,
    scene: &SceneDescription,
    lights: &[Span],
    diagnostics: &mut Diagnostics,
) {
    let Some(place) = place.filter(|_| scene.settings.photons > 0.0) else { return };
    let integrator = scene.settings.integrator;
    if integrator != Integrator::Path {
        let message = format!("`photons` does nothing under `integrator {integrator}`");
        let help = "write `integrator PATH`, the integrator that uses photons";
        diagnostics.push(Diagnostic::warning(message).at(place, "").help(help));
        return;
    }
    if !any_object(scene, &MaterialKind::is_sharp) {
        let warning = Diagnostic::warning("`photons` finds nothing: no object is smooth enough");
        let help = "photons follow mirrors, metal, gloss, coats and glass whose roughness is below \
                    0.447, and Phong's whose spread is below 0.142";
        diagnostics.push(warning.at(place, "").help(help));
        return;
    }
    let is_of_thesis = |number: &usize| scene.lights[*number].kind.is_of_thesis();
    let of_thesis: Vec<usize> = (0..scene.lights.len()).filter(is_of_thesis).collect();
    if let [first, others @ ..] = &of_thesis[..] {
        let light = &scene.lights[*first];
        let message = format!("light `{}` sends no photons", light.name);
        let label = match others.len() {
            0 => String::new(),
            1 => "nor does another light".into(),
            n => format!("nor do {n} other lights"),
        };
        let warning = Diagnostic::warning(message).at(lights[*first], label);
        let help = "light that does not fall off with distance has no power: use `lamp_point` or \
                    `lamp_rectangle` for caustics";
        diagnostics.push(warning.help(help));
        return;
    }
    let shines = scene.lights.iter().any(|light| !light.kind.is_dark());
    if !shines && !any_object(scene, &emits) {
        let warning = Diagnostic::warning("`photons` finds nothing: there is no lamp to send them");
        let help = "`background` sends none: use an `environment`";
        diagnostics.push(warning.at(place, "").help(help));
    }
}

fn emits(kind: &MaterialKind) -> bool {
    !matches!(kind, MaterialKind::Phong(_)) && kind.glows()
}

/// Whether the material of some object, or something that it is mixed from, has a property.
fn any_object(scene: &SceneDescription, has: &dyn Fn(&MaterialKind) -> bool) -> bool {
    let numbers = scene.objects.iter().map(|object| object.material.0 as usize);
    super::oddities::any_part(&scene.materials, numbers, has)
}
