//! Command lines that fail: their exit codes and messages.

use std::process::Stdio;

use super::{Folder, Run, SCENE};

/// The scene with so many samples that rendering takes hours.
fn endless() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 65535");
    Folder::with_scene(&text.replace("width 16 height 9", "width 4000 height 4000"))
}

#[track_caller]
fn check(folder: &Folder, typed: &str, exit: i32, said: &[&str]) {
    let before = folder.names();
    let run = folder.run(typed);
    assert_eq!(run.exit, exit, "{typed}: {}", run.said);
    assert_eq!(run.printed, "", "{typed}");
    for part in said {
        assert!(run.said.contains(part), "{typed}: no `{part}` in\n{}", run.said);
    }
    assert_eq!(folder.names(), before, "{typed}");
}

#[test]
fn wrong_command_lines() {
    let folder = Folder::new();
    check(&folder, "--nonsense", 2, &["--nonsense"]);
    check(&folder, "--scen scene.txt", 2, &["--scene"]);
    check(&folder, "scene.txt", 2, &["--scene scene.txt"]);
    check(&folder, "-f x", 2, &["--frame"]);
    check(&folder, "-s scene.txt -pre a/b", 2, &["--outdir"]);
    check(&folder, "-s scene.txt --size 0x5", 2, &["65536"]);
    check(&folder, "-id in", 2, &["--scene"]);
    let isa = folder.command("-s scene.txt").env("SLO_RT_ISA", "abacus").output().unwrap();
    assert_eq!(Run::of(isa).exit, 2);
}

