//! Spaces as groups, or as key frames of the only thing that hangs in them.

use glam::{DQuat, DVec3};

use super::numbers::{number, rounded, vector};
use crate::model::{Key, Model, Pose, Space};
use crate::names::Names;

/// The names of all groups, lamps and objects, and how they hang in one another.
pub(super) struct Spaces<'a> {
    spaces: &'a [Space],
    groups: Vec<String>,
    pub(super) lamps: Vec<String>,
    pub(super) objects: Vec<String>,
    /// How many spaces, and how many other things, hang in each space.
    held: Vec<[usize; 2]>,
}

impl<'a> Spaces<'a> {
    pub(super) fn of(model: &'a Model) -> Self {
        let mut held = vec![[0; 2]; model.spaces.len()];
        let lamps = model.lamps.iter().map(|lamp| lamp.space);
        for space in model.objects.iter().map(|object| object.space).chain(lamps).flatten() {
            held[space][1] += 1;
        }
        // Spaces follow the spaces that they hang in.
        for (space, of) in model.spaces.iter().enumerate().rev() {
            if let Some(parent) = of.parent.filter(|_| held[space] != [0; 2]) {
                held[parent][0] += 1;
            }
        }
        let mut names = Names::default();
        // Things that can be seen have the first choice.
        let objects =
            model.objects.iter().map(|object| names.new_name(&object.name, "object")).collect();
        let lamps = model.lamps.iter().map(|lamp| names.new_name(&lamp.name, "lamp")).collect();
        let mut groups = Vec::new();
        for (space, held) in model.spaces.iter().zip(&held) {
            let is_group = is_group(*held);
            groups.push(if is_group {
                names.new_name(&space.name, "group")
            } else {
                String::new()
            });
        }
        Self { spaces: &model.spaces, groups, lamps, objects, held }
    }

    /// The text of all groups.
    pub(super) fn groups(&self) -> impl Iterator<Item = String> {
        let all = self.spaces.iter().zip(&self.groups).zip(&self.held);
        all.filter(|(_, held)| is_group(**held)).map(|((space, name), _)| {
            format!("group {name} {{{}{} }}\n", frames(&space.keys), self.place(space.parent))
        })
    }

    /// What puts a thing into a space: `parent`, or the key frames of a space that holds nothing else.
    pub(super) fn place(&self, space: Option<usize>) -> String {
        let Some(space) = space else { return String::new() };
        if is_group(self.held[space]) {
            return format!("  parent {}", self.groups[space]);
        }
        let Space { keys, parent, .. } = &self.spaces[space];
        frames(keys) + &self.place(*parent)
    }
}

/// Whether a space needs a name: several things hang in it, or other spaces do.
fn is_group([spaces, things]: [usize; 2]) -> bool {
    spaces > 0 || things > 1
}

fn frames(keys: &[Key]) -> String {
    let turns = keys.iter().any(|key| angle_of(key.pose.turn).1 != 0.0);
    match keys {
        [key] if key.pose == Pose::default() => String::new(),
        [key] => format!("  {}", frame(key, turns)),
        keys => {
            let lines = keys.iter().map(|key| format!("\n    {}", frame(key, turns)));
            lines.collect::<String>() + "\n "
        }
    }
}

fn frame(key: &Key, turns: bool) -> String {
    let Pose { pivot, turn, scale } = key.pose;
    let mut text =
        format!("addKframe {{ time {}  key {{ pivot {}", number(key.time), vector(pivot));
    if turns {
        let (axis, angle) = angle_of(turn);
        text += &format!("  turn {{ axis {} angle_deg {} }}", vector(axis), number(angle));
    }
    if scale != DVec3::ONE {
        text += &format!("  scale {}", vector(scale));
    }
    text + " } }"
}

/// The axis of a turn, and its angle in degrees.
fn angle_of(turn: DQuat) -> (DVec3, f64) {
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let sine = DVec3::new(turn.x, turn.y, turn.z).length();
    let angle = rounded(2.0 * libm::atan2(sine, turn.w).to_degrees());
    let axis = if angle > 0.0 { DVec3::new(turn.x, turn.y, turn.z) / sine } else { DVec3::Z };
    (axis, angle)
}
