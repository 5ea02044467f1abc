//! What there is to know about the scene, for the page.

use glam::DVec3;
use serde_json::{Value, json};
use slo_scene::animation::Clock;
use slo_scene::diagnostics::{Diagnostic, Diagnostics, Severity};
use slo_scene::{Accelerator, CamSegment, SceneDescription};

use super::loading::Loading;
use super::other::Other;
use super::stage::Stage;
use crate::camera::Held;
use crate::changes::parts_of;
use crate::document::Hunk;
use crate::look::Looker;
use crate::pick::Seen;
use crate::placing::Placed;

/// What the state is made from.
pub(super) struct Known<'a> {
    pub(super) loading: &'a Loading,
    pub(super) stage: Option<&'a Stage>,
    pub(super) picked: Option<&'a Seen>,
    pub(super) placed: Option<&'a Placed>,
    /// Number of vertices of the selected mesh.
    pub(super) mesh: Option<usize>,
    /// Vertices that are shown.
    pub(super) vertices: Option<Value>,
    pub(super) why: Option<&'a Value>,
    pub(super) plan: Option<&'a Value>,
    pub(super) other: Option<&'a Other>,
    pub(super) looker: &'a Looker,
    /// Why another frame is shown than the one that was asked for.
    pub(super) missing: Option<String>,
    pub(super) fault: Option<&'a str>,
    pub(super) unwritten: Option<&'a str>,
    pub(super) exposure: f32,
}

/// Most messages that the page shows.
const MOST_MESSAGES: usize = 50;
/// Most objects and lamps that the page lists.
const MOST_THINGS: usize = 500;
/// Most places of differences that the page shows.
const MOST_HUNKS: usize = 100;
/// Most characters of a line that the page shows.
const LONGEST_LINE: usize = 300;

/// Returns what there is to know.
pub(super) fn of(known: &Known<'_>) -> Value {
    let Known {
        loading,
        stage,
        picked,
        placed,
        mesh,
        vertices,
        why,
        plan,
        other,
        looker,
        missing,
        fault,
        unwritten,
        exposure,
    } = known;
    json!({
        "name": loading.name(),
        "messages": messages(loading),
        "fault": fault,
        "missing": missing,
        "exposure": exposure,
        "accelerators": accelerators(),
        "unwritten": unwritten,
        "picked": picked.map(|picked| seen(picked, *placed, loading)),
        "mesh": mesh,
        "vertices": vertices,
        "why": why,
        "plan": plan,
        "other": other.map(Other::to_json),
        "files": loading.files(),
        "scenes": loading.scenes(),
        "overlay": { "shown": looker.overlay().word(), "fault": looker.overlay_fault() },
        "text": text(loading),
        "stage": stage.map(of_stage),
    })
}

/// Returns the names of the structures that this program can use.
fn accelerators() -> Vec<&'static str> {
    let has_gpu = slo_render::frame::offers_device();
    let usable = Accelerator::NAMES.iter().filter(|(_, kind)| has_gpu || !kind.needs_gpu());
    usable.map(|(name, _)| *name).collect()
}

fn of_stage(stage: &Stage) -> Value {
    let (scene, shown) = (stage.scene(), stage.shown());
    let segments: Vec<_> = Clock::new(&scene.camera)
        .segments()
        .map(
            |segment| json!({ "name": segment.name, "first": segment.first, "last": segment.last }),
        )
        .collect();
    json!({
        "frame": stage.frame(),
        "segments": segments,
        "fps": scene.camera.fps,
        "film": [scene.camera.film.width, scene.camera.film.height],
        "size": [shown.camera.film.width, shown.camera.film.height],
        "share": stage.share(),
        "accelerator": stage.accelerator().map(|of| of.to_string()),
        "integrator": scene.settings.integrator.to_string(),
        "things": things(scene),
        "path": stage.path().map(path),
        "camera": stage.held().map(|held| camera(&held)),
        "moved": stage.is_moved(),
    })
}

fn camera(Held { view, shutter }: &Held) -> Value {
    json!({
        "position": view.position.to_array(),
        "target": view.target.to_array(),
        "sky": view.sky.to_array(),
        "fov": view.fov,
        "dof": view.dof,
        "radius": view.lens_radius,
        "shutter": shutter,
    })
}

/// What there is to know about the text.
fn text(loading: &Loading) -> Value {
    let document = loading.document();
    let hunk = |hunk: Hunk| json!({ "line": hunk.line, "old": hunk.old, "new": hunk.new });
    let [undo, redo] = document.next();
    json!({
        "file": loading.has_file(),
        "changed": document.is_changed(),
        "conflict": document.has_conflict(),
        "differences": document.differences().into_iter().take(MOST_HUNKS).map(hunk).collect::<Vec<_>>(),
        "undo": undo,
        "redo": redo,
    })
}

/// Names of objects and lamps.
fn things(scene: &SceneDescription) -> Vec<&str> {
    let objects = scene.objects.iter().map(|object| &*object.name);
    let lights = scene.lights.iter().map(|light| &*light.name);
    objects.chain(lights).take(MOST_THINGS).collect()
}

/// The camera's path.
fn path(segment: &CamSegment) -> Value {
    let points = |points: &[DVec3]| -> Vec<[f64; 3]> {
        points.iter().map(|point| point.to_array()).collect()
    };
    json!({
        "segment": segment.name,
        "positions": points(&segment.positions),
        "targets": points(&segment.targets),
    })
}

/// Where handles stand.
fn handle(placed: &Placed) -> Value {
    json!({
        "at": placed.at().to_array(),
        "axes": placed.axes().map(|axis| axis.to_array()),
        "radius": placed.radius,
    })
}

fn seen(seen: &Seen, placed: Option<&Placed>, loading: &Loading) -> Value {
    let object = seen.object.as_deref().unwrap_or_default();
    let parts = parts_of(loading.document().text(), object, seen.material.as_deref());
    json!({
        "handle": placed.filter(|_| !parts.is_empty()).map(handle),
        "parts": parts,
        "point": seen.point.to_array(),
        "depth": seen.depth,
        "object": seen.object,
        "material": seen.material,
    })
}

fn messages(loading: &Loading) -> Vec<Value> {
    if let Some(why) = loading.unreadable() {
        return vec![json!({ "severity": "error", "message": why })];
    }
    let diagnostics = loading.diagnostics();
    let all = |diagnostics: &Diagnostics| -> Vec<Value> {
        diagnostics.sorted().into_iter().map(|one| message(one, diagnostics)).collect()
    };
    let mut messages = all(diagnostics);
    for mut message in loading.of_file().map(all).unwrap_or_default() {
        // What the text and the file have in common is said once.
        if !messages.contains(&message) {
            message["of"] = json!("file");
            messages.push(message);
        }
    }
    messages.truncate(MOST_MESSAGES);
    messages
}

fn message(diagnostic: &Diagnostic, all: &Diagnostics) -> Value {
    let place = diagnostic.primary.as_ref().map(|label| {
        let source = all.source(label.span.source);
        let start = source.text.floor_char_boundary(label.span.start);
        let before = &source.text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = source.text[line_start..].lines().next().unwrap_or_default();
        json!({
            "file": source.name,
            "line": source.first_line + before.matches('\n').count(),
            "column": source.text[line_start..start].chars().count() + 1,
            "text": line.chars().take(LONGEST_LINE).collect::<String>(),
            "label": label.text,
        })
    });
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        _ => "warning",
    };
    json!({
        "severity": severity,
        "message": diagnostic.message,
        "help": diagnostic.help,
        "place": place,
    })
}
