//! States in files: sound ones, damaged ones, and ones whose numbers can't be.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use slo_scene::{LightGroups, MaskNames};

use super::file::*;
use crate::film::{
    Area, Features, FirstHitLayers, Fixed, MaskKind, Merger, Place, PlaceLayers, SignedFixed,
    State, Subject, Wide, base_end,
};

/// What a state of a test is about.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Uniform samples, under way.
    Checkpoint,
    /// The same, with none missing in half of the pixels.
    Part,
    /// Samples that stand out count, and so do layers.
    Contrast,
    /// Some of the samples.
    Share,
}

const KINDS: [Kind; 4] = [Kind::Checkpoint, Kind::Part, Kind::Contrast, Kind::Share];

fn recipe(kind: Kind) -> String {
    let (least, layers) = match kind {
        Kind::Contrast => {
            (1, ", \"layers\": [\"albedo\", \"lights\", \"depth\", \"motion\", \"crypto_object\"]")
        }
        _ => (4, ""),
    };
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "{{ \"version\": \"{version}\", \"width\": 20, \"height\": 5, \"imageSamples\": 4, \
         \"imageMinSamples\": {least}, \"dofSamples\": 2, \"contrastType\": \"WEBER\", \
         \"imageContrastLimit\": 0.1, \"output\": \"EXR_IMAGE\", \
         \"encoding\": \"RAW\"{layers} }}"
    )
}

/// Numbers of the samples of a pixel that are there.
fn numbers(kind: Kind, pixel: usize) -> std::ops::Range<u32> {
    match kind {
        Kind::Part => 0..8 * (pixel as u32 % 2),
        Kind::Share => 3..3 + pixel as u32 % 5,
        Kind::Checkpoint | Kind::Contrast => 0..pixel as u32 % 9,
    }
}

fn first_hits(kind: Kind) -> FirstHitLayers {
    if !matches!(kind, Kind::Contrast) {
        return FirstHitLayers::default();
    }
    let places = PlaceLayers { depth: true, motion: true, ..PlaceLayers::default() };
    let objects = Some(MaskNames::new(["ball", "box"]));
    FirstHitLayers { places, objects, ..FirstHitLayers::default() }
}

fn state(kind: Kind) -> State {
    let subject = Subject {
        recipe: recipe(kind),
        area: Area { x0: 8, y0: 0, x1: 16, y1: 5 },
        region: Area { x0: 9, y0: 1, x1: 12, y1: 4 },
        samples: matches!(kind, Kind::Share).then_some(3..7),
        with_spreads: matches!(kind, Kind::Contrast),
        with_features: matches!(kind, Kind::Contrast),
        light_groups: matches!(kind, Kind::Contrast).then(|| LightGroups::new(["key", "rim"])),
        first_hits: first_hits(kind),
    };
    let mut film = subject.film().unwrap();
    for i in 0..subject.area.len() {
        for number in numbers(kind, i) {
            let value = |k: u32| [Fixed::from_units(u64::from(k * number) + i as u64); 3];
            let signed =
                |k: u32| [SignedFixed::from_units(i64::from(k * number) + i as i64 - 20); 3];
            let (pixel, spread) = film.at_mut(i);
            match kind {
                Kind::Share if number < base_end(8) => pixel.add_base(value(7), 1),
                Kind::Share => pixel.add_later(value(7), 1),
                _ => pixel.add(value(7), 1),
            }
            spread.into_iter().for_each(|spread| spread.add(value(7)));
            if let Some(features) = film.features_mut(i) {
                *features += Features { albedo: signed(5), normal: signed(11) };
            }
            film.lights_mut(i).iter_mut().for_each(|light| *light = value(3));
            let (places, hits) = (subject.first_hits.places, film.first_hits_mut());
            let place = Place { depth: number.into(), motion: [-1.0; 4], ..Place::default() };
            places.add(hits.places_mut(i), &place);
            if let Some(ids) = hits.ids_mut(MaskKind::Object, i) {
                ids.add(number % 3, 1).unwrap();
            }
        }
    }
    State { subject, film, is_complete: matches!(kind, Kind::Part) }
}

/// A file with a state, in a folder of its own.
struct Lab {
    folder: tempfile::TempDir,
}

