//! Failures while frames are rendered: nothing is lost, and no wrong file gets a final name.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::{Folder, Run, SCENE, noisy_scene};

/// A scene whose frames take a fifth of a second each.
fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 60");
    Folder::with_scene(&text.replace("width 16 height 9", "width 100 height 70"))
}

const FRAMES: &str = "-q -s scene.txt -f 0-3 --checkpoint 1";

/// The frames, rendered without failures.
fn expected() -> Vec<(String, Vec<u8>)> {
    let folder = folder();
    let printed = folder.printed(FRAMES);
    printed.lines().map(|name| (name.to_owned(), folder.read(name))).collect()
}

/// Asserts that every file with a final name is correct.
fn check_names(folder: &Folder, expected: &[(String, Vec<u8>)]) {
    for (name, bytes) in expected {
        let path = folder.path().join(name);
        assert!(!path.exists() || fs::read(&path).unwrap() == *bytes, "{name}: other bytes");
    }
}

fn check_all(folder: &Folder, expected: &[(String, Vec<u8>)]) {
    for (name, bytes) in expected {
        assert!(folder.read(name) == *bytes, "{name}: other bytes");
    }
}

#[test]
fn killed_at_fifty_random_moments() {
    let (expected, folder) = (expected(), folder());
    let mut random = StdRng::seed_from_u64(50);
    let mut kills = 0;
    while kills < 50 {
        let mut child = folder.command(FRAMES).stdout(Stdio::null()).spawn().unwrap();
        sleep(Duration::from_millis(random.random_range(1..400)));
        let done = child.try_wait().unwrap().is_some();
        let _ = child.kill();
        child.wait().unwrap();
        kills += 1;
        check_names(&folder, &expected);
        if done {
            let frame = random.random_range(0..expected.len());
            fs::remove_file(folder.path().join(&expected[frame].0)).unwrap();
        }
    }
    folder.printed(FRAMES);
    check_all(&folder, &expected);
    assert!(!folder.names().iter().any(|name| name.ends_with(".state")), "{:?}", folder.names());
}

#[test]
fn several_processes_on_one_folder() {
    let (expected, folder) = (expected(), folder());
    let start = |order: &str| {
        let typed = format!("{FRAMES} --order {order}");
        folder.command(&typed).stdout(Stdio::null()).spawn().unwrap()
    };
    let mut children = ["forward", "reverse", "coarse"].map(start);
    let _ = children[1].kill();
    for (i, child) in children.iter_mut().enumerate() {
        let status = child.wait().unwrap();
        assert!(i == 1 || status.success(), "process {i}");
    }
    check_all(&folder, &expected);
}

