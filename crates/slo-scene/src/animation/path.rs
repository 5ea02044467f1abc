//! Paths of things that hang in others: products of the paths of all spaces that hold them.

use std::sync::Arc;

use crate::description::{KeyFrame, Space, SpaceId};
use crate::settings::Repeat;

use super::affine::DAffine;
use super::key_frames::{KeyFrameError, KeyFrames};

/// The paths of all spaces of a scene, each in its own parent.
#[derive(Clone, Debug, Default)]
pub struct Spaces {
    paths: Vec<Factor>,
    parents: Vec<Option<SpaceId>>,
}

/// The path of a thing through scene time, whatever it hangs in.
#[derive(Clone, Debug)]
pub struct Path {
    /// The thing's own path, then its parent's, and so on.
    factors: Vec<Factor>,
}

/// How one space lies in another.
#[derive(Clone, Debug)]
enum Factor {
    Keys(Arc<KeyFrames>),
    /// At rest.
    Place(DAffine),
}

impl Factor {
    fn pose(&self, time: f64) -> DAffine {
        match self {
            Self::Keys(path) => path.placed(time),
            Self::Place(place) => *place,
        }
    }

    fn is_rigid(&self) -> bool {
        match self {
            Self::Keys(path) => path.is_rigid(),
            Self::Place(place) => place.is_rigid(),
        }
    }

    fn keys(&self) -> Option<&KeyFrames> {
        match self {
            Self::Keys(path) => Some(path),
            Self::Place(_) => None,
        }
    }
}

impl Spaces {
    /// The paths of these spaces.
    ///
    /// # Errors
    /// The index of the first space whose key frames are no path.
    pub fn new(spaces: &[Space]) -> Result<Self, (usize, KeyFrameError)> {
        let path = |(number, space): (usize, &Space)| match KeyFrames::new(&space.key_frames) {
            Ok(path) => Ok(Factor::Keys(Arc::new(path.repeated(space.repeat)))),
            Err(error) => Err((number, error)),
        };
        let paths = spaces.iter().enumerate().map(path).collect::<Result<_, _>>()?;
        Ok(Self { paths, parents: spaces.iter().map(|space| space.parent).collect() })
    }

    /// Adds a space with these key frames in a parent.
    ///
    /// # Errors
    /// The key frames are no path.
    pub fn add(
        &mut self,
        key_frames: &[KeyFrame],
        repeat: Option<Repeat>,
        parent: Option<SpaceId>,
    ) -> Result<SpaceId, KeyFrameError> {
        let path = KeyFrames::new(key_frames)?.repeated(repeat);
        Ok(self.push(Factor::Keys(Arc::new(path)), parent))
    }

    /// Adds a space that rests in a parent.
    pub fn add_place(&mut self, place: DAffine, parent: Option<SpaceId>) -> SpaceId {
        self.push(Factor::Place(place), parent)
    }

    /// Adds a space that moves in a parent as another space does in its own.
    pub fn add_copy(&mut self, of: SpaceId, parent: Option<SpaceId>) -> SpaceId {
        self.push(self.paths[of.0 as usize].clone(), parent)
    }

    fn push(&mut self, factor: Factor, parent: Option<SpaceId>) -> SpaceId {
        let id = SpaceId(self.paths.len() as u32);
        self.paths.push(factor);
        self.parents.push(parent);
        id
    }

    /// The path of a thing with these key frames in a parent.
    ///
    /// # Errors
    /// Its own key frames are no path.
    pub fn path(
        &self,
        key_frames: &[KeyFrame],
        repeat: Option<Repeat>,
        parent: Option<SpaceId>,
    ) -> Result<Path, KeyFrameError> {
        let own = KeyFrames::new(key_frames)?.repeated(repeat);
        let mut factors = vec![Factor::Keys(Arc::new(own))];
        let mut next = parent;
        // A ring, which scenes must not have, ends too.
        while let Some(number) = next.map(|id| id.0 as usize)
            && let (Some(path), true) = (self.paths.get(number), factors.len() <= self.paths.len())
        {
            factors.push(path.clone());
            next = self.parents[number];
        }
        Ok(Path { factors })
    }
}

impl Path {
    /// The map from object space to scene space at a scene time; always finite.
    pub fn pose(&self, time: f64) -> DAffine {
        let mut factors = self.factors(time);
        let first = factors.next().unwrap_or(DAffine::IDENTITY);
        factors.fold(first, |pose, outer| outer.after(&pose))
    }

    /// The maps whose product is [`pose`](Self::pose): that of the thing in its parent, then the
    /// parent's, and so on.
    pub fn factors(&self, time: f64) -> impl Iterator<Item = DAffine> {
        self.factors.iter().map(move |factor| factor.pose(time))
    }

    /// Whether it turns and moves only, at all times.
    pub fn is_rigid(&self) -> bool {
        self.factors.iter().all(Factor::is_rigid)
    }

