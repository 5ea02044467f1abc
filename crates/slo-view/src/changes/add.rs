//! New things.

use glam::DVec3;
use slo_scene::edit::{Edit, Outline, numbers};
use slo_scene::format::written;

use super::{PLACES, scaling};

/// Significant digits of a new thing's numbers.
const DIGITS: usize = 3;

/// A thing to be added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct New {
    pub(crate) kind: Kind,
    /// The path of a mesh, as the scene writes it.
    pub(crate) file: String,
}

/// Kinds of things that can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Sphere,
    Box,
    Cylinder,
    Cone,
    Plane,
    Mesh,
    PointLight,
    PointLamp,
    SpotLamp,
    SunLamp,
}

impl Kind {
    const ALL: [(Self, &str); 10] = [
        (Self::Sphere, "sphere"),
        (Self::Box, "box"),
        (Self::Cylinder, "cylinder"),
        (Self::Cone, "cone"),
        (Self::Plane, "plane"),
        (Self::Mesh, "mesh"),
        (Self::PointLight, "light_point"),
        (Self::PointLamp, "lamp_point"),
        (Self::SpotLamp, "lamp_spot"),
        (Self::SunLamp, "lamp_sun"),
    ];

    /// The kind of a keyword.
    pub(crate) fn read(keyword: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known)| *known == keyword).map(|(kind, _)| *kind)
    }

    fn keyword(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, keyword)| keyword)
    }

    fn is_lamp(self) -> bool {
        matches!(self, Self::PointLight | Self::PointLamp | Self::SpotLamp | Self::SunLamp)
    }
}

/// Adds a thing of a size at a place, in scene space, made of a material of the text. Returns the changes,
/// and its name.
///
/// # Errors
/// A path can't be written.
pub(crate) fn add(
    text: &str,
    new: &New,
    at: DVec3,
    size: f64,
    material: Option<&str>,
) -> Result<(Vec<Edit>, String), String> {
    let outline = Outline::new(text);
    let scale = scaling(&outline);
    let is_taken = |name: &str| outline.elements().any(|part| part.name() == Some(name));
    let free = |stem: &str| {
        let name = |i: usize| if i == 1 { stem.to_owned() } else { format!("{stem}_{i}") };
        (1..).map(name).find(|name| !is_taken(name)).unwrap_or_default()
    };
    if new.file.contains(|c: char| c == '"' || c.is_control()) {
        return Err(format!("`{}` can't be written as a path", new.file));
    }
    let name = free(new.kind.keyword());
    let known = |name: &&str| {
        outline
            .elements()
            .any(|part| part.keyword().starts_with("material_") && part.name() == Some(*name))
    };
    let first = || {
        let mut materials =
            outline.elements().filter(|part| part.keyword().starts_with("material_"));
        materials.find_map(|part| part.name())
    };
    let mut lines = Vec::new();
    let material = match material.filter(known).or_else(first) {
        Some(material) => written(material).to_string(),
        None if new.kind.is_lamp() => String::new(),
        None => {
            let grey = free("grey");
            lines.push(format!("phong_info {grey} {{ diffuse {{ 0.5 0.5 0.5 }} }}"));
            lines.push(format!("material_phong {grey} {{ phong_info {grey} }}"));
            grey
        }
    };
    let (at, size) = (at / scale, size / scale);
    let vector = |of: DVec3| numbers(&of.to_array(), PLACES);
    let point = |x: f64, y: f64, z: f64| vector(rounded(at + DVec3::new(x, y, z) * size, size));
    let number = |of: f64| numbers(&[of], DIGITS);
    let power = number(40.0 * size * size * scale * scale);
    let inside = match new.kind {
        Kind::Sphere => {
            format!("center {{ {} }} radius {}", point(0.0, 0.0, 0.5), number(size * 0.5))
        }
        Kind::Box => format!(
            "vertex0 {{ {} }} vertex1 {{ {} }} vertex2 {{ {} }} height {}",
            point(-0.5, -0.5, 0.0),
            point(0.5, -0.5, 0.0),
            point(0.5, 0.5, 0.0),
            number(size)
        ),
        Kind::Cylinder | Kind::Cone => format!(
            "base {{ {} }} {} {{ {} }} radius {}",
            point(0.0, 0.0, 0.0),
            if new.kind == Kind::Cone { "apex" } else { "top" },
            point(0.0, 0.0, 1.0),
            number(size * 0.4)
        ),
        Kind::Plane => format!("normal {{ 0 0 1 }} position {{ {} }}", point(0.0, 0.0, 0.0)),
        Kind::Mesh => format!(
            "filename {} addKframe {{ time 0 key {{ pivot {{ {} }} }} }}",
            written(&new.file),
            point(0.0, 0.0, 0.0)
        ),
        Kind::PointLight => {
            format!("color {{ 0.5 0.5 0.5 }} position {{ {} }}", point(0.0, 0.0, 2.0))
        }
        Kind::PointLamp => format!(
            "power {{ {power} {power} {power} }} position {{ {} }} radius {}",
            point(0.0, 0.0, 2.0),
            number(size * 0.1)
        ),
        Kind::SpotLamp => format!(
            "power {{ {power} {power} {power} }} position {{ {} }} target {{ {} }} angle_deg 40",
            point(0.0, 0.0, 3.0),
            point(0.0, 0.0, 0.0)
        ),
        Kind::SunLamp => "irradiance { 1 1 1 } direction { 0.3 0.4 -1 } angle_deg 0.5".to_owned(),
    };
    let made_of = if new.kind.is_lamp() { String::new() } else { format!(" material {material}") };
    lines.push(format!("{} {name} {{ {inside}{made_of} }}", new.kind.keyword()));
    let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let before = if text.is_empty() || text.ends_with('\n') { "" } else { newline };
    let added = format!("{before}{}{newline}", lines.join(newline));
    Ok((vec![Edit { range: text.len()..text.len(), text: added }], name))
}

