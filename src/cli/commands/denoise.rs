//! `denoise`: writes pictures without their noise, beside the noisy ones or to another folder.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::args::DenoiseArgs;
use crate::cli::base::{Exit, Problem, Terminal, print};
use crate::cli::files::new_folders::NewFolders;
use crate::cli::files::pictures::{NO_PICTURE, read, unreadable};
use crate::cli::values::Threads;
use slo_picture::denoise::{Denoiser, Noisy};
use slo_picture::film::FileLayer;
use slo_picture::output::{
    Picture, Raster, Values, check_writable, is_companion, is_denoised, read_layers, read_recipe,
    settings_of, with_denoiser,
};
use slo_scene::Look;

/// Denoises the pictures one after the other, and prints the paths of the results.
pub(crate) fn run(args: &DenoiseArgs, terminal: Terminal) -> Result<(), Problem> {
    let threads = args.threads.and_then(|threads| match threads {
        Threads::All => None,
        Threads::Count(threads) => Some(threads),
    });
    let denoiser = Denoiser::load(args.library.as_deref(), threads).map_err(not_there)?;
    for path in &args.pictures {
        let target = target(path, args.outdir.as_deref());
        let _folders = NewFolders::of(&target);
        check_target(path, &target)?;
        let layers = denoise(path, &target, &denoiser)?;
        let told = match layers.is_empty() {
            true => {
                "from its colours alone; layers (`--layers albedo,normal`) would keep more detail"
                    .to_owned()
            }
            false => format!("from its colours, {}", names(&layers)),
        };
        terminal.note(format_args!("denoised `{}` {told}", path.display()));
        print(target.as_os_str().as_encoded_bytes()).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't print the picture's path: {error}"))
        })?;
    }
    Ok(())
}

fn not_there(why: String) -> Problem {
    Problem::new(Exit::Failed, format!("Open Image Denoise can't be loaded: {why}")).with_help(
        "name its library, version 2, with `--library FILE`; docs/denoising.md says where to get it",
    )
}

/// Returns the path of the denoised picture: beside the noisy one under another name, or in
/// another folder under the same name.
fn target(path: &Path, outdir: Option<&Path>) -> PathBuf {
    let name = path.file_name().unwrap_or_default();
    match outdir {
        Some(folder) => folder.join(name),
        None => {
            let part = |part: Option<&std::ffi::OsStr>| {
                part.unwrap_or_default().to_string_lossy().into_owned()
            };
            let (stem, extension) = (part(path.file_stem()), part(path.extension()));
            path.with_file_name(format!("{stem}_denoised.{extension}"))
        }
    }
}

/// Checks that the denoised picture can be written and does not replace the noisy one.
fn check_target(path: &Path, target: &Path) -> Result<(), Problem> {
    check_writable(target).map_err(|error| {
        Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", target.display()))
    })?;
    if let (Ok(one), Ok(other)) = (path.canonicalize(), target.canonicalize())
        && one == other
    {
        let message = format!("`{}` would be replaced by its denoised copy", path.display());
        return Err(
            Problem::new(Exit::Usage, message).with_help("choose another folder with `--outdir`")
        );
    }
    Ok(())
}

/// Denoises one picture, and returns the layers that helped.
fn denoise(path: &Path, target: &Path, denoiser: &Denoiser) -> Result<Vec<FileLayer>, Problem> {
    let shown = path.display();
    let bad = |why: String| Problem::new(Exit::BadInput, format!("`{shown}`: {why}"));
    let raster = read(path)?;
    let recipe = read_recipe(path).map_err(|error| bad(error.to_string()))?;
    if is_companion(&recipe) {
        return Err(bad(NO_PICTURE.into()));
    }
    let parsed: Value = serde_json::from_str(&recipe).map_err(|error| bad(error.to_string()))?;
    if is_denoised(&parsed) {
        return Err(bad("it is denoised already".into()));
    }
    let Some((format, look)) = settings_of(&parsed) else {
        return Err(bad("its recipe does not name a file format".into()));
    };
    let layers = read_layers(path).map_err(|error| {
        Problem::new(unreadable(&error), format!("can't read `{shown}`: {error}"))
    })?;
    let crop = raster.crop;
    let is_linear = raster.values == Values::Linear;
    let noisy = Noisy { image: &raster.image, is_linear, layers: &layers };
    let used: Vec<FileLayer> = noisy.usable().into_iter().map(|(layer, _)| layer.clone()).collect();
    let image = denoiser
        .denoise(&noisy)
        .map_err(|why| Problem::new(Exit::Failed, format!("`{shown}` can't be denoised: {why}")))?;
    let image = Raster { image, ..raster }.into_linear();
    let helped = if used.is_empty() { String::new() } else { format!(": {}", names(&used)) };
    let recipe = with_denoiser(&recipe, &format!("{}{helped}", denoiser.name()));
    // The values of a PNG file are exposed and mapped already.
    let look = Look::of(look.encoding);
    let picture = Picture { image: &image, format, look, recipe: &recipe, crop };
    picture.save_with(target, &layers).map_err(|error| {
        Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", target.display()))
    })?;
    Ok(used)
}

fn names(layers: &[FileLayer]) -> String {
    layers.iter().map(FileLayer::name).collect::<Vec<_>>().join(", ")
}
