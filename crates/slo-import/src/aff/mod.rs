//! AFF, the format of BART (J. Lext, U. Assarsson, T. Möller, "A Benchmark for Animated Ray Tracing", 2001),
//! and NFF, which it contains.
//!
//! E. Haines, "A Proposal for Standard Graphics Environments" (1987). Lights do not fall off with
//! distance there, and materials are those of Phong, so scenes become classical ones. In NFF, each of n
//! lights has the weight sqrt(n) / (2 n).

mod blocks;
mod fills;
mod moves;
mod shapes;
mod spline;

use glam::DVec3;

use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Lamp, LampKind, Model, Pose, Space, View};
use crate::words::{Words, shortened};
use blocks::{Block, about};
use fills::light_from_everywhere;
use moves::{Moves, Seen};
use shapes::{Batches, Drawing};

/// Deepest nesting of groups and included files.
const DEEPEST: usize = 100;

/// Most files that are read in place, one as often as it is named.
const MOST_INCLUDES: usize = 50_000;

/// Most bytes of all files that are read in place.
const MOST_INCLUDED: usize = 2 << 30;

/// Most pixels of a side, and most frames.
const MOST: usize = 65536;

/// Which of the two formats a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flavour {
    Nff,
    Aff,
}

/// Reads a file.
pub(crate) fn read(source: &Source, flavour: Flavour) -> Result<Model, ImportError> {
    let is_aff = flavour == Flavour::Aff;
    let model = Model { is_classical: true, has_clear_shadows: is_aff, ..Model::default() };
    let mut reader = Reader {
        flavour,
        drawing: Drawing::new(source, model),
        moves: Moves::default(),
        depth: 0,
        level: 0,
        included: (0, 0),
        everywhere: DVec3::ONE,
    };
    let text = source.text();
    reader.items(&mut Words::new(source, &text), false)?;
    let Reader { mut drawing, moves, everywhere, .. } = reader;
    drawing.end(Batches::default());
    let mut model = drawing.model;
    light_from_everywhere(&mut model, everywhere);
    moves.apply(&mut model);
    if flavour == Flavour::Nff {
        weight_lights(&mut model);
    }
    Ok(model)
}

fn weight_lights(model: &mut Model) {
    let count = model.lamps.len() as f64;
    for lamp in &mut model.lamps {
        if let LampKind::Classical { color, .. } = &mut lamp.kind {
            *color = color.map(|c| c * count.sqrt() / (2.0 * count));
        }
    }
}

struct Reader<'a> {
    flavour: Flavour,
    drawing: Drawing<'a>,
    moves: Moves,
    depth: usize,
    /// The level of detail.
    level: i64,
    /// Files that were read in place, and their bytes.
    included: (usize, usize),
    /// The light that is everywhere.
    everywhere: DVec3,
}

