//! Warnings about scenes that the language allows but nobody means.

use crate::attributes::Fields;
use crate::description::{CamSegment, Camera, KeyFrame, SceneDescription};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::material::wholes;

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

/// The scene time that a segment shows, in ascending order.
fn scene_time(segment: &CamSegment) -> [f64; 2] {
    let [start, end] = segment.scene;
    [start.min(end), start.max(end)]
}

/// Warns of a scene without any light.
pub(super) fn check_light(scene: &SceneDescription, diagnostics: &mut Diagnostics) {
    let SceneDescription { settings, lights, materials, objects, .. } = scene;
    let wholes = wholes(materials);
    let glows = objects.iter().any(|object| {
        let material = wholes.get(object.material.0 as usize);
        material.is_some_and(|material| material.glows)
    });
    if objects.is_empty() || glows || settings.background != [0.0; 3] {
        return;
    }
    let help = "write `light_point NAME { color { 1 1 1 } position { x y z } }`, or give a material \
                `ambient` light";
    if lights.is_empty() {
        diagnostics
            .push(Diagnostic::warning("the scene has no light: its picture is black").help(help));
    } else if lights.iter().all(|light| light.kind.is_dark()) {
        let message = "all lights are black, and so is the picture";
        diagnostics.push(Diagnostic::warning(message).help(help));
    }
}
