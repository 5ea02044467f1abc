//! `compare`: how far two pictures are apart.

use std::path::Path;

use super::Exit;
use super::args::CompareArgs;
use super::problem::Problem;
use super::terminal::print;
use crate::compare::{Distances, compare};
use crate::film::Area;
use crate::output::{Raster, write_difference_map};

/// Prints the distances of a picture from a reference; fails where one is beyond what is allowed.
pub(super) fn run(args: &CompareArgs) -> Result<(), Problem> {
    let (picture, reference) = (read(&args.picture)?, read(&args.reference)?);
    let Some((distances, map)) = compare(&picture, &reference) else {
        let size = |raster: &Raster| format!("{}x{}", raster.image.width, raster.image.height);
        let message = format!(
            "`{}` has {} pixels and `{}` {}",
            args.picture.display(),
            size(&picture),
            args.reference.display(),
            size(&reference)
        );
        return Err(Problem::new(Exit::BadInput, message));
    };
    print(report(&distances).as_bytes()).map_err(|error| {
        Problem::new(Exit::Failed, format!("can't print the distances: {error}"))
    })?;
    if let Some(path) = &args.map {
        let area = Area::whole(picture.image.width, picture.image.height);
        write_difference_map(path, area, &map).map_err(|error| {
            Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", path.display()))
        })?;
    }
    check(&distances, args)
}

/// A picture that is there.
pub(super) fn read(path: &Path) -> Result<Raster, Problem> {
    Raster::read(path).map_err(|error| {
        let exit = if path.is_file() { Exit::BadInput } else { Exit::NoInput };
        Problem::new(exit, format!("can't read `{}`: {error}", path.display()))
    })
}

/// A line each: name, tab, number.
fn report(distances: &Distances) -> String {
    let Distances { pixels, rmse, relative_mse, psnr, flip } = distances;
    format!(
        "pixels\t{pixels}\nrmse\t{rmse:.4e}\nrelative-mse\t{relative_mse:.4e}\n\
         psnr\t{psnr:.2}\nflip\t{flip:.5}"
    )
}

fn check(distances: &Distances, args: &CompareArgs) -> Result<(), Problem> {
    let limits = [
        ("pixels", Some(distances.pixels as f64), args.max_pixels.map(|n| n as f64)),
        ("rmse", Some(distances.rmse), args.max_rmse),
        ("relative-mse", Some(distances.relative_mse), args.max_relative_mse),
        ("flip", Some(distances.flip), args.max_flip),
    ];
    let beyond = limits.into_iter().find_map(|(name, found, limit)| {
        let (found, limit) = (found?, limit?);
        (found.is_nan() || found > limit).then(|| format!("{name} is beyond {limit}"))
    });
    match beyond {
        Some(message) => Err(Problem::new(Exit::Failed, message)),
        None => Ok(()),
    }
}
