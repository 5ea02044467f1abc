//! `import`: scenes of other programs as scene text.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::cli::args::ImportArgs;
use crate::cli::base::{Exit, Problem, Terminal, print};
use crate::cli::files::new_folders::NewFolders;
use slo_import::{ImportError, Imported, import};
use slo_picture::output::write_atomically;

/// Imports a file, and prints the path of the scene.
pub(crate) fn run(args: &ImportArgs, terminal: Terminal) -> Result<(), Problem> {
    let imported = import(&args.file, args.allow_outside).map_err(|error| problem(&error))?;
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(&imported.name));
    if folder.as_os_str().is_empty() {
        return Err(Problem::new(Exit::Usage, "--output: the path is empty"));
    }
    let scene = folder.join(format!("{}.txt", imported.name));
    let paths = paths(&folder, &imported);
    if !args.overwrite {
        let taken = paths.iter().map(|(path, _)| path).chain([&scene]).find(|path| path.exists());
        if let Some(path) = taken {
            let message = format!("`{}` exists already", path.display());
            return Err(Problem::new(Exit::CantCreate, message)
                .with_help("`--overwrite` replaces it, and `-o` names another folder"));
        }
    }
    let _folders: Vec<NewFolders> = paths
        .iter()
        .map(|(path, _)| path)
        .chain([&scene])
        .map(|path| NewFolders::of(path))
        .collect();
    // The scene comes last, so that it never names files that are not there.
    let scene_file = (scene.clone(), imported.text.as_bytes());
    let mut made: Vec<&Path> = Vec::new();
    for (path, bytes) in paths.iter().chain([&scene_file]) {
        let is_new = !path.exists();
        if let Err(problem) = write(path, bytes) {
            made.iter().for_each(|path| drop(fs::remove_file(path)));
            return Err(problem);
        }
        made.extend(is_new.then_some(path.as_path()));
    }
    tell(&imported, terminal);
    print(scene.as_os_str().as_encoded_bytes()).map_err(|error| {
        Problem::new(Exit::Failed, format!("can't print the scene's path: {error}"))
    })
}

/// Where the files of a scene go.
fn paths<'a>(folder: &Path, imported: &'a Imported) -> Vec<(PathBuf, &'a [u8])> {
    let path = |(name, bytes): &'a (String, Vec<u8>)| (folder.join(name), bytes.as_slice());
    imported.files.iter().map(path).collect()
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    let mut is_made = false;
    let mut make = || -> io::Result<()> {
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        write_atomically(path, |file| {
            is_made = true;
            file.write_all(bytes)
        })
    };
    make().map_err(|error| {
        let (exit, what) =
            if is_made { (Exit::CantWrite, "write") } else { (Exit::CantCreate, "create") };
        Problem::new(exit, format!("can't {what} `{}`: {error}", path.display()))
    })
}

fn tell(imported: &Imported, terminal: Terminal) {
    let Imported { shapes: (triangles, others), materials, lamps, .. } = imported;
    let mut parts = Vec::new();
    for (count, one, many) in [
        (triangles, "triangle", "triangles"),
        (others, "other shape", "other shapes"),
        (materials, "material", "materials"),
        (lamps, "lamp", "lamps"),
    ] {
        if *count > 0 {
            parts.push(format!("{count} {}", if *count == 1 { one } else { many }));
        }
    }
    terminal.note(format_args!("imported {}", parts.join(", ")));
    for made_up in &imported.made_up {
        terminal.note(format_args!("made up: {made_up}"));
    }
    for left_out in &imported.left_out {
        terminal.warn(format_args!("left out: {left_out}"));
    }
}

fn problem(error: &ImportError) -> Problem {
    let exit = match error {
        ImportError::Read { .. } => Exit::NoInput,
        _ => Exit::BadInput,
    };
    Problem::new(exit, error.to_string())
}
