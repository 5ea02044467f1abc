//! The `settings` element, and elements that are lists of settings as it is.

use crate::attributes::Fields;
use crate::attributes::schema::{Attribute, Schema, attributes};
use crate::diagnostics::Diagnostic;
use crate::settings::{Entries, Form, MOST_CAMERA_SAMPLES, Settings, Value};

const ATTRIBUTES: [Attribute; Settings::ENTRIES.len()] = attributes(Settings::ENTRIES);

/// `settings`
pub(super) const SETTINGS: Schema = Schema::new("settings", &ATTRIBUTES);

/// Sets all that an element says; the names of what it says without a mistake.
pub(super) fn read<S: Entries>(fields: &mut Fields<'_, '_, '_>, to: &mut S) -> Vec<&'static str> {
    let mut known = Vec::new();
    for entry in S::ENTRIES {
        let value = value(fields, entry.name, entry.form);
        if value.is_some_and(|value| entry.set(to, value)) {
            known.push(entry.name);
        }
    }
    known
}

fn value(fields: &mut Fields<'_, '_, '_>, name: &str, form: Form) -> Option<Value> {
    Some(match form {
        Form::Flag => Value::Flag(fields.count(name, 0, 1)?.value == 1),
        Form::Count(least, most) => Value::Count(fields.count(name, least, most)?.value),
        Form::Whole => Value::Whole(fields.seed(name)?),
        Form::Single(bound) => Value::Single(fields.number_f32(name, bound)?),
        Form::Double(bound) => Value::Double(fields.number(name, bound)?.value),
        Form::Color => Value::Color(fields.color(name)?),
        Form::Word(words) => Value::Word(fields.choice(name, words)?),
        Form::Text(_) => Value::Text(fields.word(name)?.text.to_owned()),
    })
}

/// What the element says, and defaults for what it does not.
pub(super) fn settings(fields: &mut Fields<'_, '_, '_>) -> Settings {
    let mut settings = Settings::default();
    let known = read(fields, &mut settings);
    check_camera_samples(fields, &settings);
    if known.contains(&"imageMinSamples") {
        settings.image_min_samples = min_samples(fields, &settings);
    } else {
        settings.image_min_samples = settings.image_samples;
    }
    if settings.noise.is_some() {
        warn_of_contrast(fields);
    }
    settings
}

/// `imageSamples` times `dofSamples` is not more than the film can add up.
fn check_camera_samples(fields: &mut Fields<'_, '_, '_>, settings: &Settings) {
    let all = settings.camera_samples();
    if all <= u64::from(MOST_CAMERA_SAMPLES) {
        return;
    }
    let message = "`imageSamples` times `dofSamples` is more than the film can add up";
    let error = Diagnostic::error(message).help(format!("at most {MOST_CAMERA_SAMPLES}"));
    let places = ["imageSamples", "dofSamples"].into_iter().filter_map(|name| fields.word(name));
    let mut places = places.map(|word| word.span);
    let error = match places.next() {
        Some(span) => error.at(span, format!("{all} samples of a pixel in all")),
        None => error,
    };
    let error = places.fold(error, |error, span| error.also(span, ""));
    fields.diagnostics.push(error);
}

/// `imageMinSamples`, at most `imageSamples`.
fn min_samples(fields: &mut Fields<'_, '_, '_>, settings: &Settings) -> u32 {
    let Settings { image_samples: most, image_min_samples: least, .. } = *settings;
    if let Some(word) = fields.word("imageMinSamples").filter(|_| least > most) {
        let label = format!("{most} are taken, as many as `imageSamples`");
        fields.diagnostics.push(
            Diagnostic::warning("`imageMinSamples` is more than `imageSamples`")
                .at(word.span, label),
        );
    }
    least.min(most)
}

/// Warns of settings without effect where `noise` decides.
fn warn_of_contrast(fields: &mut Fields<'_, '_, '_>) {
    let noise = fields.get("noise").map(|field| field.keyword.span);
    for name in ["contrastType", "imageContrastLimit"] {
        if let (Some(noise), Some(field)) = (noise, fields.get(name)) {
            let message = format!("`{name}` does nothing beside `noise`");
            let warning = Diagnostic::warning(message).at(field.keyword.span, "");
            fields.diagnostics.push(warning.also(noise, "this decides"));
        }
    }
}

/// What only `PHOTON_MAP` looks at.
pub(super) const OF_PHOTON_MAP: [&str; 12] = [
    "photonMapSize",
    "causticMapSize",
    "photonNearest",
    "photonDistance",
    "causticNearest",
    "causticDistance",
    "causticFilter",
    "gather",
    "gatherRays",
    "gatherLimit",
    "cacheError",
    "cacheInFront",
];
