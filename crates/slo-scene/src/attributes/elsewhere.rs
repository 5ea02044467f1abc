//! Words that Blender, glTF, pbrt and Mitsuba have for what this language calls otherwise.

use super::schema::{Attribute, Schema};

/// Elements.
const ELEMENTS: [(&str, &[&str]); 6] = [
    ("lamp_point", &["point_light", "lamp_sphere", "sphere_light", "light_sphere"]),
    ("lamp_spot", &["spot", "spot_light", "light_spot", "spotlight"]),
    (
        "lamp_sun",
        &[
            "sun",
            "sun_light",
            "light_sun",
            "sunlight",
            "directional",
            "distant",
            "light_directional",
        ],
    ),
    (
        "lamp_rectangle",
        &["area", "area_light", "light_area", "lamp_area", "lamp_quad", "quad_light", "lamp_plane"],
    ),
    ("lamp_disc", &["lamp_disk", "light_disc", "light_disk", "disc_light", "disk_light"]),
    (
        "environment",
        &[
            "hdri",
            "hdr",
            "sky",
            "skybox",
            "world",
            "envmap",
            "env",
            "environment_map",
            "infinite",
            "dome",
            "dome_light",
            "light_dome",
            "light_environment",
        ],
    ),
];

/// Attributes: the word, and what it may mean, the most probable first.
const ATTRIBUTES: [(&str, &[&str]); 34] = [
    ("intensity", LIGHT),
    ("energy", LIGHT),
    ("watts", LIGHT),
    ("flux", LIGHT),
    ("brightness", LIGHT),
    ("emission", LIGHT),
    ("light", LIGHT),
    ("color", COLOR),
    ("colour", COLOR),
    ("strength", LIGHT),
    ("scale", &["strength"]),
    ("L", &["radiance"]),
    ("I", &["power"]),
    ("multiplier", &["strength"]),
    ("filename", &["texture"]),
    ("image", &["texture"]),
    ("map", &["texture"]),
    ("rotation", &["turn_deg"]),
    ("angle", &["angle_deg", "turn_deg"]),
    ("size", &["radius", "angle_deg"]),
    ("spot_size", &["angle_deg"]),
    ("cone_angle", &["angle_deg"]),
    ("cutoff_angle", &["angle_deg"]),
    ("spot_blend", &["blend"]),
    ("from", &["position", "center"]),
    ("to", &["target"]),
    ("direction", &["target"]),
    ("location", &["position", "center"]),
    ("center", &["position"]),
    ("position", &["center"]),
    ("max_depth", &["recursion"]),
    ("max_bounces", &["recursion"]),
    ("bounces", &["recursion"]),
    ("spp", &["imageSamples"]),
];

/// What says how strong a light is.
const LIGHT: &[&str] = &["power", "irradiance", "radiance"];

/// What says which colour a thing has, or its light.
const COLOR: &[&str] = &["power", "irradiance", "radiance", "base_color"];

/// The element that a word of another program means.
pub(crate) fn element_meant(word: &str) -> Option<&'static str> {
    let plain = plain(word);
    let is_it = |words: &[&str]| words.iter().any(|known| known.replace('_', "") == plain);
    ELEMENTS.iter().find(|(_, words)| is_it(words)).map(|(meant, _)| *meant)
}

/// The attribute of an element that a word of another program means.
pub(super) fn attribute_meant(word: &str, schema: &Schema) -> Option<&'static Attribute> {
    let simple = plain(word);
    let is_it = |known: &str| known == word || known.len() > 1 && known.replace('_', "") == simple;
    let (_, meant) = ATTRIBUTES.iter().find(|(known, _)| is_it(known))?;
    meant.iter().find_map(|name| schema.attribute(name))
}

/// Without capitals and underscores, as other programs may write a word.
fn plain(word: &str) -> String {
    word.chars().take(40).filter(|c| *c != '_').flat_map(char::to_lowercase).collect()
}
