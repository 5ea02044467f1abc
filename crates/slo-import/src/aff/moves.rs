//! What is known at the end of a file only: what moves, and when.

use std::collections::HashMap;

use glam::DVec3;

use super::blocks::{Block, Range};
use crate::model::{Camera, Key, LampKind, Model, Shape, Space, Times, View};

/// Frames a second of files that do not say.
const FPS: f64 = 25.0;

/// Most frames of files that do not say.
const MOST_FRAMES: f64 = 5000.0;

/// A view, without what may move it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) view: View,
    pub(super) size: [u32; 2],
    pub(super) fov: f64,
}

/// What moves.
#[derive(Debug, Default)]
pub(super) struct Moves {
    pub(super) view: Option<Seen>,
    /// Key frames, by names.
    pub(super) blocks: HashMap<String, Block>,
    /// Spaces that blocks of these names move.
    pub(super) groups: Vec<(usize, String)>,
    /// Lights that blocks of these names move.
    pub(super) lights: Vec<(usize, String)>,
    /// The first and the last time of the animation, and its frames.
    pub(super) range: Option<(f64, f64, usize)>,
}

impl Moves {
    /// Moves groups, lights and the camera.
    pub(super) fn apply(&self, model: &mut Model) {
        let range = self.range(model);
        self.move_lights(&range, model);
        self.move_groups(&range, model);
        place_still_lights(model);
        self.look(&range, model);
        if range.frames > 1 {
            model.fps = Some(range.fps);
            model.duration = range.frames as f64 / range.fps;
        }
        for object in &mut model.objects {
            if let Shape::Changing { times: Times::At(times), .. } = &mut object.shape {
                times.iter_mut().for_each(|time| *time -= range.start);
            }
        }
        if range.start != 0.0 {
            let note = format!("when it starts: at 0 s, which is {} s in the file", range.start);
            model.notes.made_up.push(note);
        }
    }

    /// The frames. Without a word of the file, they are those in which something moves.
    fn range(&self, model: &mut Model) -> Range {
        match self.range {
            Some((start, end, frames)) if frames > 1 && end > start => {
                return Range { start, fps: (frames - 1) as f64 / (end - start), frames };
            }
            Some((start, ..)) => return Range { start, fps: FPS, frames: 1 },
            None => {}
        }
        let names = self.groups.iter().chain(&self.lights).map(|(_, name)| name.as_str());
        let blocks = names.chain(["camera"]).filter_map(|name| self.blocks.get(name));
        let shapes = model.objects.iter().filter_map(|object| match &object.shape {
            Shape::Changing { times: Times::At(times), .. } => Some(times),
            _ => None,
        });
        let times = blocks.flat_map(Block::times).chain(shapes.flatten().copied());
        let ends = times.fold(None, |ends: Option<[f64; 2]>, time| {
            let [least, most] = ends.unwrap_or([time; 2]);
            Some([least.min(time), most.max(time)])
        });
        let Some([start, end]) = ends.filter(|[start, end]| start < end) else {
            return Range { start: 0.0, fps: FPS, frames: 1 };
        };
        model.notes.made_up.push(format!("its frames: {FPS} a second while something moves"));
        let frames = ((end - start) * FPS).ceil().min(MOST_FRAMES) as usize + 1;
        Range { start, fps: FPS, frames }
    }

    /// A light that a block moves hangs in a space of its own.
    fn move_lights(&self, range: &Range, model: &mut Model) {
        for (light, name) in &self.lights {
            let Some(block) = self.blocks.get(name) else { continue };
            let lamp = &mut model.lamps[*light];
            let keys = block.keys_of_light(range);
            let space = Space { name: format!("{name}_way"), parent: lamp.space, keys };
            lamp.space = Some(model.spaces.len());
            model.spaces.push(space);
        }
    }

    fn move_groups(&self, range: &Range, model: &mut Model) {
        let mut known: HashMap<&str, Vec<Key>> = HashMap::new();
        let mut never = vec![false; model.spaces.len()];
        let mut is_told = false;
        for (space, name) in &self.groups {
            let Some(block) = self.blocks.get(name) else { continue };
            let keys = known.entry(name).or_insert_with(|| block.keys(range));
            model.spaces[*space].keys.clone_from(keys);
            never[*space] = block.is_never_seen(range);
            is_told |= !never[*space] && block.comes_and_goes(range);
        }
        model.drop_spaces(|space| never[space]);
        if is_told {
            let note = "how what comes and goes is hidden: it is a millionth of its size";
            model.notes.made_up.push(note.into());
        }
    }

    /// The camera. A block of its name says where it is, instead of the view.
    fn look(&self, range: &Range, model: &mut Model) {
        let Some(seen) = self.view else { return };
        let mut views = vec![seen.view];
        if let Some(block) = self.blocks.get("camera") {
            views = (0..range.frames).map(|frame| block.view(range.time(frame))).collect();
            // The last frame lasts as long as the others.
            views.extend((range.frames > 1).then(|| block.view(range.time(range.frames - 1))));
            let is_still = views.windows(2).all(|pair| {
                let [a, b] = [pair[0], pair[1]];
                let ways = [a.position - b.position, a.target - b.target, a.up - b.up];
                ways.iter().all(|way| *way == DVec3::ZERO)
            });
            views.truncate(if is_still { 1 } else { views.len() });
        }
        model.camera = Some(Camera { size: seen.size, fov: seen.fov, views });
    }
}

/// Takes lights out of spaces that do not move.
fn place_still_lights(model: &mut Model) {
    for light in 0..model.lamps.len() {
        let space = model.lamps[light].space;
        if model.moves(space) {
            continue;
        }
        let matrix = model.matrix(space, 0.0);
        let lamp = &mut model.lamps[light];
        lamp.space = None;
        if let LampKind::Classical { position, .. } = &mut lamp.kind {
            let placed = matrix.transform_point3(*position);
            *position = if placed.is_finite() { placed } else { *position };
        }
    }
}
