//! Rectangles of pixels.

/// Side of the blocks whose pixels take the same number of samples.
pub const BLOCK: u32 = 8;

/// Side of a tile in pixels: its samples fit into the second-level cache, and threads do not wait long
/// for the last tiles of a picture.
pub const TILE: u32 = 32;

/// A rectangle of pixels, `x0..x1` times `y0..y1`; y grows downward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}

impl Area {
    /// All of a picture.
    #[inline]
    pub fn whole(width: u32, height: u32) -> Self {
        Self { x0: 0, y0: 0, x1: width, y1: height }
    }

    /// Columns.
    #[inline]
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// Pixels.
    #[inline]
    pub fn len(&self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// Whether it has no pixels.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether all of `other` lies inside.
    #[inline]
    pub fn holds(&self, other: &Self) -> bool {
        self.x0 <= other.x0 && self.y0 <= other.y0 && self.x1 >= other.x1 && self.y1 >= other.y1
    }

    /// The intersection; empty if they do not meet.
    #[inline]
    pub fn common(&self, other: &Self) -> Self {
        let (x0, y0) = (self.x0.max(other.x0), self.y0.max(other.y0));
        Self { x0, y0, x1: self.x1.min(other.x1).max(x0), y1: self.y1.min(other.y1).max(y0) }
    }

    /// The smallest area of whole blocks of `whole` around this one.
    pub fn in_blocks(&self, whole: &Self) -> Self {
        let down = |x: u32| x / BLOCK * BLOCK;
        let up = |x: u32| x.div_ceil(BLOCK).saturating_mul(BLOCK);
        Self { x0: down(self.x0), y0: down(self.y0), x1: up(self.x1), y1: up(self.y1) }
            .common(whole)
    }

    /// The rectangles of `side` columns and rows in it, counted from the picture's corner, row by
    /// row.
    pub fn cells(&self, side: u32) -> impl Iterator<Item = Self> + use<> {
        let area = *self;
        let starts = move |from: u32, to: u32| (from / side * side..to).step_by(side as usize);
        let cell = move |(x, y): (u32, u32)| {
            Self { x0: x, y0: y, x1: x.saturating_add(side), y1: y.saturating_add(side) }
                .common(&area)
        };
        let columns = move |y| starts(area.x0, area.x1).map(move |x| (x, y));
        starts(area.y0, area.y1).flat_map(columns).map(cell).filter(|cell| !cell.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn area(x0: u32, y0: u32, x1: u32, y1: u32) -> Area {
        Area { x0, y0, x1, y1 }
    }

    #[test]
    fn blocks_around_an_area() {
        let whole = Area::whole(61, 37);
        assert_eq!(area(9, 0, 16, 33).in_blocks(&whole), area(8, 0, 16, 37));
        assert_eq!(area(60, 36, 61, 37).in_blocks(&whole), area(56, 32, 61, 37));
    }

    #[test]
    fn cells_hold_every_pixel_once() {
        let whole = area(5, 9, 40, 23);
        let cells: Vec<_> = whole.cells(8).collect();
        assert_eq!(cells[0], area(5, 9, 8, 16));
        assert_eq!(cells.iter().map(Area::len).sum::<usize>(), whole.len());
        assert!(cells.iter().all(|cell| whole.holds(cell)));
        assert_eq!(area(3, 3, 3, 9).cells(8).count(), 0);
    }

    #[test]
    fn what_does_not_meet_has_nothing_in_common() {
        assert!(area(0, 0, 4, 4).common(&area(5, 0, 9, 4)).is_empty());
        assert_eq!(area(0, 0, 4, 4).common(&area(2, 1, 9, 3)), area(2, 1, 4, 3));
    }
}
