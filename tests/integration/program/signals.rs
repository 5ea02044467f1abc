//! Ctrl-C.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Folder, SCENE};

/// Minutes of rendering, in tiles of a fraction of a second.
fn long() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 256");
    Folder::with_scene(&text.replace("width 16 height 9", "width 8000 height 8000"))
}

/// Whether this process, and so its children, ignore SIGINT: `nohup` and background jobs of
/// scripts do, and the program respects it.
fn interrupts_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    u64::from_str_radix(mask.trim(), 16).unwrap_or(0) & 0b11 != 0
}

fn check(signal: &str) {
    if interrupts_are_ignored() {
        eprintln!("SIGINT or SIGHUP is ignored here: nothing to see");
        return;
    }
    let folder = long();
    let mut child = folder
        .command("-s scene.txt")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "it still renders");
    let start = Instant::now();
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{signal}");
    assert!(output.stdout.is_empty());
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
    assert!(start.elapsed() < Duration::from_secs(60), "it stops at the next tile");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn an_interrupted_rendering_leaves_nothing() {
    check("-INT");
}

#[test]
fn a_terminated_rendering_leaves_nothing() {
    check("-TERM");
}
