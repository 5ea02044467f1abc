//! AFF, the format of BART (J. Lext, U. Assarsson, T. Möller, "A Benchmark for Animated Ray Tracing", 2001),
//! and NFF, which it contains.
//!
//! E. Haines, "A Proposal for Standard Graphics Environments" (1987). Lights do not fall off with
//! distance there, and materials are those of Phong, so scenes become classical ones. In NFF, each of n
//! lights has the weight sqrt(n) / (2 n).

mod blocks;
mod fills;
mod finish;
mod shapes;
mod spline;

use std::collections::HashMap;

use glam::DVec3;

use crate::error::ImportError;
use crate::files::Source;
use crate::images::Images;
use crate::model::{KnownMeshes, Lamp, LampKind, Model, Pose, Space, View};
use crate::words::{Words, shortened};
use blocks::{Block, about};
use fills::Fills;
use shapes::Batches;

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
    let mut reader = Reader {
        main: source,
        flavour,
        model: Model {
            is_classical: true,
            has_clear_shadows: flavour == Flavour::Aff,
            ..Model::default()
        },
        fills: Fills::default(),
        images: Images::default(),
        meshes: KnownMeshes::default(),
        batches: Batches::new(source.stem()),
        space: None,
        depth: 0,
        level: 0,
        included: (0, 0),
        everywhere: DVec3::ONE,
        view: None,
        blocks: HashMap::new(),
        groups: Vec::new(),
        lights: Vec::new(),
        range: None,
    };
    let text = source.text();
    reader.items(&mut Words::new(source, &text), false)?;
    reader.flush(Batches::new(String::new()));
    reader.finish();
    Ok(reader.model)
}

/// A view, without what may move it.
#[derive(Clone, Copy, Debug)]
struct Seen {
    view: View,
    size: [u32; 2],
    fov: f64,
}

struct Reader<'a> {
    main: &'a Source,
    flavour: Flavour,
    model: Model,
    fills: Fills,
    images: Images,
    meshes: KnownMeshes,
    /// Shapes of the current file.
    batches: Batches,
    /// The space of the current group.
    space: Option<usize>,
    depth: usize,
    /// The level of detail.
    level: i64,
    /// Files that were read in place, and their bytes.
    included: (usize, usize),
    /// The light that is everywhere.
    everywhere: DVec3,
    view: Option<Seen>,
    /// Key frames, by names.
    blocks: HashMap<String, Block>,
    /// Spaces that blocks of these names move.
    groups: Vec<(usize, String)>,
    /// Lights that blocks of these names move.
    lights: Vec<(usize, String)>,
    /// The first and the last time of the animation, and its frames.
    range: Option<(f64, f64, usize)>,
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
                self.model.background = Some(words.vector()?.max(DVec3::ZERO).to_array());
                Ok(())
            }
            "l" => self.light(words, None),
            "f" => self.fills.plain(words),
            "s" => self.sphere(words),
            "c" => self.cone(words),
            "p" => self.polygon(words, false),
            "pp" => self.polygon(words, true),
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
            "fm" => self.fills.colors(words, &mut self.model),
            "tt" => self.triangle(words, false),
            "ttp" => self.triangle(words, true),
            "tpa" => self.changing(words),
            "m" => self.mesh(words),
            "d" => {
                self.level = whole(words)?;
                Ok(())
            }
            "i" => self.include(words),
            "x" => self.group(words),
            "xs" => self.still_group(words),
            "k" => {
                let name = words.name("the name of key frames")?;
                let block = Block::read(words, &mut self.model.notes)?;
                self.blocks.insert(name.to_owned(), block);
                Ok(())
            }
            "a" => {
                let (start, end) = (words.number()?, words.number()?);
                self.range = Some((start, end, words.count(1, MOST)?));
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
        self.view = Some(Seen { view: View { position, target, up }, size, fov });
        Ok(())
    }

    /// A light; blocks of its name move it.
    fn light(&mut self, words: &mut Words<'_>, name: Option<&str>) -> Result<(), ImportError> {
        let position = words.vector()?;
        let color = if words.is_number() { words.vector()? } else { DVec3::ONE };
        let kind = LampKind::Classical { color: color.max(DVec3::ZERO).to_array(), position };
        if let Some(name) = name {
            self.lights.push((self.model.lamps.len(), name.to_owned()));
        }
        let name = name.unwrap_or("light").to_owned();
        self.model.lamps.push(Lamp { name, space: self.space, kind });
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
        let outer = std::mem::replace(&mut self.batches, Batches::new(source.stem()));
        let text = source.text();
        self.depth += 1;
        self.items(&mut Words::new(&source, &text), false)?;
        self.depth -= 1;
        self.flush(outer);
        Ok(())
    }

    /// A group that key frames of its name move.
    fn group(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let name = words.name("the name of a group")?;
        self.groups.push((self.model.spaces.len(), name.to_owned()));
        let space = Space::still(name.to_owned(), self.space, Pose::default());
        self.inside(words, Some(space))
    }

    /// A group with a scale, a turn, and a translation.
    fn still_group(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let (scale, axis, angle) = (words.vector()?, words.vector()?, words.number()?);
        let pose = Pose { pivot: words.vector()?, turn: about(axis, angle), scale };
        let name = "group".to_owned();
        let space = (pose != Pose::default()).then(|| Space::still(name, self.space, pose));
        self.inside(words, space)
    }

    /// The items of a group. A space that changes nothing is none.
    fn inside(&mut self, words: &mut Words<'_>, space: Option<Space>) -> Result<(), ImportError> {
        words.word("{")?;
        if self.depth >= DEEPEST {
            return words.bad(format!("files or groups are nested more than {DEEPEST} deep"));
        }
        let outer = self.space;
        if let Some(space) = space {
            self.space = Some(self.model.spaces.len());
            self.model.spaces.push(space);
        }
        self.depth += 1;
        self.items(words, true)?;
        self.depth -= 1;
        self.space = outer;
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
