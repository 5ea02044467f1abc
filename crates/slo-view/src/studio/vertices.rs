//! Vertices of the selected mesh: shown, chosen and moved.

use glam::{DMat3, DVec3};
use serde_json::{Value, json};
use slo_scene::edit::{Outline, applied};
use slo_scene::shape::MeshSurface;
use slo_scene::{SceneDescription, Shape};

use super::{Effects, Studio};
use crate::changes::scaling;
use crate::command::Drag;
use crate::placing::{Motion, Placed};
use crate::sculpting::{Eye, Sculpted, Sculptures, free_name, named, near, renamed};
use crate::sculpting::{together, uses, y_up};

/// Most vertices that are shown.
const MOST_SHOWN: usize = 200;
/// Most vertices of a mesh that can be changed: every step reads and writes all of them.
const MOST: usize = 200_000;

/// Vertices of a mesh that are shown.
#[derive(Debug)]
pub(super) struct Vertices {
    name: String,
    /// The place of the picture that they are near.
    near: [f64; 2],
    /// With their places in scene space.
    shown: Vec<(u32, DVec3)>,
    /// Whether there are no others in front.
    is_all: bool,
    /// Those that are moved; of several at one place, one.
    chosen: Vec<u32>,
    count: usize,
    /// Middle of those that are chosen, and axes of the mesh, in scene space.
    handle: Option<(DVec3, [DVec3; 3])>,
}

/// Vertices that are moved by a handle.
#[derive(Debug)]
pub(super) struct Sculpting {
    number: u64,
    /// The text and the meshes when they were taken hold of.
    base: (String, Sculptures),
    /// The same after the last step.
    last: (String, Sculptures),
    /// The text that names the new file.
    text: String,
    file: String,
    mesh: Sculpted,
    /// Where the vertices were, in the file.
    start: Vec<(u32, DVec3)>,
    /// From ways in scene space to ways in the file.
    to_file: DMat3,
}

/// The mesh of an object.
fn mesh_of<'s>(scene: &'s SceneDescription, name: &str) -> Option<&'s MeshSurface> {
    let object = scene.objects.iter().find(|object| object.name == name)?;
    match &object.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    }
}

impl Studio {
    /// Number of vertices of the selected mesh; `None` if it is no mesh.
    pub(super) fn vertex_count(&self) -> Option<usize> {
        let name = self.picked.as_ref()?.object.as_deref()?;
        Some(mesh_of(self.stage.as_ref()?.scene(), name)?.mesh.positions.len())
    }

    /// Shows vertices of the selected mesh near a place of the picture, or shows none.
    pub(super) fn show_vertices(&mut self, near: Option<[f64; 2]>) -> Result<Effects, String> {
        let Some(near) = near else {
            self.vertices = None;
            return Ok(Effects::default());
        };
        let name = self.picked.as_ref().and_then(|picked| picked.object.clone());
        let name = name.ok_or("select a mesh first")?;
        let count = self.vertex_count().ok_or_else(|| format!("`{name}` is no mesh"))?;
        if count > MOST {
            return Err(format!(
                "`{name}` has {count} vertices; of more than {MOST}, none can be moved"
            ));
        }
        // Whether it can be changed is known now.
        named(self.loading.document().text(), &name, "a.slo")?;
        let before = self.vertices.take().filter(|of| of.name == name);
        let chosen = before.map(|of| of.chosen).unwrap_or_default();
        let (shown, is_all, handle) = (Vec::new(), false, None);
        self.vertices = Some(Vertices { name, near, shown, is_all, chosen, count, handle });
        self.place_vertices();
        Ok(Effects::default())
    }

    /// Finds out which vertices are shown, and where.
    pub(super) fn place_vertices(&mut self) {
        let Some(mut of) = self.vertices.take() else { return };
        let is_picked =
            self.picked.as_ref().and_then(|picked| picked.object.as_ref()) == Some(&of.name);
        let Some(stage) = self.stage.as_ref().filter(|_| is_picked) else { return };
        let mesh = mesh_of(stage.scene(), &of.name).map(|of| &of.mesh);
        let placed = Placed::of(stage.scene(), &of.name, stage.frame());
        let (Some(mesh), Some(placed), Some(held)) = (mesh, placed, stage.held()) else { return };
        let film = &stage.shown().camera.film;
        let eye = Eye::new(&held.view, f64::from(film.width) / f64::from(film.height));
        let pose = placed.parent.after(&placed.pose);
        (of.shown, of.is_all) = near(mesh, &pose, &eye, of.near, MOST_SHOWN);
        of.count = mesh.positions.len();
        of.chosen.retain(|vertex| (*vertex as usize) < of.count);
        let places: Vec<DVec3> =
            of.chosen.iter().map(|vertex| pose.point(mesh.positions[*vertex as usize])).collect();
        let middle = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
        of.handle = (!places.is_empty()).then_some((middle, placed.axes()));
        self.vertices = Some(of);
    }

