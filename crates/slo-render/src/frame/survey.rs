//! Which copies become a crowd, and which are written out one by one.

use std::collections::HashMap;

use super::glow::Glow;
use super::members::Members;
use super::sharpness::shares;
use slo_scene::animation::Spaces;
use slo_scene::{
    Copy, Integrator, KeyFrame, Layer, MOST_NESTED, MaterialId, Object, Original, Repeat,
    SceneDescription,
};

/// Copies of fewer things are written out, unless there are more than [`MOST_FLAT`] in all.
const FEW: u64 = 4096;

/// Copies of fewer triangles are written out, unless there are more than [`MOST_FLAT`] things.
const FEW_TRIANGLES: u64 = 1 << 20;

/// Triangles that a curved surface counts for: a crowd of them takes as much memory.
const AS_TRIANGLES: u64 = 64;

/// If there are more things, copies of copies stay nested.
pub(super) const MOST_FLAT: u64 = 1 << 20;

/// What is known of copies, with all that they show.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// How many things are shown.
    things: u64,
    /// How many triangles they have.
    triangles: u64,
    /// Whether they are plain: things at rest in the copy that need nothing of their own. Lamps are
    /// not, nor are things that rays or photons are sent toward, and meshes that change shape.
    is_plain: bool,
}

impl Facts {
    const NOTHING: Self = Self { things: 0, triangles: 0, is_plain: true };
    const UNFIT: Self = Self { things: 1, triangles: 0, is_plain: false };

    fn and(self, other: Self) -> Self {
        Self {
            things: self.things.saturating_add(other.things),
            triangles: self.triangles.saturating_add(other.triangles),
            is_plain: self.is_plain && other.is_plain,
        }
    }

    fn times(self, count: u64) -> Self {
        Self {
            things: self.things.saturating_mul(count),
            triangles: self.triangles.saturating_mul(count),
            ..self
        }
    }
}

/// Finds out what copies show. What it finds depends on the scene only, so it is the same in all
/// frames.
pub(super) struct Survey<'a, 's> {
    scene: &'a SceneDescription,
    members: &'s Members,
    spaces: &'s Spaces,
    known: HashMap<(Original, Option<MaterialId>), Facts>,
    /// By material: whether rays are sent toward it, and whether photons are.
    emits: Vec<bool>,
    is_target: Vec<bool>,
}

/// What copies have become.
pub(super) struct Found<'a> {
    /// Copies that become crowds, by number.
    pub(super) crowds: Vec<u32>,
    /// Copies that are written out.
    pub(super) others: Vec<&'a Copy>,
    /// Whether copies of copies stay nested.
    pub(super) is_nested: bool,
    /// The objects of crowds, each with its material and how many there are.
    pub(super) casts: Vec<(u32, MaterialId, u64)>,
    /// How many things originals show, by the material that a copy gives them.
    pub(super) things: HashMap<(Original, Option<MaterialId>), u64>,
}

impl<'a, 's> Survey<'a, 's> {
    pub(super) fn new(
        scene: &'a SceneDescription,
        members: &'s Members,
        spaces: &'s Spaces,
    ) -> Self {
        let materials = scene.materials.len();
        let emits = (0..materials).map(|m| !matches!(Glow::of(scene, m as u32), Glow::Dark));
        let sends = scene.settings.integrator == Integrator::PhotonMap
            || (scene.settings.photons > 0.0 && scene.settings.integrator == Integrator::Path);
        let is_target = match sends {
            true => shares(&scene.materials).into_iter().map(|share| share > 0.0).collect(),
            false => vec![false; materials],
        };
        let known = HashMap::new();
        Self { scene, members, spaces, known, emits: emits.collect(), is_target }
    }

