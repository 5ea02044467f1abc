//! Splits of many primitives, by bins along each axis.
//!
//! Source: Wald, *On fast construction of SAH-based bounding volume hierarchies* (2007).

use glam::Vec4;
use rayon::prelude::*;

use super::boxes::{Box8, Portable, Reference, Wide};
use super::heuristic::cost;
use crate::isa::Isa;

/// Bins along each axis.
const BINS: usize = 32;

/// Nodes with more primitives bin them in parallel, in chunks of this many.
pub(super) const PARALLEL_CHUNK: usize = 1 << 15;

/// Which bin a centre lies in, on each axis.
pub(super) struct Binning {
    min: Vec4,
    scale: Vec4,
}

impl Binning {
    /// Adding 2^23 to a number below it leaves the rounded number in the low bits.
    const ROUNDER: Vec4 = Vec4::splat(8_388_608.0);

    pub(super) fn new(centers: &Box8) -> Self {
        let size = centers.size();
        // Finite and not 0, or every primitive falls into the first bin.
        let usable = size.cmpgt(Vec4::splat(f32::MIN_POSITIVE * BINS as f32))
            & size.cmplt(Vec4::splat(f32::INFINITY));
        let last = Vec4::splat((BINS - 1) as f32);
        let scale = Vec4::select(usable, last / size, Vec4::ZERO);
        Self { min: centers.min(), scale: scale.with_w(0.0) }
    }

    /// The bins on all axes, plus [`ROUNDER`](Self::ROUNDER).
    #[inline(always)]
    fn places(&self, center: Vec4) -> Vec4 {
        (center - self.min) * self.scale + Self::ROUNDER
    }
}

