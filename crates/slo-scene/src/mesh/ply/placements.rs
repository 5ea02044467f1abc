//! Placements of copies from the vertices of a `.ply` file.

use std::io::Read;

use glam::DVec3;

use super::header::{Element, Header, Property, Scalar};
use super::properties::{context, skip_property};
use super::values::Values;
use super::vertices::MAX_RESERVE;
use crate::attributes::{FARTHEST, SHORTEST};
use crate::format::{FileError, Input};
use crate::placements::Placements;

/// Names of numbers that belong together.
const TURN: [&str; 4] = ["qx", "qy", "qz", "qw"];
const SCALES: [&str; 3] = ["sx", "sy", "sz"];
const TINT: [&str; 3] = ["r", "g", "b"];

/// What a number of a placement is for; with the index into the vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Position(usize),
    Turn(usize),
    Scale,
    Scales(usize),
    Kind,
    Tint(usize),
    Unused,
}

impl Slot {
    fn of(property: &Property) -> Self {
        let name = property.name.as_str();
        let place = |names: &[&str]| names.iter().position(|known| *known == name);
        if property.list.is_some() {
            return Self::Unused;
        }
        match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "scale" => Self::Scale,
            "kind" => Self::Kind,
            _ => place(&TURN)
                .map(Self::Turn)
                .or_else(|| place(&SCALES).map(Self::Scales))
                .or_else(|| place(&TINT).map(Self::Tint))
                .unwrap_or(Self::Unused),
        }
    }
}

/// Which columns a file has.
struct Columns {
    turns: bool,
    scale: bool,
    scales: bool,
    kinds: bool,
    tints: bool,
}

impl Columns {
    /// # Errors
    /// Numbers that belong together are not all there.
    fn of(element: &Element) -> Result<Self, FileError> {
        let has =
            |name: &str| element.properties.iter().any(|of| of.name == name && of.list.is_none());
        for name in ["x", "y", "z"] {
            if !has(name) {
                let message = format!("a placement has no property `{name}`");
                return Err(FileError::whole_file(message).with_help(HELP));
            }
        }
        let all = |names: &[&str]| -> Result<bool, FileError> {
            let missing: Vec<_> = names.iter().filter(|name| !has(name)).collect();
            match missing.as_slice() {
                [] => Ok(true),
                [first, ..] if missing.len() < names.len() => {
                    let with = names.iter().find(|name| has(name)).unwrap_or(first);
                    let message = format!("a placement has `{with}` and no `{first}`");
                    Err(FileError::whole_file(message).with_help(HELP))
                }
                _ => Ok(false),
            }
        };
        let columns = Self {
            turns: all(&TURN)?,
            scale: has("scale"),
            scales: all(&SCALES)?,
            kinds: has("kind"),
            tints: all(&TINT)?,
        };
        if columns.scale && columns.scales {
            let message = "a placement has `scale` beside `sx`, `sy` and `sz`";
            return Err(FileError::whole_file(message));
        }
        Ok(columns)
    }
}

/// What a file of placements may say.
const HELP: &str =
    "a placement has x y z, and optionally qw qx qy qz, scale or sx sy sz, kind, r g b";

/// Reads the vertices of a file as placements; positions are multiplied by `scaling`. `kinds` is the
/// number of originals that there are.
///
/// # Errors
/// The first fault in the file, with its place if the file is text.
pub(crate) fn read(
    reader: &mut dyn Read,
    scaling: f64,
    kinds: usize,
) -> Result<Placements, FileError> {
    let mut input = Input::new(reader, 0);
    let header = Header::read(&mut input)?;
    let mut values = Values::new(input, header.encoding);
    for element in &header.elements {
        if element.name == "vertex" {
            return read_placements(element, &mut values, scaling, kinds);
        }
        for item in 0..element.count {
            for property in &element.properties {
                skip_property(element, item, property, &mut values)?;
            }
        }
    }
    Err(FileError::whole_file("the file has no element `vertex`").with_help(HELP))
}

