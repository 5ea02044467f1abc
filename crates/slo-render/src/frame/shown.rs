//! What a frame shows: objects and lights, and all copies of them, one by one.

use slo_scene::animation::{Spaces, placed};
use slo_scene::{
    Copy, KeyFrame, Light, MOST_COPIED, MOST_NESTED, MaterialId, Object, Original,
    SceneDescription, SpaceId,
};

use super::error::FrameError;

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
}

impl<'a> Shown<'a> {
    /// Finds what a scene shows.
    pub(super) fn of(scene: &'a SceneDescription) -> Result<Self, FrameError> {
        let spaces = Spaces::new(&scene.spaces).map_err(|(space, reason)| {
            let object = scene.spaces[space].name.clone();
            FrameError::Path { object, reason }
        })?;
        let mut shown = Self { objects: Vec::new(), lights: Vec::new(), spaces };
        for object in scene.objects.iter().filter(|of| !of.hidden && !scene.hides(of.parent)) {
            let Object { key_frames, parent, material, .. } = object;
            let at = Whereabouts { key_frames, parent: *parent };
            let tint = [1.0; 3];
            shown.objects.push(ShownObject { object, at, material: *material, tint });
        }
        for light in scene.lights.iter().filter(|of| !scene.hides(of.parent)) {
            let at = Whereabouts { key_frames: &light.key_frames, parent: light.parent };
            shown.lights.push(ShownLight { light, at });
        }
        if !scene.copies.is_empty() {
            Expansion { scene, members: Members::of(scene), shown: &mut shown }.copies()?;
        }
        Ok(shown)
    }
}

/// Indices of what hangs in each space directly, and is not hidden.
struct Members {
    objects: Vec<Vec<u32>>,
    lights: Vec<Vec<u32>>,
    copies: Vec<Vec<u32>>,
    spaces: Vec<Vec<u32>>,
}

impl Members {
    fn of(scene: &SceneDescription) -> Self {
        let sorted = |parents: &mut dyn Iterator<Item = (bool, Option<SpaceId>)>| {
            let mut members = vec![Vec::new(); scene.spaces.len()];
            for (number, (is_hidden, parent)) in (0u32..).zip(parents) {
                if let Some(parent) = parent.filter(|_| !is_hidden) {
                    members[parent.0 as usize].push(number);
                }
            }
            members
        };
        Self {
            objects: sorted(&mut scene.objects.iter().map(|of| (of.hidden, of.parent))),
            lights: sorted(&mut scene.lights.iter().map(|of| (false, of.parent))),
            copies: sorted(&mut scene.copies.iter().map(|of| (of.hidden, of.parent))),
            spaces: sorted(&mut scene.spaces.iter().map(|of| (of.hidden, of.parent))),
        }
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
    members: Members,
    shown: &'s mut Shown<'a>,
}

impl<'a> Expansion<'a, '_> {
    fn copies(&mut self) -> Result<(), FrameError> {
        let scene = self.scene;
        for copy in scene.copies.iter().filter(|of| !of.hidden && !scene.hides(of.parent)) {
            let space = self.add_space(copy, copy.parent)?;
            let change = Change { material: None, tint: [1.0; 3], depth: 0 };
            self.copy(copy, space, change)?;
        }
        Ok(())
    }

    /// Adds the space that the key frames of a copy make.
    fn add_space(&mut self, copy: &Copy, parent: Option<SpaceId>) -> Result<SpaceId, FrameError> {
        let added = self.shown.spaces.add(&copy.key_frames, parent);
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
        let at = Whereabouts { key_frames: &[], parent: Some(space) };
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
                let key_frames = &scene.objects[number as usize].key_frames;
                self.add_object(number, Whereabouts { key_frames, parent: Some(to) }, change)?;
            }
            for i in 0..self.members.lights[group].len() {
                let number = self.members.lights[group][i];
                let key_frames = &scene.lights[number as usize].key_frames;
                self.add_light(number, Whereabouts { key_frames, parent: Some(to) })?;
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
        if count as u64 > MOST_COPIED { Err(FrameError::Copies) } else { Ok(()) }
    }
}
