//! Pictures of shipped scenes through structures that a GPU traverses: the bytes of the CPU's.
//!
//! Without an adapter the tests say so and pass; with `SLO_REQUIRE_GPU=1` they fail.

use std::fs;
use std::process::{Command, Output};

use tempfile::TempDir;

/// The adapter is missing, or cannot take the scene.
const UNAVAILABLE: i32 = 69;

/// Renders a scene in a small size and returns the program's output, and the bytes of the picture.
fn render(scene: &str, accelerator: &str, more: &str) -> (Output, Vec<u8>) {
    let folder = TempDir::new().expect("the system has a folder for temporary files");
    let mut command = Command::new(env!("CARGO_BIN_EXE_slo-rt"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["-v", "-s", scene]);
    command.args(["--size", "64x36", "--samples", "2", "--accelerator", accelerator]);
    command.arg("-od").arg(folder.path()).args(more.split_whitespace());
    let output = command.output().expect("the program starts");
    let picture = fs::read(String::from_utf8_lossy(&output.stdout).trim()).unwrap_or_default();
    (output, picture)
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Whether there is a GPU; if not, says so.
fn has_gpu() -> bool {
    let (output, _) = render("scenes/soft_shadows.txt", "GPU_BVH", "--region 1x1+0+0");
    let is_missing = output.status.code() == Some(UNAVAILABLE);
    let is_asked_for = std::env::var_os("SLO_REQUIRE_GPU").is_some_and(|value| value == "1");
    assert!(!is_missing || !is_asked_for, "SLO_REQUIRE_GPU=1: {}", said(&output));
    if is_missing {
        eprintln!("SKIPPED: {}", said(&output));
    }
    !is_missing
}

#[test]
fn pictures_are_those_of_the_cpu() {
    if !has_gpu() {
        return;
    }
    // Meshes and textures; glass; moving meshes; curved surfaces beside triangles; a mesh that bends.
    for scene in ["table", "glossy_refraction", "motion_blur", "soft_shadows", "flag"] {
        let scene = format!("scenes/{scene}.txt");
        let (_, expected) = render(&scene, "BVH", "");
        assert!(!expected.is_empty(), "{scene}");
        for accelerator in ["GPU_BVH", "GPU_KD", "GPU_GRID"] {
            let (output, picture) = render(&scene, accelerator, "");
            assert!(output.status.success(), "{scene}, {accelerator}: {}", said(&output));
            assert!(picture == expected, "{scene}, {accelerator}");
            let said = said(&output);
            assert!(said.contains(&format!("{accelerator} structure on ")), "{scene}: {said}");
            assert!(!said.contains("failed"), "{scene}: {said}");
        }
    }
}

#[test]
fn any_options_give_the_same_picture() {
    if !has_gpu() {
        return;
    }
    let scene = "scenes/glossy_refraction.txt";
    let (_, expected) = render(scene, "BVH", "");
    for (accelerator, options) in [
        ("GPU_KD", "traversal=restart"),
        ("GPU_KD", "traversal=push-down"),
        ("GPU_KD", "stack=1"),
        ("GPU_GRID", "density=20"),
        ("GPU_BVH", "leaf=8"),
    ] {
        let (output, picture) =
            render(scene, accelerator, &format!("--threads 4 --accelerator-options {options}"));
        assert!(picture == expected, "{accelerator}, {options}: {}", said(&output));
    }
}

#[test]
fn what_is_missing_is_named() {
    let folder = TempDir::new().expect("the system has a folder for temporary files");
    let render = |driver: &str, adapter: &str, more: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slo-rt"));
        command.current_dir(folder.path()).args(more.split_whitespace());
        command.env("SLO_RT_GPU", adapter).args(["--size", "16x9", "--samples", "1"]);
        if !driver.is_empty() {
            command.env("VK_ICD_FILENAMES", driver).env("VK_DRIVER_FILES", driver);
        }
        let output = command.output().expect("the program starts");
        assert_eq!(output.status.code(), Some(UNAVAILABLE), "{}", said(&output));
        said(&output)
    };
    let none = render("/none", "", "--accelerator GPU_BVH");
    assert!(none.contains("GPU_BVH: no GPU: Vulkan finds no adapter"), "{none}");
    assert!(none.contains("--accelerator BVH"), "{none}");
    if has_gpu() {
        let none = render("", "abacus", "--accelerator GPU_KD");
        assert!(none.contains("no GPU is named `abacus`; there are "), "{none}");
        let none = render("", "", "--accelerator GPU_GRID --accelerator-options mailbox=1");
        assert!(none.contains("without mailboxes"), "{none}");
    }
}
