//! Finished pictures, whoever made them: pixels, layers and recipe.

use crate::{file, within_limits};
use slo_picture::output;

const RECIPE: &str = "{\n  \"program\": \"slo-rt\",\n  \"frame\": 0\n}";

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let path = file("picture", data);
        if let Ok(raster) = output::Raster::read(&path) {
            let count = raster.image.width as usize * raster.image.height as usize;
            assert_eq!(raster.image.rgb.len(), count);
            let _ = raster.cut(raster.area());
            let _ = raster.into_shown();
        }
        let _ = output::read_layers(&path);
        output::claimed_pixels(&path);
        let recipe = output::read_recipe(&path).unwrap_or_default();
        output::find_picture(&path, RECIPE);
        output::find_picture(&path, &recipe);
        output::find_timed_picture(&path, RECIPE);
        output::made_by_others(&path);
        let _ = output::check_companion(&path);
    });
}
