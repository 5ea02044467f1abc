//! Warnings about scenes that the language allows and that nobody means.

use super::fields::{Fields, Value};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::{CamSegment, Camera, KeyFrame, Material, SceneDescription};

/// The brightest channel past which a colour of whole numbers was probably meant to go up to 255.
const DIMMEST_BYTE: f64 = 32.0;

/// How much more light than arrives a material may give back by the rounding of its numbers.
const ROUNDING: f64 = 1e-3;

/// Warns of a `phong_info` that gives back more light than arrives, or says what has no effect.
pub(super) fn check_phong_info(fields: &mut Fields<'_, '_, '_>, material: &Material) {
    let [mirrors, passes] = [material.reflectance > 0.0, material.refraction > 0.0];
    let dependent = [
        ("refraction_index", material.refraction_index != 1.0, "refraction", passes),
        ("diffuse_refraction", material.diffuse_refraction > 0.0, "refraction", passes),
        ("diffuse_reflection", material.diffuse_reflection > 0.0, "reflectance", mirrors),
        ("shininess", material.shininess > 0.0, "specular", material.specular != [0.0; 3]),
    ];
    for (name, is_given, needs, is_there) in dependent {
        let is_broken = |name| fields.get(name).is_some_and(|f| matches!(f.value, Value::Broken));
        let Some(field) = fields.get(name).filter(|_| is_given && !is_there && !is_broken(needs))
        else {
            continue;
        };
        let help = match needs {
            "specular" => "write `specular { r g b }`, the colour of the highlight",
            "refraction" => "write `refraction NUMBER`, the share of the light that passes through",
            _ => "write `reflectance NUMBER`, the share of the light that is mirrored",
        };
        let message = format!("`{name}` has no effect without `{needs}`");
        fields.diagnostics.push(Diagnostic::warning(message).at(field.keyword.span, "").help(help));
    }
    let diffuse = material.diffuse.into_iter().fold(0.0, f32::max);
    if let Some(field) = fields.get("diffuse")
        && f64::from(diffuse) > 1.0 + ROUNDING
        && !looks_like_bytes(material.diffuse)
    {
        let message = format!("`diffuse` gives back {diffuse} times the light that arrives");
        let warning = Diagnostic::warning(message).at(field.keyword.span, "");
        fields.diagnostics.push(warning.help("colours of surfaces are from 0 to 1"));
    }
    let sent = f64::from(material.reflectance) + f64::from(material.refraction);
    if sent > 1.0 + ROUNDING {
        let spans =
            ["reflectance", "refraction"].map(|name| fields.get(name)).into_iter().flatten();
        let mut spans = spans.map(|field| field.keyword.span);
        let Some(first) = spans.next() else { return };
        let message = format!("this sends on {sent:.3} times the light that arrives");
        let warning = Diagnostic::warning(message).at(first, "");
        let warning = spans.fold(warning, |warning, span| warning.also(span, "and this"));
        let help = "the picture gets brighter with each bounce; the sum should be 1 or less";
        fields.diagnostics.push(warning.help(help));
    }
}

/// Warns of a colour whose channels seem to go from 0 to 255.
pub(super) fn check_color(
    fields: &mut Fields<'_, '_, '_>,
    name: &str,
    span: Span,
    color: [f32; 3],
) {
    if looks_like_bytes(color) {
        let message = format!("`{name}` seems to be given from 0 to 255");
        let [r, g, b] = color.map(|c| format!("{:.3}", f64::from(c) / 255.0));
        let help = format!("full intensity is 1: write `{name} {{ {r} {g} {b} }}`");
        fields.diagnostics.push(Diagnostic::warning(message).at(span, "").help(help));
    }
}

fn looks_like_bytes(color: [f32; 3]) -> bool {
    let color = color.map(f64::from);
    let largest = color.into_iter().fold(0.0, f64::max);
    (DIMMEST_BYTE..=255.0).contains(&largest) && color.iter().all(|c| c.fract() == 0.0)
}

/// Warns of a shutter that is open for `blur` seconds if its segment takes less.
pub(super) fn check_shutter(
    fields: &mut Fields<'_, '_, '_>,
    blur: f64,
    span: Span,
    [start, end]: [f64; 2],
) {
    if blur <= end - start {
        return;
    }
    let message = format!(
        "the shutter is open for {blur} s, longer than {} takes ({} s)",
        fields.element.title(),
        end - start
    );
    let help = "`blurDuration` is in seconds: a shutter of 180 degrees is open for half a frame, \
                0.02 at 25 frames per second";
    fields.diagnostics.push(Diagnostic::warning(message).at(span, "").help(help));
}

/// Warns if all key frames of an object lie before the scene time that the camera sees, or after it.
pub(super) fn check_key_times(
    fields: &mut Fields<'_, '_, '_>,
    key_frames: &[KeyFrame],
    camera: &Camera,
) {
    let ([first, .., last], Some(at)) = (key_frames, fields.get("addKframe")) else { return };
    let seen = camera.segments.iter().map(scene_time);
    let seen = seen.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some([start, end]) = seen.filter(|[start, end]| *end < first.time || last.time < *start)
    else {
        return;
    };
    let when = if end < first.time { "after the end" } else { "before the start" };
    let message = format!("{} has key frames only {when} of scene time", fields.element.title());
    let mut warning = Diagnostic::warning(message)
        .at(at.keyword.span, format!("key frames from {} to {}", first.time, last.time))
        .help(format!("scene time goes from {start} to {end}: the object does not move"));
    let in_seconds = last.time / camera.fps;
    let are_frames = key_frames.iter().all(|key_frame| key_frame.time.fract() == 0.0);
    if are_frames && end < first.time && in_seconds <= end {
        warning = warning.help(format!(
            "scene time is in seconds, from {start} to {end}: frame {} is at time {in_seconds:.3}",
            last.time
        ));
    }
    fields.diagnostics.push(warning);
}

/// What a segment sees of scene time, in order.
fn scene_time(segment: &CamSegment) -> [f64; 2] {
    let [start, end] = segment.scene;
    [start.min(end), start.max(end)]
}

/// Warns of a scene without any light.
pub(super) fn check_light(scene: &SceneDescription, diagnostics: &mut Diagnostics) {
    let SceneDescription { settings, lights, materials, objects, .. } = scene;
    let is_dark = |color: [f32; 3]| color == [0.0; 3];
    let glows = objects.iter().any(|object| {
        let material = materials.get(object.material.0 as usize);
        material.is_some_and(|material| !is_dark(material.ambient))
    });
    if objects.is_empty() || glows || !is_dark(settings.background) {
        return;
    }
    let help = "write `light_point NAME { color { 1 1 1 } position { x y z } }`, or give a material \
                `ambient` light";
    if lights.is_empty() {
        diagnostics
            .push(Diagnostic::warning("the scene has no light: its picture is black").help(help));
    } else if lights.iter().all(|light| is_dark(light.color)) {
        let message = "all lights are black, and so is the picture";
        diagnostics.push(Diagnostic::warning(message).help(help));
    }
}
