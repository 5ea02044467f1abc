//! What a picture shows of the first surfaces that camera rays hit: for compositors.
//!
//! All of it are exact sums over samples, as the sums of [`Pixel`](super::Pixel). Means are means over
//! the samples that hit something.

use std::ops::Range;

use slo_scene::{Layer, LayerNames, MaskNames};

use super::area::Area;
use super::ids::IdCounts;
use super::mask::{MaskKind, RANKS};
use super::memory::{TooLarge, copied, filled, filled_times};
use super::wide::Wide;

/// Depth of a pixel in which no sample hits anything, as in Blender.
const NOWHERE: f32 = 1e10;

/// Which layers a film has of what camera rays hit first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FirstHitLayers {
    /// Layers of numbers.
    pub places: PlaceLayers,
    /// Names of objects, with [`Layer::CryptoObject`].
    pub objects: Option<MaskNames>,
    /// Names of materials, with [`Layer::CryptoMaterial`].
    pub materials: Option<MaskNames>,
}

impl FirstHitLayers {
    /// Those among some layers.
    pub fn of(layers: &[Layer], names: &LayerNames) -> Self {
        let names_if = |layer, names: &MaskNames| layers.contains(&layer).then(|| names.clone());
        Self {
            places: PlaceLayers::of(layers),
            objects: names_if(Layer::CryptoObject, &names.objects),
            materials: names_if(Layer::CryptoMaterial, &names.materials),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The names of a mask, if there is such a layer.
    pub fn names(&self, kind: MaskKind) -> Option<&MaskNames> {
        match kind {
            MaskKind::Object => self.objects.as_ref(),
            MaskKind::Material => self.materials.as_ref(),
        }
    }

    /// Whether there are masks.
    pub fn has_ids(&self) -> bool {
        self.objects.is_some() || self.materials.is_some()
    }

    /// Number of [`FileLayer`](super::FileLayer)s that a file needs for them.
    pub fn images(&self) -> u64 {
        let PlaceLayers { depth, position, uv, motion } = self.places;
        let masks = MaskKind::ALL.iter().filter(|kind| self.names(**kind).is_some()).count();
        let single = [depth, position, uv].into_iter().map(u64::from).sum::<u64>();
        single + 2 * u64::from(motion) + (RANKS * masks) as u64
    }

    /// Bytes of a pixel, if it sees two ids of each kind.
    pub fn bytes(&self) -> usize {
        let masks = MaskKind::ALL.iter().filter(|kind| self.names(**kind).is_some()).count();
        self.places.columns() * size_of::<Wide>() + masks * (size_of::<IdCounts>() + 48)
    }
}

/// Which layers of numbers a film has of what camera rays hit first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlaceLayers {
    /// See [`Layer::Depth`].
    pub depth: bool,
    /// See [`Layer::Position`].
    pub position: bool,
    /// See [`Layer::Uv`].
    pub uv: bool,
    /// See [`Layer::Motion`].
    pub motion: bool,
}

impl PlaceLayers {
    /// Those among some layers.
    pub fn of(layers: &[Layer]) -> Self {
        let has = |layer| layers.contains(&layer);
        Self {
            depth: has(Layer::Depth),
            position: has(Layer::Position),
            uv: has(Layer::Uv),
            motion: has(Layer::Motion),
        }
    }

    /// Number of sums of a pixel.
    pub fn columns(self) -> usize {
        self.sizes().iter().map(|size| size.1).sum()
    }

    /// Each layer, with the number of its sums: how many samples hit something, and its numbers.
    fn sizes(self) -> [(Layer, usize); 4] {
        let size = |is_there: bool, numbers: usize| if is_there { 1 + numbers } else { 0 };
        [
            (Layer::Depth, size(self.depth, 1)),
            (Layer::Position, size(self.position, 3)),
            (Layer::Uv, size(self.uv, 2)),
            (Layer::Motion, size(self.motion, 4)),
        ]
    }

    /// Where the sums of a layer are among the sums of a pixel; nowhere if it is not there.
    fn columns_of(self, layer: Layer) -> Range<usize> {
        let mut start = 0;
        for (other, size) in self.sizes() {
            if other == layer {
                return start..start + size;
            }
            start += size;
        }
        0..0
    }

    /// Adds one sample that hit something to the sums of a pixel.
    pub fn add(self, sums: &mut [Wide], place: &Place) {
        self.add_to(sums, Layer::Depth, &[place.depth]);
        self.add_to(sums, Layer::Position, &place.position);
        if let Some(uv) = place.uv {
            self.add_to(sums, Layer::Uv, &uv);
        }
        self.add_to(sums, Layer::Motion, &place.motion);
    }