impl Lab {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self) -> std::path::PathBuf {
        self.folder.path().join("state")
    }

    fn bytes_of(&self, state: &State) -> Vec<u8> {
        write_state(&self.path(), state).unwrap();
        std::fs::read(self.path()).unwrap()
    }

    fn read(&self, bytes: &[u8]) -> Result<State, String> {
        std::fs::write(self.path(), bytes).unwrap();
        read_state(&self.path()).map_err(|error| error.to_string())
    }

    /// The same of bytes that get the checksum that they should have.
    fn read_sealed(&self, mut bytes: Vec<u8>) -> Result<State, String> {
        let end = bytes.len() - HASH as usize;
        let hash = blake3::hash(&bytes[..end]);
        bytes[end..].copy_from_slice(hash.as_bytes());
        self.read(&bytes)
    }
}

#[test]
fn what_was_written_is_read() {
    let lab = Lab::new();
    for kind in KINDS {
        let state = state(kind);
        assert_eq!(lab.read(&lab.bytes_of(&state)), Ok(state), "{kind:?}");
    }
}

#[test]
fn every_damage_is_found() {
    let lab = Lab::new();
    let whole = lab.bytes_of(&state(Kind::Contrast));
    // Odd steps, so that all bytes of a number have their turn.
    for length in (0..whole.len()).step_by(3) {
        assert!(lab.read(&whole[..length]).is_err(), "cut off at {length}");
    }
    for at in 0..whole.len() {
        let bit = if at % 2 == 0 { 0 } else { 7 };
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << bit;
        assert!(lab.read(&damaged).is_err(), "bit {bit} of byte {at}");
    }
    assert!(lab.read(&[&whole[..], &[0]].concat()).is_err(), "a byte more");
}

#[test]
fn a_small_file_never_asks_for_much_memory() {
    let lab = Lab::new();
    let huge = recipe(Kind::Checkpoint)
        .replace("\"width\": 20", "\"width\": 65536")
        .replace("\"height\": 5", "\"height\": 65536");
    let mut bytes = lab.bytes_of(&state(Kind::Checkpoint));
    let start = 16 + recipe(Kind::Checkpoint).len();
    bytes.splice(12..start, [&(huge.len() as u32).to_le_bytes()[..], huge.as_bytes()].concat());
    let all: Vec<u8> = [0u32, 0, 65_536, 65_536].into_iter().flat_map(u32::to_le_bytes).collect();
    let start = 16 + huge.len();
    bytes[start..start + 16].copy_from_slice(&all);
    bytes[start + 16..start + 32].copy_from_slice(&all);
    let why = "it is damaged: it is too short for its pixels";
    assert_eq!(lab.read_sealed(bytes).unwrap_err(), why);
    assert_eq!(read_subject(&lab.path()).unwrap_err().to_string(), why);
}

