//! One mistake gives one message, or few: what follows from it is left out.

use slo_scene::{Files, load};

const EVERYTHING: &str = include_str!("../scenes/everything.txt");
const SCENES: [&str; 2] = [EVERYTHING, include_str!("../scenes/materials.txt")];
const FILES: &[(&str, &[u8])] = &[
    ("files/plank.png", include_bytes!("../scenes/files/plank.png")),
    ("files/row.ply", include_bytes!("../scenes/files/row.ply")),
];

/// How many errors a scene has if the bytes `start..end` are replaced, and the report.
fn errors(scene: &str, start: usize, end: usize, replacement: &str) -> (usize, String) {
    let text = format!("{}{replacement}{}", &scene[..start], &scene[end..]);
    let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
    (loaded.diagnostics.error_count(), loaded.diagnostics.render(false))
}

/// Makes a mistake at each place of a scene. No place may give more than 3 errors, and all together not more
/// than 1.5 each.
fn check(scene: &str, places: &[(usize, usize)], replacement: &str) {
    let mut sum = 0;
    for (start, end) in places {
        let (count, report) = errors(scene, *start, *end, replacement);
        assert!(count <= 3, "{:?} at {start} as {replacement:?}:\n{report}", &scene[*start..*end]);
        sum += count;
    }
    let mean = sum as f64 / places.len() as f64;
    assert!((0.8..=1.5).contains(&mean), "{mean} errors for one mistake");
}

fn places_of(scene: &str, brace: char) -> Vec<(usize, usize)> {
    scene.match_indices(brace).map(|(i, _)| (i, i + 1)).collect()
}

fn words(scene: &str) -> Vec<(usize, usize)> {
    let first = scene.find('\n').unwrap_or(0); // behind the comment
    let is_end = |c: char| c.is_whitespace() || c == '{' || c == '}';
    let mut words = Vec::new();
    let mut start = None;
    for (i, c) in scene.char_indices().filter(|(i, _)| *i >= first) {
        match start {
            None if !is_end(c) => start = Some(i),
            Some(from) if is_end(c) => {
                words.push((from, i));
                start = None;
            }
            _ => {}
        }
    }
    words
}

/// Makes a mistake at each place of a brace: it gives one error.
fn check_braces(brace: char, replacement: &str) {
    for scene in SCENES {
        for (start, end) in places_of(scene, brace) {
            let (count, report) = errors(scene, start, end, replacement);
            assert_eq!(count, 1, "{brace} at {start} as {replacement:?}:\n{report}");
        }
    }
}

#[test]
fn a_brace_is_missing() {
    check_braces('{', "");
    check_braces('}', "");
}

#[test]
fn a_brace_is_doubled() {
    check_braces('{', "{ {");
    check_braces('}', "} }");
}

#[test]
fn a_brace_is_the_other() {
    check_braces('{', "}");
    check_braces('}', "{");
}

#[test]
fn a_brace_is_another() {
    for bracket in ["(", "["] {
        check_braces('{', bracket);
    }
    for bracket in [")", "]"] {
        check_braces('}', bracket);
    }
}

#[test]
fn all_braces_of_an_element_are_others() {
    let scene = EVERYTHING;
    let end = scene.find("\nplane").expect("there is a plane") + 1;
    let after = scene[end..].find('\n').expect("it has a line") + end;
    let line = scene[end..after].replace('{', "(").replace('}', ")");
    let (count, report) = errors(scene, end, after, &line);
    assert_eq!(count, 3, "{report}");
    let (count, report) = errors(scene, end, after, &line.replace(" ( ", "(").replace(" )", ")"));
    assert_eq!(count, 3, "{report}");
}

#[test]
fn a_word_is_missing() {
    SCENES.iter().for_each(|scene| check(scene, &words(scene), ""));
}

#[test]
fn a_word_is_wrong() {
    for scene in SCENES {
        check(scene, &words(scene), "xyzzy");
        check(scene, &words(scene), "7,5");
    }
}
