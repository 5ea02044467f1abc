//! What there is to know about the scene, for the page.

use serde_json::{Value, json};
use slo_scene::Accelerator;
use slo_scene::animation::Clock;
use slo_scene::diagnostics::{Diagnostic, Diagnostics, Severity};

use super::loading::Loading;
use super::stage::Stage;
use crate::camera::Held;
use crate::changes::parts_of;
use crate::document::Hunk;
use crate::pick::Seen;

/// What the state is made from.
pub(super) struct Known<'a> {
    pub(super) loading: &'a Loading,
    pub(super) stage: Option<&'a Stage>,
    pub(super) picked: Option<&'a Seen>,
    pub(super) fault: Option<&'a str>,
    pub(super) unwritten: Option<&'a str>,
    pub(super) exposure: f32,
}

/// Most messages that the page shows.
const MOST_MESSAGES: usize = 50;
/// Most places of differences that the page shows.
const MOST_HUNKS: usize = 100;
/// Most characters of a line that the page shows.
const LONGEST_LINE: usize = 300;

/// Returns what there is to know.
pub(super) fn of(known: &Known<'_>) -> Value {
    let Known { loading, stage, picked, fault, unwritten, exposure } = known;
    json!({
        "name": loading.name(),
        "messages": messages(loading),
        "fault": fault,
        "exposure": exposure,
        "accelerators": accelerators(),
        "unwritten": unwritten,
        "picked": picked.map(|picked| seen(picked, loading)),
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
        "camera": stage.held().map(|held| camera(&held)),
        "moved": stage.is_moved(),
    })
}

fn camera(Held { view, shutter }: &Held) -> Value {
    json!({
        "position": view.position.to_array(),
        "target": view.target.to_array(),
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

fn seen(seen: &Seen, loading: &Loading) -> Value {
    let object = seen.object.as_deref().unwrap_or_default();
    let parts = parts_of(loading.document().text(), object, seen.material.as_deref());
    json!({
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
    let sorted = diagnostics.sorted();
    sorted.into_iter().take(MOST_MESSAGES).map(|one| message(one, diagnostics)).collect()
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
