//! `compare`, `verify`, `sheet`, and the maps.

use super::{Folder, SCENE};

fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 8");
    Folder::with_scene(&text.replace("width 16 height 9", "width 100 height 70"))
}

fn value(printed: &str, name: &str) -> f64 {
    let line = printed.lines().find_map(|line| line.strip_prefix(&format!("{name}\t"))).unwrap();
    line.parse().unwrap()
}

#[test]
fn pictures_are_compared() {
    let folder = folder();
    folder.printed("-q -s scene.txt");
    folder.printed("-q -s scene.txt -f 1 --seed 1");
    folder.printed("-q -s scene.txt -f 2 --size 50x70");
    let same = folder.printed("compare ball_00000.png ball_00000.png --max-pixels 0");
    assert_eq!(value(&same, "pixels"), 0.0);
    assert_eq!(value(&same, "flip"), 0.0);
    assert!(same.contains("psnr\tinf"), "{same}");
    let run = folder.run("compare ball_00001.png ball_00000.png --map map.png --max-rmse 1e-9");
    assert_eq!(run.exit, 1, "{}", run.said);
    assert!(run.said.contains(", beyond 0.000000001"), "{}", run.said);
    assert!(value(&run.printed, "rmse") > 1e-4 && value(&run.printed, "flip") > 1e-4);
    let map = image::load_from_memory(&folder.read("map.png")).unwrap();
    assert_eq!((map.width(), map.height()), (100, 70));
    let bias = value(&run.printed, "mean-ratio") - 1.0;
    assert!(bias != 0.0 && bias.abs() < 0.05, "{bias}");
    let limited =
        |limit: &str| folder.run(&format!("compare ball_00001.png ball_00000.png {limit}"));
    assert_eq!(limited("--max-bias 0.05").exit, 0);
    let biased = limited("--max-bias 0");
    assert_eq!(biased.exit, 1);
    assert!(biased.said.contains("bias is "), "{}", biased.said);
    let several = limited("--max-pixels 0 --max-rmse 1 --max-flip 0");
    assert!(several.said.contains("pixels is ") && several.said.contains("; flip is "));
    assert!(!several.said.contains("rmse"), "{}", several.said);
    for limit in ["--max-rmse nan", "--max-flip -1", "--max-relative-mse=-0.5", "--max-bias inf"] {
        let run = limited(limit);
        assert_eq!((run.exit, &*run.printed), (2, ""), "{limit}");
        assert!(run.said.contains("0 or more"), "{}", run.said);
    }
    let run = folder.run("compare ball_00002.png ball_00000.png");
    assert_eq!(run.exit, 65);
    assert!(run.said.contains("50x70"), "{}", run.said);
    assert_eq!(folder.run("compare none.png ball_00000.png").exit, 66);
    assert_eq!(folder.run("compare scene.txt ball_00000.png").exit, 65);
}

