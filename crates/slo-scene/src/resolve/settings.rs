//! The `settings` element.

use crate::attributes::schema::{Schema, choice, color, number};
use crate::attributes::{Bound, Fields, Found};
use crate::diagnostics::Diagnostic;
use crate::settings::{
    Accelerator, Contrast, Generator, LightSampling, MOST_CAMERA_SAMPLES, Settings, ShadowMode,
};

/// `settings`
pub(super) const SETTINGS: Schema = Schema::new(
    "settings",
    &[
        choice("generatorType"),
        choice("lightSamplingType"),
        choice("contrastType"),
        number("imageSamples"),
        number("imageMinSamples"),
        number("imageContrastLimit"),
        number("dofSamples"),
        number("softShadowSamples"),
        number("diffuseReflectionSamples"),
        number("diffuseRefractionSamples"),
        number("recursion"),
        number("sectionsHorizontal"),
        number("sectionsVertical"),
        number("parallelThreads"),
        number("sectionsPerThread"),
        color("background"),
        number("seed"),
        choice("accelerator"),
        number("spatialSplits"),
        choice("shadow"),
        number("noise"),
        number("transformSamplesPerMs"),
    ],
);

/// Samples of one kind; the product with another kind still fits u32.
const MOST_SAMPLES: u32 = 65_535;
const MOST_BOUNCES: u32 = 1000;
const MOST_SECTIONS: u32 = 65_536;
const MOST_THREADS: u32 = 65_536;

const GENERATORS: [(&str, Generator); 3] =
    [("PSEUDO", Generator::Pseudo), ("QUASI", Generator::Quasi), ("ZERO_TWO", Generator::ZeroTwo)];
const LIGHT_SAMPLINGS: [(&str, LightSampling); 2] =
    [("SAMPLE_ONE_AT_TIME", LightSampling::One), ("SAMPLE_ALL_AT_TIME", LightSampling::All)];
const CONTRASTS: [(&str, Contrast); 3] = [
    ("DIFFERENCE", Contrast::Difference),
    ("WEBER", Contrast::Weber),
    ("MICHELSON", Contrast::Michelson),
];
const SHADOWS: [(&str, ShadowMode); 2] =
    [("OPAQUE", ShadowMode::Opaque), ("TRANSPARENT", ShadowMode::Transparent)];

/// What the element says, and defaults for what it does not.
pub(super) fn settings(fields: &mut Fields<'_, '_, '_>) -> Settings {
    let mut settings = Settings::default();
    choices(fields, &mut settings);
    samples(fields, &mut settings);
    sections(fields, &mut settings);
    let spatial_splits = fields.count("spatialSplits", 0, 1);
    settings.spatial_splits = spatial_splits.is_some_and(|s| s.value == 1);
    set(&mut settings.background, fields.color("background"));
    set(&mut settings.seed, fields.seed("seed"));
    settings.noise = fields.number_f32("noise", Bound::Error);
    if settings.noise.is_some() {
        warn_of_contrast(fields);
    }
    let per_ms = fields.number("transformSamplesPerMs", Bound::Positive);
    set(&mut settings.transform_samples_per_ms, per_ms.map(|f| f.value));
    settings
}

fn set<T>(target: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *target = value;
    }
}

fn choices(fields: &mut Fields<'_, '_, '_>, settings: &mut Settings) {
    set(&mut settings.generator, fields.choice("generatorType", &GENERATORS));
    set(&mut settings.light_sampling, fields.choice("lightSamplingType", &LIGHT_SAMPLINGS));
    set(&mut settings.contrast, fields.choice("contrastType", &CONTRASTS));
    set(&mut settings.accelerator, fields.choice("accelerator", &Accelerator::NAMES));
    set(&mut settings.shadow, fields.choice("shadow", &SHADOWS));
}

fn samples(fields: &mut Fields<'_, '_, '_>, settings: &mut Settings) {
    camera_samples(fields, settings);
    let mut count = |name| fields.count(name, 1, MOST_SAMPLES).map(|f| f.value);
    set(&mut settings.soft_shadow_samples, count("softShadowSamples"));
    set(&mut settings.diffuse_reflection_samples, count("diffuseReflectionSamples"));
    set(&mut settings.diffuse_refraction_samples, count("diffuseRefractionSamples"));
    settings.image_min_samples = min_samples(fields, settings.image_samples);
    set(&mut settings.recursion, fields.count("recursion", 0, MOST_BOUNCES).map(|f| f.value));
    set(
        &mut settings.image_contrast_limit,
        fields.number_f32("imageContrastLimit", Bound::NotNegative),
    );
}

/// `imageSamples` and `dofSamples`, whose product is not more than the film can add up.
fn camera_samples(fields: &mut Fields<'_, '_, '_>, settings: &mut Settings) {
    let [image, dof] =
        ["imageSamples", "dofSamples"].map(|name| fields.count(name, 1, MOST_SAMPLES));
    set(&mut settings.image_samples, image.map(|f| f.value));
    set(&mut settings.dof_samples, dof.map(|f| f.value));
    let all = u64::from(settings.image_samples) * u64::from(settings.dof_samples);
    if all > u64::from(MOST_CAMERA_SAMPLES) {
        let message = "`imageSamples` times `dofSamples` is more than the film can add up";
        let error = Diagnostic::error(message).help(format!("at most {}", MOST_CAMERA_SAMPLES));
        let mut places = [image, dof].into_iter().flatten().map(|Found { span, .. }| span);
        let error = places.next().map_or(error.clone(), |span| {
            error.at(span, format!("{all} samples of a pixel in all"))
        });
        fields.diagnostics.push(places.fold(error, |error, span| error.also(span, "")));
    }
}

/// `imageMinSamples`, at most `image_samples`.
fn min_samples(fields: &mut Fields<'_, '_, '_>, image_samples: u32) -> u32 {
    let Some(min) = fields.count("imageMinSamples", 1, MOST_SAMPLES) else { return image_samples };
    if min.value > image_samples {
        let label = format!("{image_samples} are taken, as many as `imageSamples`");
        fields.diagnostics.push(
            Diagnostic::warning("`imageMinSamples` is more than `imageSamples`")
                .at(min.span, label),
        );
    }
    min.value.min(image_samples)
}

/// Warns of what says nothing where `noise` decides.
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

fn sections(fields: &mut Fields<'_, '_, '_>, settings: &mut Settings) {
    let mut count = |name, most| fields.count(name, 1, most).map(|f| f.value);
    settings.sections_horizontal = count("sectionsHorizontal", MOST_SECTIONS);
    settings.sections_vertical = count("sectionsVertical", MOST_SECTIONS);
    settings.parallel_threads = count("parallelThreads", MOST_THREADS);
    set(&mut settings.sections_per_thread, count("sectionsPerThread", u32::MAX));
}
