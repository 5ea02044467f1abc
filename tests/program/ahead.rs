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
