//! The camera's path: seen from above, its control points moved, and once around something.

use serde_json::{Value, json};

use super::{Effects, Studio};
use crate::changes;
use crate::command::PathPoint;
use crate::placing::{boxes, middle};

/// What a moved control point is called among the changes of the text.
const PATH: &str = "the camera's path";
/// Most objects that the view from above shows.
const MOST_BOXES: usize = 400;

impl Studio {
    /// Shows the view from above, or does not.
    pub(super) fn set_plan(&mut self, is_shown: bool) {
        self.plan = is_shown.then(|| self.boxes());
    }

    /// Boxes around all objects, for the view from above.
    pub(super) fn boxes(&self) -> Value {
        let Some(stage) = &self.stage else { return json!([]) };
        let all = boxes(stage.scene(), stage.frame(), MOST_BOXES);
        let object = |(name, [min, max]): (&str, [glam::DVec3; 2])| json!({ "name": name, "min": min.to_array(), "max": max.to_array() });
        all.into_iter().map(object).collect()
    }

    /// Moves a control point of the camera. All steps of one drag are one change.
    pub(super) fn move_point(&mut self, point: &PathPoint) -> Result<Effects, String> {
        self.settle();
        let stage = self.stage.as_ref().filter(|_| !self.loading.diagnostics().has_errors());
        let scene = stage.ok_or("the scene has errors")?.scene();
        let mut segments = scene.camera.segments.iter();
        let before = segments.find(|segment| segment.name == point.segment);
        let before = before.ok_or_else(|| format!("there is no `{}`", point.segment))?;
        let mut after = before.clone();
        let points = if point.is_target { &mut after.targets } else { &mut after.positions };
        *points.get_mut(point.index).ok_or("there is no such point")? = point.to;
        let edits = changes::camera(self.loading.document().text(), before, &after)?;
        if self.path_drag.replace(point.number) != Some(point.number) {
            self.loading.seal();
        }
        self.loading.change(edits, PATH, true)?;
        Ok(self.load_again())
    }

    /// Adds a segment in which the camera goes once around what was clicked, or the middle of the scene.
    pub(super) fn orbit_once(&mut self, seconds: f64) -> Result<Effects, String> {
        self.settle();
        let stage = self.stage.as_ref().filter(|_| !self.loading.diagnostics().has_errors());
        let stage = stage.ok_or("the scene has errors")?;
        let (scene, view) = (stage.scene(), stage.held().ok_or("there is no such frame")?.view);
        let picked = self.picked.as_ref().map(|picked| picked.point);
        let center = picked.or_else(|| middle(scene, stage.frame())).unwrap_or(view.target);
        let segments = &scene.camera.segments;
        let text = self.loading.document().text();
        let (edits, start) = changes::orbit(text, segments, &view, center, seconds)?;
        let frame = (start * scene.camera.fps - 1e-6).ceil() as i64;
        self.loading.change(edits, "a segment around the scene", false)?;
        let effects = self.load_again();
        if let Some(stage) = &mut self.stage {
            stage.set_frame(frame);
            self.frame = stage.frame();
        }
        self.looker.change_content();
        self.place();
        Ok(effects)
    }
}
