//! Nodes with their fields, as files hold them.

use std::rc::Rc;

use glam::{DQuat, DVec3};

/// A node.
#[derive(Debug, Default)]
pub(super) struct Node {
    pub(super) class: String,
    /// What `DEF` calls it.
    pub(super) name: Option<String>,
    pub(super) fields: Vec<(String, Value)>,
    pub(super) children: Vec<Rc<Node>>,
}

/// The value of a field.
#[derive(Debug)]
pub(super) enum Value {
    Numbers(Vec<f64>),
    /// Words and texts.
    Words(Vec<String>),
    Node(Rc<Node>),
}

impl Node {
    fn field(&self, name: &str) -> Option<&Value> {
        self.fields.iter().find(|(field, _)| field == name).map(|(_, value)| value)
    }

    /// The numbers of a field, if the file gives it.
    pub(super) fn numbers(&self, name: &str) -> Option<&[f64]> {
        match self.field(name) {
            Some(Value::Numbers(numbers)) => Some(numbers),
            _ => None,
        }
    }

    pub(super) fn number(&self, name: &str, usual: f64) -> f64 {
        self.numbers(name).and_then(|numbers| numbers.first().copied()).unwrap_or(usual)
    }

    pub(super) fn vector(&self, name: &str, usual: DVec3) -> DVec3 {
        self.vectors(name).and_then(|vectors| vectors.first().copied()).unwrap_or(usual)
    }

    /// The vectors of a field, if the file gives it.
    pub(super) fn vectors(&self, name: &str) -> Option<Vec<DVec3>> {
        let numbers = self.numbers(name)?;
        Some(numbers.chunks_exact(3).map(DVec3::from_slice).collect())
    }

    /// The pairs of a field; none if the file does not give it.
    pub(super) fn pairs(&self, name: &str) -> Vec<[f64; 2]> {
        let numbers = self.numbers(name).unwrap_or(&[]);
        numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// A turn: an axis, and an angle in radians.
    pub(super) fn turn(&self, name: &str) -> DQuat {
        match self.numbers(name) {
            Some(&[x, y, z, angle]) => turn(DVec3::new(x, y, z), angle),
            _ => DQuat::IDENTITY,
        }
    }

    /// Indices of a field, if the file gives it.
    pub(super) fn indices(&self, name: &str) -> Option<Vec<i64>> {
        Some(self.numbers(name)?.iter().map(|&number| number as i64).collect())
    }

    /// The word of a field; empty if the file does not give it.
    pub(super) fn word(&self, name: &str) -> &str {
        self.words(name).first().map_or("", String::as_str)
    }

    /// The words of a field; none if the file does not give it.
    pub(super) fn words(&self, name: &str) -> &[String] {
        match self.field(name) {
            Some(Value::Words(words)) => words,
            _ => &[],
        }
    }

    pub(super) fn flag(&self, name: &str, usual: bool) -> bool {
        match self.field(name) {
            Some(Value::Words(words)) => words.first().map_or(usual, |word| word == "TRUE"),
            Some(Value::Numbers(numbers)) => numbers.first().map_or(usual, |&number| number != 0.0),
            _ => usual,
        }
    }

    /// The node in a field.
    pub(super) fn node(&self, name: &str) -> Option<&Rc<Node>> {
        match self.field(name) {
            Some(Value::Node(node)) => Some(node),
            _ => None,
        }
    }
}

/// A turn about an axis of any length by radians.
pub(super) fn turn(axis: DVec3, angle: f64) -> DQuat {
    let v = axis.normalize_or_zero() * libm::sin(angle / 2.0);
    if v == DVec3::ZERO {
        DQuat::IDENTITY
    } else {
        DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(angle / 2.0))
    }
}
