//! Warnings about scenes that the language allows but nobody means.

use std::collections::HashSet;

use crate::attributes::Fields;
use crate::description::{CamSegment, Camera, KeyFrame, LightGroups, SceneDescription};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::format::syntax::Word;
use crate::material::{Material, MaterialKind};
use crate::settings::{Integrator, Layer, Settings, ShadowMode};

/// Warns of a shutter that is open for `blur` seconds if its segment takes less.
pub(super) fn check_shutter(
    fields: &mut Fields<'_, '_, '_>,
    blur: f64,
    span: Span,
    [start, end]: [f64; 2],
) {
    // Programs write times that were rounded.
    if blur <= (end - start) * (1.0 + 1e-9) {
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

/// Warns if all key frames of an object or a lamp lie before the scene time that the camera sees, or after it.
pub(super) fn check_key_times(
    fields: &mut Fields<'_, '_, '_>,
    key_frames: &[KeyFrame],
    camera: &Camera,
) {
    let ([first, .., last], Some(at)) = (key_frames, fields.get("addKframe")) else { return };
    if fields.get("repeat").is_some() {
        return;
    }
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
        .help(format!(
            "scene time goes from {start} to {end}: {} does not move",
            fields.element.title()
        ));
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

/// Where a scene says what may have no effect.
#[derive(Clone, Debug, Default)]
pub(super) struct Said<'a> {
    /// `shadow`
    pub(super) shadow: Option<Span>,
    /// Settings that only `PHOTON_MAP` looks at.
    pub(super) of_photon_map: Vec<Word<'a>>,
    /// `photons` and `photonSeed`
    pub(super) photons: [Option<Span>; 2],
    /// Each `ambient` that is not black.
    pub(super) ambient: Vec<Span>,
    /// Names of groups of lights.
    pub(super) groups: Vec<Word<'a>>,
    /// What objects say about the light that they emit.
    pub(super) emission: Vec<Emission>,
}

/// Warns of what has no effect in a scene without errors, and of a scene without light.
pub(super) fn check(said: &Said<'_>, scene: &SceneDescription, diagnostics: &mut Diagnostics) {
    check_ambient(&said.ambient, scene.settings.integrator, diagnostics);
    check_shadow(said.shadow, &scene.settings, diagnostics);
    check_photon_map(&said.of_photon_map, scene.settings.integrator, diagnostics);
    check_light(scene, diagnostics);
    check_emission(&said.emission, &scene.materials, diagnostics);
    check_groups(&said.groups, scene, diagnostics);
}

/// Warns of a scene without any light.
fn check_light(scene: &SceneDescription, diagnostics: &mut Diagnostics) {
    let SceneDescription { settings, lights, materials, objects, .. } = scene;
    let is_path = settings.integrator != Integrator::Distributed;
    let glows = |kind: &MaterialKind| match kind {
        MaterialKind::Phong(_) if is_path => false,
        _ => kind.glows(),
    };
    let shown = objects.iter().map(|object| object.material.0 as usize);
    let is_seen = || any_part(materials, shown, glows);
    if objects.is_empty() || settings.background != [0.0; 3] || is_seen() {
        return;
    }
    let help = if is_path {
        "write `lamp_point NAME { power { 100 100 100 } position { x y z } }`, or \
         `environment NAME { radiance { 1 1 1 } }`"
    } else {
        "write `light_point NAME { color { 1 1 1 } position { x y z } }`, or give a material \
         `ambient` light"
    };
    if lights.is_empty() {
        diagnostics
            .push(Diagnostic::warning("the scene has no light: its picture is black").help(help));
    } else if lights.iter().all(|light| light.kind.is_dark()) {
        let message = "all lights are black, and so is the picture";
        diagnostics.push(Diagnostic::warning(message).help(help));
    }
}

/// Warns of `ambient` light under an integrator that computes what it stands in for; `places` are
/// where it is written.
fn check_ambient(places: &[Span], integrator: Integrator, diagnostics: &mut Diagnostics) {
    let [first, others @ ..] = places else { return };
    if integrator == Integrator::Distributed {
        return;
    }
    let label = match others.len() {
        0 => String::new(),
        1 => "and in one other `phong_info`".into(),
        n => format!("and in {n} other `phong_info`s"),
    };
    let message = format!("`ambient` does nothing under `integrator {integrator}`");
    let warning = Diagnostic::warning(message).at(*first, label);
    diagnostics
        .push(warning.help("it stands in for light between surfaces, which is computed here"));
}

/// Warns of transparent shadows under an integrator that has none; `place` is where they are asked
/// for.
fn check_shadow(place: Option<Span>, settings: &Settings, diagnostics: &mut Diagnostics) {
    let Settings { integrator, shadow, .. } = *settings;
    let Some(place) = place else { return };
    if integrator == Integrator::Distributed || shadow == ShadowMode::Opaque {
        return;
    }
    let message = format!("`shadow {shadow}` does nothing under `integrator {integrator}`");
    let help = "refracted rays bring the light behind glass: of lamps with an area, and of skies";
    diagnostics.push(Diagnostic::warning(message).at(place, "").help(help));
}

/// Warns of settings of `PHOTON_MAP` under another integrator.
fn check_photon_map(said: &[Word<'_>], integrator: Integrator, diagnostics: &mut Diagnostics) {
    if integrator == Integrator::PhotonMap {
        return;
    }
    for word in said {
        let message = format!("`{}` does nothing under `integrator {integrator}`", word.text);
        let warning = Diagnostic::warning(message).at(word.span, "");
        diagnostics.push(warning.help("write `integrator PHOTON_MAP`"));
    }
}

/// Warns of names of groups that differ only in case, and if the light of groups is asked for where
/// there are none.
fn check_groups(groups: &[Word<'_>], scene: &SceneDescription, diagnostics: &mut Diagnostics) {
    let mut known: Vec<Word<'_>> = Vec::new();
    for group in groups {
        if known.iter().any(|other| other.text == group.text) {
            continue;
        }
        let lower = group.text.to_lowercase();
        let twin = known.iter().find(|other| other.text.to_lowercase() == lower);
        if let Some(twin) = twin {
            let (one, other) = (twin.text, group.text);
            let message = format!("the light groups `{one}` and `{other}` differ only in case");
            let warning = Diagnostic::warning(message).at(group.span, "a group of its own");
            diagnostics.push(warning.also(twin.span, "first here"));
        } else if lower == LightGroups::REST && group.text != LightGroups::REST {
            let (name, rest) = (group.text, LightGroups::REST);
            let message = format!("the light group `{name}` is not `{rest}`");
            let warning = Diagnostic::warning(message).at(group.span, "a group of its own");
            let help = format!("`{rest}` is the group of all lights that name none");
            diagnostics.push(warning.help(help));
        }
        known.push(*group);
    }
    if scene.camera.film.layers.contains(&Layer::Lights) && scene.light_groups().is_empty() {
        let message = "there is no light group to keep apart: the layer `lights.rest` is the \
                       whole picture";
        let help = "write `light_group NAME` in lamps, in an `environment`, and in objects that \
                    emit light";
        diagnostics.push(Diagnostic::warning(message).help(help));
    }
}

/// What an object says about the light that it emits.
#[derive(Clone, Debug)]
pub(super) struct Emission {
    /// `sampled` or `light_group`.
    name: &'static str,
    place: Span,
    object: String,
    /// Index of the object's material.
    material: usize,
}

/// What an object of a material says about the light that it emits.
pub(super) fn emission(fields: &Fields<'_, '_, '_>, material: usize) -> Vec<Emission> {
    let object = fields.element.title();
    let said = ["sampled", "light_group"].into_iter().filter_map(|name| {
        let place = fields.get(name)?.keyword.span;
        Some(Emission { name, place, object: object.clone(), material })
    });
    said.collect()
}

/// Warns of what objects say about the light that they emit if they emit none.
fn check_emission(said: &[Emission], materials: &[Material], diagnostics: &mut Diagnostics) {
    let emits = |kind: &MaterialKind| !matches!(kind, MaterialKind::Phong(_)) && kind.glows();
    for Emission { name, place, object, material } in said {
        if any_part(materials, std::iter::once(*material), emits) {
            continue;
        }
        let message = format!("`{name}` has no effect: {object} emits no light");
        let warning = Diagnostic::warning(message).at(*place, "");
        let help = "a `material_principled` with `emission_strength` makes an object a lamp";
        diagnostics.push(warning.help(help));
    }
}

/// Whether some of these materials, or something that they are mixed from, has a property.
pub(super) fn any_part(
    materials: &[Material],
    of: impl Iterator<Item = usize>,
    has: impl Fn(&MaterialKind) -> bool,
) -> bool {
    let mut seen = HashSet::new();
    let mut waiting: Vec<usize> = of.filter(|material| seen.insert(*material)).collect();
    while let Some(Material { kind, .. }) = waiting.pop().and_then(|index| materials.get(index)) {
        if has(kind) {
            return true;
        }
        if let MaterialKind::Mix(mix) = kind {
            let parts = [mix.first, mix.second].map(|part| part.0 as usize);
            waiting.extend(parts.into_iter().filter(|part| seen.insert(*part)));
        }
    }
    false
}
