//! Divides a picture into the sections of the settings, and those into tiles.

use std::ops::Range;

use slo_picture::film::{Area, TILE};
use slo_scene::Settings;

/// The thesis's division of a picture into sections, as evenly as whole tiles allow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sections {
    width: u32,
    height: u32,
    columns: u32,
    rows: u32,
}

impl Sections {
    /// Creates the division that the settings ask for: by default, one section for each tile.
    pub(super) fn new(settings: &Settings, width: u32, height: u32) -> Self {
        let count = |asked: Option<u32>, pixels: u32| {
            asked.unwrap_or(pixels.div_ceil(TILE)).clamp(1, pixels)
        };
        Self {
            width,
            height,
            columns: count(settings.sections_horizontal, width),
            rows: count(settings.sections_vertical, height),
        }
    }

    /// Returns what lies in an area of all sections that have tiles, row by row. Takes no longer for a small
    /// area of a large picture than for a small picture.
    pub(super) fn areas(&self, within: &Area) -> Vec<Area> {
        let columns = bands(self.columns, self.width, within.x0..within.x1);
        let rows = bands(self.rows, self.height, within.y0..within.y1);
        let area = |y: &Range<u32>, x: &Range<u32>| Area {
            x0: x.start,
            y0: y.start,
            x1: x.end,
            y1: y.end,
        };
        rows.iter().flat_map(|y| columns.iter().map(move |x| area(y, x))).collect()
    }
}

/// The parts of `within` in each of `count` equal bands of pixels, without those that are empty.
fn bands(count: u32, pixels: u32, within: Range<u32>) -> Vec<Range<u32>> {
    let border = |i: u32| match i {
        _ if i == count => pixels,
        _ => (u64::from(i) * u64::from(pixels) / u64::from(count)) as u32 / TILE * TILE,
    };
    let band = |i| border(i).max(within.start)..border(i + 1).min(within.end);
    (0..count).map(band).filter(|band| !band.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile() {
        for (columns, rows) in
            [(None, None), (Some(1), Some(1)), (Some(3), Some(7)), (Some(999), None)]
        {
            let mut settings = Settings::default();
            (settings.sections_horizontal, settings.sections_vertical) = (columns, rows);
            let (width, height) = (131, 67);
            let mut seen = vec![0; (width * height) as usize];
            let sections = Sections::new(&settings, width, height);
            let sections = sections.areas(&Area::whole(width, height));
            for tile in sections.into_iter().flat_map(|section| section.cells(TILE)) {
                assert_eq!((tile.x0 % TILE, tile.y0 % TILE), (0, 0));
                for y in tile.y0..tile.y1 {
                    for x in tile.x0..tile.x1 {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{columns:?} {rows:?}");
        }
    }

    #[test]
    fn a_region_has_the_tiles_that_it_meets() {
        let region = Area { x0: 40_000, y0: 63, x1: 40_008, y1: 66 };
        for (columns, rows) in [(None, None), (Some(1), Some(1)), (Some(3), Some(7))] {
            let mut settings = Settings::default();
            (settings.sections_horizontal, settings.sections_vertical) = (columns, rows);
            let sections = Sections::new(&settings, 65_536, 65_536).areas(&region);
            let tiles: Vec<_> = sections.iter().flat_map(|section| section.cells(TILE)).collect();
            let (above, below) = (Area { y1: 64, ..region }, Area { y0: 64, ..region });
            assert_eq!(tiles, [above, below], "{columns:?} {rows:?}");
        }
    }
}
