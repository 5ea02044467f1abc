//! Regions, parts, and `merge`.

use super::{Folder, SCENE};

fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 12");
    Folder::with_scene(&text.replace("width 16 height 9", "width 100 height 70"))
}

fn pixels(png: &[u8]) -> (u32, Vec<[u8; 3]>) {
    let image = image::load_from_memory(png).unwrap().to_rgb8();
    (image.width(), image.pixels().map(|pixel| pixel.0).collect())
}

#[test]
fn a_region_is_cut_out_of_the_picture() {
    let folder = folder();
    folder.printed("-q -s scene.txt");
    let name = folder.printed("-q -s scene.txt --region 33x21+50+17");
    assert_eq!(name, "ball_00000_region=33x21+50+17.png\n");
    let (_, whole) = pixels(&folder.read("ball_00000.png"));
    let (width, region) = pixels(&folder.read(name.trim_end()));
    assert_eq!((width, region.len()), (33, 33 * 21));
    for (i, pixel) in region.iter().enumerate() {
        assert_eq!(*pixel, whole[(17 + i / 33) * 100 + 50 + i % 33], "pixel {i}");
    }
    let recipe = folder.printed(&format!("--recipe {}", name.trim_end()));
    assert!(recipe.contains("\"region\": [50, 17, 33, 21]"), "{recipe}");
    let run = folder.run("-s scene.txt --region 33x21+50+50");
    assert_eq!(run.exit, 2);
    assert!(run.said.contains("not inside the picture, which has 100x70 pixels"), "{}", run.said);
}

#[test]
fn parts_make_the_picture() {
    for by in ["pixels", "samples"] {
        let folder = folder();
        folder.printed("-q -s scene.txt -f 0,1");
        for number in [3, 1, 2] {
            let printed = folder
                .printed(&format!("-q -s scene.txt -f 0-1 --part {number}/3 --part-by {by} -od p"));
            assert!(printed.starts_with(&format!("p/ball_00000.{by}-{number}-of-3.part\n")));
        }
        let parts = (0..2).flat_map(|frame| (1..4).map(move |number| (frame, number)));
        let parts = parts.map(|(f, n)| format!("p/ball_0000{f}.{by}-{n}-of-3.part"));
        let printed =
            folder.printed(&format!("merge -od m {}", parts.collect::<Vec<_>>().join(" ")));
        assert_eq!(printed, "m/ball_00000.png\nm/ball_00001.png\n");
        for name in ["ball_00000.png", "ball_00001.png"] {
            assert!(folder.read(name) == folder.read(&format!("m/{name}")), "{by} {name}");
        }
        let again = folder.run(&format!("-s scene.txt -f 0-1 --part 1/3 --part-by {by} -od p"));
        assert!(again.said.contains("2 frames were finished already"), "{}", again.said);
    }
}

#[test]
fn regions_in_parts_make_the_picture_or_the_region() {
    let folder = folder();
    folder.printed("-q -s scene.txt");
    let left = folder.printed("-q -s scene.txt --region 45x70+0+0 --part 1/1");
    let right = [1, 2].map(|number| {
        folder.printed(&format!("-q -s scene.txt --region 55x70+45+0 --part {number}/2"))
    });
    let files =
        |parts: &[&String]| parts.iter().map(|p| p.trim_end()).collect::<Vec<_>>().join(" ");
    let all = files(&[&left, &right[0], &right[1]]);
    assert_eq!(folder.printed(&format!("merge -q -od m {all}")), "m/ball_00000.png\n");
    assert!(folder.read("m/ball_00000.png") == folder.read("ball_00000.png"));
    let name = folder.printed("-q -s scene.txt --region 55x70+45+0");
    let region = folder.printed(&format!("merge -q -od m {}", files(&[&right[0], &right[1]])));
    assert_eq!(region, format!("m/{name}"));
    assert!(folder.read(region.trim_end()) == folder.read(name.trim_end()));
}

#[test]
fn a_region_of_an_exr_picture_lies_where_it_belongs() {
    let folder = folder();
    let text = String::from_utf8(folder.read("scene.txt")).unwrap();
    folder.write("scene.txt", text.replace("PNG_IMAGE", "EXR_IMAGE"));
    let name = folder.printed("-q -s scene.txt --region 33x21+50+17");
    let bytes = folder.read(name.trim_end());
    // Columns and rows of the first and of the last pixel, both inclusive.
    assert_eq!(window(&bytes, b"displayWindow"), [0, 0, 99, 69]);
    assert_eq!(window(&bytes, b"dataWindow"), [50, 17, 82, 37]);
    let part = folder.printed("-q -s scene.txt --region 33x21+50+17 --part 1/1");
    let merged = folder.printed(&format!("merge -q -od m {part}"));
    assert!(folder.read(merged.trim_end()) == bytes);
    folder.printed("-q -s scene.txt --region 33x21+50+17 --sample-map map.exr");
    assert_eq!(window(&folder.read("map.exr"), b"dataWindow"), [50, 17, 82, 37]);
}

/// Reads a window in the header of an EXR file.
fn window(exr: &[u8], name: &[u8]) -> [i32; 4] {
    let start = [name, b"\0box2i\0", &16u32.to_le_bytes()].concat();
    let at = exr.windows(start.len()).position(|bytes| bytes == start).unwrap() + start.len();
    std::array::from_fn(|i| i32::from_le_bytes(*exr[at + 4 * i..].first_chunk().unwrap()))
}