    /// Decides about all copies that a frame shows.
    pub(super) fn decide(mut self) -> Found<'a> {
        let scene = self.scene;
        let shown = (0..).zip(&scene.copies);
        let shown = shown.filter(|(_, of)| !of.hidden && !scene.hides(of.parent));
        let facts: Vec<_> =
            shown.map(|(number, _)| (number, self.of(Original::Copy(number), None, 0))).collect();
        let all = facts.iter().fold(Facts::NOTHING, |all, (_, facts)| all.and(*facts));
        let is_nested = all.things > MOST_FLAT;
        let (mut crowds, mut others, mut casts) = (Vec::new(), Vec::new(), Vec::new());
        let mut numbers = HashMap::new();
        for (number, facts) in facts {
            let copy = &scene.copies[number as usize];
            let is_many = facts.things > FEW && facts.triangles > FEW_TRIANGLES;
            if facts.is_plain && (is_nested || is_many) && self.may_move(copy, facts) {
                crowds.push(number);
                let mut tally = Tally { numbers: &mut numbers, casts: &mut casts };
                self.tally_copy(copy, None, 1, &mut tally);
            } else {
                others.push(copy);
            }
        }
        let things = self.known.into_iter().map(|(of, facts)| (of, facts.things)).collect();
        Found { crowds, others, is_nested, casts, things }
    }

    /// Whether a copy rests at all times, or may move with all that it shows.
    fn may_move(&self, copy: &Copy, facts: Facts) -> bool {
        let path = self.spaces.path(&copy.key_frames, copy.repeat, copy.parent);
        let knows_motion = self.scene.camera.film.layers.contains(&Layer::Motion);
        path.is_ok_and(|path| path.rests() || (facts.things > 1 && !knows_motion))
    }

    fn rests(&self, key_frames: &[KeyFrame], repeat: Option<Repeat>) -> bool {
        key_frames.len() < 2
            || self.spaces.path(key_frames, repeat, None).is_ok_and(|path| path.rests())
    }

    fn of_object(&self, number: u32, material: Option<MaterialId>) -> Facts {
        let Object { shape, sampled, material: own, .. } = &self.scene.objects[number as usize];
        let material = material.unwrap_or(*own).0 as usize;
        let is_lamp = *sampled && self.emits[material];
        let is_plain = !is_lamp && !shape.changes() && !self.is_target[material];
        let triangles = match shape.triangle_count() {
            0 => AS_TRIANGLES,
            triangles => triangles as u64,
        };
        Facts { things: 1, triangles, is_plain }
    }

    fn of_copy(&mut self, copy: &Copy, material: Option<MaterialId>, depth: u32) -> Facts {
        if depth > MOST_NESTED {
            return Facts::UNFIT;
        }
        let material = material.or(copy.material);
        let counts = counts(copy);
        let counted = copy.of.iter().zip(counts).filter(|(_, count)| *count > 0);
        counted.fold(Facts::NOTHING, |all, (of, count)| {
            all.and(self.of(*of, material, depth).times(count))
        })
    }

    fn of(&mut self, original: Original, material: Option<MaterialId>, depth: u32) -> Facts {
        if let Some(facts) = self.known.get(&(original, material)) {
            return *facts;
        }
        let scene = self.scene;
        let facts = match original {
            Original::Object(number) => self.of_object(number, material),
            Original::Light(_) => Facts::UNFIT,
            Original::Copy(number) => {
                self.of_copy(&scene.copies[number as usize], material, depth + 1)
            }
            Original::Group(group) => {
                let (mut all, mut waiting) = (Facts::NOTHING, vec![group.0 as usize]);
                while let Some(space) = waiting.pop() {
                    for _ in &self.members.lights[space] {
                        all = all.and(Facts::UNFIT);
                    }
                    for &number in &self.members.objects[space] {
                        let object = &scene.objects[number as usize];
                        let mut facts = self.of_object(number, material);
                        facts.is_plain &= self.rests(&object.key_frames, object.repeat);
                        all = all.and(facts);
                    }
                    for &number in &self.members.copies[space] {
                        let copy = &scene.copies[number as usize];
                        let mut facts = self.of(Original::Copy(number), material, depth);
                        facts.is_plain &= self.rests(&copy.key_frames, copy.repeat);
                        all = all.and(facts);
                    }
                    for &number in &self.members.spaces[space] {
                        let space = &scene.spaces[number as usize];
                        all.is_plain &= self.rests(&space.key_frames, space.repeat);
                        waiting.push(number as usize);
                    }
                }
                all
            }
        };
        self.known.insert((original, material), facts);
        facts
    }

    fn tally_copy(
        &self,
        copy: &Copy,
        material: Option<MaterialId>,
        count: u64,
        tally: &mut Tally<'_>,
    ) {
        let material = material.or(copy.material);
        for (of, many) in copy.of.iter().zip(counts(copy)) {
            if many > 0 {
                self.tally(*of, material, count.saturating_mul(many), tally);
            }
        }
    }

    /// Counts the objects of a crowd.
    fn tally(
        &self,
        original: Original,
        material: Option<MaterialId>,
        count: u64,
        tally: &mut Tally<'_>,
    ) {
        let scene = self.scene;
        match original {
            Original::Object(number) => {
                let own = scene.objects[number as usize].material;
                tally.add(number, material.unwrap_or(own), count);
            }
            Original::Light(_) => {}
            Original::Copy(number) => {
                self.tally_copy(&scene.copies[number as usize], material, count, tally);
            }
            Original::Group(group) => {
                let mut waiting = vec![group.0 as usize];
                while let Some(space) = waiting.pop() {
                    for &number in &self.members.objects[space] {
                        self.tally(Original::Object(number), material, count, tally);
                    }
                    for &number in &self.members.copies[space] {
                        self.tally(Original::Copy(number), material, count, tally);
                    }
                    waiting.extend(self.members.spaces[space].iter().map(|&of| of as usize));
                }
            }
        }
    }
}

/// Returns how many copies show each of the originals.
fn counts(copy: &Copy) -> Vec<u64> {
    let mut counts = vec![0; copy.of.len()];
    match &copy.placements {
        None => counts.fill(1),
        Some(placements) if placements.kinds.is_empty() => {
            if let Some(first) = counts.first_mut() {
                *first = placements.len() as u64;
            }
        }
        Some(placements) => {
            for &kind in &placements.kinds {
                if let Some(count) = counts.get_mut(kind as usize) {
                    *count += 1;
                }
            }
        }
    }
    counts
}

/// The objects of crowds, as they are found.
struct Tally<'t> {
    numbers: &'t mut HashMap<(u32, MaterialId), usize>,
    casts: &'t mut Vec<(u32, MaterialId, u64)>,
}

impl Tally<'_> {
    fn add(&mut self, object: u32, material: MaterialId, count: u64) {
        let place = *self.numbers.entry((object, material)).or_insert_with(|| {
            self.casts.push((object, material, 0));
            self.casts.len() - 1
        });
        let total = &mut self.casts[place].2;
        *total = total.saturating_add(count);
    }
}
