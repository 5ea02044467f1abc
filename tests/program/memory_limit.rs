//! `--memory-limit`: what would take more is refused before it is begun.

use super::{Folder, SCENE};

fn check(folder: &Folder, typed: &str, exit: i32, expected: &[&str]) {
    let run = folder.run(typed);
    assert_eq!(run.exit, exit, "{}", run.said);
    for part in expected {
        assert!(run.said.contains(part), "{part}: {}", run.said);
    }
    assert_eq!(run.printed, "");
}

#[test]
fn a_picture_that_is_too_large_is_refused() {
    let folder = Folder::with_scene(SCENE);
    let expected = ["the picture needs", "the limit of `--memory-limit` leaves", "--size"];
    check(&folder, "-s scene.txt --size 4000x4000 --memory-limit 200MB", 1, &expected);
    let run = folder.run("-s scene.txt --memory-limit 2GiB");
    assert_eq!(run.exit, 0, "{}", run.said);
}

#[test]
fn an_image_that_is_too_large_is_refused() {
    let scene = SCENE.replace(
        "sphere ball",
        "texture wood { filename wood.png } material_principled wood { base_color wood }
         rectangle board { vertex0 { 0 0 0 } vertex1 { 1 0 0 } vertex2 { 1 1 0 } material wood }
         sphere ball",
    );
    let folder = Folder::with_scene(&scene);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 8192, 8192);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&vec![7; 8192 * 8192]).unwrap();
    assert!(file.len() < 1 << 20, "a small file");
    folder.write("wood.png", file);
    let expected = ["wood.png", "8192 x 8192 pixels and needs 269 MB", "scale it down"];
    check(&folder, "-s scene.txt --memory-limit 200MB", 65, &expected);
}

#[test]
fn lamps_that_are_too_many_are_refused() {
    let mut scene = SCENE.to_owned();
    scene += "\ngroup g { }\nlamp_point l { power { 1 1 1 } position { 0 0 3 } parent g }\n";
    for level in 1..=6 {
        let of = if level == 1 { "g".to_owned() } else { format!("g{}", level - 1) };
        scene += &format!("group g{level} {{ }}\n");
        for i in 0..10 {
            scene += &format!(
                "copy c{level}_{i} {{ of {of} parent g{level} addKframe {{ time 0 key {{ pivot {{ {i} 0 {level} }} }} }} }}\n"
            );
        }
    }
    let folder = Folder::with_scene(&scene);
    let expected = ["the lamps of the frame", "`--memory-limit` leaves", "fewer copies"];
    check(&folder, "-s scene.txt --memory-limit 300MB", 1, &expected);
}

#[test]
fn photons_that_are_too_many_are_refused() {
    let scene = SCENE.replace(
        "sphere ball",
        "lamp_point lamp { power { 1 1 1 } position { 0 0 3 } radius .1 }
         material_principled glass { transmission 1 roughness 0 }
         sphere lens { center { 0 0 1 } radius .3 material glass }
         sphere ball",
    );
    let folder = Folder::with_scene(&scene);
    let typed = "-s scene.txt --integrator path --size 400x300 --samples 20 --memory-limit 100MB";
    let expected = ["the photons of a pass need", "`--memory-limit` leaves", "lower `photons`"];
    check(&folder, &format!("{typed} --photons 40"), 1, &expected);
    let run = folder.run(&format!("{typed} --photons .1"));
    assert_eq!(run.exit, 0, "{}", run.said);
}

#[test]
fn counting_by_pixel_takes_memory_too() {
    let folder = Folder::with_scene(SCENE);
    let typed = "-s scene.txt --size 1000x1000 --samples 1 --memory-limit 130MB --threads 1";
    let expected = ["the picture needs", "the limit of `--memory-limit` leaves"];
    check(&folder, &format!("{typed} --cost-map costs.png"), 1, &expected);
    let run = folder.run(&format!("{typed} --sample-map samples.png"));
    assert_eq!(run.exit, 0, "{}", run.said);
}

#[test]
fn copies_that_are_too_many_are_refused() {
    let mut ply = String::from("ply\nformat ascii 1.0\nelement vertex 400000\n");
    ply += "property float x\nproperty float y\nproperty float z\nend_header\n";
    (0..400_000).for_each(|x| ply += &format!("{x} 0 0\n"));
    let folder =
        Folder::with_scene(&format!("{SCENE}\ncopies row {{ of ball placements row.ply }}"));
    folder.write("row.ply", ply);
    let expected = ["the places of the frame's copies need 64 MB", "fewer copies"];
    check(&folder, "-s scene.txt --memory-limit 70MB", 1, &expected);
    // Reading them takes less, but not little.
    let expected = ["placements `row.ply` need", "--> scene.txt", "give fewer"];
    check(&folder, "-s scene.txt --memory-limit 15MB", 65, &expected);
}

#[test]
fn other_commands_have_the_limit_too() {
    let folder =
        Folder::with_scene(&SCENE.replace("sphere ball {", "sphere ball { lightMap 2048 "));
    let expected = ["the light map of `ball` needs 503 MB", "the limit of `--memory-limit` leaves"];
    check(&folder, "bake scene.txt --memory-limit 300MB", 1, &expected);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4096, 4096);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&vec![7; 4096 * 4096]).unwrap();
    folder.write("a.png", file);
    let expected = ["its 4096x4096 pixels need 202 MB", "the limit of `--memory-limit` leaves"];
    check(&folder, "compare a.png a.png --memory-limit 100MB", 1, &expected);
}
