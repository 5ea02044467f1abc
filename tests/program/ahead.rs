//! Frames that are built, and pictures that are written, while another frame is rendered.

use super::{Folder, SCENE};

/// Four frames of a mesh that has another shape in each.
fn folder() -> Folder {
    let scene = SCENE.replace(
        "sphere ball",
        "mesh sail { shapes { filename sail_##.slo first 0 last 4 fps 25 } material matte }
         sphere ball",
    );
    let folder = Folder::with_scene(&scene);
    for i in 0..=4 {
        let top = 2.0 - 0.3 * f64::from(i);
        let mesh = format!("slo_mesh 1 vertices {{ -2 -2 0 2 -2 0 0 -2 {top} }} faces {{ 0 1 2 }}");
        folder.write(&format!("sail_{i:02}.slo"), mesh);
    }
    folder
}

fn names(frames: &[u32]) -> String {
    frames.iter().map(|frame| format!("ball_{frame:05}.png\n")).collect()
}

#[test]
fn a_sequence_has_the_bytes_of_single_frames_in_order() {
    let (together, alone) = (folder(), folder());
    let run = together.run("-s scene.txt -f 0-3 -v --threads 2");
    assert_eq!((run.exit, run.printed), (0, names(&[0, 1, 2, 3])), "{}", run.said);
    assert!(run.said.contains("beside rendering: building "), "{}", run.said);
    let one_thread = alone.run("-s scene.txt -f 0-3 -v --threads 1");
    assert!(!one_thread.said.contains("beside rendering"), "{}", one_thread.said);
    for frame in 0..4 {
        let name = format!("ball_{frame:05}.png");
        let picture = together.read(&name);
        assert!(picture == alone.read(&name), "{name}");
        alone.printed(&format!("-q -s scene.txt -f {frame}"));
        assert!(picture == alone.read(&name), "{name}");
    }
}

#[test]
fn a_frame_that_cannot_be_built_costs_no_other_frame() {
    let folder = folder();
    folder.write("sail_02.slo", "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 x } faces { 0 1 2 }");
    let run = folder.run("-s scene.txt -f 0-3 --threads 2 --progress json");
    assert_eq!((run.exit, &*run.printed), (1, &*names(&[0, 1, 3])), "{}", run.said);
    let place = |text: &str| run.said.find(text).unwrap_or_else(|| panic!("{text}: {}", run.said));
    let failed = place("error: frame 2: ");
    assert!(run.said[failed..].contains("sail_02.slo"), "{}", run.said);
    let finished = |frame: u32| {
        let event = |line: &&str| line.contains("\"finished\"");
        let events = run.said.lines().filter(event);
        let mut events = events.filter(|line| line.contains(&format!("\"frame\":{frame},")));
        let line = events.next().unwrap_or_else(|| panic!("{frame}: {}", run.said));
        place(line)
    };
    assert!(finished(1) < failed && failed < finished(3), "{}", run.said);
    // A file that nobody needs may be missing, one that a frame needs may not.
    std::fs::remove_file(folder.path().join("sail_02.slo")).unwrap();
    let run = folder.run("-s scene.txt -f 0-3 --overwrite --threads 2");
    assert_eq!(run.exit, 66, "{}", run.said);
}

#[test]
fn only_frames_whose_shapes_changed_are_rendered_again() {
    let folder = folder();
    folder.run("-q -s scene.txt -f 0-3");
    let mesh = "slo_mesh 1 vertices { -2 -2 0 2 -2 0 0 -2 3 } faces { 0 1 2 }";
    folder.write("sail_02.slo", mesh);
    let verified = folder.run("verify ball_00000.png ball_00002.png -s scene.txt");
    assert!(verified.said.contains("the scene has changed since"), "{}", verified.said);
    assert!(!verified.said.contains("different tiles"), "{}", verified.said);
    let again = folder.run("-s scene.txt -f 0-3 --progress json");
    let rendered = |frame: u32| {
        let of_frame = |line: &&str| line.contains(&format!("\"frame\":{frame},"));
        let mut lines = again.said.lines().filter(of_frame);
        lines.any(|line| line.contains("\"finished\"") && !line.contains("\"skipped\""))
    };
    assert_eq!([0, 1, 2, 3].map(rendered), [false, false, true, false], "{}", again.said);
}

#[test]
fn a_part_does_not_go_with_parts_of_another_shape() {
    let folder = folder();
    folder.run("-q -s scene.txt -f 2 --part 1/2 --part-by samples");
    folder.write("sail_02.slo", "slo_mesh 1 vertices { -2 -2 0 2 -2 0 0 -2 3 } faces { 0 1 2 }");
    folder.run("-q -s scene.txt -f 2 --part 2/2 --part-by samples");
    let merged = folder.run("merge ball_00002.samples-1-of-2.part ball_00002.samples-2-of-2.part");
    assert_eq!(merged.exit, 65, "{} {}", merged.said, folder.names().join(" "));
}

#[test]
fn events_come_frame_by_frame() {
    let folder = folder();
    let run = folder.run("-s scene.txt -f 0-3 --threads 2 --progress json -q");
    let events = run.said.lines().map(|line| {
        let event: serde_json::Value = serde_json::from_str(line).unwrap();
        (
            event["event"].as_str().unwrap().to_owned(),
            event["frame"].as_i64(),
            event["index"].as_i64(),
        )
    });
    let events: Vec<_> =
        events.filter(|event| event.1.is_some() && event.0 != "progress").collect();
    let expected = (0..4).flat_map(|frame| {
        [
            ("started".to_owned(), Some(frame), Some(frame + 1)),
            ("finished".to_owned(), Some(frame), None),
        ]
    });
    assert_eq!(events, expected.collect::<Vec<_>>());
}