/// Boxes and counts of the bins of three axes.
#[derive(Clone)]
struct Bins {
    boxes: [[Box8; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[Box8::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn of(binning: &Binning, references: &[Reference], isa: Isa) -> Self {
        match isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the set is one that the CPU has.
            Isa::Avx512 | Isa::Avx2 => unsafe { fill_avx2(binning, references) },
            // SAFETY: plain Rust.
            _ => unsafe { Self::fill::<Portable>(binning, references) },
        }
    }

    #[inline(always)]
    unsafe fn fill<W: Wide>(binning: &Binning, references: &[Reference]) -> Self {
        // Neighbours often fall into one bin: two sets of bins need not wait for one another.
        let (mut even, mut odd) = (Self::EMPTY, Self::EMPTY);
        let mut pairs = references.chunks_exact(2);
        // SAFETY: the caller's.
        unsafe {
            for pair in &mut pairs {
                even.add::<W>(binning, &pair[0]);
                odd.add::<W>(binning, &pair[1]);
            }
            for last in pairs.remainder() {
                even.add::<W>(binning, last);
            }
        }
        even.merge(&odd);
        even
    }

    #[inline(always)]
    unsafe fn add<W: Wide>(&mut self, binning: &Binning, reference: &Reference) {
        // SAFETY: the caller's.
        unsafe {
            let bounds = W::load(reference.bounds());
            let places = binning.places(bounds.center());
            for (axis, place) in [places.x, places.y, places.z].into_iter().enumerate() {
                let bin = place.to_bits() as usize % BINS;
                let all = &mut self.boxes[axis][bin];
                bounds.union(W::load(all)).store(all);
                self.counts[axis][bin] += 1;
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..BINS {
                let all = &mut self.boxes[axis][bin];
                *all = all.union(&other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// The cheapest split along one axis.
    fn sweep(&self, axis: usize) -> Split {
        let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
        let mut right = [(Box8::EMPTY, 0.0f32); BINS];
        let (mut all, mut count) = (Box8::EMPTY, 0);
        for bin in (1..BINS).rev() {
            all = all.union(&boxes[bin]);
            count += counts[bin];
            right[bin] = (all, cost(all.half_area(), count));
        }
        let mut best = Split { cost: f32::INFINITY, axis, bin: 0, sides: [Box8::EMPTY; 2] };
        let (mut all, mut count) = (Box8::EMPTY, 0);
        for bin in 1..BINS {
            all = all.union(&boxes[bin - 1]);
            count += counts[bin - 1];
            let cost = cost(all.half_area(), count) + right[bin].1;
            if cost < best.cost {
                best = Split { cost, axis, bin, sides: [all, right[bin].0] };
            }
        }
        best
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn fill_avx2(binning: &Binning, references: &[Reference]) -> Bins {
    // SAFETY: the caller's.
    unsafe { Bins::fill::<std::arch::x86_64::__m256>(binning, references) }
}

/// Primitives whose bin on an axis is below `bin` go left.
pub(super) struct Split {
    pub(super) cost: f32,
    axis: usize,
    bin: usize,
    /// Boxes of both sides.
    pub(super) sides: [Box8; 2],
}

/// The cheapest split between bins; none if all lie in one bin, or costs overflow.
pub(super) fn best_split(binning: &Binning, references: &[Reference], isa: Isa) -> Option<Split> {
    let bins = if references.len() > 2 * PARALLEL_CHUNK {
        let chunks: Vec<Bins> =
            references.par_chunks(PARALLEL_CHUNK).map(|c| Bins::of(binning, c, isa)).collect();
        chunks.iter().fold(Bins::EMPTY, |mut all, chunk| {
            all.merge(chunk);
            all
        })
    } else {
        Bins::of(binning, references, isa)
    };
    let [x, y, z] = [0, 1, 2].map(|axis| bins.sweep(axis));
    let best = if x.cost <= y.cost && x.cost <= z.cost {
        x
    } else if y.cost <= z.cost {
        y
    } else {
        z
    };
    (best.cost < f32::INFINITY).then_some(best)
}

/// Moves the left primitives to the front; returns their number, and the boxes about the centres of
/// both sides.
pub(super) fn partition(
    references: &mut [Reference],
    binning: &Binning,
    split: &Split,
    isa: Isa,
) -> (usize, [Box8; 2]) {
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the set is one that the CPU has.
        Isa::Avx512 | Isa::Avx2 => unsafe { partition_avx2(references, binning, split) },
        // SAFETY: plain Rust.
        _ => unsafe { partition_by::<Portable>(references, binning, split) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn partition_avx2(
    references: &mut [Reference],
    binning: &Binning,
    split: &Split,
) -> (usize, [Box8; 2]) {
    // SAFETY: the caller's.
    unsafe { partition_by::<std::arch::x86_64::__m256>(references, binning, split) }
}

#[inline(always)]
unsafe fn partition_by<W: Wide>(
    references: &mut [Reference],
    binning: &Binning,
    split: &Split,
) -> (usize, [Box8; 2]) {
    let mut limit = [f32::INFINITY; 4];
    limit[split.axis] = Binning::ROUNDER.x + split.bin as f32;
    let limit = Vec4::from_array(limit);
    let mut middle = 0;
    let mut centers = [Box8::EMPTY; 2];
    // SAFETY: the caller's.
    unsafe {
        let (mut left, mut right) = (W::load(&centers[0]), W::load(&centers[1]));
        for i in 0..references.len() {
            let bounds = W::load(references[i].bounds());
            let center = bounds.center();
            // NaN, from infinite centres, is in the first bin too.
            let is_left = !binning.places(center).cmpge(limit).any();
            let point = W::point(center);
            left = point.or_nan(!is_left).union(left);
            right = point.or_nan(is_left).union(right);
            W::load(references[middle].bounds()).store(references[i].bounds_mut());
            bounds.store(references[middle].bounds_mut());
            middle += usize::from(is_left);
        }
        left.store(&mut centers[0]);
        right.store(&mut centers[1]);
    }
    (middle, centers)
}
