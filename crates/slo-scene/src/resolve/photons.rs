//! Warnings about photons that find nothing.

use crate::description::SceneDescription;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::material::MaterialKind;
use crate::settings::Integrator;

/// Warns of `photons` if it finds nothing, of `photonSeed` without it, and of the lights that send no
/// photons. `photons` and `seed` are where the two are written, `lights` where the lights are.
pub(super) fn check(
    [photons, seed]: [Option<Span>; 2],
    scene: &SceneDescription,
    lights: &[Span],
    diagnostics: &mut Diagnostics,
) {
    let integrator = scene.settings.integrator;
    let is_photon_map = integrator == Integrator::PhotonMap;
    if is_photon_map {
        check_lights(scene, lights, diagnostics);
    }
    if scene.settings.photons == 0.0 {
        if is_photon_map {
            return;
        }
        if let Some(place) = seed {
            let warning = Diagnostic::warning("`photonSeed` does nothing without `photons`");
            diagnostics.push(warning.at(place, ""));
        }
        return;
    }
    // An option has no place.
    let warning = |message: String| {
        let warning = Diagnostic::warning(message);
        if let Some(place) = photons { warning.at(place, "") } else { warning }
    };
    if integrator != Integrator::Path {
        let message = format!("`photons` does nothing under `integrator {integrator}`");
        let help = if is_photon_map {
            "`photonMapSize` and `causticMapSize` say how many photons there are"
        } else {
            "write `integrator PATH`, the integrator that uses photons"
        };
        diagnostics.push(warning(message).help(help));
        return;
    }
    if !any_object(scene, &MaterialKind::is_sharp) {
        let message = "`photons` finds nothing: no object is smooth enough";
        let help = "photons follow mirrors, metal, gloss, coats and glass whose roughness is below \
                    0.447, and Phong's whose spread is below 0.142";
        diagnostics.push(warning(message.into()).help(help));
        return;
    }
    if check_lights(scene, lights, diagnostics) {
        return;
    }
    let shines = scene.lights.iter().any(|light| !light.kind.is_dark());
    if !shines && !any_object(scene, &emits) {
        let message = "`photons` finds nothing: there is no lamp to send them";
        let help = "`background` sends none: use an `environment`";
        diagnostics.push(warning(message.into()).help(help));
    }
}

/// Warns of the lights that send no photons. Returns whether there are any.
fn check_lights(scene: &SceneDescription, lights: &[Span], diagnostics: &mut Diagnostics) -> bool {
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
        return true;
    }
    false
}

fn emits(kind: &MaterialKind) -> bool {
    !matches!(kind, MaterialKind::Phong(_)) && kind.glows()
}

/// Whether the material of some object, or something that it is mixed from, has a property.
fn any_object(scene: &SceneDescription, has: &dyn Fn(&MaterialKind) -> bool) -> bool {
    let numbers = scene.objects.iter().map(|object| object.material.0 as usize);
    super::oddities::any_part(&scene.materials, numbers, has)
}
