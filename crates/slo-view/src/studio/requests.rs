//! What each request does.

use slo_scene::Accelerator;

use super::{CAMERA, Effects, Studio};
use crate::camera::{Held, Move, moved};
use crate::changes;
use crate::command::{Command, Lens, Show, TextEdit};
use crate::document::Document;
use crate::finished::Finishing;
use crate::pick::{Seen, pick, sharp};

/// Size of a new thing, as a share of what is seen.
const NEW_SHARE: f64 = 0.3;

impl Studio {
    /// Does what is asked for.
    pub(super) fn perform(&mut self, command: Command) -> Result<Effects, String> {
        if command == Command::Cancel {
            self.link.set_finishing(Finishing::default());
            self.link.finishing_changed();
            return Ok(Effects::default());
        }
        if let Some(effects) = self.perform_on_text(&command) {
            return effects;
        }
        if self.stage.is_none() {
            return Err("the scene has errors".into());
        }
        match command {
            Command::Frame(frame) => {
                if let Some(why) = self.stage.as_ref().and_then(|stage| stage.lacks(frame)) {
                    return Err(why);
                }
                // The camera that was moved belongs to the frame before.
                self.settle();
                let effects = self.change(|stage| stage.set_frame(frame))?;
                self.looker.change_content();
                self.place();
                self.plan = self.plan.is_some().then(|| self.boxes());
                self.frame = self.stage.as_ref().map_or(frame, |stage| stage.frame());
                Ok(effects)
            }
            Command::Reset => self.change(|stage| stage.reset()),
            Command::Move(by) => self.move_camera(by),
            Command::Lens(lens) => self.set_lens(lens),
            Command::Pick(at) => {
                let seen = self.seen_at(at);
                self.set_picked(seen);
                if let (Some(seen), Some(stage)) = (&self.picked, &mut self.stage) {
                    stage.set_pivot(seen.point);
                }
                Ok(Effects::default())
            }
            Command::Select(name) => self.select(&name),
            Command::Why(at) => self.explain(at),
            Command::Vertices(near) => self.show_vertices(near),
            Command::Vertex(vertex, beside) => self.choose_vertex(vertex, beside),
            Command::Drag(drag) => self.drag(&drag),
            Command::Point(point) => self.move_point(&point),
            Command::OrbitOnce(seconds) => self.orbit_once(seconds),
            Command::Focus(at) => {
                let seen = self.seen_at(at).ok_or("there is nothing to focus on")?;
                self.set_lens(Lens { dof: Some(seen.depth), ..Lens::default() })
            }
            Command::Show(show) => self.set_show(show),
            Command::Finish => self.finish(),
            _ => Ok(Effects::default()),
        }
    }

    /// Does what is asked of the text; `None` if nothing is.
    fn perform_on_text(&mut self, command: &Command) -> Option<Result<Effects, String>> {
        let step: fn(&mut Document) = match command {
            Command::Edit(edit) => {
                return Some(self.edit(edit));
            }
            Command::Open(path) => return Some(self.open_other(path)),
            Command::Take(chosen) => return Some(self.take(chosen)),
            Command::Close => {
                self.other = None;
                return Some(Ok(Effects::default()));
            }
            Command::Save(with_errors) => {
                self.settle();
                let effects = match self.loading.is_stale() {
                    true => self.load_again(),
                    false => Effects::default(),
                };
                let saved = self.loading.save(*with_errors);
                // Meshes that were saved are read from their files from now on.
                let again = self.loading.is_stale().then(|| self.load_again());
                return Some(saved.map(|()| again.unwrap_or(effects)));
            }
            Command::Reset => {
                // All movements since another change are one step.
                self.settle();
                if self.loading.document().next()[0] != Some(CAMERA) {
                    return None;
                }
                |document| _ = document.undo()
            }
            Command::Undo => |document| _ = document.undo(),
            Command::Redo => |document| _ = document.redo(),
            Command::Revert => Document::revert,
            Command::Mine => Document::keep,
            _ => return None,
        };
        self.settle();
        self.loading.step(step);
        Some(Ok(self.load_again()))
    }