#[test]
fn pictures_are_verified() {
    let exr = folder();
    exr.write("exr.txt", SCENE.replace("PNG_IMAGE", "EXR_IMAGE"));
    exr.printed("-q -s exr.txt -f 7");
    assert_eq!(exr.printed("verify ball_00007.exr -s exr.txt"), "same\tball_00007.exr\t1 tile\n");
    let folder = folder();
    folder.printed("-q -s scene.txt -f 7 --seed 3 --noise 0.02");
    folder.printed("-q -s scene.txt -f 8 --region 60x50+33+11");
    let printed = folder
        .printed("verify ball_00007.png ball_00008_region=60x50+33+11.png -s scene.txt --tiles 99");
    assert_eq!(
        printed,
        "same\tball_00007.png\t12 tiles\nsame\tball_00008_region=60x50+33+11.png\t4 tiles\n"
    );
    // A node that computes wrong results: one value of one pixel.
    let name = "ball_00007.png";
    let bytes = folder.read(name);
    let decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
    let mut reader = decoder.read_info().unwrap();
    let text = reader.info().uncompressed_latin1_text[0].clone();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels[4000] ^= 1;
    let mut wrong = Vec::new();
    let mut encoder = png::Encoder::new(&mut wrong, 100, 70);
    encoder.set_color(png::ColorType::Rgb);
    encoder.add_text_chunk(text.keyword, text.text).unwrap();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    folder.write(name, &wrong);
    let run = folder.run("verify ball_00007.png -s scene.txt --tiles 99");
    assert_eq!((run.exit, &*run.printed), (1, "different\tball_00007.png\t1 of 12 tiles\n"));
    // A picture that cannot be verified, or a wrong one, does not keep the others from being
    // verified.
    folder.write("none.exr", "no picture");
    let run = folder.run(
        "verify scene.txt none.exr gone.png ball_00007.png ball_00008_region=60x50+33+11.png \
         -s scene.txt --tiles 99",
    );
    let fields = |line: &str| line.split('\t').take(2).collect::<Vec<_>>().join(" ");
    let lines: Vec<String> = run.printed.lines().map(fields).collect();
    assert_eq!(
        lines,
        [
            "unverified scene.txt",
            "unverified none.exr",
            "unverified gone.png",
            "different ball_00007.png",
            "same ball_00008_region=60x50+33+11.png"
        ]
    );
    assert_eq!(run.exit, 1);
    let said = "1 of 5 pictures is not what its recipe makes here; 3 of 5 pictures can't be";
    assert!(run.said.contains(said), "{}", run.said);
    let run =
        folder.run("verify gone.png scene.txt ball_00008_region=60x50+33+11.png -s scene.txt");
    assert_eq!(run.exit, 66, "the first that can't be verified decides");
    assert_eq!(run.printed.lines().count(), 3);
    // Another scene, and a file of another program.
    folder.write("other.txt", SCENE);
    let run = folder.run("verify ball_00007.png -s other.txt");
    assert_eq!(run.exit, 65);
    assert!(run.said.contains("another scene"), "{}", run.said);
    let run = folder.run("verify ball_00007.png");
    assert_eq!(run.exit, 65);
    let said = "it belongs to another scene; name it with `-s`";
    assert!(run.said.contains(said) && run.printed.contains(said), "{}", run.said);
    assert_eq!(folder.run("verify scene.txt -s scene.txt").exit, 65);
}

#[test]
fn damaged_pictures_are_refused_by_all() {
    let text = SCENE.replace("output PNG_IMAGE", "output PNG_IMAGE encoding SRGB");
    let folder = Folder::with_scene(&text);
    folder.printed("-q -s scene.txt");
    folder.printed("-q -s scene.txt -f 1");
    let whole = folder.read("ball_00000.png");
    let chunk = |name: &[u8; 4]| whole.windows(4).position(|found| found == name).unwrap();
    let flipped = |at: usize| {
        let mut damaged = whole.clone();
        damaged[at] ^= 4;
        damaged
    };
    let cases = [
        (flipped(chunk(b"sRGB") + 4), "the checksum of its sRGB chunk is wrong"),
        (flipped(chunk(b"sRGB")), "chunk is wrong"),
        (flipped(chunk(b"tEXt") + 6), "the checksum of its tEXt chunk is wrong"),
        (flipped(chunk(b"tEXt") + 60), "the checksum of its tEXt chunk is wrong"),
        (flipped(chunk(b"tEXt") - 1), "it is damaged"),
        (flipped(chunk(b"IDAT") - 1), "it is damaged"),
        ([&whole[..], b"x"].concat(), "there are bytes after its end"),
        (whole[..whole.len() - 3].to_vec(), "it ends before the end of its IEND chunk"),
    ];
    for (damaged, why) in cases {
        folder.write("ball_00000.png", damaged);
        for typed in [
            "compare ball_00000.png ball_00001.png",
            "compare ball_00001.png ball_00000.png",
            "verify ball_00000.png -s scene.txt",
            "sheet ball_00000.png ball_00001.png",
            "--recipe ball_00000.png",
        ] {
            let run = folder.run(typed);
            assert_eq!(run.exit, 65, "{typed}: {why}: {}", run.said);
            assert!(run.said.contains("it is damaged: "), "{typed}: {}", run.said);
            assert!(run.said.contains(why), "{typed}: {}", run.said);
            assert!(!run.said.contains("critical"), "{typed}: {}", run.said);
            assert!(!typed.starts_with("verify") || run.printed.starts_with("unverified\t"));
        }
        let planned = folder.printed("-s scene.txt -f 0-1 --dry-run");
        assert!(planned.starts_with("0\tball_00000.png\tdamaged\n"), "{why}: {planned}");
    }
}

