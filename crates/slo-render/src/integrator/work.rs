//! The input and the output of an integrator.

use slo_accel::study::Totals;
use slo_picture::film::{Features, Fixed, PlaceLayers, Wide};

use super::ray_kind::RayKind;
use crate::frame::FrameScene;
use crate::guiding::Field;
use crate::photons::{PhotonCounts, PhotonLight, PhotonMaps};

/// Samples `first..first + count` of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// Column.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// First sample.
    pub first: u32,
    /// Number of samples.
    pub count: u32,
}

/// Exact sum of the radiances of camera samples, RGB.
pub type SampleSum = [Fixed; 3];

/// Result of tracing camera samples, for each entry of the work in its order.
#[derive(Clone, Copy, Debug)]
pub struct Traced<'a> {
    /// Exact sums of radiance over the samples of each entry.
    pub sums: &'a [SampleSum],
    /// Exact sums of surface features over the samples of each entry; empty unless requested.
    pub features: &'a [Features],
    /// Exact sums of the light of each named group of lights, group by group: the sum of group `g` and
    /// entry `i` is at `g * sums.len() + i`. Each contribution is the one that was added to `sums`. What
    /// is missing to `sums` belongs to the group without a name; if this is empty, all light does.
    pub groups: &'a [SampleSum],
    /// Exact sums of the places of first hits over the samples of each entry: those of an entry are
    /// neighbours. Empty unless requested.
    pub places: &'a [Wide],
    /// What each sample hit first, if it hit something, in any order; empty unless requested.
    pub seen: &'a [Seen],
    /// Counts of what was traced.
    pub statistics: Statistics,
}

/// What the samples of some work use and collect, besides the frame and the sums of radiance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// The photons of the passes that the samples use, if the frame has photons.
    pub maps: Option<&'a PhotonMaps>,
    /// The light that photons brought, under `PHOTON_MAP`.
    pub light: Option<&'a PhotonLight>,
    /// Whether surface features are.
    pub features: bool,
    /// Which places of first hits are.
    pub places: PlaceLayers,
    /// Whether ids of first hits are.
    pub ids: bool,
    /// How many named groups of lights there are whose light is collected by itself; see
    /// [`Traced::groups`].
    pub light_groups: usize,
}

/// What a camera sample hit first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Index of the entry of the work that the sample belongs to.
    pub entry: u32,
    /// Ids of the object and of its material, by [`MaskKind`](slo_picture::film::MaskKind); 0: none.
    pub ids: [u32; 2],
}

/// Counts of what was traced, for the log; never part of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples taken.
    pub camera_rays: u64,
    /// Rays to lights.
    pub shadow_rays: u64,
    /// Reflected and refracted rays.
    pub bounce_rays: u64,
    /// Contributions that were clamped to the film's range, or left out because they were no numbers.
    pub refused_contributions: u64,
    /// What photons took.
    pub photons: PhotonCounts,
    /// What rays took in the structures, by [`RayKind`]; all 0 unless rays are
    /// [counted](FrameScene::count).
    pub rays: [Totals; RayKind::NAMES.len()],
}

impl std::ops::AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.camera_rays += other.camera_rays;
        self.shadow_rays += other.shadow_rays;
        self.bounce_rays += other.bounce_rays;
        self.refused_contributions += other.refused_contributions;
        self.photons += other.photons;
        self.rays.iter_mut().zip(other.rays).for_each(|(sum, more)| *sum += more);
    }
}

/// The work at hand, read by every stage.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) frame: &'a FrameScene,
    pub(super) work: &'a [Work],
    /// The photons that the work uses, if the frame has any.
    pub(super) maps: Option<&'a PhotonMaps>,
    /// The field that guides rays, if any.
    pub(super) guide: Option<&'a Field>,
    /// Whether the paths are pilot paths, from which a field is learned.
    pub(super) is_pilot: bool,
    /// The light that photons brought, under `PHOTON_MAP`.
    pub(super) light: Option<&'a PhotonLight>,
    /// Whether to stop at once and lose the work.
    pub(super) gives_up: &'a dyn Fn() -> bool,
}

impl<'a> Job<'a> {
    /// Work that uses nothing beside the frame.
    pub(super) fn new(
        frame: &'a FrameScene,
        work: &'a [Work],
        gives_up: &'a dyn Fn() -> bool,
    ) -> Self {
        Self { frame, work, maps: None, guide: None, is_pilot: false, light: None, gives_up }
    }

    /// Whether rough lobes share their directions with a field, or will.
    pub(super) fn is_guided(&self) -> bool {
        self.guide.is_some() || self.is_pilot
    }

    /// Returns `None` if the work is to be given up. Called between batches, and between the rays
    /// that a batch sends out.
    pub(super) fn goes_on(&self) -> Option<()> {
        (!(self.gives_up)()).then_some(())
    }
}
