//! Reads NFF files (Haines, "A Proposal for Standard Graphics Environments", 1987) as objects.

use std::str::FromStr;

use slo_accel::glam::DVec3;

use crate::objects::{Fill, Object, Shape};

/// Where rays start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: DVec3,
    /// Between the first and the last ray of a row, in radians.
    pub(crate) angle: f64,
}

/// A scene of objects.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) view: View,
    pub(crate) lights: Vec<DVec3>,
    pub(crate) objects: Vec<Object>,
}

struct Words<'a>(Box<dyn Iterator<Item = &'a str> + 'a>);

impl Words<'_> {
    fn number(&mut self) -> Result<f64, String> {
        let word = self.0.next().ok_or("a number is missing at the end")?;
        f64::from_str(word).map_err(|_| format!("expected a number instead of `{word}`"))
    }

    fn vector(&mut self) -> Result<DVec3, String> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    fn named<T>(
        &mut self,
        name: &str,
        read: impl Fn(&mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        match self.0.next() {
            Some(word) if word == name => read(self),
            word => Err(format!("expected `{name}` instead of {word:?}")),
        }
    }
}

/// Reads the text of a file. All items but colours count.
pub(crate) fn read(text: &str) -> Result<Scene, String> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    // A light's colour is optional; a word follows it at the latest.
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    let mut at = 0;
    let (mut view, mut fill) = (None, Fill::default());
    let (mut lights, mut objects) = (Vec::new(), Vec::new());
    while at < words.len() {
        let item = words[at];
        let end = words[at + 1..]
            .iter()
            .position(|word| matches!(*word, "v" | "b" | "l" | "f" | "s" | "c" | "p" | "pp"));
        let end = end.map_or(words.len(), |end| at + 1 + end);
        let mut rest = Words(Box::new(words[at + 1..end].iter().copied()));
        let shape = match item {
            "v" => {
                view = Some(View {
                    eye: rest.named("from", Words::vector)?,
                    target: rest.named("at", Words::vector)?,
                    up: rest.named("up", Words::vector)?,
                    angle: rest.named("angle", Words::number)?.to_radians(),
                });
                None
            }
            "b" => None,
            "l" => {
                lights.push(rest.vector()?);
                None
            }
            "f" => {
                rest.vector()?;
                let [_, specular, _, transmission, ior] = [
                    rest.number()?,
                    rest.number()?,
                    rest.number()?,
                    rest.number()?,
                    rest.number()?,
                ];
                fill = Fill { reflects: specular > 0.0, transmits: transmission > 0.0, ior };
                None
            }
            "s" => Some(Shape::sphere(rest.vector()?, rest.number()?.abs())),
            "c" => {
                let (base, base_radius) = (rest.vector()?, rest.number()?.abs());
                Some(Shape::cone(base, base_radius, rest.vector()?, rest.number()?.abs()))
            }
            "p" | "pp" => {
                let count = rest.number()? as usize;
                let (mut corners, mut normals) = (Vec::new(), Vec::new());
                for _ in 0..count {
                    corners.push(rest.vector()?);
                    if item == "pp" {
                        normals.push(rest.vector()?);
                    }
                }
                Shape::polygon(corners, normals)
            }
            _ => return Err(format!("`{item}` is not an item of NFF")),
        };
        objects.extend(shape.map(|shape| Object { shape, fill }));
        at = end;
    }
    Ok(Scene { view: view.ok_or("there is no view")?, lights, objects })
}