fn read_placements(
    element: &Element,
    values: &mut Values<'_>,
    scaling: f64,
    kinds: usize,
) -> Result<Placements, FileError> {
    let columns = Columns::of(element)?;
    let slots: Vec<_> = element.properties.iter().map(Slot::of).collect();
    let mut to = Placements::default();
    to.positions.reserve(element.count.min(MAX_RESERVE) as usize);
    for item in 0..element.count {
        let (mut position, mut turn) = ([0.0; 3], [0.0f32; 4]);
        let (mut scale, mut tint, mut kind) = ([1.0f32; 3], [1.0f32; 3], 0);
        let mut last = None;
        for (property, slot) in element.properties.iter().zip(&slots) {
            if *slot == Slot::Unused {
                skip_property(element, item, property, values)?;
                continue;
            }
            let context = context(element, item, property);
            let value = values.next(property.scalar, context)?;
            let wrong = match *slot {
                Slot::Position(axis) => {
                    position[axis] = value * scaling;
                    (position[axis].abs() > FARTHEST).then(|| format!("is beyond {FARTHEST:e}"))
                }
                Slot::Turn(axis) => {
                    turn[axis] = value as f32;
                    last = Some(context);
                    (value.abs() > 1e9).then(|| "is too large".to_owned())
                }
                Slot::Scale | Slot::Scales(_) => {
                    match slot {
                        Slot::Scales(axis) => scale[*axis] = value as f32,
                        _ => scale = [value as f32; 3],
                    }
                    let is_in = (SHORTEST..=FARTHEST).contains(&value);
                    (!is_in).then(|| format!("is not from {SHORTEST:e} to {FARTHEST:e}"))
                }
                Slot::Kind => {
                    kind = value as u32;
                    let is_one = value.fract() == 0.0 && value >= 0.0 && value < kinds as f64;
                    (!is_one).then(|| match kinds {
                        1 => "is not 0, and there is one `of`".to_owned(),
                        _ => format!("is not a whole number from 0 to {}", kinds - 1),
                    })
                }
                Slot::Tint(channel) => {
                    let most = if property.scalar == Scalar::U8 { 255.0 } else { 1.0 };
                    tint[channel] = (value / most) as f32;
                    let is_in = value >= 0.0 && tint[channel].is_finite();
                    (!is_in).then(|| "is negative, or too large".to_owned())
                }
                Slot::Unused => None,
            };
            if let Some(wrong) = wrong {
                return Err(values.fault(context, &wrong));
            }
        }
        to.positions.push(DVec3::from_array(position));
        if columns.turns {
            let length = turn.iter().map(|c| f64::from(*c) * f64::from(*c)).sum::<f64>().sqrt();
            if let (true, Some(context)) = (length < 1e-6, last) {
                return Err(values.fault(context, "belongs to a quaternion of length 0"));
            }
            to.turns.push(turn.map(|c| (f64::from(c) / length) as f32));
        }
        if columns.scale || columns.scales {
            to.scales.push(scale);
        }
        if columns.kinds {
            to.kinds.push(kind);
        }
        if columns.tints {
            to.tints.push(tint);
        }
    }
    Ok(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(properties: &str, rows: &str) -> String {
        let properties: String =
            properties.split(' ').map(|name| format!("property float {name}\n")).collect();
        let count = rows.lines().count();
        format!("ply\nformat ascii 1.0\nelement vertex {count}\n{properties}end_header\n{rows}\n")
    }

    fn placements(properties: &str, rows: &str) -> Result<Placements, String> {
        let text = file(properties, rows);
        read(&mut text.as_bytes(), 2.0, 2).map_err(|error| {
            format!(
                "{}:{} {} {}",
                error.line,
                error.column,
                error.message,
                error.help.unwrap_or_default()
            )
        })
    }

    #[test]
    fn all_columns_are_read() {
        let read = placements("x y z", "1 2 3\n4 5 6").expect("it is whole");
        assert_eq!(read.positions, [DVec3::new(2.0, 4.0, 6.0), DVec3::new(8.0, 10.0, 12.0)]);
        assert!(read.turns.is_empty() && read.scales.is_empty() && read.tints.is_empty());
        let all = placements(
            "kind x age y z qw qx qy qz sx sy sz r g b",
            "1 1 99 2 3 0 0 0 -2 1 2 3 .5 .25 4",
        );
        let all = all.expect("it is whole");
        assert_eq!((all.turns[0], all.scales[0]), ([0.0, 0.0, -1.0, 0.0], [1.0, 2.0, 3.0]));
        assert_eq!((all.kinds[0], all.tints[0]), (1, [0.5, 0.25, 4.0]));
        assert_eq!(placements("x y z scale", "1 1 1 3").expect("whole").scales, [[3.0; 3]]);
        let bytes = "ply\nformat ascii 1.0\nelement other 1\nproperty list uchar int of\n\
            element vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
            property uchar r\nproperty uchar g\nproperty uchar b\nend_header\n2 7 8\n0 0 0 255 0 51\n";
        let read = read_bytes(bytes.as_bytes());
        assert_eq!(read.tints, [[1.0, 0.0, 0.2]]);
    }

    fn read_bytes(bytes: &[u8]) -> Placements {
        read(&mut &*bytes, 1.0, 1).expect("it is whole")
    }

    #[test]
    fn faults_have_a_place() {
        for (properties, rows, expected) in [
            ("x y", "1 2", "0:0 a placement has no property `z`"),
            ("x y z qw qx qz", "1 2 3 1 0 0", "0:0 a placement has `qx` and no `qy`"),
            ("x y z scale sx sy sz", "1 2 3 1 1 1 1", "beside `sx`"),
            ("x y z scale", "1 2 3 1\n1 2 3 0", "10:7 `scale` of vertex 1 is not from 1e-9 to 1e9"),
            ("x y z sx sy sz", "1 2 3 1 -1 1", "`sy` of vertex 0 is not from"),
            ("x y z kind", "1 2 3 2", "`kind` of vertex 0 is not a whole number from 0 to 1"),
            ("x y z kind", "1 2 3 .5", "`kind` of vertex 0"),
            (
                "x y z qw qx qy qz",
                "1 2 3 0 0 0 0",
                "`qz` of vertex 0 belongs to a quaternion of length 0",
            ),
            ("x y z r g b", "1 2 3 0 -1 0", "`g` of vertex 0 is negative"),
            ("x y z", "1 nan 3", "`y` of vertex 0 is not finite"),
            ("x y z", "1 2e9 3", "`y` of vertex 0 is beyond 1e9"),
        ] {
            let error = placements(properties, rows).expect_err(properties);
            assert!(error.contains(expected), "{error}, expected {expected}");
        }
        let none = "ply\nformat ascii 1.0\nelement face 0\nproperty int a\nend_header\n";
        assert!(read(&mut none.as_bytes(), 1.0, 1).expect_err("none").message.contains("`vertex`"));
    }
}