    /// Chooses a vertex, beside those that are chosen or instead of them.
    pub(super) fn choose_vertex(&mut self, vertex: u32, beside: bool) -> Result<Effects, String> {
        let of = self.vertices.as_mut().ok_or("show the vertices first")?;
        if vertex as usize >= of.count {
            return Err("there is no such vertex".into());
        }
        let was_chosen = of.chosen.contains(&vertex);
        match beside {
            true => of.chosen.retain(|known| *known != vertex),
            false => of.chosen.clear(),
        }
        if !(beside && was_chosen) {
            of.chosen.push(vertex);
        }
        self.place_vertices();
        Ok(Effects::default())
    }

    /// Moves the vertices that are chosen. All steps of one drag are one change.
    pub(super) fn drag_vertices(&mut self, drag: &Drag) -> Result<Effects, String> {
        let Motion::Move(way) = drag.motion else {
            return Err("vertices can only be moved".into());
        };
        if self.sculpting.as_ref().is_none_or(|of| of.number != drag.number) {
            self.take_hold_of_vertices(drag)?;
        }
        let document = self.loading.document();
        let now = (document.text(), document.meshes());
        let of = self.sculpting.as_mut().filter(|of| (&*of.last.0, &of.last.1) == now);
        let of = of.ok_or("the text has changed meanwhile")?;
        let next = if way == DVec3::ZERO {
            of.base.clone()
        } else {
            let way = of.to_file * way;
            let mesh = of.mesh.with(of.start.iter().map(|(vertex, at)| (*vertex, *at + way)));
            (of.text.clone(), of.base.1.with(&of.file, mesh))
        };
        of.last.clone_from(&next);
        let what = format!("vertices of {} moved", drag.name);
        self.loading.sculpt(next.0, next.1, &what)?;
        Ok(self.load_again())
    }

    fn take_hold_of_vertices(&mut self, drag: &Drag) -> Result<(), String> {
        self.settle();
        let name = &drag.name;
        let stage = self.stage.as_ref().filter(|_| !self.loading.diagnostics().has_errors());
        let stage = stage.ok_or("the scene has errors")?;
        let of = self.vertices.as_ref().filter(|of| of.name == *name && !of.chosen.is_empty());
        let of = of.ok_or("choose a vertex first")?;
        let shown = &mesh_of(stage.scene(), name).ok_or("it is no mesh")?.mesh;
        let placed = Placed::of(stage.scene(), name, stage.frame());
        let placed = placed.ok_or_else(|| format!("`{name}` has no place of its own"))?;
        let text = self.loading.document().text().to_owned();
        let (scale, is_y_up) = (scaling(&Outline::new(&text)), y_up(&text, name));
        let meshes = self.loading.document().meshes().clone();
        let now = uses(&text, name).unwrap_or_default();
        // A mesh that others show too stays as it is.
        let is_own = renamed(&text, now, now).1 == 1;
        let known = meshes.get(now);
        let file = match known.filter(|_| is_own) {
            Some(_) => now.to_owned(),
            None => free_name(now, |name| self.loading.is_free(name)),
        };
        let mesh = known.cloned().unwrap_or_else(|| Sculpted::new(shown, scale, is_y_up));
        let vertices = of.chosen.iter().flat_map(|vertex| together(shown, *vertex));
        let start = vertices.filter_map(|vertex| Some((vertex, mesh.position(vertex)?))).collect();
        let linear = placed.parent.after(&placed.pose).linear;
        let upright = match is_y_up {
            true => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
            false => DMat3::IDENTITY,
        };
        let to_file = upright * linear.inverse() * (1.0 / scale);
        if !to_file.is_finite() {
            return Err(format!("`{name}` is flat here, so its vertices can't be moved"));
        }
        let edits = named(&text, name, &file)?;
        let named = applied(&text, edits).ok_or("the text has changed meanwhile")?;
        self.loading.seal();
        let base = (text, meshes);
        let last = base.clone();
        let number = drag.number;
        self.sculpting =
            Some(Sculpting { number, base, last, text: named, file, mesh, start, to_file });
        Ok(())
    }

    /// What the page shows of the vertices.
    pub(super) fn vertices_to_json(&self) -> Option<Value> {
        let of = self.vertices.as_ref()?;
        let handle = of.handle.map(|(at, axes)| json!({ "at": at.to_array(), "axes": axes.map(|axis| axis.to_array()), "radius": 0.0 }));
        let shown = of.shown.iter().map(|(vertex, at)| json!([vertex, at.x, at.y, at.z]));
        Some(json!({
            "shown": shown.collect::<Vec<_>>(),
            "chosen": of.chosen,
            "all": of.is_all,
            "handle": handle,
        }))
    }
}
