//! What every structure does: the seam between the [list](super) and the folders.

use std::borrow::Cow;
use std::fmt::Debug;

use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Curved, Primitives, Triangle};
use crate::rays::{Coherence, Hits, Rays};
use crate::structure::device::Device;
use crate::structure::study::{Counts, Parameters, Statistics};

/// How a structure is built. No option changes a hit.
///
/// ```
/// use slo_accel::{BuildOptions, Isa};
///
/// let options = BuildOptions::new(Isa::best()).with_spatial_splits(true);
/// assert!(options.spatial_splits);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BuildOptions {
    /// Instruction set of builder and queries.
    pub isa: Isa,
    /// Whether triangles may be cut where boxes would overlap. Among long triangles this speeds up
    /// incoherent rays, but slows down packets of shadow rays and doubles the time to build. At
    /// most a quarter of the triangles is added as pieces. Only [`Bvh`](crate::Accelerator::Bvh)
    /// cuts triangles; the other structures ignore the option.
    pub spatial_splits: bool,
    /// Parameters of structures [to study](crate::study), which the other structures ignore.
    pub parameters: Parameters,
}

impl BuildOptions {
    /// Options for an instruction set, without spatial splits, and with no parameters given.
    pub fn new(isa: Isa) -> Self {
        Self { isa, spatial_splits: false, parameters: Parameters::default() }
    }

    /// The same options with or without spatial splits.
    #[must_use]
    pub fn with_spatial_splits(self, spatial_splits: bool) -> Self {
        Self { spatial_splits, ..self }
    }

    /// The same options with other parameters of structures to study.
    #[must_use]
    pub fn with_parameters(self, parameters: Parameters) -> Self {
        Self { parameters, ..self }
    }
}

impl From<Isa> for BuildOptions {
    fn from(isa: Isa) -> Self {
        Self::new(isa)
    }
}

/// Bytes in which a structure is [kept](super::Structure::kept), section by section. They may have been
/// written by anybody.
pub trait Sections {
    /// The length of a section in bytes; `None` if there is none of this number.
    fn length(&self, section: usize) -> Option<usize>;

    /// Fills `to`, which is as long as the section, with its bytes. Returns false if they can't be read,
    /// or are not those that were written.
    fn read(&self, section: usize, to: &mut [u8]) -> bool;
}

/// A structure over primitives.
///
/// Hits are exactly those of [`Brute`](super::brute::Brute), bit by bit: the first with
/// `0 < t < t_max`, of equal ones the one of the lowest id, by the tests of
/// [`triangle`](crate::primitives::triangle) and [`curved`](crate::primitives::curved). Triangles
/// that [are degenerate](crate::primitives::triangle::is_degenerate) are never hit.
pub(crate) trait SpatialIndex: Debug + Sized + Send + Sync {
    /// Where the primitives are kept: [`Primitives`], unless the structure stores them its own way.
    type Geometry: Geometry;

    /// Working memory of queries, one per thread; holds nothing between calls.
    type Scratch: Debug + Default;

    /// Builds the structure, on all threads of the current rayon pool; it is the same for any
    /// number of threads.
    fn build(primitives: Primitives, options: BuildOptions) -> Self;

    /// Gives the structure to a device, which answers from then on.
    fn upload(&mut self, device: &dyn Device) -> Result<(), String> {
        let _ = device;
        Err("no device traverses this structure".to_owned())
    }

    /// What was built over the primitives, for [`restore`](Self::restore); `None` if it can't be kept.
    fn kept(&self) -> Option<Vec<Cow<'_, [u8]>>> {
        None
    }

    /// Makes of sections that were kept the structure that [`build`](Self::build) makes of the same
    /// primitives. Gives the primitives back if the sections can't belong to them. Whatever the
    /// sections hold, queries stay within bounds and come to an end.
    fn restore(
        primitives: Primitives,
        options: BuildOptions,
        sections: &dyn Sections,
    ) -> Result<Self, Primitives> {
        let _ = (options, sections);
        Err(primitives)
    }

    /// Makes of this structure the one over the same primitives where they are now. `None`: it can't
    /// be done, or a ray would cost more than `most_growth` times as much as in one that was built.
    fn refitted(
        &self,
        primitives: &Primitives,
        most_growth: f64,
        options: BuildOptions,
    ) -> Option<Self> {
        let _ = (primitives, most_growth, options);
        None
    }

    /// The primitives, as they were given.
    fn geometry(&self) -> &Self::Geometry;

    /// Boxes about all primitives that can be hit, at most `count`, or 8 if that is less.
    fn parts(&self, count: usize) -> Vec<Bounds> {
        let _ = count;
        vec![self.geometry().all_bounds()]
    }

    /// Bytes held beyond the geometry.
    fn overhead(&self) -> usize;

    /// What the structure is made of, if it can tell.
    fn statistics(&self) -> Option<Statistics> {
        None
    }

    /// Whether [`count`](Self::count) counts.
    fn can_count(&self) -> bool {
        false
    }

    /// Traces one ray of a batch by itself, to its first hit or to any if that is enough, and adds what
    /// it takes. Returns the t of the hit; infinite if there is none.
    fn count(
        &self,
        rays: &Rays,
        i: usize,
        any: bool,
        scratch: &mut Self::Scratch,
        counts: &mut Counts,
    ) -> f32 {
        let _ = (rays, i, any, scratch, counts);
        f32::INFINITY
    }

    /// Writes the first hit of each ray to `hits`, which are as many as the rays and all of
    /// nothing. Returns how alike the rays turned out to be, or `coherence` if the structure cannot
    /// tell.
    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Self::Scratch,
    ) -> Coherence;

    /// Sets those of `blocked` whose rays hit anything; there is a `false` for each ray. Returns as
    /// [`intersect`](Self::intersect) does.
    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Self::Scratch,
    ) -> Coherence;
}

/// The primitives inside a structure.
pub(crate) trait Geometry {
    /// Number of triangles: ids below it are triangles.
    fn triangle_count(&self) -> usize;

    /// The triangle of an id.
    fn triangle(&self, id: u32) -> Triangle;

    /// The curved surfaces; their ids follow those of the triangles.
    fn curved(&self) -> &[Curved];

    /// The smallest box about all primitives.
    fn all_bounds(&self) -> Bounds;

    /// Bytes held.
    fn memory(&self) -> usize;
}

impl Geometry for Primitives {
    #[inline]
    fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    #[inline]
    fn triangle(&self, id: u32) -> Triangle {
        self.triangles[id as usize]
    }

    #[inline]
    fn curved(&self) -> &[Curved] {
        &self.curved
    }

    fn all_bounds(&self) -> Bounds {
        Primitives::all_bounds(self)
    }

    fn memory(&self) -> usize {
        Primitives::memory(self)
    }
}
