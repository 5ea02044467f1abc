//! `import`: scenes of other programs.

use super::Folder;

const SPHERES: &str = "v from 0 -5 1 at 0 0 0 up 0 0 1 angle 45 hither 1 resolution 16 9
b .1 .2 .3
l 3 -4 5
f 1 .5 0 .5 .25 8 0 0
s 0 0 0 1
";

#[test]
fn an_imported_scene_renders() {
    let folder = Folder::new();
    folder.write("balls.nff", SPHERES);
    let run = folder.run("import balls.nff");
    assert_eq!((run.exit, &*run.printed), (0, "balls/balls.txt\n"));
    assert!(run.said.contains("imported 1 other shape, 1 material, 1 lamp"), "{}", run.said);
    let run = folder.run("-s balls/balls.txt --samples 1 -q");
    assert_eq!((run.exit, &*run.printed, &*run.said), (0, "frame_00000.png\n", ""));
}

#[test]
fn files_that_exist_stay() {
    let folder = Folder::new();
    folder.write("balls.nff", SPHERES);
    assert_eq!(folder.printed("import balls.nff -o in -q"), "in/balls.txt\n");
    folder.write("in/balls.txt", "mine");
    let run = folder.run("import balls.nff -o in");
    assert_eq!(run.exit, 73);
    assert!(run.said.contains("`in/balls.txt` exists already"), "{}", run.said);
    assert_eq!(folder.read("in/balls.txt"), b"mine");
    assert_eq!(folder.printed("import balls.nff -o in -q --overwrite"), "in/balls.txt\n");
}

#[test]
fn what_can_not_be_imported_leaves_nothing() {
    let folder = Folder::new();
    folder.write("bad.nff", "s 0 0 0 x");
    folder.write("good.nff", SPHERES);
    for (typed, exit, said) in [
        ("import gone.gltf", 66, "can't read `gone.gltf`"),
        ("import bad.nff", 65, "`bad.nff`, line 1: expected a number instead of `x`"),
        ("import bad.nff -o \"\"", 65, "line 1"),
        ("import", 2, "FILE"),
        ("import a.nff b.nff", 2, "tip: import one file at a time"),
        ("import good.nff -o bad.nff", 73, "can't create `bad.nff/good.txt`"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
    }
    assert!(!folder.path().join("bad").exists());
}
