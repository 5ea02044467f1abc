//! Builds crowds: lists of placements, from the copies of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::affine::Affine;
use super::crowd::{Cast, Crowd, Level, Member, Nested, Resting, ToPlace};
use super::error::FrameError;
use super::instance::all_of;
use super::parts::{Parts, Seen, fits};
use super::sampled_motion::ObjectBox;
use super::shown::Shown;
use super::survey::MOST_FLAT;
use slo_accel::instances::{self, BuildError, Child, Placements};
use slo_accel::{Instances, Isa};
use slo_scene::animation::{DAffine, placed};
use slo_scene::{Copy, KeyFrame, MaterialId, Original, Repeat, SceneDescription, SpaceId};

/// Placements that are computed together.
const TOGETHER: usize = 1 << 16;

/// Something that copies show: an original, with the material that they give it.
type Part = (Original, Option<MaterialId>);

/// Places the crowds of a frame. Their objects are added to the others. `before` is a crowd about the same
/// origin, of another frame of the same scene.
pub(super) fn crowd(
    shown: &Shown<'_>,
    parts: &mut Parts,
    scene: &SceneDescription,
    seen: &Seen<'_>,
    isa: Isa,
    before: Option<&Resting>,
) -> Result<Crowd, FrameError> {
    if shown.crowds.is_empty() {
        return Ok(Crowd::default());
    }
    let first_cast = parts.objects.len() as u32;
    let (mut casts, mut numbers) = (Vec::new(), HashMap::new());
    for (number, &(object, material, _)) in (0..).zip(&shown.casts) {
        let (cast, about) =
            parts.add_cast(&scene.objects[object as usize], material, scene, isa)?;
        casts.push((cast, about));
        numbers.insert((object, material), number);
    }
    // Crowds are placed together with all other instances.
    if let Some(before) = before.filter(|_| parts.instances.is_empty()) {
        let (bare, abouts): (Vec<_>, Vec<_>) = casts.into_iter().unzip();
        casts = match Crowd::again(before, first_cast, bare) {
            Ok(crowd) => return Ok(crowd),
            Err(bare) => bare.into_iter().zip(abouts).collect(),
        };
    }
    let time = seen.shutter.scene_time(0.0);
    let nested = HashMap::new();
    let rests = parts.instances.is_empty();
    let mut lists =
        Lists { shown, scene, seen, isa, time, casts, numbers, first_cast, nested, rests };
    let mut top = List::default();
    (top.children, top.placements) = all_of(&parts.instances);
    // Nobody asks for these: they are kept one by one.
    top.level.members.resize(top.children.len(), Member::Object(u32::MAX));
    let mut moving = 0;
    for &number in &shown.crowds {
        moving += lists.add_copy(number, &mut top)?;
    }
    let rests = lists.rests;
    let casts = lists.casts.into_iter().map(|(cast, _)| cast).collect();
    let List { children, placements, level, .. } = top;
    let (to_place, top) = (Some(ToPlace::List(children, placements)), Arc::new(level));
    Ok(Crowd { to_place, top, casts, first_cast, moving, rests })
}

/// Why a frame cannot be built if the instances of a copy cannot.
pub(super) fn not_placed(error: BuildError, copy: &Copy) -> FrameError {
    let name = copy.name.clone();
    match error {
        BuildError::TooDeep => FrameError::Nested { copy: name },
        BuildError::NotInvertible(_) => FrameError::Extent { object: name },
        _ => FrameError::Copies,
    }
}

/// A list of placements that grows.
#[derive(Default)]
struct List {
    children: Vec<Child>,
    placements: Placements,
    level: Level,
    /// Numbers of children.
    numbers: HashMap<Target, u32>,
}

/// What is placed.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Target {
    /// The object of a crowd with this number.
    Cast(u32),
    /// Copies that stay together.
    Nested(Part),
}

/// Something that an original shows, in the space of the original.
#[derive(Clone)]
struct Item {
    pose: DAffine,
    target: Target,
    /// Factors of colours, from the inside out.
    tints: Vec<[f32; 3]>,
}

/// An item, ready to be placed.
struct Ready {
    item: Item,
    child: u32,
    about: ObjectBox,
    center: DVec3,
}