#[test]
fn parts_that_are_no_whole_are_refused_by_name() {
    let folder = folder();
    for number in 1..4 {
        folder.printed(&format!("-q -s scene.txt --part {number}/3"));
    }
    folder.printed("-q -s scene.txt --part 2/2 -od half");
    folder.printed("-q -s scene.txt --part 2/2 --part-by samples -od half");
    folder.printed("-q -s scene.txt --part 3/3 --seed 7 -od other");
    let part = |number: u32| format!("ball_00000.pixels-{number}-of-3.part");
    let check = |files: &[&str], exit: i32, said: &[&str]| {
        let run = folder.run(&format!("merge -od m {}", files.join(" ")));
        assert_eq!((run.exit, &*run.printed), (exit, ""), "{files:?}: {}", run.said);
        for said in said {
            assert!(run.said.contains(said), "{files:?}: no `{said}` in {}", run.said);
        }
        assert!(!folder.path().join("m").exists(), "{files:?}");
    };
    let [one, two, three] = [1, 2, 3].map(part);
    check(&[&one, &three], 65, &["part 2 of 3 is missing: ", " pixels, the first in column 32"]);
    check(&[&one], 65, &["parts 2 and 3 of 3 are missing: ", "one part of `ball_00000`"]);
    folder.write("renamed.part", folder.read(&one));
    check(&["renamed.part"], 65, &["a part is missing: ", " pixels, the first in column 32"]);
    check(&[&one, &two, &two, &three], 65, &[&two, "the same pixels"]);
    check(&[&one, "half/ball_00000.pixels-2-of-2.part"], 65, &["half/", "the same pixels"]);
    check(
        &["half/ball_00000.samples-2-of-2.part"],
        65,
        &["part 1 of 2 is missing: samples 0 to 5 of"],
    );
    check(&[&one, &two, "other/ball_00000.pixels-3-of-3.part"], 65, &["other/", "seed: 7"]);
    check(&["none.part"], 66, &["none.part"]);
    check(&["scene.txt"], 65, &["scene.txt", "no state of slo-rt"]);
    let mut bytes = folder.read(&three);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    folder.write("damaged.part", &bytes);
    check(&[&one, &two, "damaged.part"], 65, &["damaged.part", "it is damaged"]);
    folder.write("short.part", &bytes[..middle]);
    check(&[&one, &two, "short.part"], 65, &["short.part", "cut off"]);
    let version = env!("CARGO_PKG_VERSION");
    let quoted = format!("\"{version}\"");
    let at = bytes.windows(quoted.len()).position(|window| window == quoted.as_bytes()).unwrap();
    bytes[at + 1] = b'9';
    folder.write("old.part", &bytes);
    check(&[&one, &two, "old.part"], 65, &["old.part", &format!("slo-rt 9{}", &version[1..])]);
    folder.printed("-q -s scene.txt -f 1 --part 1/1");
    folder.printed("-q -s scene.txt -f 0 --part 1/1");
    let renamed = "p/ball_00000.pixels-1-of-1.part";
    folder.write(renamed, folder.read("ball_00001.pixels-1-of-1.part"));
    check(
        &["ball_00000.pixels-1-of-1.part", renamed],
        65,
        &["different frames", "m/ball_00000.png"],
    );
    check(&[], 2, &["FILES"]);
}

#[test]
fn a_part_of_no_samples_is_refused() {
    let folder = Folder::new();
    let run = folder.run("-s scene.txt --part 1/3 --part-by samples");
    assert_eq!((run.exit, folder.names().len()), (2, 0), "{}", run.said);
    assert!(run.said.contains("more parts than samples"), "{}", run.said);
    assert_eq!(folder.run("-q -s scene.txt --part 2/2 --part-by samples").exit, 0);
}

/// A state of a picture that claims to have more pixels than any memory holds.
#[test]
fn a_small_part_of_a_huge_picture_is_refused() {
    let folder = Folder::new();
    folder.printed("-q -s scene.txt --region 8x8+0+0 --part 1/1");
    let name = "ball_00000_region=8x8+0+0.pixels-1-of-1.part";
    let bytes = folder.read(name);
    let text = String::from_utf8_lossy(&bytes);
    let start = text.find('{').unwrap();
    let recipe = &text[start..=text.find('}').unwrap()];
    let huge = recipe.replace("\"width\": 16", "\"width\": 65536");
    let huge = huge.replace("\"height\": 9", "\"height\": 65536");
    let length = (huge.len() as u32).to_le_bytes();
    let body = &bytes[start + recipe.len()..bytes.len() - 32];
    let mut part = [&bytes[..start - 4], &length, huge.as_bytes(), body].concat();
    let hash = blake3::hash(&part);
    part.extend_from_slice(hash.as_bytes());
    folder.write(name, &part);
    let run = folder.run(&format!("merge -od m {name}"));
    assert_eq!(run.exit, 0, "a region alone is a picture: {}", run.said);
    // With a second region, the merged area is the whole picture, most of which is missing.
    folder.printed("-q -s scene.txt --region 8x8+8+0 --part 1/1");
    let name2 = "ball_00000_region=8x8+8+0.pixels-1-of-1.part";
    let second = folder.read(name2);
    let body = &second[start + recipe.len()..second.len() - 32];
    let mut part = [&second[..start - 4], &length, huge.as_bytes(), body].concat();
    let hash = blake3::hash(&part);
    part.extend_from_slice(hash.as_bytes());
    folder.write(name2, &part);
    let run = folder.run(&format!("merge -od n {name} {name2}"));
    assert_eq!(run.exit, 65, "{}", run.said);
    assert!(run.said.contains("missing: 4294967168 pixels or more"), "{}", run.said);
}

#[test]
fn samples_of_adaptive_pictures_are_not_shared_out() {
    let folder = Folder::with_scene(&SCENE.replace("imageSamples 2", "imageSamples 8 noise 0.1"));
    let run = folder.run("-s scene.txt --part 1/2 --part-by samples");
    assert_eq!(run.exit, 2);
    assert!(run.said.contains("--part-by pixels"), "{}", run.said);
}