impl Reader<'_> {
    /// Reads items up to the end of the file, or of the group.
    fn items(&mut self, words: &mut Words<'_>, is_group: bool) -> Result<(), ImportError> {
        loop {
            match words.next() {
                Some("}") if is_group => return Ok(()),
                Some(word) => self.item(word, words)?,
                None if is_group => return words.bad("a group is not closed at the end"),
                None => return Ok(()),
            }
        }
    }

    fn item(&mut self, word: &str, words: &mut Words<'_>) -> Result<(), ImportError> {
        match word {
            "v" => self.view(words),
            "b" => {
                self.drawing.model.background = Some(words.vector()?.max(DVec3::ZERO).to_array());
                Ok(())
            }
            "l" => self.light(words, None),
            "f" => self.drawing.fills.plain(words),
            "s" => self.drawing.sphere(words),
            "c" => self.drawing.cone(words),
            "p" => self.drawing.polygon(words, false),
            "pp" => self.drawing.polygon(words, true),
            _ if self.flavour == Flavour::Aff => self.item_of_aff(word, words),
            _ => words.bad(format!("`{}` is not an item of NFF", shortened(word))),
        }
    }

    fn item_of_aff(&mut self, word: &str, words: &mut Words<'_>) -> Result<(), ImportError> {
        match word {
            "la" => {
                let name = words.name("the name of a light")?;
                self.light(words, Some(name))
            }
            "am" => {
                self.everywhere = words.vector()?.max(DVec3::ZERO);
                Ok(())
            }
            "fm" => self.drawing.fills.colors(words, &mut self.drawing.model),
            "tt" => self.drawing.triangle(words, false),
            "ttp" => self.drawing.triangle(words, true),
            "tpa" => self.drawing.changing(words),
            "m" => self.drawing.mesh(words),
            "d" => {
                self.level = whole(words)?;
                Ok(())
            }
            "i" => self.include(words),
            "x" => self.group(words),
            "xs" => self.still_group(words),
            "k" => {
                let name = words.name("the name of key frames")?;
                let block = Block::read(words, &mut self.drawing.model.notes)?;
                self.moves.blocks.insert(name.to_owned(), block);
                Ok(())
            }
            "a" => {
                let (start, end) = (words.number()?, words.number()?);
                self.moves.range = Some((start, end, words.count(1, MOST)?));
                Ok(())
            }
            _ => words.bad(format!("`{}` is not an item of AFF", shortened(word))),
        }
    }

    fn view(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        words.word("from")?;
        let position = words.vector()?;
        words.word("at")?;
        let target = words.vector()?;
        words.word("up")?;
        let up = words.vector()?;
        words.word("angle")?;
        let angle = words.number()?;
        words.word("hither")?;
        words.number()?;
        words.word("resolution")?;
        let size = [words.count(1, MOST)? as u32, words.count(1, MOST)? as u32];
        let fov = libm::tan(angle.to_radians() / 2.0);
        if !(angle > 0.0 && angle < 180.0) || position == target || up == DVec3::ZERO {
            return words.bad("this view sees nothing");
        }
        self.moves.view = Some(Seen { view: View { position, target, up }, size, fov });
        Ok(())
    }

    /// A light; blocks of its name move it.
    fn light(&mut self, words: &mut Words<'_>, name: Option<&str>) -> Result<(), ImportError> {
        let position = words.vector()?;
        let color = if words.is_number() { words.vector()? } else { DVec3::ONE };
        let kind = LampKind::Classical { color: color.max(DVec3::ZERO).to_array(), position };
        if let Some(name) = name {
            self.moves.lights.push((self.drawing.model.lamps.len(), name.to_owned()));
        }
        let name = name.unwrap_or("light").to_owned();
        self.drawing.model.lamps.push(Lamp { name, space: self.drawing.space, kind });
        Ok(())
    }

    /// Reads a file in place, if it belongs to the level of detail.
    fn include(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let (level, name) = (whole(words)?, words.name("the name of a file")?);
        if level > self.level {
            return Ok(());
        }
        if self.depth >= DEEPEST {
            return words.bad(format!("files or groups are nested more than {DEEPEST} deep"));
        }
        let source = match words.source.beside(name) {
            Ok(source) => source,
            Err(error) => return words.bad(format!("this includes a file: {error}")),
        };
        self.included.0 += 1;
        self.included.1 += source.bytes.len();
        if self.included.0 > MOST_INCLUDES || self.included.1 > MOST_INCLUDED {
            return words.bad(format!(
                "more than {MOST_INCLUDES} files or {} GiB are read in place",
                MOST_INCLUDED >> 30
            ));
        }
        let outer = self.drawing.begin(source.stem());
        let text = source.text();
        self.depth += 1;
        self.items(&mut Words::new(&source, &text), false)?;
        self.depth -= 1;
        self.drawing.end(outer);
        Ok(())
    }

    /// A group that key frames of its name move.
    fn group(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let name = words.name("the name of a group")?;
        self.moves.groups.push((self.drawing.model.spaces.len(), name.to_owned()));
        let space = Space::still(name.to_owned(), self.drawing.space, Pose::default());
        self.inside(words, Some(space))
    }

    /// A group with a scale, a turn, and a translation.
    fn still_group(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let (scale, axis, angle) = (words.vector()?, words.vector()?, words.number()?);
        let pose = Pose { pivot: words.vector()?, turn: about(axis, angle), scale };
        let name = "group".to_owned();
        let space = (pose != Pose::default()).then(|| Space::still(name, self.drawing.space, pose));
        self.inside(words, space)
    }

    /// The items of a group. A space that changes nothing is none.
    fn inside(&mut self, words: &mut Words<'_>, space: Option<Space>) -> Result<(), ImportError> {
        words.word("{")?;
        if self.depth >= DEEPEST {
            return words.bad(format!("files or groups are nested more than {DEEPEST} deep"));
        }
        let outer = self.drawing.space;
        if let Some(space) = space {
            self.drawing.space = Some(self.drawing.model.spaces.len());
            self.drawing.model.spaces.push(space);
        }
        self.depth += 1;
        self.items(words, true)?;
        self.depth -= 1;
        self.drawing.space = outer;
        Ok(())
    }
}

fn whole(words: &mut Words<'_>) -> Result<i64, ImportError> {
    let number = words.number()?;
    if number.fract() != 0.0 {
        return words.bad(format!("expected a whole number instead of {number}"));
    }
    Ok(number as i64)
}
