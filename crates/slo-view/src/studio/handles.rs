//! Things that are selected, and moved by handles.

use slo_scene::edit::applied;

use super::{Effects, Studio};
use crate::camera::axes;
use crate::command::Drag;
use crate::pick::Seen;
use crate::placing::{Motion, Placed, edits};

/// A thing that is moved by a handle.
#[derive(Debug)]
pub(super) struct Dragging {
    number: u64,
    name: String,
    /// Where it was, and what the text was, when it was taken hold of.
    placed: Placed,
    base: String,
    /// What the text is since the last step.
    last: String,
}

impl Studio {
    /// Selects an object or a lamp by its name.
    pub(super) fn select(&mut self, name: &str) -> Result<Effects, String> {
        let stage = self.stage.as_ref().ok_or("the scene has errors")?;
        let scene = stage.scene();
        let object = scene.objects.iter().find(|object| object.name == name);
        if object.is_none() && !scene.lights.iter().any(|light| light.name == name) {
            return Err(format!("there is no `{name}`"));
        }
        let placed = Placed::of(scene, name, stage.frame());
        let view = stage.held().map(|held| held.view);
        let point = placed.map(|placed| placed.at());
        let depth = view.zip(point).map(|(view, at)| (at - view.position).dot(axes(&view)[2]));
        self.set_picked(Some(Seen {
            point: point.unwrap_or_default(),
            depth: depth.unwrap_or_default(),
            object: Some(name.to_owned()),
            material: object.map(|of| scene.materials[of.material.0 as usize].name.clone()),
        }));
        if let (Some(point), Some(stage)) = (point, &mut self.stage) {
            stage.set_pivot(point);
        }
        Ok(Effects::default())
    }

    /// Something else is selected.
    pub(super) fn set_picked(&mut self, seen: Option<Seen>) {
        self.picked = seen;
        let name = self.picked.as_ref().and_then(|picked| picked.object.as_deref());
        self.looker.set_apart(name);
        self.place();
    }

    /// Finds out where the selected thing is.
    pub(super) fn place(&mut self) {
        let name = self.picked.as_ref().and_then(|picked| picked.object.as_deref());
        let stage = self.stage.as_ref();
        self.placed = name
            .zip(stage)
            .and_then(|(name, stage)| Placed::of(stage.scene(), name, stage.frame()));
        self.place_vertices();
    }

    /// Moves, turns or scales a thing. All steps of one drag start from where it was taken hold of, and
    /// are one change.
    pub(super) fn drag(&mut self, drag: &Drag) -> Result<Effects, String> {
        let Drag { number, name, motion, is_of_vertices } = drag;
        if *is_of_vertices {
            return self.drag_vertices(drag);
        }
        let is_next = self.dragging.as_ref().is_none_or(|of| of.number != *number);
        if is_next {
            self.take_hold(*number, name)?;
        }
        let now = self.loading.document().text();
        let of = self.dragging.as_mut().filter(|of| of.name == *name && of.last == now);
        let of = of.ok_or("the text has changed meanwhile")?;
        let edits = edits(&of.base, name, &of.placed, *motion)?;
        let text = applied(&of.base, edits).ok_or("the text has changed meanwhile")?;
        of.last.clone_from(&text);
        let what = match motion {
            Motion::Move(_) => format!("{name} moved"),
            Motion::Turn(..) => format!("{name} turned"),
            Motion::Scale(_) => format!("{name} scaled"),
        };
        self.loading.replace(text, &what)?;
        Ok(self.load_again())
    }

    fn take_hold(&mut self, number: u64, name: &str) -> Result<(), String> {
        self.settle();
        let stage = self.stage.as_ref().filter(|_| !self.loading.diagnostics().has_errors());
        let stage = stage.ok_or("the scene has errors")?;
        let placed = Placed::of(stage.scene(), name, stage.frame());
        let placed = placed.ok_or_else(|| format!("`{name}` has no place of its own"))?;
        self.loading.seal();
        let base = self.loading.document().text().to_owned();
        let (name, last) = (name.to_owned(), base.clone());
        self.dragging = Some(Dragging { number, name, placed, base, last });
        Ok(())
    }
}
