//! Instances that are not kept one by one: copies, very many of them, on one level or on several.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::affine::Affine;
use super::instance::Body;
use slo_accel::instances::{Child, MAX_DEPTH, Placements};
use slo_accel::{Instances, Structure};

/// Instances that are not kept one by one. Their numbers follow those of all others.
#[derive(Debug, Default)]
pub(super) struct Crowd {
    /// What is placed, and where, until it is.
    pub(super) to_place: Option<ToPlace>,
    pub(super) top: Arc<Level>,
    /// What objects are made of, from number `first_cast` on.
    pub(super) casts: Vec<Cast>,
    pub(super) first_cast: u32,
    /// Number of instances that move within the shutter.
    pub(super) moving: usize,
    /// Whether everything is at the same place in all frames.
    pub(super) rests: bool,
}

/// Instances of a crowd, and of what is not in it.
#[derive(Debug)]
pub(super) enum ToPlace {
    /// What is placed, and where.
    List(Vec<Child>, Placements),
    /// The instances of another frame.
    Placed(Arc<Instances>),
}

/// A crowd at rest that has been placed.
#[derive(Clone, Debug)]
pub(super) struct Resting {
    all: Arc<Instances>,
    top: Arc<Level>,
    first_cast: u32,
    /// Addresses of what the objects are made of, which the instances keep.
    bodies: Vec<usize>,
}

/// What the children of [`Instances`] are.
#[derive(Debug, Default)]
pub(super) struct Level {
    /// By the number of the child.
    pub(super) members: Vec<Member>,
    /// Factors of colours, by the number of the placement; empty if there are none.
    pub(super) tints: Vec<[f32; 3]>,
}

#[derive(Clone, Debug)]
pub(super) enum Member {
    /// The object with this number.
    Object(u32),
    /// Copies that hang together and are placed as a whole.
    Nested(Arc<Nested>),
}

/// Copies that hang together, about a middle of their own.
#[derive(Debug)]
pub(super) struct Nested {
    pub(super) instances: Arc<Instances>,
    pub(super) level: Level,
}

/// The primitives of an object, and the middle of the object.
#[derive(Debug)]
pub(super) struct Cast {
    pub(super) body: Body,
    pub(super) center: Vec3,
}

impl Crowd {
    pub(super) fn is_empty(&self) -> bool {
        self.casts.is_empty()
    }

    /// Returns what is to be placed, once.
    pub(super) fn take(&mut self) -> Option<ToPlace> {
        self.to_place.take()
    }

    /// Returns what another frame may use if the crowd is at rest, and is all that `all` has.
    pub(super) fn resting(&self, all: &Arc<Instances>) -> Option<Resting> {
        let bodies = self.casts.iter().map(|cast| cast.body.address().addr()).collect();
        (self.rests && !self.is_empty()).then(|| Resting {
            all: all.clone(),
            top: self.top.clone(),
            first_cast: self.first_cast,
            bodies,
        })
    }

    /// Returns a crowd that stands where another one does, if it is made of the same objects.
    pub(super) fn again(
        before: &Resting,
        first_cast: u32,
        casts: Vec<Cast>,
    ) -> Result<Self, Vec<Cast>> {
        let bodies = casts.iter().map(|cast| cast.body.address().addr());
        if first_cast != before.first_cast || !bodies.eq(before.bodies.iter().copied()) {
            return Err(casts);
        }
        let to_place = Some(ToPlace::Placed(before.all.clone()));
        let top = before.top.clone();
        Ok(Self { to_place, top, casts, first_cast, moving: 0, rests: true })
    }

