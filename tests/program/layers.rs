//! `--layers`, and `denoise` if no denoiser is installed.

use super::{Folder, SCENE};

fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 8");
    Folder::with_scene(&text.replace("width 16 height 9", "width 100 height 70"))
}

const LAYERS: &str = "--format exr --layers albedo,normal";

/// Names of the channels of an EXR file.
fn channels(bytes: &[u8]) -> Vec<String> {
    let meta = exr::meta::MetaData::read_from_buffered(bytes, false).unwrap();
    meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect()
}

#[test]
fn layers_are_channels_of_the_same_file() {
    let folder = folder();
    assert_eq!(folder.printed(&format!("-q -s scene.txt {LAYERS}")), "ball_00000.exr\n");
    let expected =
        ["B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "normal.X", "normal.Y", "normal.Z"];
    assert_eq!(channels(&folder.read("ball_00000.exr")), expected);
    let recipe = folder.printed("--recipe ball_00000.exr");
    assert!(recipe.contains("\"layers\": [\"albedo\", \"normal\"]"), "{recipe}");
    let verified = folder.printed("verify ball_00000.exr -s scene.txt --tiles 99");
    assert_eq!(verified, "same\tball_00000.exr\t12 tiles\n");
    folder.printed("-q -s scene.txt -f 1 --format exr --layers normal,normal");
    assert_eq!(channels(&folder.read("ball_00001.exr"))[3..], expected[6..]);
    folder.printed("-q -s scene.txt -f 2 --format exr");
    assert_eq!(channels(&folder.read("ball_00002.exr")), expected[..3]);
    assert!(!folder.printed("--recipe ball_00002.exr").contains("layers"));
    // The colours are the same, but a sequence detects that the layers differ.
    folder.printed("-q -s scene.txt --format exr -od plain");
    let same = "compare ball_00000.exr plain/ball_00000.exr --max-pixels 0";
    assert!(folder.printed(same).starts_with("pixels\t0\n"));
    let found = folder.printed(&format!("-s scene.txt -f 0-0 {LAYERS} -od plain --dry-run"));
    assert!(found.contains("stale (") || found.contains("layers"), "{found}");
}

#[test]
fn a_png_has_no_layers() {
    let folder = folder();
    let run = folder.run("-s scene.txt --layers albedo");
    assert_eq!(run.exit, 2, "{}", run.said);
    assert!(run.said.contains("EXR") && run.said.contains("--format exr"), "{}", run.said);
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn parts_and_more_samples_make_the_same_layers() {
    let folder = folder();
    folder.printed(&format!("-q -s scene.txt {LAYERS} -od whole"));
    let whole = folder.read("whole/ball_00000.exr");
    for by in ["pixels", "samples"] {
        let mut parts = String::new();
        for number in [2, 1, 3] {
            let part = format!("--part {number}/3 --part-by {by}");
            parts += &folder.printed(&format!("-q -s scene.txt {LAYERS} {part} -od parts"));
        }
        folder.printed(&format!("merge -q -od merged {}", parts.replace('\n', " ")));
        assert!(folder.read("merged/ball_00000.exr") == whole, "{by}");
    }
    folder.printed(&format!("-q -s scene.txt {LAYERS} --samples 3 --keep-state"));
    let run = folder.run(&format!("-v -s scene.txt {LAYERS} --samples 8"));
    assert!(run.said.contains("35000 "), "five of eight samples are new: {}", run.said);
    folder.printed(&format!("-q -s scene.txt {LAYERS} --samples 8 -od anew"));
    assert!(folder.read("ball_00000.exr") == folder.read("anew/ball_00000.exr"));
}

#[test]
fn layers_for_compositors_are_verified_merged_and_kept() {
    let layers =
        "--format exr --layers depth,uv,motion,crypto_object,crypto_material,samples,error";
    let folder = folder();
    folder.printed(&format!("-q -s scene.txt {layers} -od whole"));
    let whole = folder.read("whole/ball_00000.exr");
    let channels = channels(&whole);
    for name in ["depth.Z", "uv.A", "motion.W", "crypto_object02.A", "samples.X", "error.G"] {
        assert!(channels.iter().any(|channel| channel == name), "{name}: {channels:?}");
    }
    let meta = exr::meta::MetaData::read_from_buffered(&whole[..], false).unwrap();
    let attributes = &meta.headers[0].own_attributes.other;
    for (key, value) in
        [("name", "crypto_object"), ("hash", "MurmurHash3_32"), ("conversion", "uint32_to_float32")]
    {
        let name = exr::meta::attribute::Text::from(&*format!("cryptomatte/f834d0a/{key}"));
        let expected = exr::meta::attribute::AttributeValue::Text(value.into());
        assert_eq!(attributes.get(&name), Some(&expected), "{key}");
    }
    let verified = folder.printed("verify whole/ball_00000.exr -s scene.txt --tiles 99");
    assert!(verified.starts_with("same\t"), "{verified}");
    let mut parts = String::new();
    for number in [2, 1] {
        let part = format!("--part {number}/2 --part-by samples");
        parts += &folder.printed(&format!("-q -s scene.txt {layers} {part} -od parts"));
    }
    folder.printed(&format!("merge -q -od merged {}", parts.replace('\n', " ")));
    assert!(folder.read("merged/ball_00000.exr") == whole, "merged");
    folder.printed(&format!("-q -s scene.txt {layers} --samples 3 --keep-state"));
    folder.printed(&format!("-q -s scene.txt {layers} --samples 8"));
    assert!(folder.read("ball_00000.exr") == whole, "more samples");
    // Samples and errors need no sums of their own; other layers do.
    folder.printed("-q -s scene.txt -f 1 --format exr --samples 3 --keep-state");
    let run = folder.run("-s scene.txt -f 1 --format exr --layers samples --samples 8");
    assert!(!run.said.contains("can't be used"), "{}", run.said);
    folder.printed("-q -s scene.txt -f 2 --format exr --samples 3 --keep-state");
    let run = folder.run("-s scene.txt -f 2 --format exr --layers depth --samples 8");
    assert!(run.said.contains("its layers for compositors are not those"), "{}", run.said);
}

#[test]
fn a_region_has_its_place_and_every_byte_counts() {
    let folder = folder();
    folder.printed(&format!("-q -s scene.txt {LAYERS}"));
    let region = format!("-q -s scene.txt {LAYERS} -f 0-0 --region 40x30+50+20");
    let name = "ball_00000_region=40x30+50+20.exr";
    assert_eq!(folder.printed(&region), format!("{name}\n"));
    let whole = folder.read(name);
    let meta = exr::meta::MetaData::read_from_buffered(&whole[..], false).unwrap();
    let header = &meta.headers[0];
    let (place, size) = (header.own_attributes.layer_position, header.layer_size);
    let display = header.shared_attributes.display_window.size;
    assert_eq!([place.x(), place.y()], [50, 20]);
    assert_eq!([size.x(), size.y(), display.x(), display.y()], [40, 30, 100, 70]);
    let same = folder.printed(&format!("compare {name} ball_00000.exr --max-pixels 0"));
    assert!(same.starts_with("pixels\t0\n"), "{same}");
    let verified = folder.printed(&format!("verify {name} -s scene.txt --tiles 99"));
    assert!(verified.starts_with("same\t"), "{verified}");
    let parts = ["1/2", "2/2"].map(|part| folder.printed(&format!("{region} --part {part}")));
    folder.printed(&format!("merge -q -od merged {}", parts.concat().replace('\n', " ")));
    assert!(folder.read(&format!("merged/{name}")) == whole);
    // One bit of a normal, which affects no other channel.
    let mut damaged = whole.clone();
    *damaged.last_mut().unwrap() ^= 1;
    std::fs::write(folder.path().join(name), damaged).unwrap();
    let run = folder.run(&format!("verify {name} -s scene.txt"));
    assert_eq!(run.exit, 65, "{}", run.said);
    assert!(run.printed.starts_with("unverified\t"), "{}", run.printed);
    folder.printed(&region);
    assert!(folder.read(name) == whole, "rendered again");
}

#[test]
fn states_with_and_without_layers_do_not_mix() {
    let folder = folder();
    folder.printed("-q -s scene.txt --format exr --samples 3 --keep-state");
    let run = folder.run(&format!("-s scene.txt {LAYERS} --keep-state"));
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains("it has no layers, but this run writes"), "{}", run.said);
    folder.printed(&format!("-q -s scene.txt {LAYERS} -od anew"));
    assert!(folder.read("ball_00000.exr") == folder.read("anew/ball_00000.exr"));
    let run = folder.run("-s scene.txt --format exr --samples 16");
    assert!(run.said.contains("it has layers, but this run does not write"), "{}", run.said);
    folder.printed("-q -s scene.txt --format exr --part 1/2");
    folder.printed(&format!("-q -s scene.txt {LAYERS} --part 2/2"));
    let run = folder.run("merge ball_00000.pixels-1-of-2.part ball_00000.pixels-2-of-2.part -od m");
    assert_eq!(run.exit, 65, "{}", run.said);
    assert!(run.said.contains("another picture") && run.said.contains("layers"), "{}", run.said);
}

#[test]
fn without_a_denoiser_it_says_what_to_do() {
    let folder = folder();
    folder.printed("-q -s scene.txt");
    let run = folder.run("denoise ball_00000.png --library none.so");
    assert_eq!((run.exit, &*run.printed), (1, ""));
    assert!(run.said.contains("Open Image Denoise can't be loaded"), "{}", run.said);
    assert!(run.said.contains("docs/denoising.md"), "{}", run.said);
    assert_eq!(folder.names(), ["ball_00000.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_in_the_current_folder_is_found() {
    let folder = folder();
    folder.printed("-q -s scene.txt");
    folder.write("libx.so", "no library");
    for name in ["libx.so", "./libx.so"] {
        let run = folder.run(&format!("denoise ball_00000.png --library {name}"));
        assert_eq!(run.exit, 1);
        assert!(run.said.contains(&format!("`{name}`: ")), "{}", run.said);
        assert!(run.said.contains("file too short"), "{}", run.said);
    }
    let run = folder.run("denoise ball_00000.png --library liby.so");
    assert!(run.said.contains("cannot open shared object file"), "{}", run.said);
}
