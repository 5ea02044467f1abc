//! No text makes the scene loader panic, overflow the stack or take forever.

use rand::rngs::StdRng;
use rand::{Rng, RngExt, SeedableRng};
use slo_scene::{Files, Loaded, load};

const SCENES: [&str; 5] = [
    include_str!("../scenes/materials.txt"),
    include_str!("../scenes/meshes.txt"),
    include_str!("../scenes/everything.txt"),
    include_str!("../scenes/minimal.txt"),
    include_str!("../scenes/errors/a_hundred_errors.txt"),
];

const FILES: &[(&str, &[u8])] = &[
    ("files/plank.png", include_bytes!("../scenes/files/plank.png")),
    ("files/row.ply", include_bytes!("../scenes/files/row.ply")),
];

/// Pieces that mean something to the parser.
const PIECES: [&str; 24] = [
    "{",
    "}",
    "{}",
    "/*",
    "*/",
    "#",
    "\n",
    " ",
    "\r\n",
    "\u{feff}",
    "\0",
    "-",
    "1e999",
    "0,5",
    "Camera",
    "Film c {",
    "sphere s {",
    "center {",
    "addKframe",
    "time 1",
    "Scaling",
    "nan",
    "é",
    "\u{a0}",
];

fn load_and_render(text: &[u8]) -> Loaded {
    let loaded = load("fuzz.txt", text, &Files::built_in("", FILES));
    assert_eq!(loaded.scene.is_none(), loaded.diagnostics.has_errors());
    let plain = loaded.diagnostics.render(false);
    assert!(!plain.contains('\u{1b}'), "no escape of the text reaches the terminal");
    assert_eq!(plain.is_empty(), loaded.diagnostics.render(true).is_empty());
    loaded
}

fn mutate(text: &mut Vec<u8>, rng: &mut StdRng) {
    let at = rng.random_range(0..=text.len());
    let end = (at + rng.random_range(0..40)).min(text.len());
    let piece = PIECES[rng.random_range(0..PIECES.len())].as_bytes();
    match rng.random_range(0..7) {
        0 => drop(text.drain(at..end)),
        1 => drop(text.splice(at..at, piece.iter().copied())),
        2 => drop(text.splice(at..end, piece.iter().copied())),
        3 => text.truncate(at),
        4 => text.insert(at, rng.random()),
        5 => drop(text.splice(at..at, text[at..end].to_vec())),
        _ => text[at..end].reverse(),
    }
}

#[test]
fn mutated_scenes() {
    let mut rng = StdRng::seed_from_u64(2011);
    let mut refused = 0;
    for i in 0..1500 {
        let mut text = SCENES[i % SCENES.len()].as_bytes().to_vec();
        for _ in 0..rng.random_range(1..8) {
            mutate(&mut text, &mut rng);
        }
        refused += usize::from(load_and_render(&text).scene.is_none());
    }
    assert!(refused > 1000, "most mutations are errors, {refused} were");
}

#[test]
fn random_bytes() {
    let mut rng = StdRng::seed_from_u64(32);
    for length in 0..300 {
        let mut text = vec![0; length];
        rng.fill_bytes(&mut text);
        load_and_render(&text);
        text.iter_mut().for_each(|byte| *byte = b"{}ab1. \n#/*"[usize::from(*byte) % 11]);
        load_and_render(&text);
    }
}

#[test]
fn long_and_deep_texts() {
    for piece in [
        "{",
        "}",
        "{}",
        "a{",
        "a b{",
        "a",
        "a ",
        "1 ",
        "a b ",
        "1,",
        "é",
        "#",
        "/*",
        "/**/",
        "Camera c{",
    ] {
        let text = piece.repeat(100_000 / piece.len());
        load_and_render(text.as_bytes());
        load_and_render(format!("sphere s {{ center {{ {text}").as_bytes());
    }
}

#[test]
fn names_cannot_speak_to_the_terminal() {
    let loaded = load_and_render(
        "sphere \u{1b}[31mred { \u{1b}]0;title { 1 } material \u{1b}c }".as_bytes(),
    );
    assert!(loaded.diagnostics.error_count() > 2);
}
