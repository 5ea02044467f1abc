//! Objects that are instances, each kept by itself.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::affine::Affine;
use slo_accel::instances::{Child, Placements};
use slo_accel::math::Bounds;
use slo_accel::math::rounding::gamma;
use slo_accel::{Bending, Structure};

/// An object that moves within the shutter, or a curved one that is stretched.
#[derive(Debug)]
pub(super) struct Instance {
    pub(super) body: Body,
    /// Middle of the object in object space. Coordinates relative to it are small and keep their
    /// precision.
    pub(super) center: Vec3,
    /// `render_from_structure`, evenly spaced over the shutter. A ray uses the pose nearest to its
    /// time.
    pub(super) poses: Vec<Affine>,
    /// Index of the object.
    pub(super) object: u32,
}

/// Primitives of an object, in object space translated by `-center`.
#[derive(Clone, Debug)]
pub(super) enum Body {
    Still(Arc<Structure>),
    Bending(Arc<Bending>),
}

impl Body {
    pub(super) fn bounds(&self) -> Bounds {
        match self {
            Self::Still(structure) => structure.bounds(),
            Self::Bending(bending) => bending.bounds(),
        }
    }

    /// Returns the structure, unless the object bends.
    pub(super) fn structure(&self) -> Option<&Arc<Structure>> {
        match self {
            Self::Still(structure) => Some(structure),
            Self::Bending(_) => None,
        }
    }

    /// Returns it as what instances place.
    pub(super) fn child(&self) -> Child {
        match self {
            Self::Still(structure) => Child::Structure(structure.clone()),
            Self::Bending(bending) => Child::Bending(bending.clone()),
        }
    }

    pub(super) fn address(&self) -> *const () {
        match self {
            Self::Still(structure) => Arc::as_ptr(structure).cast(),
            Self::Bending(bending) => Arc::as_ptr(bending).cast(),
        }
    }
}

impl Instance {
    /// Returns `render_from_structure` at a time of the shutter in `[0, 1]`.
    ///
    /// Source: thesis 5.3, with rounding to the nearest pose.
    #[inline]
    pub(super) fn pose(&self, time: f32) -> &Affine {
        let last = self.poses.len() - 1;
        &self.poses[((time * last as f32 + 0.5) as usize).min(last)]
    }

    /// Whether it moves or bends within the shutter.
    pub(super) fn moves(&self) -> bool {
        self.poses.len() > 1 || matches!(self.body, Body::Bending(_))
    }

    /// Returns the bounding box of all poses.
    pub(super) fn bounds(&self) -> Bounds {
        let corners = self.body.bounds().corners();
        let at = |pose: &Affine| Bounds::of_points(corners.map(|c| pose.point(c)));
        let bounds = self.poses.iter().map(at).fold(Bounds::EMPTY, Bounds::union);
        // Rays are transformed to object space with rounding errors of their own.
        let far = bounds.min.abs().max(bounds.max.abs());
        let stretched = self.poses.iter().filter(|pose| !pose.is_rigid);
        let size = stretched
            .fold(far.max_element(), |size, pose| size.max(pose.round_trip(far).max_element()));
        let margin = Vec3::splat(size * gamma(16));
        Bounds { min: bounds.min - margin, max: bounds.max + margin }
    }
}

/// Returns what instances place, each once, and where.
pub(super) fn all_of(instances: &[Instance]) -> (Vec<Child>, Placements) {
    let mut numbers = HashMap::new();
    let mut children = Vec::new();
    let mut placements = Placements::with_capacity(instances.len());
    let mut poses = Vec::new();
    for instance in instances {
        let child = *numbers.entry(instance.body.address()).or_insert_with(|| {
            children.push(instance.body.child());
            children.len() as u32 - 1
        });
        poses.clear();
        poses.extend(instance.poses.iter().map(Affine::placed));
        placements.push(child, &poses);
    }
    (children, placements)
}