#[test]
fn a_frame_that_the_scene_does_not_have() {
    let folder = Folder::new();
    check(&folder, "-s scene.txt -f 26", 2, &["frame 26", "`only` 0 s to 1 s", "--frame"]);
    check(&folder, "-s scene.txt -f -1 --check", 2, &["frame -1"]);
    check(&folder, "-s scene.txt -f 9223372036854775807", 2, &[]);
    check(&folder, "-s scene.txt -f -9223372036854775808", 2, &[]);
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_gpu_without_support_for_it() {
    let folder = Folder::new();
    for name in ["GPU_BVH", "gpu_kd", "GPU_GRID"] {
        let typed = format!("-s scene.txt --accelerator {name}");
        check(&folder, &typed, 69, &["--features gpu", "--accelerator BVH"]);
        check(&folder, &format!("{typed} --check"), 69, &["--features gpu"]);
    }
}

#[test]
fn scenes_with_errors() {
    let folder = Folder::with_scene(&SCENE.replace("diffuse", "difuse"));
    folder.write("binary.txt", b"\0\x01\x02");
    let place = "scene.txt:12:";
    check(&folder, "-s scene.txt", 65, &[place, "difuse", "diffuse"]);
    check(&folder, "--check -s scene.txt", 65, &[place]);
    check(&folder, "-q -s scene.txt", 65, &[place]);
    check(&folder, "-s binary.txt", 65, &[]);
}

#[test]
fn what_the_check_passes_can_be_rendered() {
    let key = |x: f64| {
        let up = "up { 0 0 1 }";
        format!(
            "radius 1 addKframe {{ time 0 key {{ pivot {{ 0 0 0 }} {up} right {{ {x:e} 0 1 }} }} }}
             addKframe {{ time 1 key {{ pivot {{ 1 0 0 }} }} }}"
        )
    };
    let mut refused = 0;
    for x in [1e-10, 3e-10, 9.9e-10, 1e-9, 1.01e-9, 1.5e-9, 2e-9, 3e-9] {
        let folder = Folder::with_scene(&SCENE.replacen("radius 1", &key(x), 1));
        let checked = folder.run("--check -s scene.txt");
        let rendered = folder.run("-q -s scene.txt");
        assert_eq!(checked.exit, rendered.exit, "{x}: {}", rendered.said);
        if checked.exit != 0 {
            refused += 1;
            assert_eq!(checked.exit, 65);
            for said in [&checked.said, &rendered.said] {
                assert!(said.contains("up is parallel to right in `key`"), "{x}: {said}");
                assert!(said.contains("scene.txt:14:"), "{x}: {said}");
            }
        }
    }
    assert!((3..8).contains(&refused), "{refused}");
}

#[test]
fn meshes_with_errors() {
    let mesh = "mesh m { filename broken.slo smooth_normals 0 material matte }";
    let folder = Folder::with_scene(&format!("{SCENE}{mesh}"));
    folder.write("broken.slo", "slo_mesh 1\nvertices { 0 0 0 1 0 0 0 1 0 }\nfaces { 0 1 3 }\n");
    check(&folder, "-s scene.txt", 65, &["broken.slo"]);
}

#[test]
fn files_that_are_missing() {
    let folder = Folder::with_scene(&format!(
        "{SCENE} mesh m {{ filename missing.slo smooth_normals 0 material matte }}"
    ));
    check(&folder, "-s scene.txt", 66, &["missing.slo"]);
    check(&folder, "-s scnee.txt", 66, &["did you mean `scene.txt`?"]);
    check(&folder, "-s none/scene.txt", 66, &["none/scene.txt"]);
    check(&folder, "-s .", 66, &["directory"]);
    check(&folder, "--recipe none.png", 66, &["none.png"]);
}

#[test]
fn files_that_are_no_pictures() {
    let folder = Folder::new();
    check(&folder, "--recipe scene.txt", 65, &["not a PNG or EXR"]);
}

#[test]
fn folders_that_are_no_files() {
    let folder = Folder::new();
    folder.printed("-q -s scene.txt");
    let picture = "ball_00000.png";
    for typed in ["--recipe .", "merge .", "compare . .", "sheet .", "-s .", "--check -s ."] {
        check(&folder, typed, 66, &["is a directory"]);
    }
    check(&folder, &format!("compare {picture} ."), 66, &["is a directory"]);
    let run = folder.run("verify . -s scene.txt");
    assert_eq!((run.exit, &*run.printed), (66, "unverified\t.\tis a directory\n"));
}

#[test]
fn paths_that_leave_the_input_folder() {
    let mesh = "mesh m { filename ../tetra.slo smooth_normals 0 material matte }";
    let folder = Folder::new();
    folder.write("in/deep/scene.txt", format!("{SCENE}{mesh}"));
    folder.write(
        "in/tetra.slo",
        "slo_mesh 1\nvertices { 0 0 0 1 0 0 0 1 0 0 0 1 }\nfaces { 0 2 1 0 1 3 1 2 3 2 0 3 }\n",
    );
    let ways_out = ["--indir", "--allow-outside"];
    check(&folder, "-s scene.txt -id in/deep --check", 65, &ways_out);
    check(&folder, "-s ../../scene.txt -id in/deep --check", 2, &ways_out);
    check(&folder, "-s deep/scene.txt -id in --check", 0, &[]);
    check(&folder, "-s in/deep/scene.txt --check", 0, &[]);
    check(&folder, "-s scene.txt -id in/deep --allow-outside --check", 0, &[]);
}

#[test]
fn what_cannot_be_created_is_found_before_rendering() {
    let folder = endless();
    folder.write("file", "");
    folder.write("taken/ball_00000.png/inside", "");
    check(&folder, "-s scene.txt -od file", 73, &["file", "not a directory", "--outdir"]);
    check(&folder, "-s scene.txt -od file/deeper", 73, &["--outdir"]);
    check(&folder, "-s scene.txt -od taken", 73, &["ball_00000.png"]);
    check(&folder, &format!("-s scene.txt -pre {}", "x".repeat(300)), 73, &[]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_nobody_can_write_to() {
    check(&endless(), "-s scene.txt -od /proc/none", 73, &["/proc/none"]);
}

#[test]
fn nobody_reads_the_path() {
    let folder = Folder::new();
    let mut child = folder
        .command("-q -s scene.txt")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.exit, &*run.said), (0, ""));
    assert_eq!(folder.names(), ["ball_00000.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_is_full() {
    let folder = Folder::new();
    folder.printed("-s scene.txt");
    for typed in ["--recipe ball_00000.png", "--help", "-h", "--version"] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let run = Run::of(folder.command(typed).stdout(full).output().unwrap());
        assert_eq!(run.exit, 1, "{typed}");
        assert!(run.said.contains("can't print the "), "{typed}: {}", run.said);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn pictures_are_rendered_even_where_their_paths_cannot_be_printed() {
    let folder = Folder::new();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let run = Run::of(folder.command("-s scene.txt -f 0-2 -q").stdout(full).output().unwrap());
    assert_eq!(run.exit, 1);
    assert!(run.said.contains("can't print the paths of the pictures"), "{}", run.said);
    assert_eq!(folder.names(), ["ball_00000.png", "ball_00001.png", "ball_00002.png"]);
}
