//! Settings of a scene and of its film: one list each.
//!
//! [`Settings`] and [`Film`] are written as lists of [`Entry`]s. An entry holds all that the program
//! knows of a setting: its name in the language, its default, its values, what of a picture depends
//! on it. The reader of scenes, the recipe inside pictures (written and read back) and the
//! comparison of recipes go through these lists.

mod choice;
mod entry;
mod film;
mod format;
mod list;
mod value;
mod words;

pub use choice::Choice;
pub use entry::{Effect, Entries, Entry, invalid, recorded, restore};
pub use film::{Film, Look, MOST_PIXELS};
pub use format::{FileValues, OutputFormat};
pub use list::{MOST_CAMERA_SAMPLES, Settings};
pub use value::{Bound, Form, Value};
pub use words::{
    Accelerator, Axes, CausticFilter, Contrast, Curve, Encoding, Filter, Generator, Integrator,
    Layer, LightSampling, PhotonSeed, Repeat, ShadowMode, ToneMap, Wrap,
};

#[cfg(test)]
mod tests {
    use super::*;

    fn check<S: Entries>() {
        let mut defaults = S::default();
        for (i, entry) in S::ENTRIES.iter().enumerate() {
            assert!(S::ENTRIES[..i].iter().all(|other| other.name != entry.name), "{}", entry.name);
            let value = entry.get(&defaults);
            if value != Value::Absent {
                assert!(entry.set(&mut defaults, value.clone()), "{} takes {value:?}", entry.name);
                assert_eq!(entry.get(&defaults), value, "{}", entry.name);
            }
            assert!(!entry.set(&mut defaults, Value::Absent), "{}", entry.name);
        }
    }

    #[test]
    fn settings_have_names_of_their_own_and_take_their_defaults() {
        check::<Settings>();
        check::<Film>();
    }

    #[test]
    fn paths_are_shown_on_a_screen() {
        let mut film = Film::default();
        let encoding = |film: &Film, integrator| {
            film.look(&Settings { integrator, ..Settings::default() }).encoding
        };
        assert_eq!(encoding(&film, Integrator::Distributed), Encoding::Raw);
        assert_eq!(encoding(&film, Integrator::Path), Encoding::Srgb);
        film.encoding = Some(Encoding::Raw);
        assert_eq!(encoding(&film, Integrator::Path), Encoding::Raw);
    }

    #[test]
    fn values_that_cannot_be_change_nothing() {
        let mut settings = Settings::default();
        for (name, bad) in [
            ("imageSamples", Value::Count(0)),
            ("imageSamples", Value::Single(4.0)),
            ("noise", Value::Single(1.5)),
            ("noise", Value::Single(f32::NAN)),
            ("transformSamplesPerMs", Value::Double(0.0)),
            ("background", Value::Color([0.0, -1.0, 0.0])),
            ("shadow", Value::Word("QUASI")),
        ] {
            let entry = Settings::ENTRIES.iter().find(|entry| entry.name == name).unwrap();
            assert!(!entry.set(&mut settings, bad), "{name}");
        }
        assert_eq!(settings, Settings::default());
    }

    /// What a recipe holds, as text.
    fn names(settings: &Settings) -> Vec<&'static str> {
        recorded(settings).into_iter().map(|(name, _)| name).collect()
    }

    #[test]
    fn recipes_hold_what_the_picture_depends_on() {
        let mut settings = Settings::default();
        let whole = names(&settings);
        assert_eq!((whole[0], whole.len()), ("seed", 15));
        settings.parallel_threads = Some(3);
        settings.accelerator = Accelerator::KdTree;
        assert_eq!(names(&settings), whole);
        settings.accelerator = Accelerator::Cwbvh;
        settings.noise = Some(0.5);
        let more = names(&settings);
        assert_eq!((more.len(), more.last()), (17, Some(&"accelerator")));
    }

    #[test]
    fn what_a_recipe_leaves_out_is_as_if_it_stood_there() {
        let all = [Effect::Nothing, Effect::Samples, Effect::Count, Effect::Display];
        let back = |settings: &Settings, others: &Settings| {
            let values = recorded(settings);
            let mut restored = others.clone();
            let find = |entry: &Entry<Settings>| {
                let value = values.iter().find(|(name, _)| *name == entry.name);
                Ok(value.map(|(_, value)| value.clone()))
            };
            restore(&mut restored, &all, find).map(|()| restored)
        };
        let plain = Settings { parallel_threads: Some(3), ..Settings::default() };
        let special = Settings {
            noise: Some(0.25),
            accelerator: Accelerator::Cwbvh,
            seed: u64::MAX,
            ..Settings::default()
        };
        let expected = Settings { parallel_threads: Some(3), ..special.clone() };
        assert_eq!(back(&special, &plain), Some(expected));
        assert_eq!(back(&plain, &special), Some(Settings::default()));
        let other = Settings { accelerator: Accelerator::KdTree, ..Settings::default() };
        assert_eq!(back(&plain, &other), Some(other));
        let nothing = restore(&mut plain.clone(), &all, |_| Ok(None));
        assert_eq!(nothing, None, "most settings stand in every recipe");
    }
}
