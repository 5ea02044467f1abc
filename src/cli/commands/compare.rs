//! `compare`: measures how much two pictures differ.

use crate::cli::args::CompareArgs;
use crate::cli::base::{Exit, Problem, print};
use crate::cli::files::new_folders::NewFolders;
use crate::cli::files::paths::{check_distinct, check_path};
use crate::cli::files::pictures::read;
use crate::cli::values::check_name;
use slo_picture::compare::{Comparison, Distances, compare};
use slo_picture::output::{Raster, write_difference_map};

/// Prints the distances of a picture from a reference. Fails if a distance exceeds its limit.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Problem> {
    let _folders = args.map.as_deref().map(NewFolders::of);
    if let Some(map) = &args.map {
        check_name("--map", map).map_err(|why| Problem::new(Exit::Usage, why))?;
        check_distinct(map, [&args.picture, &args.reference])?;
        check_path(map)?;
    }
    let (picture, reference) = (read(&args.picture)?, read(&args.reference)?);
    let Some(Comparison { distances, flip, area, whole }) = compare(&picture, &reference) else {
        return Err(not_alike(args, &picture, &reference));
    };
    print(report(&distances).as_bytes()).map_err(|error| {
        Problem::new(Exit::Failed, format!("can't print the distances: {error}"))
    })?;
    drop((picture, reference));
    if let Some(path) = &args.map {
        write_difference_map(path, area, whole, &flip).map_err(|error| {
            Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", path.display()))
        })?;
    }
    check(&distances, args)
}

fn not_alike(args: &CompareArgs, picture: &Raster, reference: &Raster) -> Problem {
    let (one, other) = (args.picture.display(), args.reference.display());
    let size = |raster: &Raster| format!("{}x{}", raster.image.width, raster.image.height);
    let (size, expected) = (size(picture), size(reference));
    let message = match size == expected {
        true => format!("`{one}` and `{other}` show different regions"),
        false => format!("`{one}` has {size} pixels, but `{other}` has {expected}"),
    };
    Problem::new(Exit::BadInput, message)
}

/// Formats one line per distance: name, tab, number.
fn report(distances: &Distances) -> String {
    let Distances { pixels, rmse, relative_mse, mean_ratio, psnr, flip } = distances;
    format!(
        "pixels\t{pixels}\nrmse\t{rmse:.4e}\nrelative-mse\t{relative_mse:.4e}\n\
         mean-ratio\t{mean_ratio:.6}\npsnr\t{psnr:.2}\nflip\t{flip:.5}"
    )
}

fn check(distances: &Distances, args: &CompareArgs) -> Result<(), Problem> {
    let limits = [
        ("pixels", distances.pixels as f64, args.max_pixels.map(|n| n as f64)),
        ("rmse", distances.rmse, args.max_rmse),
        ("relative-mse", distances.relative_mse, args.max_relative_mse),
        ("bias", (distances.mean_ratio - 1.0).abs(), args.max_bias),
        ("flip", distances.flip, args.max_flip),
    ];
    let beyond = limits.into_iter().filter_map(|(name, found, limit)| {
        let limit = limit?;
        let found = (found.is_nan() || found > limit).then(|| shown(found))?;
        Some(format!("{name} is {found}, beyond {limit}"))
    });
    match beyond.collect::<Vec<_>>() {
        none if none.is_empty() => Ok(()),
        beyond => Err(Problem::new(Exit::Failed, beyond.join("; "))),
    }
}

/// Formats a whole number as it is, and any other with a few digits.
fn shown(number: f64) -> String {
    if number.fract() == 0.0 { number.to_string() } else { format!("{number:.4e}") }
}