    /// Changes the text, and what is shown.
    fn edit(&mut self, edit: &TextEdit) -> Result<Effects, String> {
        self.settle();
        let text = self.loading.document().text();
        let mut added = None;
        let (edits, what) = match edit {
            TextEdit::Set(field) => {
                (changes::set(text, field)?, format!("{} of {}", field.attribute, field.place.name))
            }
            TextEdit::Hide(name) => (changes::hide(text, name)?, format!("{name} hidden")),
            TextEdit::Remove(name) => (changes::remove(text, name)?, format!("{name} removed")),
            TextEdit::Copy(name) => (changes::copy(text, name)?, format!("{name} copied")),
            TextEdit::Add(new) => {
                let stage = self.stage.as_ref().ok_or("the scene has errors")?;
                let view = stage.held().ok_or("the scene has no such frame")?.view;
                let at = stage.pivot().unwrap_or(view.target);
                let size = (at - view.position).length() * view.fov * NEW_SHARE;
                let material = self.picked.as_ref().and_then(|picked| picked.material.as_deref());
                let (edits, name) = changes::add(text, new, at, size, material)?;
                added = Some(name.clone());
                (edits, format!("{name} added"))
            }
            TextEdit::KeyFrame(name) => {
                let place = self.stage.as_ref().and_then(|stage| stage.place_of(name));
                let (time, place) = place.ok_or("it is no object, or its size changes")?;
                let edits = changes::key_frame(text, name, time, place)?;
                (edits, format!("a key frame of {name}"))
            }
        };
        // A slider that is dragged is one step.
        self.loading.change(edits, &what, matches!(edit, TextEdit::Set(_)))?;
        let effects = self.load_again();
        if let Some(name) = added {
            // If the text has errors, there is nothing to select.
            let _ = self.select(&name);
        }
        Ok(effects)
    }

    pub(super) fn load_again(&mut self) -> Effects {
        Effects { picture: self.load(self.frame), ..Effects::default() }
    }

    fn change(&mut self, change: impl FnOnce(&mut super::Stage)) -> Result<Effects, String> {
        self.stage.as_mut().map(change).ok_or("the scene has errors")?;
        Ok(Effects { picture: true, ..Effects::default() })
    }

    fn held(&self) -> Result<Held, String> {
        let held = self.stage.as_ref().and_then(|stage| stage.held());
        held.ok_or_else(|| "the scene has no such frame".into())
    }

    fn move_camera(&mut self, by: Move) -> Result<Effects, String> {
        let held = self.held()?;
        let pivot = self.stage.as_ref().and_then(|stage| stage.pivot());
        let view = moved(&held.view, by, pivot.unwrap_or(held.view.target));
        self.change(|stage| stage.hold(&Held { view, ..held }))
    }

    fn set_lens(&mut self, lens: Lens) -> Result<Effects, String> {
        let mut held = self.held()?;
        let Lens { fov, dof, radius, shutter } = lens;
        held.view.fov = fov.unwrap_or(held.view.fov);
        held.view.dof = dof.unwrap_or(held.view.dof);
        held.view.lens_radius = radius.unwrap_or(held.view.lens_radius);
        held.shutter = shutter.unwrap_or(held.shutter);
        self.change(|stage| stage.hold(&held))
    }

    fn seen_at(&mut self, at: [f64; 2]) -> Option<Seen> {
        let stage = self.stage.as_ref()?;
        let scene = sharp(stage.shown());
        self.looker.lend(&scene, stage.frame(), |frame| pick(&scene, frame, at)).ok()?
    }

    fn set_show(&mut self, show: Show) -> Result<Effects, String> {
        let Show { exposure, share, accelerator, overlay, plan } = show;
        let mut effects = Effects::default();
        if let Some(exposure) = exposure {
            self.exposure = exposure;
            effects.exposure = true;
        }
        if let Some(plan) = plan {
            self.set_plan(plan);
        }
        if let Some(overlay) = overlay {
            effects.overlay = true;
            effects.picture |= self.looker.set_overlay(overlay);
        }
        let Some(stage) = &mut self.stage else { return Ok(effects) };
        if let Some(share) = share {
            stage.set_share(share);
            effects.picture = true;
        }
        if let Some(word) = accelerator {
            let mut known = Accelerator::NAMES.iter();
            let chosen = known.find(|(name, _)| *name == word).map(|(_, accelerator)| *accelerator);
            if chosen.is_none() && !word.is_empty() {
                return Err(format!("there is no structure `{word}`"));
            }
            stage.set_accelerator(chosen);
            self.looker.change_content();
            effects.picture = true;
        }
        Ok(effects)
    }

    /// Renders the frame as the program does.
    fn finish(&mut self) -> Result<Effects, String> {
        self.settle();
        let effects = match self.loading.is_stale() {
            true => self.load_again(),
            false => Effects::default(),
        };
        if self.loading.is_stale() || self.loading.diagnostics().has_errors() {
            return Err("the scene has errors".into());
        }
        let Some(stage) = &self.stage else { return Err("the scene has errors".into()) };
        let mut scene = stage.scene().clone();
        scene.camera.segments.clone_from(&stage.shown().camera.segments);
        let (pool, isa, link) = (self.looker.pool().clone(), self.looker.isa(), self.link.clone());
        let news = move || link.finishing_changed();
        self.link.set_finishing(Finishing::start(scene, stage.frame(), pool, isa, news));
        self.link.finishing_changed();
        Ok(effects)
    }
}
