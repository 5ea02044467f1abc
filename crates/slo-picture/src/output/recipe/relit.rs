//! Recipes of pictures that were made from a picture: in another light, in another look, or both.

use std::fmt::Write;

use slo_scene::{Look, OutputFormat, ToneMap};

use super::outcome::{Outcome, with_outcome, without_outcome};

/// The recipe of a picture in another file format and with another look. Where it is the recipe of a
/// rendered picture, so is the result. The error is unknown, since it depends on the look.
pub fn with_look(recipe: &str, format: OutputFormat, look: Look) -> String {
    let mut members = Members::of(&without_outcome(recipe));
    members.set("output", &format!("\"{format}\""));
    members.set("encoding", &format!("\"{}\"", look.encoding));
    // Those that came later stand there unless they are as they always were.
    members.remove("exposure");
    members.remove("toneMap");
    if look.tone_map != ToneMap::None {
        members.insert_behind("encoding", "toneMap", &format!("\"{}\"", look.tone_map));
    }
    if look.exposure != 0.0 {
        members.insert_behind("encoding", "exposure", &format!("{:?}", look.exposure));
    }
    if !format.has_layers() {
        members.remove("layers");
    }
    let parsed: Option<serde_json::Value> = serde_json::from_str(recipe).ok();
    let samples = parsed.as_ref().and_then(|it| it["result"]["samplesPerPixel"].as_f64());
    match samples {
        Some(samples) => with_outcome(&members.text(), &Outcome { samples, error: None }),
        None => members.text(),
    }
}

/// The recipe of a picture whose groups of lights were changed; `gains` says how. No rendered picture has
/// such a recipe.
pub fn with_relit(recipe: &str, gains: &str) -> String {
    let mut members = Members::of(recipe);
    let relit = format!("  \"relit\": {}", ascii(gains));
    match members.0.last() {
        Some(last) if last.starts_with("  \"result\"") => {
            let place = members.0.len() - 1;
            members.0.insert(place, relit);
        }
        _ => members.0.push(relit),
    }
    members.text()
}

/// Whether a recipe belongs to a picture whose groups of lights were changed.
pub fn is_relit(recipe: &serde_json::Value) -> bool {
    recipe.get("relit").is_some()
}

/// A text as JSON in ASCII.
pub(super) fn ascii(text: &str) -> String {
    let mut json = String::new();
    for c in serde_json::Value::from(text).to_string().chars() {
        if c.is_ascii() {
            json.push(c);
            continue;
        }
        let mut units = [0; 2];
        for unit in c.encode_utf16(&mut units) {
            let _ = write!(json, "\\u{unit:04x}");
        }
    }
    json
}

/// The members of a recipe, one a line.
struct Members(Vec<String>);

impl Members {
    fn of(recipe: &str) -> Self {
        let inside = recipe.strip_prefix("{\n").and_then(|inside| inside.strip_suffix("\n}"));
        Self(inside.unwrap_or_default().split(",\n").map(str::to_owned).collect())
    }

    fn text(&self) -> String {
        format!("{{\n{}\n}}", self.0.join(",\n"))
    }

    fn place(&self, key: &str) -> Option<usize> {
        let start = format!("  \"{key}\": ");
        self.0.iter().position(|member| member.starts_with(&start))
    }

    fn set(&mut self, key: &str, value: &str) {
        if let Some(place) = self.place(key) {
            self.0[place] = format!("  \"{key}\": {value}");
        }
    }

    fn remove(&mut self, key: &str) {
        if let Some(place) = self.place(key) {
            self.0.remove(place);
        }
    }

    fn insert_behind(&mut self, other: &str, key: &str, value: &str) {
        let place = self.place(other).map_or(self.0.len(), |place| place + 1);
        self.0.insert(place, format!("  \"{key}\": {value}"));
    }
}

#[cfg(test)]
mod tests {
    use slo_scene::{Camera, Encoding, Film, Layer, SceneDescription, Settings};

    use super::super::write::Recipe;
    use super::*;

    fn recipe(change: impl FnOnce(&mut Film)) -> String {
        let mut film = Film::default();
        film.encoding = Some(Encoding::Raw);
        change(&mut film);
        let scene = SceneDescription {
            settings: Settings::default(),
            camera: Camera { fps: 25.0, film, segments: Vec::new() },
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            objects: Vec::new(),
            copies: Vec::new(),
            spaces: Vec::new(),
            content_hash: [7; 32],
        };
        Recipe { scene: &scene, frame: 3 }.to_json()
    }

    #[test]
    fn another_look_is_as_if_it_had_been_rendered() {
        let exr = |film: &mut Film| {
            film.output = OutputFormat::Exr;
            film.layers = vec![Layer::Albedo, Layer::Lights];
        };
        let look = Look { exposure: -1.5, tone_map: ToneMap::Agx, encoding: Encoding::Srgb };
        let shown = |film: &mut Film| {
            film.encoding = Some(look.encoding);
            (film.exposure, film.tone_map) = (look.exposure, look.tone_map);
        };
        let png = OutputFormat::Png8;
        assert_eq!(with_look(&recipe(exr), png, look), recipe(shown));
        assert_eq!(with_look(&recipe(shown), png, Look::default()), recipe(|_| {}));
        let same = with_look(&recipe(exr), OutputFormat::Exr, Look::default());
        assert_eq!(same, recipe(exr));
        let outcome = Outcome { samples: 4.5, error: Some(0.25) };
        let rendered = with_outcome(&recipe(exr), &outcome);
        let expected = with_outcome(&recipe(shown), &Outcome { error: None, ..outcome });
        assert_eq!(with_look(&rendered, png, look), expected);
    }

    #[test]
    fn a_relit_picture_is_no_rendered_one() {
        let outcome = Outcome { samples: 4.0, error: None };
        for rendered in [recipe(|_| {}), with_outcome(&recipe(|_| {}), &outcome)] {
            let relit = with_relit(&rendered, "Küche \"1\"=0.5, 💡=1,1,0");
            assert!(relit.is_ascii(), "{relit}");
            let parsed: serde_json::Value = serde_json::from_str(&relit).unwrap();
            assert_eq!(parsed["relit"], "Küche \"1\"=0.5, 💡=1,1,0");
            let rendered: serde_json::Value = serde_json::from_str(&rendered).unwrap();
            assert_eq!(parsed.get("result"), rendered.get("result"));
            assert!(is_relit(&parsed) && !is_relit(&rendered));
            assert_ne!(without_outcome(&relit), recipe(|_| {}));
        }
    }
}
