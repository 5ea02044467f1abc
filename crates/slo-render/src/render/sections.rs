//! Divides a picture into the sections of the settings, and those into tiles.

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

    /// Returns all sections that have tiles, row by row.
    pub(super) fn areas(&self) -> Vec<Area> {
        let border = |i: u32, count: u32, pixels: u32| match i {
            _ if i == count => pixels,
            _ => (u64::from(i) * u64::from(pixels) / u64::from(count)) as u32 / TILE * TILE,
        };
        let area = |row, column| Area {
            x0: border(column, self.columns, self.width),
            y0: border(row, self.rows, self.height),
            x1: border(column + 1, self.columns, self.width),
            y1: border(row + 1, self.rows, self.height),
        };
        let row = |row| (0..self.columns).map(move |column| area(row, column));
        (0..self.rows).flat_map(row).filter(|area| !area.is_empty()).collect()
    }
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
            let sections = Sections::new(&settings, width, height).areas();
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
}