#[test]
fn files_that_were_damaged_are_rendered_again() {
    let (expected, folder) = (expected(), folder());
    folder.printed(FRAMES);
    let mut random = StdRng::seed_from_u64(7);
    for _ in 0..20 {
        let (name, whole) = &expected[random.random_range(0..expected.len())];
        let mut damaged = whole.clone();
        let at = random.random_range(0..whole.len());
        match random.random_range(0..3) {
            0 => damaged.truncate(at),
            1 => damaged[at] ^= 1 << random.random_range(0..8),
            // What a file system may leave of a block after a power failure.
            _ => damaged[at..].iter_mut().take(64).for_each(|byte| *byte = 0),
        }
        folder.write(name, damaged);
        folder.printed(FRAMES);
        check_all(&folder, &expected);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_state_that_can_not_be_kept_leaves_the_picture() {
    let folder = folder();
    for (typed, pictures) in [
        ("-s scene.txt --samples 1", "ball_00000.png\n"),
        ("-s scene.txt --samples 1 -f 1-2", "ball_00001.png\nball_00002.png\n"),
    ] {
        let program = env!("CARGO_BIN_EXE_slo-rt");
        let mut shell = Command::new("sh");
        // Enough for a picture, but not for the sums of its samples.
        shell.arg("-c").arg(format!("ulimit -f 200; exec {program} --keep-state {typed}"));
        let run = Run::of(shell.current_dir(folder.path()).output().unwrap());
        assert_eq!((run.exit, &*run.printed), (74, pictures), "{}", run.said);
        let state = pictures.lines().next().unwrap().replace(".png", ".state");
        assert!(run.said.contains(&format!("can't write `{state}`")), "{}", run.said);
    }
    assert_eq!(folder.names(), ["ball_00000.png", "ball_00001.png", "ball_00002.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_the_size_of_files_is_told_and_leaves_nothing() {
    let folder = folder();
    let limited = |typed: &str| {
        let program = env!("CARGO_BIN_EXE_slo-rt");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(format!("ulimit -f 1; exec {program} {typed}"));
        Run::of(shell.current_dir(folder.path()).output().unwrap())
    };
    let run = limited("-q -s scene.txt -f 0");
    assert_eq!((run.exit, &*run.printed), (74, ""), "{}", run.said);
    assert!(run.said.contains("can't write `ball_00000.png`"), "{}", run.said);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let run = limited("-q -s scene.txt -f 0-1");
    assert!(run.said.contains("2 of 2 frames failed: 0-1"), "{}", run.said);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

/// Under any limit on memory, a picture is either refused before it is rendered, or finished.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_memory_is_told_before_anything_is_lost() {
    let folder = Folder::new();
    for typed in ["", "--format exr --layers normal", "--keep-state", "--error-map map.png"] {
        let mut exits = Vec::new();
        for megabytes in (40..340).step_by(20) {
            let program = env!("CARGO_BIN_EXE_slo-rt");
            let options = "-q -s scene.txt --size 1000x750 --samples 1 --threads 1 --overwrite";
            let line = format!(
                "ulimit -c 0; ulimit -v {}; exec {program} {options} {typed}",
                megabytes * 1000
            );
            let mut shell = Command::new("sh");
            let run = shell.arg("-c").arg(line).current_dir(folder.path()).output().unwrap();
            let run = Run::of(run);
            let is_refused = run.said.contains("error: the picture needs ")
                && run.said.contains("but the limit on the address space");
            assert!(
                run.exit == 0 || (run.exit == 1 && is_refused),
                "{typed} with {megabytes} MB: {} {}",
                run.exit,
                run.said
            );
            exits.push(run.exit);
        }
        assert!(exits.contains(&0) && exits.contains(&1), "{typed}: {exits:?}");
    }
}

#[test]
fn a_clock_that_goes_backwards() {
    let (expected, folder) = (expected(), folder());
    folder.printed("-q -s scene.txt -f 0-1");
    // Files with times in the future, and a scene newer than all of them.
    for (name, _) in &expected[..2] {
        let file = fs::File::options().write(true).open(folder.path().join(name)).unwrap();
        file.set_modified(std::time::SystemTime::now() + Duration::from_secs(1 << 30)).unwrap();
    }
    let plan = folder.printed(&format!("{FRAMES} --dry-run"));
    let states: Vec<_> = plan.lines().map(|line| line.rsplit('\t').next().unwrap()).collect();
    assert_eq!(states, ["finished", "finished", "missing", "missing"]);
    folder.printed(FRAMES);
    check_all(&folder, &expected);
}

/// Whether permissions stop this user; they do not stop root.
fn permissions_count(folder: &Path) -> bool {
    fs::write(folder.join("probe"), "").is_err()
}

#[test]
fn a_folder_that_can_only_be_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::set_permissions(&out, fs::Permissions::from_mode(0o555)).unwrap();
    if permissions_count(&out) {
        let run = folder.run(&format!("{FRAMES} -od out"));
        assert_eq!((run.exit, &*run.printed), (73, ""), "{}", run.said);
        assert!(run.said.contains("can't create `out/ball_00000.png`"), "{}", run.said);
    } else {
        eprintln!("SKIPPED: this user may write to folders that can only be read");
    }
    fs::set_permissions(&out, fs::Permissions::from_mode(0o755)).unwrap();
}

fn wait_for_file(path: &Path) {
    let deadline = Instant::now() + Duration::from_secs(100);
    while !path.exists() && Instant::now() < deadline {
        sleep(Duration::from_millis(20));
    }
}

/// A file system of a few kilobytes, which is unmounted when the value is dropped.
struct SmallDisk(std::path::PathBuf);

impl SmallDisk {
    fn mount(at: std::path::PathBuf, size: &str) -> Option<Self> {
        fs::create_dir(&at).unwrap();
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", size, "tmpfs"]).arg(&at).stderr(Stdio::null());
        mount.status().is_ok_and(|status| status.success()).then_some(Self(at))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_waited_for() {
    let (expected, folder) = (expected(), folder());
    let Some(disk) = SmallDisk::mount(folder.path().join("small"), "size=64k") else {
        eprintln!("SKIPPED: this user may not mount a file system");
        return;
    };
    // 16 pages of 4 KiB, of which two are left: one for each frame.
    assert!(expected.iter().all(|(_, bytes)| bytes.len() <= 4096));
    fs::write(disk.0.join("ballast"), vec![0; 14 * 4096]).unwrap();
    let mut command = folder.command(&format!("-s scene.txt -f 0-3 -od {}", disk.0.display()));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_file(&disk.0.join(&expected[1].0));
    sleep(Duration::from_secs(2));
    assert!(child.try_wait().unwrap().is_none(), "it waits");
    for (name, bytes) in &expected {
        let path = disk.0.join(name);
        assert!(!path.exists() || fs::read(&path).unwrap() == *bytes, "{name}");
    }
    fs::remove_file(disk.0.join("ballast")).unwrap();
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains("waiting until it works, nothing is lost"), "{}", run.said);
    assert!(run.said.contains("the output folder has"), "{}", run.said);
    for (name, bytes) in &expected {
        assert!(fs::read(disk.0.join(name)).unwrap() == *bytes, "{name}");
    }
}

/// Space runs out while each picture is written. No encoder hides the cause.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_inside_a_picture_is_waited_for() {
    for format in ["png", "png16", "exr"] {
        let folder = Folder::with_scene(&noisy_scene([200, 150]));
        let typed = format!("-q -s scene.txt -f 0-1 --checkpoint 0 --format {format}");
        let names: Vec<String> = folder.printed(&typed).lines().map(str::to_owned).collect();
        let Some(disk) = SmallDisk::mount(folder.path().join("small"), "size=2m") else {
            eprintln!("SKIPPED: this user may not mount a file system");
            return;
        };
        // Three pages are left.
        assert!(names.iter().all(|name| folder.read(name).len() > 4 * 4096));
        fs::write(disk.0.join("ballast"), vec![0; (2 << 20) - 3 * 4096]).unwrap();
        let mut command = folder.command(&format!("{typed} -od {}", disk.0.display()));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        sleep(Duration::from_secs(3));
        assert!(child.try_wait().unwrap().is_none(), "{format}: it waits");
        assert!(names.iter().all(|name| !disk.0.join(name).exists()), "{format}");
        fs::remove_file(disk.0.join("ballast")).unwrap();
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 0, "{format}: {}", run.said);
        assert!(run.said.contains("waiting until it works, nothing is lost"), "{}", run.said);
        for name in &names {
            assert!(fs::read(disk.0.join(name)).unwrap() == folder.read(name), "{format}: {name}");
        }
    }
}

/// A disk that is remounted read-only for a while, since permissions do not stop root.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_can_only_be_read_for_a_while_is_waited_for() {
    let (expected, folder) = (expected(), folder());
    let Some(disk) = SmallDisk::mount(folder.path().join("small"), "size=2m") else {
        eprintln!("SKIPPED: this user may not mount a file system");
        return;
    };
    let again = |how: &str| {
        let mut mount = Command::new("mount");
        mount.args(["-o", &format!("remount,{how}")]).arg(&disk.0).stderr(Stdio::null());
        mount.status().unwrap().success()
    };
    for share in ["", "--share=2"] {
        let typed = format!("{FRAMES} -od {} {share}", disk.0.display());
        let mut command = folder.command(&typed);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for_file(&disk.0.join(&expected[0].0));
        // It is busy while a file is open for writing.
        while !again("ro") {
            sleep(Duration::from_millis(5));
        }
        sleep(Duration::from_millis(1500));
        assert!(again("rw"));
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 0, "{share}: {}", run.said);
        for (name, bytes) in &expected {
            assert!(fs::read(disk.0.join(name)).unwrap() == *bytes, "{name}");
            fs::remove_file(disk.0.join(name)).unwrap();
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn waiting_for_a_disk_ends_with_a_signal() {
    let (expected, folder) = (expected(), folder());
    let Some(disk) = SmallDisk::mount(folder.path().join("small"), "size=64k") else {
        eprintln!("SKIPPED: this user may not mount a file system");
        return;
    };
    assert!(expected.iter().all(|(_, bytes)| bytes.len() > 1));
    fs::write(disk.0.join("ballast"), vec![0; 16 * 4096]).unwrap();
    for typed in ["-s scene.txt -f 0", "-s scene.txt -f 0-3", "-s scene.txt -f 0-3 --share=60"] {
        let mut command = folder.command(&format!("{typed} -od {}", disk.0.display()));
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        sleep(Duration::from_secs(4));
        let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!((run.exit, &*run.printed), (75, ""), "{typed}: {}", run.said);
        assert!(run.said.contains("interrupted while waiting to "), "{typed}: {}", run.said);
        let names: Vec<_> = fs::read_dir(&disk.0).unwrap().flatten().collect();
        assert_eq!(names.len(), 1, "{typed}: {names:?}");
    }
}

/// The system's program that reports free space may hang with a file server, so slo-rt does not
/// call it.
#[test]
fn a_program_that_hangs_stops_nothing() {
    let folder = Folder::new();
    folder.write("bin/df", "#!/bin/sh\nexec sleep 1000\n");
    let df = folder.path().join("bin/df");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    fs::set_permissions(df, mode).unwrap();
    let mut command = folder.command("-q -s scene.txt");
    let run = Run::of(command.env("PATH", folder.path().join("bin")).output().unwrap());
    assert_eq!((run.exit, &*run.printed), (0, "ball_00000.png\n"), "{}", run.said);
}

#[test]
fn a_folder_that_vanishes_is_waited_for() {
    let (expected, folder) = (expected(), folder());
    let mut command = folder.command("-s scene.txt -f 0-3 -od out --checkpoint 0");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let out = folder.path().join("out");
    wait_for_file(&out.join(&expected[0].0));
    fs::rename(&out, folder.path().join("elsewhere")).unwrap();
    sleep(Duration::from_millis(1500));
    if !out.exists() && child.try_wait().unwrap().is_none() {
        fs::rename(folder.path().join("elsewhere"), &out).unwrap();
    }
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.said);
    for (name, bytes) in &expected {
        let there = [out.join(name), folder.path().join("elsewhere").join(name)];
        let found = there.iter().find_map(|path| fs::read(path).ok());
        assert!(found.as_ref() == Some(bytes), "{name}");
    }
}