    fn add_to(self, sums: &mut [Wide], layer: Layer, numbers: &[f64]) {
        if let Some((hits, sums)) = sums[self.columns_of(layer)].split_first_mut() {
            *hits += Wide::ONE;
            for (sum, number) in sums.iter_mut().zip(numbers) {
                *sum += Wide::clamped(*number);
            }
        }
    }
}

/// What one sample hit first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// See [`Layer::Depth`].
    pub depth: f64,
    /// See [`Layer::Position`].
    pub position: [f64; 3],
    /// See [`Layer::Uv`]; `None` for lamps.
    pub uv: Option<[f64; 2]>,
    /// See [`Layer::Motion`]: right and up in the frame before minus right and up now, and those now
    /// minus those in the next frame.
    pub motion: [f64; 4],
}

/// Sums of what a picture shows of the first surfaces that camera rays hit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FirstHits {
    layers: FirstHitLayers,
    /// The sums of a pixel are neighbours.
    sums: Vec<Wide>,
    /// Of each pixel; empty without such a layer. By [`MaskKind`].
    ids: [Vec<IdCounts>; 2],
}

impl FirstHits {
    pub(super) fn new(area: Area, layers: FirstHitLayers) -> Result<Self, TooLarge> {
        let sums = filled_times(area, layers.places.columns())?;
        let ids = |kind| match layers.names(kind) {
            Some(_) => filled(area),
            None => Ok(Vec::new()),
        };
        let ids = [ids(MaskKind::Object)?, ids(MaskKind::Material)?];
        Ok(Self { layers, sums, ids })
    }

    /// The layers that there are.
    pub fn layers(&self) -> &FirstHitLayers {
        &self.layers
    }

    /// The sums of the pixel of row-major index `i`, layer by layer.
    pub fn places(&self, i: usize) -> &[Wide] {
        let each = self.layers.places.columns();
        &self.sums[i * each..(i + 1) * each]
    }

    /// The same, to be changed.
    pub fn places_mut(&mut self, i: usize) -> &mut [Wide] {
        let each = self.layers.places.columns();
        &mut self.sums[i * each..(i + 1) * each]
    }

    /// The ids of a pixel; `None` without such a layer.
    pub fn ids(&self, kind: MaskKind, i: usize) -> Option<&IdCounts> {
        self.ids[kind as usize].get(i)
    }

    /// The same, to be changed.
    pub fn ids_mut(&mut self, kind: MaskKind, i: usize) -> Option<&mut IdCounts> {
        self.ids[kind as usize].get_mut(i)
    }

    /// Adds a pixel of another; `None` on overflow.
    pub(super) fn checked_add(&mut self, to: usize, other: &Self, from: usize) -> Option<()> {
        if self.layers.places == other.layers.places {
            for (sum, more) in self.places_mut(to).iter_mut().zip(other.places(from)) {
                *sum = sum.checked_add(*more)?;
            }
        }
        for kind in MaskKind::ALL {
            if let (Some(ids), Some(more)) = (self.ids_mut(kind, to), other.ids(kind, from)) {
                ids.add_all(more)?;
            }
        }
        Some(())
    }

    /// Removes all pixels, and takes over the layers of another.
    pub(super) fn clear_for(&mut self, other: &Self) {
        if self.layers != other.layers {
            self.layers.clone_from(&other.layers);
        }
        self.sums.clear();
        self.ids.iter_mut().for_each(Vec::clear);
    }

    /// Appends pixels of another with the same layers.
    pub(super) fn append(&mut self, other: &Self, pixels: Range<usize>) {
        self.sums.extend_from_slice(&other.sums[other.columns(&pixels)]);
        for (ids, from) in self.ids.iter_mut().zip(&other.ids) {
            ids.extend_from_slice(from.get(pixels.clone()).unwrap_or_default());
        }
    }

    /// Copies pixels of another with the same layers.
    pub(super) fn put(&mut self, pixels: Range<usize>, other: &Self, from: Range<usize>) {
        let columns = self.columns(&pixels);
        self.sums[columns].copy_from_slice(&other.sums[other.columns(&from)]);
        for (ids, other) in self.ids.iter_mut().zip(&other.ids) {
            if !ids.is_empty() {
                ids[pixels.clone()].clone_from_slice(&other[from.clone()]);
            }
        }
    }

    /// A copy, if there is memory for it.
    pub(super) fn try_clone(&self) -> Option<Self> {
        let [objects, materials] = &self.ids;
        Some(Self {
            layers: self.layers.clone(),
            sums: copied(&self.sums)?,
            ids: [copied(objects)?, copied(materials)?],
        })
    }

    fn columns(&self, pixels: &Range<usize>) -> Range<usize> {
        let each = self.layers.places.columns();
        pixels.start * each..pixels.end * each
    }

    /// Depth of a pixel.
    pub(super) fn depth(&self, i: usize) -> f32 {
        self.mean::<1>(Layer::Depth, i).map_or(NOWHERE, |[depth]| depth)
    }

    /// Position of a pixel; 0 where no sample hits anything.
    pub(super) fn position(&self, i: usize) -> [f32; 3] {
        self.mean(Layer::Position, i).unwrap_or_default()
    }

    /// Texture coordinates of a pixel of so many samples, and the share of the samples that hit an
    /// object.
    pub(super) fn uv(&self, i: usize, samples: u32) -> [f32; 3] {
        let [u, v] = self.mean(Layer::Uv, i).unwrap_or_default();
        [u, v, (self.hits(Layer::Uv, i) / f64::from(samples.max(1))) as f32]
    }