struct Lists<'a, 's> {
    shown: &'s Shown<'a>,
    scene: &'s SceneDescription,
    seen: &'s Seen<'s>,
    isa: Isa,
    /// Scene time at which copies rest where they rest.
    time: f64,
    /// Objects of crowds, with boxes in object space.
    casts: Vec<(Cast, ObjectBox)>,
    numbers: HashMap<(u32, MaterialId), u32>,
    first_cast: u32,
    /// With boxes and origins.
    nested: HashMap<Part, (Arc<Nested>, ObjectBox, DVec3)>,
    /// Whether all copies so far are at the same place in all frames, and nothing else is placed with
    /// them.
    rests: bool,
}

impl Lists<'_, '_> {
    /// Adds what a copy shows to the list of all instances. Returns how many instances move.
    fn add_copy(&mut self, number: u32, top: &mut List) -> Result<usize, FrameError> {
        let copy = &self.scene.copies[number as usize];
        let Copy { name, key_frames, repeat, parent, .. } = copy;
        let path = self.seen.spaces.path(key_frames, *repeat, *parent);
        let path = path.map_err(|reason| FrameError::Path { object: name.clone(), reason })?;
        if path.rests() {
            let kinds = self.kinds(copy, copy.material, self.shown.is_nested)?;
            let outer: Vec<_> = path.factors(self.time).collect();
            self.fill(top, copy, kinds, &outer, self.seen.origin)?;
            return Ok(0);
        }
        self.rests = false;
        let target = Target::Nested((Original::Copy(number), None));
        let (child, about, center) = self.child(target, top)?;
        let poses = self.seen.poses(name, &path, &about)?;
        let pose =
            |pose: &DAffine| Affine::relative(&pose.about(center), self.seen.origin).placed();
        let poses: Vec<_> = poses.iter().map(pose).collect();
        top.placements.push(child, &poses);
        if !top.level.tints.is_empty() {
            top.level.tints.push([1.0; 3]);
        }
        let things = self.things((Original::Copy(number), None));
        Ok(if poses.len() > 1 { things as usize } else { 0 })
    }

    fn things(&self, part: Part) -> u64 {
        self.shown.things.get(&part).copied().unwrap_or(1)
    }

    fn pose(
        &self,
        name: &str,
        key_frames: &[KeyFrame],
        repeat: Option<Repeat>,
    ) -> Result<DAffine, FrameError> {
        let path = self.seen.spaces.path(key_frames, repeat, None);
        let path = path.map_err(|reason| FrameError::Path { object: name.to_owned(), reason })?;
        Ok(path.pose(self.time))
    }

    /// What each of the originals of a copy shows.
    fn kinds(
        &self,
        copy: &Copy,
        material: Option<MaterialId>,
        nests: bool,
    ) -> Result<Vec<Vec<Item>>, FrameError> {
        copy.of.iter().map(|of| self.part((*of, material), nests)).collect()
    }

    /// What an original shows, or the original as a whole if it is not a single thing and `nests`.
    fn part(&self, part: Part, nests: bool) -> Result<Vec<Item>, FrameError> {
        if nests && self.things(part) > 1 {
            let target = Target::Nested(part);
            return Ok(vec![Item { pose: DAffine::IDENTITY, target, tints: Vec::new() }]);
        }
        self.items(part, nests)
    }

    /// What an original shows, one by one.
    fn items(&self, (original, material): Part, nests: bool) -> Result<Vec<Item>, FrameError> {
        let scene = self.scene;
        match original {
            Original::Object(number) => {
                let pose = DAffine::IDENTITY;
                Ok(self.object(number, material, pose).into_iter().collect())
            }
            // Copies of lamps are no crowds.
            Original::Light(_) => Ok(Vec::new()),
            Original::Group(group) => self.members(group, material, nests),
            Original::Copy(number) => {
                let copy = &scene.copies[number as usize];
                let kinds = self.kinds(copy, material.or(copy.material), nests)?;
                let Some(placements) = &copy.placements else { return Ok(kinds.concat()) };
                let mut items = Vec::new();
                for number in 0..placements.len() {
                    let place = placed(placements, number);
                    let kind = kinds.get(placements.kind(number) as usize);
                    for item in kind.into_iter().flatten() {
                        let mut item = item.clone();
                        item.pose = place.after(&item.pose);
                        item.tints.extend(placements.tint(number));
                        items.push(item);
                    }
                }
                Ok(items)
            }
        }
    }