/// Changes to a state that is sound but for them; each has to be refused.
#[test]
fn numbers_that_can_not_be_are_refused() {
    let lab = Lab::new();
    let check = |kind: Kind, why: &str, change: &dyn Fn(&mut State)| {
        let mut state = state(kind);
        change(&mut state);
        let error = lab.read(&lab.bytes_of(&state)).unwrap_err();
        assert!(error.starts_with("it is damaged: ") && error.contains(why), "{kind:?}: {error}");
    };
    let last = |state: &State| state.film.pixels().iter().rposition(|p| p.samples > 2).unwrap();
    let units = |units: u64| [Fixed::from_units(units); 3];
    for kind in KINDS {
        check(kind, "more samples than were asked for", &|s| {
            s.film.at_mut(last(s)).0.samples = 9;
        });
        check(kind, "larger than rendered", &|s| s.film.at_mut(last(s)).0.sum = units(1 << 62));
        check(kind, "larger than rendered", &|s| {
            s.film.at_mut(last(s)).0.sum[2] = Fixed::MAX;
        });
        check(kind, "recipe", &|s| {
            s.subject.recipe = s.subject.recipe.replace("\"dofSamples\": 2, ", "");
        });
        check(kind, "recipe", &|s| {
            s.subject.recipe = s.subject.recipe.replace("\"dofSamples\": 2", "\"dofSamples\": 2.5");
        });
        check(kind, "recipe", &|s| {
            let endless = "\"imageSamples\": 4294967295";
            s.subject.recipe = s.subject.recipe.replace("\"imageSamples\": 4", endless);
        });
        check(kind, "recipe can't be read", &|s| s.subject.recipe = "none".into());
        check(kind, "area", &|s| s.subject.region.x1 = 21);
        check(kind, "area", &|s| s.subject.region.x0 = 3);
        check(kind, "area", &|s| s.subject.area.x1 = u32::MAX);
        check(kind, "does not fit its recipe", &|s| {
            s.subject.recipe = s.subject.recipe.replace("\"width\": 20", "\"width\": 14");
        });
        check(kind, "not what its recipe asks for", &|s| {
            s.subject.with_spreads = !s.subject.with_spreads;
        });
        check(kind, "not what its recipe asks for", &|s| {
            s.subject.with_features = !s.subject.with_features;
        });
        check(kind, "not what its recipe asks for", &|s| {
            let groups = s.subject.light_groups.take();
            s.subject.light_groups = groups.is_none().then(LightGroups::default);
        });
    }
    check(Kind::Share, "not among its recipe", &|s| s.subject.samples = Some(3..9));
    check(Kind::Share, "not among its recipe", &|s| {
        s.subject.samples = Some(std::ops::Range { start: 5, end: 3 });
    });
    check(Kind::Contrast, "not what its recipe asks for", &|s| s.subject.samples = Some(0..4));
    check(Kind::Part, "fewer samples than the others", &|s| {
        s.film.at_mut(last(s)).0.samples = 7;
    });
    check(Kind::Contrast, "do not fit its samples", &|s| {
        s.film.at_mut(last(s)).0.sum = units(1 << 30);
    });
    check(Kind::Contrast, "do not fit its samples", &|s| {
        s.film.at_mut(last(s)).1.unwrap().most = units(1);
    });
    check(Kind::Contrast, "ids do not fit its samples", &|s| {
        let place = last(s);
        s.film.first_hits_mut().ids_mut(MaskKind::Object, place).unwrap().add(9, 8).unwrap();
    });
    check(Kind::Contrast, "larger than rendered", &|s| {
        let place = last(s);
        s.film.first_hits_mut().places_mut(place)[1] = Wide::from_units(i128::MIN);
    });
    check(Kind::Contrast, "not what its recipe asks for", &|s| {
        s.subject.first_hits.places.motion = false;
    });
    check(Kind::Contrast, "not what its recipe asks for", &|s| s.subject.first_hits.objects = None);
    check(Kind::Share, "contradict each other", &|s| {
        // The first samples of all are in the base, and this pixel has one.
        let one = s.film.pixels().iter().position(|pixel| pixel.samples == 1).unwrap();
        s.film.at_mut(one).0.base = units(1);
    });
}

/// Numbers anywhere in a file, with the right checksum: what is taken can be used.
#[test]
fn whatever_is_taken_can_be() {
    const NUMBERS: [u64; 10] =
        [0, 1, 2, 9, 255, 65_536, 1 << 31, 1 << 62, u64::MAX, i64::MAX as u64];
    let lab = Lab::new();
    let mut rng = StdRng::seed_from_u64(7);
    let (mut taken, mut refused) = (0, 0);
    let whole = KINDS.map(|kind| lab.bytes_of(&state(kind)));
    for round in 0..4000 {
        let mut bytes = whole[round % whole.len()].clone();
        for _ in 0..rng.random_range(1..4) {
            let width = [1, 4, 8][rng.random_range(0..3)];
            let at = rng.random_range(0..bytes.len() - HASH as usize - width);
            let number = match rng.random_range(0..3) {
                0 => rng.random(),
                _ => NUMBERS[rng.random_range(0..NUMBERS.len())],
            };
            bytes[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
        }
        match lab.read_sealed(bytes) {
            Err(_) => refused += 1,
            Ok(state) => {
                taken += 1;
                check_use(&state);
            }
        }
    }
    assert!(taken > 100 && refused > 1000, "{taken} {refused}");
}

/// What is done with states: nothing overflows.
fn check_use(state: &State) {
    let Subject { area, region, .. } = state.subject;
    assert!(area.holds(&region) && state.film.area() == area);
    assert!(state.film.pixels().iter().all(|pixel| pixel.samples < 1 << 22));
    let image = state.film.image_of(region);
    assert!(image.rgb.as_flattened().iter().all(|value| value.is_finite()));
    let mut merger = Merger::new(&state.subject, 8).unwrap();
    let _ = merger.add(0, state).map(|()| merger.finish());
    let mut film = state.film.clone();
    for i in 0..area.len() {
        // Another part with the brightest samples there can be.
        let brightest = [Fixed::new(Fixed::LIMIT).unwrap(); 3];
        film.at_mut(i).0.add(brightest, 1);
    }
}
