//! The result of a picture: how clean it is, and what it took.

use rayon::prelude::*;
use slo_accel::Isa;

use crate::film::{Area, Display, Film};

/// How clean a picture is, and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Camera samples per pixel, on average.
    pub samples: f64,
    /// Estimated error as the viewer sees it: root mean square over pixels and channels; 1 is the range
    /// from black to white. `None` if a pixel has fewer than two samples.
    pub error: Option<f64>,
}

impl Outcome {
    /// The outcome of an area of a film.
    pub fn of(film: &Film, area: Area, display: Display, isa: Isa) -> Self {
        let count = area.len().max(1) as f64;
        let samples: u64 = film.pixels_of(area).map(|pixel| u64::from(pixel.samples)).sum();
        // Rows in parallel, added in order: the bits do not depend on threads.
        let row = |y: u32| {
            let row = film.pixels_of(Area { y0: y, y1: y + 1, ..area });
            display.squared_errors(isa, row).iter().sum::<f64>()
        };
        let rows: Vec<f64> = (area.y0..area.y1).into_par_iter().map(row).collect();
        let squares: f64 = rows.into_iter().sum();
        let error = (squares / count).sqrt();
        Self { samples: samples as f64 / count, error: Some(error).filter(|e| e.is_finite()) }
    }
}

/// The recipe with the outcome as its last member, `result`.
pub fn with_outcome(recipe: &str, outcome: &Outcome) -> String {
    let whole = recipe.strip_suffix("\n}").unwrap_or(recipe);
    let error = outcome.error.map_or("null".into(), |error| format!("{error:.2e}"));
    let samples = outcome.samples;
    format!("{whole},\n{RESULT}{{ \"samplesPerPixel\": {samples:.2}, \"error\": {error} }}\n}}")
}

/// The recipe without the outcome.
pub fn without_outcome(recipe: &str) -> String {
    match recipe.rsplit_once(&format!(",\n{RESULT}")) {
        Some((whole, _)) => format!("{whole}\n}}"),
        None => recipe.to_owned(),
    }
}

/// The recipe of a denoised picture, with the denoiser's name. No rendered picture has such a recipe.
pub fn with_denoiser(recipe: &str, denoiser: &str) -> String {
    let denoised = format!(",\n  \"denoised\": \"{denoiser}\"");
    match recipe.rsplit_once(&format!(",\n{RESULT}")) {
        Some((made, outcome)) => format!("{made}{denoised},\n{RESULT}{outcome}"),
        None => format!("{}{denoised}\n}}", recipe.strip_suffix("\n}").unwrap_or(recipe)),
    }
}

/// Whether a recipe belongs to a denoised picture.
pub fn is_denoised(recipe: &serde_json::Value) -> bool {
    recipe.get("denoised").is_some()
}

const RESULT: &str = "  \"result\": ";

#[cfg(test)]
mod tests {
    use slo_scene::{Look, OutputFormat};

    use super::*;
    use crate::film::Fixed;

    fn raw() -> Display {
        Display::of(OutputFormat::Png8, Look::default())
    }

    #[test]
    fn the_outcome_is_the_last_member() {
        let recipe = "{\n  \"frame\": 5\n}";
        let outcome = Outcome { samples: 12.25, error: Some(0.008_123) };
        let full = with_outcome(recipe, &outcome);
        insta::assert_snapshot!(full, @r#"
        {
          "frame": 5,
          "result": { "samplesPerPixel": 12.25, "error": 8.12e-3 }
        }
        "#);
        assert!(serde_json::from_str::<serde_json::Value>(&full).is_ok());
        assert_eq!(without_outcome(&full), recipe);
        assert_eq!(without_outcome(recipe), recipe);
        assert!(with_outcome(recipe, &Outcome { error: None, ..outcome }).contains("null"));
    }

    #[test]
    fn a_denoised_picture_is_no_rendered_one() {
        let recipe = "{\n  \"frame\": 5\n}";
        let outcome = Outcome { samples: 4.0, error: None };
        for rendered in [recipe.to_owned(), with_outcome(recipe, &outcome)] {
            let denoised = with_denoiser(&rendered, "Some Denoiser 1.2.3: albedo");
            let parsed: serde_json::Value = serde_json::from_str(&denoised).unwrap();
            assert_eq!(parsed["denoised"], "Some Denoiser 1.2.3: albedo");
            assert_eq!(parsed["frame"], 5);
            let rendered: serde_json::Value = serde_json::from_str(&rendered).unwrap();
            assert_eq!(parsed.get("result"), rendered.get("result"));
            assert!(is_denoised(&parsed) && !is_denoised(&rendered));
            assert!(without_outcome(&denoised) != recipe);
        }
    }

    #[test]
    fn the_error_is_the_mean_over_the_pixels() {
        let mut film = Film::new(Area::whole(2, 2), false).unwrap();
        for i in 0..4 {
            // Two pixels between 0.4 and 0.6, whose error is 0.1, and two without any.
            for value in if i < 2 { [0.4, 0.6] } else { [0.5, 0.5] } {
                film.at_mut(i).0.add([Fixed::new(value).unwrap(); 3], 1);
            }
        }
        let outcome = Outcome::of(&film, film.area(), raw(), Isa::Portable);
        assert!((outcome.error.unwrap() - 0.1 * 0.5f64.sqrt()).abs() < 1e-6, "{outcome:?}");
        assert_eq!(outcome.samples, 2.0);
        film.at_mut(3).0.samples = 1;
        assert_eq!(Outcome::of(&film, film.area(), raw(), Isa::Portable).error, None);
    }
}