/// A point with no more digits than a thing of this size needs.
fn rounded(point: DVec3, size: f64) -> DVec3 {
    let step = libm::pow(10.0, libm::floor(libm::log10(size.max(1e-300))) - 2.0);
    (point / step).round() * step
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;
    use slo_scene::{Files, load};

    use super::*;

    const TEXT: &str = "Scaling twice { 2 }
settings s {}
Camera c { fps 10 Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
    CamSegment only { videoStart 0 videoEnd 2 addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 0.4 } }
light_point lamp { color { 1 1 1 } position { 2 -3 4 } }";

    #[test]
    fn new_things_are_where_they_should_be() {
        let files = Files::built_in(
            "",
            &[("a b.slo", b"slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }")],
        );
        let mut text = TEXT.to_owned();
        for (_, keyword) in Kind::ALL.iter().chain(&Kind::ALL) {
            let new = New { kind: Kind::read(keyword).unwrap(), file: "a b.slo".into() };
            let (edits, _) =
                add(&text, &new, DVec3::new(1.0, 2.0, 3.0), 0.5, Some("none")).unwrap();
            text = applied(&text, edits).unwrap();
        }
        let loaded = load("scene.txt", &text, &files);
        let scene =
            loaded.scene.unwrap_or_else(|| panic!("{}\n{text}", loaded.diagnostics.render(false)));
        assert_eq!((scene.objects.len(), scene.lights.len(), scene.materials.len()), (12, 9, 1));
        assert!(
            text.contains("sphere sphere_2 { center { 0.5 1 1.625 } radius 0.125 material grey }"),
            "{text}"
        );
        let bad = New { kind: Kind::Mesh, file: "a\"b".into() };
        assert!(add(&text, &bad, DVec3::ZERO, 1.0, None).is_err());
    }
}