#[test]
fn the_yardstick_is_told_from_the_other_structures() {
    let folder = folder();
    for (name, is_told) in [("cwbvh", true), ("kdtree", false)] {
        let run = folder.run(&format!("-s scene.txt -od {name} --accelerator {name}"));
        assert_eq!(run.exit, 0, "{}", run.said);
        assert_eq!(run.said.contains("CWBVH is for measurements"), is_told, "{}", run.said);
        let picture = format!("{name}/ball_00000.png");
        let recipe = folder.printed(&format!("--recipe {picture}"));
        assert_eq!(recipe.contains("\"accelerator\": \"CWBVH\""), is_told, "{recipe}");
        folder.printed(&format!("verify {picture} -s scene.txt"));
    }
    let planned = folder.printed("-s scene.txt -od kdtree --accelerator cwbvh --dry-run");
    assert!(planned.ends_with("\tstale (without accelerator: CWBVH)\n"), "{planned}");
}

#[test]
fn regions_are_verified_and_compared_with_the_whole() {
    for keyword in ["PNG_IMAGE", "EXR_IMAGE"] {
        let folder = folder();
        let text = String::from_utf8(folder.read("scene.txt")).unwrap();
        folder.write("scene.txt", text.replace("PNG_IMAGE", keyword));
        let whole = folder.printed("-q -s scene.txt -od whole");
        let all = folder.printed("-q -s scene.txt --region 100x70+0+0");
        let part = folder.printed("-q -s scene.txt --region 60x50+33+11");
        let printed = folder.printed(&format!("verify -s scene.txt {all} {part}"));
        assert!(printed.lines().all(|line| line.starts_with("same\t")), "{printed}");
        let same = folder.printed(&format!("compare {all} {whole} --max-pixels 0"));
        assert_eq!(value(&same, "pixels"), 0.0, "{keyword}");
        let run = folder.run(&format!("compare {part} {whole} --max-pixels 0 --map map.exr"));
        // Only EXR files store the position of a region.
        assert_eq!(run.exit, if keyword == "EXR_IMAGE" { 0 } else { 65 }, "{}", run.said);
    }
}

