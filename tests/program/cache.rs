//! `--cache`: large meshes and their structures are worked out once.

use std::fs;
use std::path::PathBuf;

use super::{Folder, SCENE};

/// A mesh of 80 000 triangles, in text of more than a megabyte.
fn folder() -> Folder {
    const SIDE: usize = 200;
    let scene = SCENE.replace(
        "sphere ball",
        "mesh land { filename land.obj smooth_normals 1 material matte } sphere ball",
    );
    let folder = Folder::with_scene(&scene);
    let mut obj = String::new();
    for (x, y) in (0..=SIDE).flat_map(|x| (0..=SIDE).map(move |y| (x, y))) {
        let [a, b] = [x, y].map(|i| i as f64 / 50.0 - 2.0);
        obj += &format!("v {a} {b} {}\n", ((x * 7 + y * 5) % 11) as f64 / 100.0 - 1.0);
    }
    for (x, y) in (0..SIDE).flat_map(|x| (0..SIDE).map(move |y| (x, y))) {
        let [a, b] = [x, x + 1].map(|x| x * (SIDE + 1) + y + 1);
        obj += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1);
    }
    folder.write("land.obj", obj);
    folder
}

fn files(folder: &Folder) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.path().join("cache")).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn the_second_run_finds_what_the_first_has_made() {
    let folder = folder();
    folder.printed("-s scene.txt -q");
    let expected = folder.read("ball_00000.png");
    let with_cache = |found: usize, made: usize| {
        let run = folder.run("-s scene.txt -v --cache cache");
        assert_eq!((run.exit, &*run.printed), (0, "ball_00000.png\n"), "{}", run.said);
        assert!(folder.read("ball_00000.png") == expected);
        let line = format!("cache: {found} found, {made} written");
        assert!(run.said.contains(&line), "{line}: {}", run.said);
        run.said
    };
    with_cache(0, 2);
    assert!(!with_cache(2, 0).contains("warning"));
    let both = files(&folder);
    let [mesh, structure] = &both[..] else { panic!("{both:?}") };
    // Damaged and foreign files are reported and made again.
    let mut bytes = fs::read(structure).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(structure, bytes).unwrap();
    fs::write(mesh, "notes").unwrap();
    let said = with_cache(0, 2);
    for path in [mesh, structure] {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(said.contains(name) && said.contains("made again"), "{name}: {said}");
    }
    with_cache(2, 0);
    // Another mesh has another name.
    let obj = folder.read("land.obj");
    folder.write("land.obj", [&obj[..], b"# the same triangles\n"].concat());
    let run = folder.run("-s scene.txt -v --cache cache");
    assert!(run.said.contains("cache: 1 found, 1 written"), "{}", run.said);
}

#[test]
fn a_cache_that_cannot_be_written_is_a_warning() {
    let folder = folder();
    folder.write("cache", "a file");
    let run = folder.run("-s scene.txt --cache cache");
    assert_eq!((run.exit, &*run.printed), (0, "ball_00000.png\n"), "{}", run.said);
    assert_eq!(run.said.matches("can't write to the cache `cache`").count(), 1, "{}", run.said);
}

#[test]
fn the_cache_keeps_its_size() {
    let folder = folder();
    let run = folder.run("-s scene.txt -v --cache cache --cache-size 1MB");
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains("cache: 0 found, 0 written"), "{}", run.said);
    let run = folder.run("-s scene.txt -v --cache cache --cache-size 1");
    assert_eq!(run.exit, 2);
    assert!(run.said.contains("20GB"), "{}", run.said);
}
