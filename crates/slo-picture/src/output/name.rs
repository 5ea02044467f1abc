//! Names of pictures.

use std::time::Duration;

use slo_scene::{Film, LightSampling, Settings};

/// What `--info` adds to the name of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Info<'a> {
    /// The settings that the picture was rendered with.
    pub settings: &'a Settings,
    /// The fewest camera samples that a pixel takes.
    pub least: u32,
    /// How long the rendering took.
    pub time: Duration,
}

/// The file name of a frame: prefix, frame as 5 digits (after a minus sign if negative), the fields of
/// `info`, extension.
///
/// Fields are `_key=value`, always the same in the same order; no value contains `_` or `=`.
pub fn file_name(film: &Film, frame: i64, info: Option<Info>) -> String {
    let sign = if frame < 0 { "-" } else { "" };
    let fields = info.map_or_else(String::new, |info| fields(film, &info));
    format!("{}{sign}{:05}{fields}.{}", film.prefix, frame.unsigned_abs(), film.output.extension())
}

fn fields(film: &Film, info: &Info) -> String {
    let settings = info.settings;
    let fields = [
        ("size", format!("{}x{}", film.width, film.height)),
        ("samples", settings.image_samples.to_string()),
        ("min", info.least.div_ceil(settings.dof_samples.max(1)).to_string()),
        ("contrast", word(settings.contrast.name())),
        ("limit", settings.image_contrast_limit.to_string()),
        ("noise", settings.noise.map_or_else(|| "none".into(), |noise| noise.to_string())),
        ("dof", settings.dof_samples.to_string()),
        ("shadow", settings.soft_shadow_samples.to_string()),
        ("reflection", settings.diffuse_reflection_samples.to_string()),
        ("refraction", settings.diffuse_refraction_samples.to_string()),
        ("recursion", settings.recursion().to_string()),
        ("generator", word(settings.generator.name())),
        ("lights", lights(settings.light_sampling()).into()),
        ("seed", settings.seed.to_string()),
        ("time", format!("{:.2}", info.time.as_secs_f64())),
    ];
    fields.iter().map(|(key, value)| format!("_{key}={value}")).collect()
}

/// A word of the scene language without the separators of fields.
fn word(keyword: &str) -> String {
    keyword.replace('_', "-").to_ascii_lowercase()
}

fn lights(sampling: LightSampling) -> &'static str {
    match sampling {
        LightSampling::One => "one",
        LightSampling::All => "all",
    }
}

/// Whether `prefix` can stand in front of a file name and stay in the output folder.
///
/// # Errors
/// A path separator or a control character, in words for the user.
pub fn check_prefix(prefix: &str) -> Result<(), String> {
    match prefix.chars().find(|&c| c == '/' || c == '\\' || c.is_control()) {
        Some(c @ ('/' | '\\')) => Err(format!(
            "a prefix is the beginning of a file name and can't hold `{c}`; --outdir names the folder"
        )),
        Some(_) => Err("a prefix can't hold control characters".into()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::{Generator, OutputFormat};

    fn film(output: OutputFormat) -> Film {
        let mut film = Film::default();
        (film.width, film.height, film.output) = (320, 240, output);
        film.prefix = "šach_".into();
        film
    }

    fn check(frame: i64, output: OutputFormat, expected: &str) {
        assert_eq!(file_name(&film(output), frame, None), expected);
    }

    #[test]
    fn frames_sort_as_text() {
        check(0, OutputFormat::Png8, "šach_00000.png");
        check(42, OutputFormat::Png16, "šach_00042.png");
        check(-5, OutputFormat::Exr, "šach_-00005.exr");
        check(123_456, OutputFormat::Png8, "šach_123456.png");
        check(i64::MIN, OutputFormat::Png8, "šach_-9223372036854775808.png");
    }

    #[test]
    fn info_can_be_split() {
        let mut settings = Settings::default();
        settings.generator = Generator::ZeroTwo;
        settings.image_contrast_limit = 1e-7;
        settings.seed = u64::MAX;
        let time = Duration::from_millis(83_456);
        let info = Info { settings: &settings, least: 16, time };
        let name = file_name(&film(OutputFormat::Png8), 7, Some(info));
        insta::assert_snapshot!(name, @"šach_00007_size=320x240_samples=16_min=16_contrast=difference_limit=0.0000001_noise=none_dof=1_shadow=1_reflection=1_refraction=1_recursion=3_generator=zero-two_lights=all_seed=18446744073709551615_time=83.46.png");
        let mut noisy = settings.clone();
        (noisy.noise, noisy.dof_samples) = (Some(0.05), 3);
        let noisy = file_name(
            &film(OutputFormat::Png8),
            7,
            Some(Info { settings: &noisy, least: 8, time }),
        );
        assert!(noisy.contains("_min=3_") && noisy.contains("_noise=0.05_"), "{noisy}");
        let stem = name.strip_prefix("šach_00007_").unwrap().strip_suffix(".png").unwrap();
        assert!(stem.split('_').all(|field| field.split('=').count() == 2), "{stem}");
    }

    #[test]
    fn prefixes_stay_in_their_folder() {
        assert_eq!(check_prefix("šach 2_"), Ok(()));
        assert_eq!(check_prefix(""), Ok(()));
        assert_eq!(check_prefix(".."), Ok(()));
        for bad in ["../x", "a/b", "a\\b", "a\0b", "a\nb"] {
            assert!(check_prefix(bad).is_err(), "{bad:?}");
        }
    }
}