#[test]
fn a_contact_sheet_is_made() {
    let folder = folder();
    folder.printed("-q -s scene.txt -f 0-4 --samples 1");
    let files = (0..5).map(|f| format!("ball_0000{f}.png")).collect::<Vec<_>>().join(" ");
    assert_eq!(folder.printed(&format!("sheet {files} --width 50 -o s.png")), "s.png\n");
    let sheet = image::load_from_memory(&folder.read("s.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (3 * 54 + 4, 2 * (35 + 18) + 4));
    assert_eq!(folder.run("sheet none.png").exit, 66);
}

#[test]
fn maps_and_sheets_replace_nothing_but_their_like() {
    let folder = folder();
    folder.printed("-q -s scene.txt -f 0,1 --samples 1");
    folder.write("photo.png", folder.read("ball_00001.png"));
    let names = folder.names();
    let refused = |typed: &str, exit: i32, said: &str| {
        let before: Vec<_> = names.iter().map(|name| folder.read(name)).collect();
        let run = folder.run(typed);
        assert_eq!((run.exit, &*run.printed), (exit, ""), "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
        assert_eq!(folder.names(), names, "{typed}");
        let after: Vec<_> = names.iter().map(|name| folder.read(name)).collect();
        assert!(before == after, "{typed}");
    };
    let render = "-s scene.txt --overwrite -f";
    refused(&format!("{render} 0 --sample-map scene.txt"), 2, "neither");
    refused(&format!("{render} 0 --error-map m.jpg"), 2, "neither");
    refused(&format!("{render} 0 --sample-map m.png --error-map ./m.png"), 2, "are both");
    refused(&format!("{render} 0 --sample-map ball_00000.png"), 2, "picture 0 are both");
    refused(&format!("{render} 0 --sample-map ball_00001.png"), 73, "no map and no sheet");
    refused(&format!("{render} 0,1 --error-map ball_#####.png"), 2, "are both");
    refused(&format!("{render} 0 --sample-map photo.png"), 73, "choose another name");
    refused(&format!("{render} 0 --sample-map photo.png/m.png"), 73, "can't create");
    let both = "compare ball_00001.png ball_00000.png --map";
    refused(&format!("{both} ball_00000.png"), 2, "is an input and would be replaced");
    refused(&format!("{both} photo.png"), 73, "no map and no sheet");
    refused(&format!("{both} m.txt"), 2, "neither");
    refused(
        "sheet ball_00000.png photo.png -o ./photo.png",
        2,
        "is an input and would be replaced",
    );
    refused("sheet ball_00000.png -o photo.png", 73, "no map and no sheet");
    refused("sheet ball_00000.png -o sheet.exr", 2, "a sheet is a .png file");
    // Maps and sheets of earlier runs are replaced, and folders are created.
    for _ in 0..2 {
        folder.printed("-q -s scene.txt --samples 1 --sample-map new/take##_####.png");
        folder.printed(&format!("{both} new/map.png"));
        folder.printed("sheet ball_00000.png");
    }
    assert!(folder.path().join("new/take##_0000.png").exists());
    for typed in ["--recipe new/map.png", "verify new/map.png -s scene.txt", "--recipe sheet.png"] {
        let run = folder.run(typed);
        assert_eq!(run.exit, 65, "{typed}");
        assert!(run.said.contains("of slo-rt, not a picture"), "{typed}: {}", run.said);
    }
}

#[test]
fn a_noise_level_is_met_and_told() {
    let folder = folder();
    let run =
        folder.run("-s scene.txt -f 3,4 --noise 0.004 --sample-map n_##.png --error-map e_##.exr");
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains("; error "), "{}", run.said);
    let recipe = folder.printed("--recipe ball_00003.png");
    let recipe: serde_json::Value = serde_json::from_str(&recipe).unwrap();
    let error = recipe["result"]["error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.004, "{error}");
    let samples = recipe["result"]["samplesPerPixel"].as_f64().unwrap();
    assert!((16.0..4096.0).contains(&samples), "{samples}");
    for name in ["n_03.png", "n_04.png", "e_03.exr", "e_04.exr"] {
        assert!(folder.names().iter().any(|n| n == name), "{name}");
    }
    let map = image::load_from_memory(&folder.read("n_03.png")).unwrap().to_rgb8();
    let colors: std::collections::BTreeSet<_> = map.pixels().map(|p| p.0).collect();
    assert!(colors.len() > 1, "blocks take different numbers");
    // A stricter noise level continues where the looser one ended, and gives the same bytes.
    folder.printed("-q -s scene.txt -f 3 --noise 0.004 --keep-state");
    let rays = |typed: &str| {
        let said = folder.run(&format!("-v -s scene.txt -f 3 --noise 0.002 {typed}")).said;
        let line = said.lines().find(|line| line.contains("rays: ")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };
    assert!(rays("") < rays("-od anew"));
    assert!(folder.read("ball_00003.png") == folder.read("anew/ball_00003.png"));
    let run = folder.run("-s scene.txt -f 3,4 --sample-map n.png");
    assert_eq!(run.exit, 2);
    assert!(run.said.contains("####"), "{}", run.said);
}
