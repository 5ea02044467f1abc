//! What a frame shows: objects and lights, and copies of them, one by one unless they are a crowd.

use std::collections::HashMap;

use slo_scene::animation::{Spaces, placed};
use slo_scene::{
    Copy, KeyFrame, Light, MOST_COPIED, MOST_NESTED, MaterialId, Object, Original, Repeat,
    SceneDescription, SpaceId, memory,
};

use super::error::FrameError;
use super::members::Members;
use super::survey::{Found, Survey};

/// An object, or a copy of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownObject<'a> {
    pub(super) object: &'a Object,
    pub(super) at: Whereabouts<'a>,
    pub(super) material: MaterialId,
    /// Factor of the material's colours.
    pub(super) tint: [f32; 3],
}

/// A light, or a copy of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownLight<'a> {
    pub(super) light: &'a Light,
    pub(super) at: Whereabouts<'a>,
}

/// Where something is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whereabouts<'a> {
    pub(super) key_frames: &'a [KeyFrame],
    pub(super) repeat: Option<Repeat>,
    pub(super) parent: Option<SpaceId>,
}

/// All that a frame shows.
#[derive(Debug)]
pub(super) struct Shown<'a> {
    /// Objects in the order of the text, then copies.
    pub(super) objects: Vec<ShownObject<'a>>,
    /// Lights in the order of the text, then copies.
    pub(super) lights: Vec<ShownLight<'a>>,
    /// What they hang in: the spaces of the scene, then those of copies.
    pub(super) spaces: Spaces,
    /// Copies that are not among the objects.
    pub(super) crowds: Vec<u32>,
    /// Whether copies of copies in crowds stay nested.
    pub(super) is_nested: bool,
    /// The objects of crowds, each with its material and how many there are.
    pub(super) casts: Vec<(u32, MaterialId, u64)>,
    /// How many things originals show, by the material that a copy gives them.
    pub(super) things: HashMap<(Original, Option<MaterialId>), u64>,
    /// What hangs in spaces of the scene; empty if there are no copies.
    pub(super) members: Members,
}

impl<'a> Shown<'a> {
    /// Finds what a scene shows.
    pub(super) fn of(scene: &'a SceneDescription) -> Result<Self, FrameError> {
        let spaces = Spaces::new(&scene.spaces).map_err(|(space, reason)| {
            let object = scene.spaces[space].name.clone();
            FrameError::Path { object, reason }
        })?;
        let mut shown = Self {
            objects: Vec::new(),
            lights: Vec::new(),
            spaces,
            crowds: Vec::new(),
            is_nested: false,
            casts: Vec::new(),
            things: HashMap::new(),
            members: Members::default(),
        };
        for object in scene.objects.iter().filter(|of| !of.hidden && !scene.hides(of.parent)) {
            let Object { key_frames, parent, material, .. } = object;
            let at = Whereabouts { key_frames, repeat: object.repeat, parent: *parent };
            let tint = [1.0; 3];
            shown.objects.push(ShownObject { object, at, material: *material, tint });
        }
        for light in scene.lights.iter().filter(|of| !scene.hides(of.parent)) {
            let Light { key_frames, repeat, parent, .. } = light;
            let at = Whereabouts { key_frames, repeat: *repeat, parent: *parent };
            shown.lights.push(ShownLight { light, at });
        }
        if !scene.copies.is_empty() {
            shown.members = Members::of(scene);
            let found = Survey::new(scene, &shown.members, &shown.spaces).decide();
            let Found { crowds, others, is_nested, casts, things } = found;
            (shown.crowds, shown.is_nested) = (crowds, is_nested);
            (shown.casts, shown.things) = (casts, things);
            let members = std::mem::take(&mut shown.members);
            let mut expansion = Expansion { scene, members: &members, shown: &mut shown };
            expansion.copies(others)?;
            shown.members = members;
        }
        Ok(shown)
    }
}

/// How a copy changes what it shows.
#[derive(Clone, Copy)]
struct Change {
    material: Option<MaterialId>,
    tint: [f32; 3],
    /// Number of copies around it.
    depth: u32,
}

/// Adds copies one by one.
struct Expansion<'a, 's> {
    scene: &'a SceneDescription,
    members: &'s Members,
    shown: &'s mut Shown<'a>,
}