    /// Motion of a pixel; 0 where no sample hits anything.
    pub(super) fn motion(&self, i: usize) -> [f32; 4] {
        self.mean(Layer::Motion, i).unwrap_or_default()
    }

    /// The id of a rank in a pixel of so many samples, as a number, and the share of the samples that
    /// saw it.
    pub(super) fn rank(&self, kind: MaskKind, rank: usize, i: usize, samples: u32) -> [f32; 2] {
        match self.ids(kind, i).and_then(|ids| ids.ranked(rank)) {
            Some((id, count)) => {
                let share = f64::from(count) / f64::from(samples.max(1));
                [f32::from_bits(id), share as f32]
            }
            None => [0.0; 2],
        }
    }

    fn hits(&self, layer: Layer, i: usize) -> f64 {
        let columns = self.layers.places.columns_of(layer);
        self.sums_of(i).get(columns).and_then(<[Wide]>::first).map_or(0.0, |hits| hits.to_f64())
    }

    /// Mean of the samples that hit something; `None` if none does.
    fn mean<const N: usize>(&self, layer: Layer, i: usize) -> Option<[f32; N]> {
        let columns = self.layers.places.columns_of(layer);
        let (hits, sums) = self.sums_of(i).get(columns)?.split_first()?;
        let sums: &[Wide; N] = sums.first_chunk()?;
        (*hits > Wide::default()).then(|| sums.map(|sum| (sum.to_f64() / hits.to_f64()) as f32))
    }

    fn sums_of(&self, i: usize) -> &[Wide] {
        let each = self.layers.places.columns();
        self.sums.get(i * each..(i + 1) * each).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: PlaceLayers = PlaceLayers { depth: true, position: true, uv: true, motion: true };

    fn place(k: f64) -> Place {
        Place {
            depth: k,
            position: [k, -k, 1e9 * k],
            uv: (k > 1.0).then_some([k * 0.25, 0.5]),
            motion: [k, 2.0 * k, 3.0 * k, -4.0 * k],
        }
    }

    #[test]
    fn means_are_those_of_samples_that_hit_something() {
        let layers = FirstHitLayers { places: ALL, ..FirstHitLayers::default() };
        let mut hits = FirstHits::new(Area::whole(2, 1), layers).unwrap();
        ALL.add(hits.places_mut(1), &place(1.0));
        ALL.add(hits.places_mut(1), &place(2.0));
        assert_eq!((hits.depth(0), hits.position(0), hits.motion(0)), (1e10, [0.0; 3], [0.0; 4]));
        assert_eq!(hits.uv(0, 4), [0.0; 3]);
        assert_eq!((hits.depth(1), hits.position(1)), (1.5, [1.5, -1.5, 1.5e9]));
        assert_eq!(hits.motion(1), [1.5, 3.0, 4.5, -6.0]);
        assert_eq!(hits.uv(1, 4), [0.5, 0.5, 0.25]);
    }

    #[test]
    fn each_layer_has_sums_of_its_own() {
        for bits in 0..16 {
            let [depth, position, uv, motion] = [1, 2, 4, 8].map(|bit| bits & bit != 0);
            let places = PlaceLayers { depth, position, uv, motion };
            let layers = FirstHitLayers { places, ..FirstHitLayers::default() };
            let mut hits = FirstHits::new(Area::whole(1, 1), layers).unwrap();
            places.add(hits.places_mut(0), &place(2.0));
            assert_eq!(hits.depth(0), if depth { 2.0 } else { NOWHERE });
            assert_eq!(hits.position(0), if position { [2.0, -2.0, 2e9] } else { [0.0; 3] });
            assert_eq!(hits.uv(0, 1), if uv { [0.5, 0.5, 1.0] } else { [0.0; 3] });
            let expected = if motion { [2.0, 4.0, 6.0, -8.0] } else { [0.0; 4] };
            assert_eq!(hits.motion(0), expected);
        }
    }

    #[test]
    fn ids_become_ranks() {
        let objects = Some(MaskNames::new(["a"]));
        let layers = FirstHitLayers { objects, ..FirstHitLayers::default() };
        let mut hits = FirstHits::new(Area::whole(1, 1), layers).unwrap();
        let (few, many) = (2.5f32.to_bits(), 0.125f32.to_bits());
        hits.ids_mut(MaskKind::Object, 0).unwrap().add(few, 1).unwrap();
        hits.ids_mut(MaskKind::Object, 0).unwrap().add(many, 2).unwrap();
        let rank = |kind, rank| hits.rank(kind, rank, 0, 4);
        assert_eq!(rank(MaskKind::Object, 0), [0.125, 0.5]);
        assert_eq!(rank(MaskKind::Object, 1), [2.5, 0.25]);
        assert_eq!(rank(MaskKind::Object, 2), [0.0; 2]);
        assert_eq!(rank(MaskKind::Material, 0), [0.0; 2]);
    }
}
