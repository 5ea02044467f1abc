//! The examples of docs/scene-format.md are scenes as they stand.

use std::collections::BTreeSet;

use slo_scene::{Files, load};

const PAGE: &str = include_str!("../../../../docs/scene-format.md");

/// All images of the examples.
const IMAGES: &[(&str, &[u8])] = &[
    ("planks.png", IMAGE),
    ("planks_orm.png", IMAGE),
    ("planks_normal.png", IMAGE),
    ("stains.png", IMAGE),
];
const IMAGE: &[u8] = include_bytes!("../scenes/files/plank.png");

/// The indented blocks of a section of the page.
fn examples(heading: &str) -> Vec<String> {
    let start = PAGE.find(&format!("\n{heading}\n")).expect("the page has the section");
    let section = &PAGE[start + 1 + heading.len()..];
    let level = heading.split(' ').next().expect("a heading begins with #");
    let end = section.find(&format!("\n{level} ")).unwrap_or(section.len());
    let mut blocks = vec![String::new()];
    for line in section[..end].lines() {
        match line.strip_prefix("    ") {
            Some(code) => blocks.last_mut().expect("there is one").push_str(&format!("{code}\n")),
            None if line.is_empty() => {}
            None => blocks.push(String::new()),
        }
    }
    blocks.retain(|block| !block.is_empty());
    blocks
}

#[test]
fn examples_of_materials_are_correct() {
    let mut kinds = BTreeSet::new();
    // Where names stand in capitals, an example shows a form.
    for example in examples("## Materials") {
        if example.contains("REF") {
            continue;
        }
        let mut text = format!("{}\n{example}", include_str!("../scenes/minimal.txt"));
        let elements = example.lines().filter(|line| line.starts_with("material_"));
        for (i, element) in elements.enumerate() {
            let mut words = element.split_whitespace();
            kinds.extend(words.next());
            let name = words.next().expect("materials have names");
            text.push_str(&format!(
                "sphere s{i} {{ center {{ {i} 9 0 }} radius .1 material {name} }}\n"
            ));
        }
        let loaded = load("example.txt", &text, &Files::built_in("", IMAGES));
        assert_eq!(loaded.diagnostics.render(false), "", "{example}");
    }
    let expected = ["material_mix", "material_phong", "material_principled"];
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), expected);
}
