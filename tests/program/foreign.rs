//! Files with the names of pictures that slo-rt did not make are left alone.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use super::{Folder, SCENE};

const NOTES: &[u8] = b"retouched by hand for three hours\n";
const FRAMES: &str = "-s scene.txt -q -f 0-2";

/// A picture that another program has read and saved again, including its text.
fn resaved(picture: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let info = reader.info();
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, info.width, info.height);
    encoder.set_color(info.color_type);
    for text in &info.uncompressed_latin1_text {
        encoder.add_text_chunk(text.keyword.clone(), text.text.clone()).unwrap();
    }
    pixels.iter_mut().for_each(|value| *value = value.saturating_add(1));
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    out
}

#[test]
fn a_sequence_leaves_files_of_others_alone_and_says_so() {
    for share in ["", "--share"] {
        let folder = Folder::new();
        let whole = {
            folder.printed(FRAMES);
            folder.read("ball_00001.png")
        };
        for content in [NOTES.to_vec(), resaved(&whole)] {
            fs::remove_file(folder.path().join("ball_00000.png")).unwrap();
            folder.write("ball_00001.png", &content);
            let plan = folder.printed(&format!("{FRAMES} --dry-run"));
            let states: Vec<_> =
                plan.lines().map(|line| line.rsplit('\t').next().unwrap()).collect();
            assert_eq!((states[0], states[2]), ("missing", "finished"));
            assert!(states[1].starts_with("foreign ("), "{plan}");
            let run = folder.run(&format!("{FRAMES} {share}"));
            assert_eq!(
                (run.exit, &*run.printed),
                (1, "ball_00000.png\nball_00002.png\n"),
                "{}",
                run.said
            );
            for said in ["frame 1: can't create `ball_00001.png`", "did not make", "--overwrite"] {
                assert!(run.said.contains(said), "no `{said}` in {}", run.said);
            }
            assert!(folder.read("ball_00001.png") == content);
            for typed in ["-f 1", "-f 1 --skip-existing", "-f 1-1"] {
                let run = folder.run(&format!("-s scene.txt -q {typed}"));
                assert_eq!((run.exit, &*run.printed), (73, ""), "{typed}: {}", run.said);
                assert!(folder.read("ball_00001.png") == content, "{typed}");
            }
        }
        folder.printed(&format!("{FRAMES} --overwrite"));
        assert!(folder.read("ball_00001.png") == whole);
    }
}

#[test]
fn what_holds_nothing_is_replaced() {
    let folder = Folder::new();
    folder.printed(FRAMES);
    let whole = folder.read("ball_00001.png");
    for content in [&b""[..], &whole[..5], &whole[..30], &whole[..whole.len() / 2], &[0; 5000]] {
        folder.write("ball_00001.png", content);
        folder.printed(FRAMES);
        assert!(folder.read("ball_00001.png") == whole);
    }
}

#[test]
fn a_file_that_comes_while_the_frame_is_rendered_stays() {
    let text = SCENE.replace("imageSamples 2", "imageSamples 2000");
    let folder = Folder::with_scene(&text.replace("width 16 height 9", "width 200 height 100"));
    let mut command = folder.command("-s scene.txt -q --progress json");
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("\"started\"")));
    folder.write("ball_00000.png", NOTES);
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(73), "{said:?}");
    assert!(folder.read("ball_00000.png") == NOTES);
    fs::remove_file(folder.path().join("ball_00000.png")).unwrap();
    folder.printed("-s scene.txt -q");
    assert_eq!(folder.names(), ["ball_00000.png"], "its samples are gone on with");
}

#[test]
fn parts_and_kept_states_replace_nothing_of_others() {
    let folder = Folder::new();
    let part = "ball_00000.pixels-1-of-2.part";
    folder.write(part, NOTES);
    let run = folder.run("-s scene.txt -q --part 1/2");
    assert_eq!((run.exit, &*run.printed), (73, ""), "{}", run.said);
    assert!(folder.read(part) == NOTES);
    folder.printed("-s scene.txt -q --part 1/2 --overwrite");
    folder.write("ball_00001.state", NOTES);
    let run = folder.run("-s scene.txt -q -f 1 --keep-state");
    assert_eq!((run.exit, &*run.printed), (74, "ball_00001.png\n"), "{}", run.said);
    assert!(
        run.said.contains("can't write `ball_00001.state`: slo-rt did not make"),
        "{}",
        run.said
    );
    assert!(folder.read("ball_00001.state") == NOTES);
    folder.printed("-s scene.txt -q -f 1 --keep-state --overwrite");
    assert!(folder.read("ball_00001.state") != NOTES);
}

#[test]
fn a_folder_under_a_frames_name_is_foreign() {
    let folder = Folder::new();
    fs::create_dir(folder.path().join("ball_00001.png")).unwrap();
    let planned = folder.run("-s scene.txt -q -f 0-1 --dry-run").printed;
    assert!(planned.contains("1\tball_00001.png\tforeign (a folder)\n"), "{planned}");
    let run = folder.run("-s scene.txt -q -f 0-1");
    assert_eq!((run.exit, &*run.printed), (1, "ball_00000.png\n"), "{}", run.said);
}
