//! What a recipe says.

use serde_json::{Map, Value as Json};
use slo_scene::settings::{Effect, Entries, Entry, Form, Value};
use slo_scene::{Film, Layer, Look, OutputFormat, Settings};

use crate::film::Steps;

/// The members of a recipe.
pub(in crate::output) type Members = Map<String, Json>;

/// The members of a recipe; `None` if the text is no recipe.
pub(in crate::output) fn members(recipe: &str) -> Option<Members> {
    serde_json::from_str(recipe).ok()
}

/// Sets the settings with certain effects as a recipe has them. `None` if a value can't be, or is
/// missing.
pub(in crate::output) fn restore_settings<S: Entries>(
    of: &mut S,
    effects: &[Effect],
    recipe: &Members,
) -> Option<()> {
    slo_scene::settings::restore(of, effects, |entry: &Entry<S>| {
        recipe.get(entry.name).map(|json| value(entry.form, json).ok_or(())).transpose()
    })
}

/// A value of a recipe in the form that a setting takes; whether the setting takes it is left open.
fn value(form: Form, json: &Json) -> Option<Value> {
    let single = |json: &Json| json.as_f64().map(|number| number as f32);
    Some(match form {
        Form::Flag => Value::Flag(match json.as_u64()? {
            0 => false,
            1 => true,
            _ => return None,
        }),
        Form::Count(..) => Value::Count(u32::try_from(json.as_u64()?).ok()?),
        Form::Whole => Value::Whole(json.as_u64()?),
        Form::Single(_) => Value::Single(single(json)?),
        Form::Double(_) => Value::Double(json.as_f64()?),
        Form::Color => match &json.as_array()?[..] {
            [r, g, b] => Value::Color([single(r)?, single(g)?, single(b)?]),
            _ => return None,
        },
        Form::Word(words) => Value::Word(words.iter().find(|word| json.as_str() == Some(word))?),
        Form::Text(_) => Value::Text(json.as_str()?.to_owned()),
    })
}

/// The steps that a recipe names; `None` if it names none.
pub fn steps_of(recipe: &Json) -> Option<Steps> {
    let number = |i: usize| u32::try_from(recipe.get("steps")?.get(i)?.as_u64()?).ok();
    Some(Steps { done: number(0)?, tiles: number(1)? })
}

/// The file format and the look that a recipe asks for; `None` if it names none.
pub fn settings_of(recipe: &Json) -> Option<(OutputFormat, Look)> {
    let mut film = Film::default();
    restore_settings(&mut film, &[Effect::Display], recipe.as_object()?)?;
    // Recipes name the encoding, so it does not depend on settings.
    Some((film.output, film.look(&Settings::default())))
}

/// The layers that a recipe asks for, in its order; `None` if it names an unknown one.
pub fn layers_of(recipe: &Json) -> Option<Vec<Layer>> {
    match recipe.get("layers") {
        None => Some(Vec::new()),
        Some(names) => {
            names.as_array()?.iter().map(|name| Layer::by_name(name.as_str()?)).collect()
        }
    }
}