impl<'a> Expansion<'a, '_> {
    fn copies(&mut self, copies: Vec<&'a Copy>) -> Result<(), FrameError> {
        for copy in copies {
            let space = self.add_space(copy, copy.parent)?;
            let change = Change { material: None, tint: [1.0; 3], depth: 0 };
            self.copy(copy, space, change)?;
        }
        Ok(())
    }

    /// Adds the space that the key frames of a copy make.
    fn add_space(&mut self, copy: &Copy, parent: Option<SpaceId>) -> Result<SpaceId, FrameError> {
        let added = self.shown.spaces.add(&copy.key_frames, copy.repeat, parent);
        added.map_err(|reason| FrameError::Path { object: copy.name.clone(), reason })
    }

    /// Adds all that a copy shows in a space.
    fn copy(&mut self, copy: &'a Copy, space: SpaceId, change: Change) -> Result<(), FrameError> {
        let depth = change.depth + 1;
        if depth > MOST_NESTED {
            return Err(FrameError::Nested { copy: copy.name.clone() });
        }
        let change = Change { material: change.material.or(copy.material), depth, ..change };
        let Some(placements) = &copy.placements else {
            return copy.of.iter().try_for_each(|original| self.show(*original, space, change));
        };
        for number in 0..placements.len() {
            let place = self.shown.spaces.add_place(placed(placements, number), Some(space));
            let tint = placements.tint(number).unwrap_or([1.0; 3]);
            let tint = std::array::from_fn(|channel| change.tint[channel] * tint[channel]);
            if let Some(original) = copy.of.get(placements.kind(number) as usize) {
                self.show(*original, place, Change { tint, ..change })?;
            }
        }
        Ok(())
    }

    /// Adds what an original is, in a space in place of its own.
    fn show(
        &mut self,
        original: Original,
        space: SpaceId,
        change: Change,
    ) -> Result<(), FrameError> {
        let scene = self.scene;
        let at = Whereabouts { key_frames: &[], repeat: None, parent: Some(space) };
        match original {
            Original::Object(number) => self.add_object(number, at, change),
            Original::Light(number) => self.add_light(number, at),
            Original::Copy(number) => self.copy(&scene.copies[number as usize], space, change),
            Original::Group(group) => self.members(group, space, change),
        }
    }

    /// Adds all that hangs in a space, in the places that it has there.
    fn members(&mut self, of: SpaceId, to: SpaceId, change: Change) -> Result<(), FrameError> {
        let scene = self.scene;
        let mut waiting = vec![(of, to)];
        while let Some((of, to)) = waiting.pop() {
            let group = of.0 as usize;
            for i in 0..self.members.objects[group].len() {
                let number = self.members.objects[group][i];
                let Object { key_frames, repeat, .. } = &scene.objects[number as usize];
                let at = Whereabouts { key_frames, repeat: *repeat, parent: Some(to) };
                self.add_object(number, at, change)?;
            }
            for i in 0..self.members.lights[group].len() {
                let number = self.members.lights[group][i];
                let Light { key_frames, repeat, .. } = &scene.lights[number as usize];
                let at = Whereabouts { key_frames, repeat: *repeat, parent: Some(to) };
                self.add_light(number, at)?;
            }
            for i in 0..self.members.copies[group].len() {
                let copy = &scene.copies[self.members.copies[group][i] as usize];
                let space = self.add_space(copy, Some(to))?;
                self.copy(copy, space, change)?;
            }
            for &space in self.members.spaces[group].iter().rev() {
                let space = SpaceId(space);
                waiting.push((space, self.shown.spaces.add_copy(space, Some(to))));
            }
        }
        Ok(())
    }

    fn add_object(
        &mut self,
        number: u32,
        at: Whereabouts<'a>,
        change: Change,
    ) -> Result<(), FrameError> {
        let object = &self.scene.objects[number as usize];
        let material = change.material.unwrap_or(object.material);
        self.shown.objects.push(ShownObject { object, at, material, tint: change.tint });
        self.check_count()
    }

    fn add_light(&mut self, number: u32, at: Whereabouts<'a>) -> Result<(), FrameError> {
        let light = &self.scene.lights[number as usize];
        self.shown.lights.push(ShownLight { light, at });
        self.check_count()
    }

    fn check_count(&self) -> Result<(), FrameError> {
        let count = self.shown.objects.len() + self.shown.lights.len();
        if count as u64 > MOST_COPIED {
            return Err(FrameError::Copies);
        }
        // Asked now and then: there may be ever more of them.
        if count.is_power_of_two() { check_things(count as u64) } else { Ok(()) }
    }
}

/// Bytes of each copy that is no plain copy. Measured with a million lamps.
const OF_THING: u64 = 1700;

/// Checks that there is memory for so many things that are shown one by one.
fn check_things(count: u64) -> Result<(), FrameError> {
    memory::check(count * OF_THING).map_err(|refusal| FrameError::Memory {
        what: "the lamps of the frame, and copies of things that glow, move or change shape, need",
        why: refusal.to_string(),
        help: "make fewer copies of them",
    })
}
