//! Key frames: the position of an object over time, and in what.

use glam::DVec3;

/// `addKframe`: the position of an object at one time, and how its path bends there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KeyFrame {
    /// Scene time.
    pub time: f64,
    /// Last but one control point of the cubic that arrives.
    pub pre: Placement,
    /// The point where the arriving and the leaving cubic meet.
    pub key: Placement,
    /// Second control point of the cubic that leaves.
    pub nex: Placement,
}

/// A control point of an object's path; what is missing is filled in by `animation`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Where the origin of object space is.
    pub pivot: Option<DVec3>,
    /// Where its z axis points; need not be unit.
    pub up: Option<DVec3>,
    /// Where its x axis points; need not be unit.
    pub right: Option<DVec3>,
    /// By how much it is larger along its own axes, before `right` and `up` turn it; more than 0.
    pub scale: Option<DVec3>,
}

/// Index of a space in [`SceneDescription::spaces`](crate::SceneDescription::spaces).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SpaceId(pub u32);
