//! Materials: what they say, and the examples of their documentation.

use std::collections::BTreeSet;
use std::sync::Arc;

use slo_scene::material::{MOST_MIXES, inside_out};
use slo_scene::{Channel, Curve, Files, ImageUse, Loaded, MaterialId, MaterialKind, load};

use super::messages::{load_fixture, mesh};

#[test]
fn everything_of_materials() {
    let loaded = load_fixture("materials.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    let mut scene = loaded.scene.expect("there are no errors");
    assert_eq!(scene.check(), Ok(()));
    scene.textures.clear();
    insta::assert_snapshot!("materials", format!("{:#?}", scene.materials));
}

#[test]
fn meshes_whose_normals_an_image_bends_have_tangents() {
    const FILES: &[(&str, &[u8])] = &[
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 0 1\nvt -1 0\nf 1/1 2/2 3/3\n"),
        ("plank.png", include_bytes!("../scenes/files/plank.png")),
    ];
    let text = format!(
        "{}\ntexture t {{ filename plank.png }}\n\
         mesh plain {{ filename a.obj material shiny }}\n\
         mesh bent {{ filename a.obj material mix addKframe {{ time 0 key {{ pivot {{ 0 0 5 }} }} }} }}\n\
         mesh smooth {{ filename a.obj material shiny smooth_normals 1 addKframe {{ time 0 key {{ pivot {{ 0 0 9 }} }} }} }}\n\
         material_mix mix {{ first shiny second bumpy }}\n\
         material_principled shiny {{ roughness_texture t }}\n\
         material_principled bumpy {{ normal_texture t }}\n",
        include_str!("../scenes/minimal.txt")
    );
    let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("there are no errors");
    let [plain, bent, smooth] = ["plain", "bent", "smooth"].map(|name| mesh(&scene, name));
    assert!(Arc::ptr_eq(plain, bent), "the mesh is there once");
    assert!(smooth.tangents.is_empty());
    let tangents = bent.tangents.as_flattened().iter().map(|tangent| tangent.unpacked());
    assert_eq!(tangents.collect::<Vec<_>>(), [[0.0, -1.0, 0.0, 1.0]; 3]);
}

#[test]
fn the_use_and_the_file_decide_how_an_image_is_read() {
    const FILES: &[(&str, &[u8])] = &[
        ("clear.png", include_bytes!("../scenes/files/clear.png")),
        ("plank.png", include_bytes!("../scenes/files/plank.png")),
    ];
    let text = format!(
        "{}\ntexture clear {{ filename clear.png }}\ntexture opaque {{ filename plank.png }}\n\
         texture raw {{ filename plank.png encoding RAW }}\n\
         texture srgb {{ filename plank.png encoding SRGB }}\n\
         material_principled m {{ base_color_texture opaque alpha_texture clear\n\
             specular_tint_texture raw metallic_texture srgb normal_texture opaque }}\n\
         material_principled n {{ alpha_texture opaque coat_texture {{ texture clear channel A }} }}\n\
         sphere a {{ center {{ 0 0 5 }} radius 1 material m }}\n\
         sphere b {{ center {{ 5 0 0 }} radius 1 material n }}\n",
        include_str!("../scenes/minimal.txt")
    );
    let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("there are no errors");
    let [_, m, n] = &scene.materials[..] else { panic!("there are three") };
    let (MaterialKind::Principled(m), MaterialKind::Principled(n)) = (&m.kind, &n.kind) else {
        panic!("they are physical");
    };
    let read = |image: Option<ImageUse>| image.map(|image| (image.channel, image.encoding));
    assert_eq!(read(m.base_color.image), Some((Channel::Color, Curve::Srgb)));
    assert_eq!(read(m.alpha.image), Some((Channel::Alpha, Curve::Raw)));
    assert_eq!(read(m.specular_tint.image), Some((Channel::Color, Curve::Raw)));
    assert_eq!(read(m.metallic.image), Some((Channel::Luminance, Curve::Srgb)));
    assert_eq!(read(m.normal), Some((Channel::Color, Curve::Raw)));
    assert_eq!(read(n.alpha.image), Some((Channel::Luminance, Curve::Raw)));
    assert_eq!(read(n.coat.image), Some((Channel::Alpha, Curve::Raw)));
    assert_eq!((m.metallic.value, m.base_color.value), (1.0, [1.0; 3]));
}

/// A scene of so many mixes, each of which holds the one before twice.
fn tower(mixes: usize) -> Loaded {
    let mut text = format!(
        "{}\nmaterial_principled m0 {{ emission_strength 1 }}\n\
         sphere s {{ center {{ 9 9 9 }} radius 1 material m{mixes} }}\n",
        include_str!("../scenes/minimal.txt")
    );
    for i in (0..mixes).rev() {
        text.push_str(&format!("material_mix m{} {{ first m{i} second m{i} }}\n", i + 1));
    }
    load("scene.txt", &text, &Files::built_in("", &[]))
}

#[test]
fn mixes_may_be_nested_but_not_without_end() {
    let loaded = tower(MOST_MIXES);
    assert_eq!(loaded.diagnostics.render(false), "");
    let mut scene = loaded.scene.expect("there are no errors");
    assert_eq!(scene.check(), Ok(()));
    let order = inside_out(&scene.materials).expect("nothing is tangled");
    let place = |id: MaterialId| order.iter().position(|of| *of == id).expect("all are there");
    for (i, material) in scene.materials.iter().enumerate() {
        let parts = material.kind.parts().into_iter().flatten();
        parts.for_each(|part| assert!(place(part) < place(MaterialId(i as u32))));
    }
    let index = |name| scene.materials.iter().position(|material| material.name == name);
    let [bottom, top] = ["m0", "m64"].map(|name| index(name).expect("it is there"));
    scene.materials[bottom].kind = scene.materials[top].kind.clone();
    assert!(scene.check().is_err_and(|error| error.ends_with("contains itself")));

    for mixes in [MOST_MIXES + 1, 20_000] {
        let diagnostics = tower(mixes).diagnostics;
        let report = diagnostics.render(false);
        assert_eq!(diagnostics.error_count(), 1, "{report}");
        assert!(report.contains("mixes are nested more than 64 deep"), "{report}");
    }
}

#[test]
fn a_circle_of_any_length_is_found() {
    let count = 20_000;
    let mut text = include_str!("../scenes/minimal.txt").to_owned();
    for i in 0..count {
        let next = (i + 1) % count;
        text.push_str(&format!("material_mix m{i} {{ first m{next} second m{next} }}\n"));
    }
    let report = load("scene.txt", &text, &Files::built_in("", &[])).diagnostics.render(false);
    assert!(report.starts_with("error: material `m0` contains itself"), "{report}");
    assert!(report.contains("m5 -> ... -> m0"), "{report}");
    assert!(report.lines().count() < 40, "{report}");
}

#[test]
fn a_scene_built_in_memory_may_not_mix_what_is_missing() {
    let mut scene = tower(2).scene.expect("there are no errors");
    scene.materials.pop();
    let error = scene.check().expect_err("a material is missing");
    assert!(error.ends_with("mixes a material that is missing"), "{error}");
    assert_eq!(inside_out(&scene.materials).map(|order| order.len()), Ok(scene.materials.len()));
}

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
            kinds.extend(words.next().map(str::to_owned));
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