    fn object(&self, number: u32, material: Option<MaterialId>, pose: DAffine) -> Option<Item> {
        let material = material.unwrap_or(self.scene.objects[number as usize].material);
        let cast = *self.numbers.get(&(number, material))?;
        Some(Item { pose, target: Target::Cast(cast), tints: Vec::new() })
    }

    /// What hangs in a space, and in those that hang in it.
    fn members(
        &self,
        group: SpaceId,
        material: Option<MaterialId>,
        nests: bool,
    ) -> Result<Vec<Item>, FrameError> {
        let (scene, members) = (self.scene, &self.shown.members);
        // The maps of spaces to those that hold them.
        let mut spaces: Vec<(DAffine, Option<usize>)> = Vec::new();
        let mut waiting = vec![(group.0 as usize, None)];
        let mut items = Vec::new();
        while let Some((space, held_by)) = waiting.pop() {
            let place = |spaces: &[(DAffine, Option<usize>)], mut item: Item| {
                let mut next: Option<usize> = held_by;
                while let Some((outer, holder)) = next.map(|of| spaces[of]) {
                    item.pose = outer.after(&item.pose);
                    next = holder;
                }
                item
            };
            for &number in &members.objects[space] {
                let object = &scene.objects[number as usize];
                let pose = self.pose(&object.name, &object.key_frames, object.repeat)?;
                let item = self.object(number, material, pose);
                items.extend(item.map(|item| place(&spaces, item)));
            }
            for &number in &members.copies[space] {
                let copy = &scene.copies[number as usize];
                let pose = self.pose(&copy.name, &copy.key_frames, copy.repeat)?;
                for mut item in self.part((Original::Copy(number), material), nests)? {
                    item.pose = pose.after(&item.pose);
                    items.push(place(&spaces, item));
                }
            }
            for &number in members.spaces[space].iter().rev() {
                let inner = &scene.spaces[number as usize];
                let pose = self.pose(&inner.name, &inner.key_frames, inner.repeat)?;
                waiting.push((number as usize, Some(spaces.len())));
                spaces.push((pose, held_by));
            }
        }
        Ok(items)
    }

    /// The number of a child in a list, and its box and its origin in its own space.
    fn child(
        &mut self,
        target: Target,
        list: &mut List,
    ) -> Result<(u32, ObjectBox, DVec3), FrameError> {
        let (child, member, about, center) = match target {
            Target::Cast(number) => {
                let (cast, about) = &self.casts[number as usize];
                let member = Member::Object(self.first_cast + number);
                (cast.body.child(), member, *about, about.center())
            }
            Target::Nested(part) => {
                let (nested, about, center) = self.nested(part)?;
                let child = Child::Instances(nested.instances.clone());
                (child, Member::Nested(nested), about, center)
            }
        };
        let List { children, level, numbers, .. } = list;
        let number = *numbers.entry(target).or_insert_with(|| {
            children.push(child);
            level.members.push(member);
            children.len() as u32 - 1
        });
        Ok((number, about, center))
    }

    /// Copies that stay together, built once; with their box and their origin.
    fn nested(&mut self, part: Part) -> Result<(Arc<Nested>, ObjectBox, DVec3), FrameError> {
        if let Some(known) = self.nested.get(&part) {
            return Ok(known.clone());
        }
        let nests = self.things(part) > MOST_FLAT;
        let mut list = List::default();
        let whole;
        let (copy, kinds) = match part {
            (Original::Copy(number), material) => {
                let copy = &self.scene.copies[number as usize];
                (copy, self.kinds(copy, material.or(copy.material), nests)?)
            }
            part => {
                let name = match part.0 {
                    Original::Group(group) => &*self.scene.spaces[group.0 as usize].name,
                    _ => "",
                };
                whole = Copy {
                    name: name.to_owned(),
                    of: vec![part.0],
                    key_frames: Vec::new(),
                    repeat: None,
                    parent: None,
                    placements: None,
                    material: None,
                    hidden: false,
                };
                (&whole, vec![self.items(part, nests)?])
            }
        };
        let center = middle(copy, &kinds);
        self.fill(&mut list, copy, kinds, &[], center)?;
        let List { children, placements, level, .. } = list;
        let instances = Instances::build(children, placements, self.isa);
        let instances = instances.map_err(|error| not_placed(error, copy))?;
        let bounds = instances.bounds();
        let [min, max] = [bounds.min, bounds.max].map(|corner| corner.as_dvec3() + center);
        let about = ObjectBox { min, max };
        let nested = Arc::new(Nested { instances: Arc::new(instances), level });
        self.nested.insert(part, (nested.clone(), about, center));
        Ok((nested, about, center))
    }