    /// Goes from all instances to the object of one. Visits its placement on each level.
    #[inline]
    fn walk<'a>(
        &'a self,
        mut instances: &'a Instances,
        mut number: u32,
        mut visit: impl FnMut(&'a Placements, u32, &'a Level),
    ) -> u32 {
        let mut level = &*self.top;
        loop {
            let (placement, rest) = instances.placement(number);
            let placements = instances.placements();
            visit(placements, placement, level);
            match &level.members[placements.child(placement) as usize] {
                Member::Object(object) => return *object,
                Member::Nested(nested) => {
                    (instances, level, number) = (&nested.instances, &nested.level, rest);
                }
            }
        }
    }

    /// Returns the number of the object of an instance of `all`.
    #[inline]
    pub(super) fn object_of(&self, all: &Instances, instance: u32) -> u32 {
        self.walk(all, instance, |_, _, _| {})
    }

    /// Returns what an object is made of, and its middle.
    #[inline]
    pub(super) fn body(&self, object: u32) -> (&Body, Vec3) {
        let Cast { body, center } = &self.casts[(object - self.first_cast) as usize];
        (body, *center)
    }

    /// Returns the map of an instance at a time of the shutter in `[0, 1]`.
    pub(super) fn pose(&self, all: &Instances, instance: u32, time: f32) -> Affine {
        let (mut linear, mut translation) = (DMat3::IDENTITY, DVec3::ZERO);
        self.walk(all, instance, |placements, placement, _| {
            let pose = placements.pose(placement, time);
            translation += linear * pose.translation.as_dvec3();
            linear *= pose.matrix.as_dmat3();
        });
        Affine::of(linear.as_mat3(), translation.as_vec3())
    }

    /// As [`Affine::magnitude`]. What the maps of all levels are computed from is added up, since
    /// each is rounded by itself.
    pub(super) fn magnitude(&self, all: &Instances, instance: u32, time: f32, of: Vec3) -> Vec3 {
        let (mut chain, mut levels) = ([Affine::IDENTITY; MAX_DEPTH], 0);
        self.walk(all, instance, |placements, placement, _| {
            let pose = placements.pose(placement, time);
            chain[levels] = Affine::of(pose.matrix, pose.translation);
            levels += 1;
        });
        let outside = chain[..levels].iter().rev().fold(of, |of, pose| pose.magnitude(of));
        outside * levels as f32
    }

    /// Returns the factor of colours of an instance.
    pub(super) fn tint(&self, all: &Instances, instance: u32) -> Vec3 {
        let mut tint = Vec3::ONE;
        self.walk(all, instance, |_, placement, level| {
            tint *= level.tints.get(placement as usize).map_or(Vec3::ONE, |t| Vec3::from(*t));
        });
        tint
    }

    /// Whether places give any tint.
    pub(super) fn tints(&self) -> bool {
        let is_tinted = |level: &Level| !level.tints.is_empty();
        is_tinted(&self.top) || self.nested().iter().any(|nested| is_tinted(&nested.level))
    }

    /// Returns the structures of all objects, some of them several times.
    pub(super) fn structures(&self) -> impl Iterator<Item = &Arc<Structure>> {
        self.casts.iter().filter_map(|cast| cast.body.structure())
    }

    /// Returns all that is nested, each once.
    fn nested(&self) -> Vec<&Arc<Nested>> {
        let (mut known, mut found) = (HashSet::new(), Vec::new());
        let mut waiting = vec![&*self.top];
        while let Some(level) = waiting.pop() {
            for member in &level.members {
                if let Member::Nested(nested) = member
                    && known.insert(Arc::as_ptr(nested))
                {
                    found.push(nested);
                    waiting.push(&nested.level);
                }
            }
        }
        found
    }

    /// Returns the memory, in bytes, of all but structures and what is placed at the top.
    pub(super) fn memory(&self) -> usize {
        let of = |level: &Level| {
            size_of_val(level.members.as_slice()) + size_of_val(level.tints.as_slice())
        };
        let nested = self.nested();
        of(&self.top)
            + size_of_val(self.casts.as_slice())
            + nested.iter().map(|n| n.instances.memory() + of(&n.level)).sum::<usize>()
    }
}