    /// Whether the thing is at one place at all times.
    pub fn rests(&self) -> bool {
        !self.moves([f64::NEG_INFINITY, f64::INFINITY])
    }

    /// Whether any of the spaces moves in its parent within an interval of scene time; see
    /// [`KeyFrames::moves`].
    pub fn moves(&self, interval: [f64; 2]) -> bool {
        self.keys().any(|keys| keys.moves(interval))
    }

    /// The moments within an interval of scene time, ends included, at which any of the spaces
    /// jumps.
    pub fn jumps(&self, interval: [f64; 2]) -> impl Iterator<Item = f64> {
        self.keys().flat_map(move |keys| keys.jumps(interval)).map(|jump| jump.time)
    }

    /// Times of the keys of all spaces inside an interval, its ends left out, in no order.
    pub fn key_times_within(&self, interval: [f64; 2]) -> impl Iterator<Item = f64> {
        self.keys().flat_map(move |keys| keys.key_times_within(interval))
    }

    fn keys(&self) -> impl Iterator<Item = &KeyFrames> {
        self.factors.iter().filter_map(Factor::keys)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::description::Placement;

    fn key(time: f64, key: Placement) -> KeyFrame {
        KeyFrame { time, key, ..KeyFrame::default() }
    }

    fn at(time: f64, pivot: DVec3, right: DVec3, scale: DVec3) -> KeyFrame {
        let [pivot, right, scale] = [pivot, right, scale].map(Some);
        key(time, Placement { pivot, right, scale, up: None })
    }

    fn space(key_frames: Vec<KeyFrame>, parent: Option<u32>) -> Space {
        Space {
            name: String::new(),
            key_frames,
            repeat: None,
            parent: parent.map(SpaceId),
            hidden: false,
        }
    }

    #[test]
    fn a_moon_goes_round_a_planet_that_goes_round_a_sun() {
        let quarters = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        // A turn per second about z, by key frames that are quarters of it.
        let turn = |seconds: f64| -> Vec<KeyFrame> {
            let key =
                |i: usize| at(i as f64 * seconds / 4.0, DVec3::ZERO, quarters[i % 4], DVec3::ONE);
            (0..=8).map(key).collect()
        };
        let offset = |x: f64| vec![at(0.0, DVec3::X * x, DVec3::X, DVec3::ONE)];
        let spaces = Spaces::new(&[
            space(turn(4.0), None),       // the sun turns,
            space(offset(10.0), Some(0)), // the planet hangs 10 away from it
            space(turn(1.0), Some(1)),    // and turns too,
        ])
        .unwrap();
        let moon = spaces.path(&offset(2.0), None, Some(SpaceId(2))).unwrap();
        assert!(moon.is_rigid());
        // The sun has turned by a quarter after a second, the planet in it once.
        let expected = [
            (0.0, DVec3::new(12.0, 0.0, 0.0)),
            (1.0, DVec3::new(0.0, 12.0, 0.0)),
            (2.0, DVec3::new(-12.0, 0.0, 0.0)),
            // an eighth of a turn, and half a turn of the planet
            (0.5, DVec3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0) * 8.0),
        ];
        for (time, place) in expected {
            let pose = moon.pose(time);
            assert!(pose.is_rigid() && (pose.translation - place).length() < 1e-12, "{time}");
        }
        assert!(moon.moves([0.1, 0.2]) && !moon.moves([9.0, 10.0]) && !moon.rests());
        let mut times: Vec<f64> = moon.key_times_within([0.9, 2.1]).collect();
        times.sort_by(f64::total_cmp);
        assert_eq!(times, [1.0, 1.0, 1.25, 1.5, 1.75, 2.0, 2.0]);
    }

    #[test]
    fn the_scale_of_a_parent_moves_what_hangs_in_it() {
        let mut leaps = vec![at(1.0, DVec3::ZERO, DVec3::X, DVec3::new(3.0, 1.0, 1.0))];
        leaps.push(at(1.0, DVec3::ZERO, DVec3::Y, DVec3::new(2.0, 2.0, 5.0)));
        let spaces = Spaces::new(&[space(leaps, None)]).unwrap();
        let own = [at(0.0, DVec3::new(1.0, 1.0, 1.0), DVec3::X, DVec3::splat(0.5))];
        let path = spaces.path(&own, None, Some(SpaceId(0))).unwrap();
        assert_eq!(path.pose(0.0).point(DVec3::ONE), DVec3::new(4.5, 1.5, 1.5));
        // scaled to (3, 3, 7.5), then turned by a quarter
        assert_eq!(path.pose(1.0).point(DVec3::ONE), DVec3::new(-3.0, 3.0, 7.5));
        assert_eq!((path.is_rigid(), path.pose(0.0).growth), (false, None));
        assert_eq!(path.jumps([0.0, 2.0]).collect::<Vec<_>>(), [1.0]);
        assert!(path.moves([0.5, 1.5]) && !path.moves([1.5, 2.0]));
    }
}