    /// Adds everything in all places of a copy to a list. `outer` are the maps from the space of the
    /// copy to that in which `origin` is the list's origin.
    fn fill(
        &mut self,
        list: &mut List,
        copy: &Copy,
        kinds: Vec<Vec<Item>>,
        outer: &[DAffine],
        origin: DVec3,
    ) -> Result<(), FrameError> {
        let mut ready = |item: Item| {
            let (child, about, center) = self.child(item.target, list)?;
            Ok(Ready { item, child, about, center })
        };
        let kinds: Vec<Vec<Ready>> = kinds
            .into_iter()
            .map(|items| items.into_iter().map(&mut ready).collect())
            .collect::<Result<_, FrameError>>()?;
        let place = |ready: &Ready, place: Option<&DAffine>| {
            let own = ready.item.pose;
            let pose = place.into_iter().chain(outer).fold(own, |pose, outer| outer.after(&pose));
            let is_fit = pose.is_rigid() || fits(&pose, &ready.about);
            let pose = || Affine::relative(&pose.about(ready.center), origin).placed();
            is_fit.then(|| (ready.child, pose()))
        };
        let failed = || FrameError::Extent { object: copy.name.clone() };
        let mut add = |found: Vec<(u32, instances::Affine)>| {
            for (child, pose) in found {
                list.placements.push(child, &[pose]);
            }
        };
        let Some(placements) = &copy.placements else {
            for ready in kinds.iter().flatten() {
                add(vec![place(ready, None).ok_or_else(failed)?]);
            }
            let tints = kinds.iter().flatten().map(|ready| [1.0; 3].tinted(&ready.item.tints));
            list.tint(tints.collect());
            return Ok(());
        };
        let kind = |number: usize| kinds.get(placements.kind(number) as usize);
        let of = |number: usize| kind(number).into_iter().flatten();
        for first in (0..placements.len()).step_by(TOGETHER) {
            let found = (first..placements.len().min(first + TOGETHER)).into_par_iter();
            let found: Option<Vec<_>> = found
                .flat_map_iter(|number| {
                    let at = placed(placements, number);
                    of(number).map(move |ready| place(ready, Some(&at)))
                })
                .collect();
            add(found.ok_or_else(failed)?);
        }
        let any_inside = kinds.iter().flatten().any(|ready| !ready.item.tints.is_empty());
        if any_inside || !placements.tints.is_empty() {
            let tints = (0..placements.len()).flat_map(|number| {
                let tint = placements.tint(number).unwrap_or([1.0; 3]);
                of(number).map(move |ready| tint.tinted(&ready.item.tints))
            });
            list.tint(tints.collect());
        } else {
            list.tint(Vec::new());
        }
        Ok(())
    }
}

impl List {
    /// Adds tints of the last placements; none if they have none.
    fn tint(&mut self, tints: Vec<[f32; 3]>) {
        let (all, count) = (&mut self.level.tints, self.placements.len());
        if tints.iter().any(|tint| *tint != [1.0; 3]) {
            all.resize(count - tints.len(), [1.0; 3]);
            all.extend(tints);
        } else if !all.is_empty() {
            all.resize(count, [1.0; 3]);
        }
    }
}

trait Tinted {
    /// Multiplied by tints, the last first.
    fn tinted(self, tints: &[[f32; 3]]) -> Self;
}

impl Tinted for [f32; 3] {
    fn tinted(self, tints: &[[f32; 3]]) -> Self {
        let times = |a: Self, b: &Self| std::array::from_fn(|channel| a[channel] * b[channel]);
        tints.iter().rev().fold(self, times)
    }
}

/// The middle of the places of what a copy shows, in the space of the copy.
fn middle(copy: &Copy, kinds: &[Vec<Item>]) -> DVec3 {
    let about = match &copy.placements {
        None => ObjectBox::about(kinds.iter().flatten().map(|item| item.pose.translation)),
        Some(placements) => {
            let points = (0..placements.len()).flat_map(|number| {
                let place = placed(placements, number);
                let items = kinds.get(placements.kind(number) as usize).into_iter().flatten();
                items.map(move |item| place.point(item.pose.translation))
            });
            ObjectBox::about(points)
        }
    };
    let center = about.center();
    if center.is_finite() { center } else { DVec3::ZERO }
}
