//! How a picture is cut: into the sections of the settings, and those into tiles.

use crate::film::Area;
use crate::scene::Settings;

/// Side of a tile in pixels: its samples stay in the second-level cache, and the last tiles of a
/// picture keep no thread waiting for long.
const TILE: u32 = 32;

/// The thesis's cut of the picture into sections, evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sections {
    width: u32,
    height: u32,
    columns: u32,
    rows: u32,
}

impl Sections {
    /// As the settings say; one section per tile where they say nothing.
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

    /// All sections, row by row.
    pub(super) fn areas(&self) -> Vec<Area> {
        let border = |i: u32, count: u32, pixels: u32| {
            (u64::from(i) * u64::from(pixels) / u64::from(count)) as u32
        };
        let area = |row, column| Area {
            x0: border(column, self.columns, self.width),
            y0: border(row, self.rows, self.height),
            x1: border(column + 1, self.columns, self.width),
            y1: border(row + 1, self.rows, self.height),
        };
        (0..self.rows).flat_map(|row| (0..self.columns).map(move |c| area(row, c))).collect()
    }
}

/// The tiles of a section, row by row.
pub(super) fn tiles(section: Area) -> Vec<Area> {
    let starts = |from: u32, to: u32| (from..to).step_by(TILE as usize);
    starts(section.y0, section.y1)
        .flat_map(|y0| starts(section.x0, section.x1).map(move |x0| (x0, y0)))
        .map(|(x0, y0)| Area {
            x0,
            y0,
            x1: (x0 + TILE).min(section.x1),
            y1: (y0 + TILE).min(section.y1),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile() {
        for (columns, rows) in
            [(None, None), (Some(1), Some(1)), (Some(3), Some(7)), (Some(999), None)]
        {
            let settings = Settings {
                sections_horizontal: columns,
                sections_vertical: rows,
                ..Settings::default()
            };
            let (width, height) = (131, 67);
            let mut seen = vec![0; (width * height) as usize];
            let sections = Sections::new(&settings, width, height).areas();
            for tile in sections.into_iter().flat_map(tiles) {
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
