//! Small files that claim to hold huge pictures.

use std::process::Command;

use super::{Folder, Run};

fn png(width: u32, height: u32, rows: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().unwrap();
    if rows < height {
        // Data that ends early, with the right checksum.
        let zlib = [0x78, 0x9c, 0x63, 0, 0, 0, 1, 0, 1];
        writer.write_chunk(png::chunk::IDAT, &zlib).unwrap();
    } else {
        let mut stream = writer.stream_writer().unwrap();
        let row = vec![0; width.div_ceil(8) as usize];
        (0..rows).for_each(|_| std::io::Write::write_all(&mut stream, &row).unwrap());
        stream.finish().unwrap();
    }
    drop(writer);
    bytes
}

/// An EXR file with a header, followed by `rest`. Channels are 32-bit floats.
fn exr(size: [i32; 2], channels: &[&str], compression: u8, rest: &[u8]) -> Vec<u8> {
    let attribute = |name: &str, kind: &str, data: &[u8]| {
        let length = (data.len() as u32).to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, data].concat()
    };
    let channel = |name: &&str| {
        let numbers: Vec<u8> = [2u32, 0, 1, 1].into_iter().flat_map(u32::to_le_bytes).collect();
        [name.as_bytes(), b"\0", &numbers].concat()
    };
    let list: Vec<u8> = channels.iter().flat_map(channel).chain([0]).collect();
    let window = [0, 0, size[0] - 1, size[1] - 1].map(i32::to_le_bytes).concat();
    [
        &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0][..],
        &attribute("channels", "chlist", &list),
        &attribute("compression", "compression", &[compression]),
        &attribute("dataWindow", "box2i", &window),
        &attribute("displayWindow", "box2i", &window),
        &attribute("lineOrder", "lineOrder", &[0]),
        &attribute("pixelAspectRatio", "float", &1f32.to_le_bytes()),
        &attribute("screenWindowCenter", "v2f", &[0; 8]),
        &attribute("screenWindowWidth", "float", &1f32.to_le_bytes()),
        &[0],
        rest,
    ]
    .concat()
}

/// Runs the program in 2 GB of address space.
fn confined(folder: &Folder, typed: &str) -> Run {
    let program = env!("CARGO_BIN_EXE_slo-rt");
    let mut shell = Command::new("sh");
    let limited = format!("ulimit -v 2000000; exec {program} {typed}");
    Run::of(shell.arg("-c").arg(limited).current_dir(folder.path()).output().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_can_not_be_is_refused_and_the_others_get_their_turn() {
    let folder = Folder::new();
    let name = folder.printed("-q -s scene.txt");
    let name = name.trim_end();
    let rgb = ["B", "G", "R"];
    let names: Vec<String> = (0..3000).map(|i| format!("c{i:04}")).collect();
    let many: Vec<&str> = rgb.into_iter().chain(names.iter().map(|name| &**name)).collect();
    let pictures = [
        ("full.png", png(30_000, 30_000, 30_000)),
        ("cut.png", png(60_000, 60_000, 0)),
        ("wide.png", png(2_000_000_000, 1, 0)),
        ("tall.png", png(1, 2_000_000_000, 0)),
        ("most.png", png(0x7fff_ffff, 0x7fff_ffff, 0)),
        ("header.exr", exr([60_000, 60_000], &rgb, 0, &[])),
        ("table.exr", exr([60_000, 60_000], &rgb, 3, &[0; 40_000])),
        ("wide.exr", exr([2_000_000_000, 1], &rgb, 0, &[0; 64])),
        ("tall.exr", exr([1, 2_000_000_000], &rgb, 0, &[0; 64])),
        ("most.exr", exr([i32::MAX, i32::MAX], &rgb, 4, &[0; 64])),
        ("many.exr", exr([30_000, 1000], &many, 3, &[0; 60_000])),
    ];
    for (bomb, bytes) in &pictures {
        assert!(bytes.len() < 300_000, "{bomb}");
        folder.write(bomb, bytes);
        for typed in [
            format!("compare {bomb} {name} --map new/map.png"),
            format!("compare {name} {bomb}"),
            format!("sheet {bomb} {name} -o new/sheet.png"),
        ] {
            let run = confined(&folder, &typed);
            assert_eq!((run.exit, &*run.printed), (65, ""), "{typed}: {}", run.said);
            assert!(run.said.contains(bomb), "{typed}: {}", run.said);
            assert!(!folder.path().join("new").exists(), "{typed}");
        }
        // A file without a recipe is not read any further.
        assert_eq!(confined(&folder, &format!("--recipe {bomb}")).exit, 65, "{bomb}");
    }
    let bombs: Vec<&str> = pictures.iter().map(|(bomb, _)| *bomb).collect();
    let bombs = bombs.join(" ");
    let run = confined(&folder, &format!("verify {bombs} {name} -s scene.txt"));
    assert_eq!(run.exit, 65, "{}", run.said);
    let lines: Vec<&str> = run.printed.lines().collect();
    assert_eq!(lines.len(), pictures.len() + 1);
    assert!(lines[..pictures.len()].iter().all(|line| line.starts_with("unverified\t")));
    assert_eq!(lines[pictures.len()], format!("same\t{name}\t1 tile"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_sheet_is_not_made_larger_than_memory() {
    let folder = Folder::new();
    folder.write("tall.png", png(1, 2_000_000, 2_000_000));
    let run = confined(&folder, "sheet tall.png");
    assert_eq!(run.exit, 1, "{}", run.said);
    assert!(run.said.contains("248x20000"), "{}", run.said);
}

#[test]
fn large_pictures_are_read() {
    let folder = Folder::new();
    folder.write("large.png", png(6000, 3000, 3000));
    let run = folder.run("sheet large.png --width 60");
    assert_eq!((run.exit, &*run.printed), (0, "sheet.png\n"), "{}", run.said);
}
