//! Pictures that get cleaner in steps, tile by tile.

use super::area::{Area, TILE};

/// How far a picture was taken: all of its tiles to step `done`, and the first `tiles` of them, in
/// an order of their own, to the next one.
///
/// Steps 0 to 3 take 1, 2, 4 and 8 samples per pixel. In step 4 blocks take samples until they are as
/// clean as with `noise` 0.2; each further step divides that error by the square root of 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Steps {
    /// The step that all tiles have reached.
    pub done: u32,
    /// How many tiles are one step further.
    pub tiles: u32,
}

impl Steps {
    /// The last step: its error is a hundredth of a step of 8 bits.
    pub const LAST: u32 = 30;

    /// The share of a picture's tiles that are one step further.
    pub fn further(self, width: u32, height: u32) -> f64 {
        let tiles = width.div_ceil(TILE) * height.div_ceil(TILE);
        f64::from(self.tiles) / f64::from(tiles.max(1))
    }

    /// The step that a tile has reached.
    pub fn of(self, tile: Area, width: u32, height: u32) -> u32 {
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let index = tile.y0 / TILE * columns + tile.x0 / TILE;
        self.done + u32::from(rank(index, columns * rows) < self.tiles)
    }
}

/// All tiles of a picture in the order of the steps: the first few are spread over all of it.
pub fn tiles_in_order(width: u32, height: u32) -> Vec<Area> {
    let tiles: Vec<Area> = Area::whole(width, height).cells(TILE).collect();
    let mut ordered = tiles.clone();
    for (index, tile) in tiles.iter().enumerate() {
        ordered[rank(index as u32, tiles.len() as u32) as usize] = *tile;
    }
    ordered
}

/// The place of tile `index` of `count` in the order of the steps: neighbours are far apart.
fn rank(index: u32, count: u32) -> u32 {
    let golden = (u64::from(count) * 1_640_531_527) >> 32;
    let is_coprime = |step: &u64| gcd(*step, u64::from(count)) == 1;
    let step = (golden.max(1)..).find(is_coprime).unwrap_or(1);
    (u64::from(index) * step % u64::from(count.max(1))) as u32
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_has_a_place() {
        for count in 1..300 {
            let mut ranks: Vec<u32> = (0..count).map(|i| rank(i, count)).collect();
            ranks.sort_unstable();
            assert!(ranks.into_iter().eq(0..count), "{count}");
        }
    }

    #[test]
    fn tiles_are_at_the_step_that_their_place_says() {
        let (width, height) = (100, 70);
        let tiles = tiles_in_order(width, height);
        assert_eq!(tiles.len(), 12);
        let steps = Steps { done: 4, tiles: 5 };
        for (place, tile) in tiles.into_iter().enumerate() {
            let expected = if place < 5 { 5 } else { 4 };
            assert_eq!(steps.of(tile, width, height), expected, "{place}");
            let inner = Area { x0: tile.x0 + 1, y0: tile.y0 + 2, ..tile };
            assert_eq!(steps.of(inner, width, height), expected, "a region begins in the tile");
        }
        assert_eq!(steps.further(width, height), 5.0 / 12.0);
    }
}
