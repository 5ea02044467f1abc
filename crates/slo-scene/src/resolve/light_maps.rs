//! Light maps of objects: whether their texture coordinates are fit for one.

use crate::attributes::{Fields, Found};
use crate::diagnostics::{Diagnostic, Span};
use crate::light_map::{Layout, LightMap, MOST_TEXELS, Unwrapped};
use crate::shape::Shape;

/// Most texels along the side of a light map that is checked for overlaps; a larger one is checked as if
/// it had so many.
const MOST_CHECKED: u32 = 1024;

/// How far texture coordinates may leave the unit square.
const TOLERANCE: f32 = 1e-4;

/// Advice on texture coordinates.
const UNWRAP: &str = "every triangle needs a place of its own between uv 0 0 and 1 1: in Blender, \
                      `Lightmap Pack` or `Smart UV Project` make one";

/// Reads the light map of an object; `shape` is its shape, if that was read.
pub(super) fn read(
    fields: &mut Fields<'_, '_, '_>,
    shape: Option<&Shape>,
    is_hidden: bool,
) -> Option<LightMap> {
    let side = fields.count("lightMap", 1, MOST_TEXELS);
    let inside = fields.count("lightMapInside", 0, 1).is_some_and(|flag| flag.value == 1);
    if let (None, Some(field)) = (fields.get("lightMap"), fields.get("lightMapInside")) {
        let warning = Diagnostic::warning("`lightMapInside` has no effect without `lightMap`");
        fields.diagnostics.push(warning.at(field.keyword.span, ""));
    }
    let Found { value: side, span } = side?;
    if is_hidden {
        let message = format!("`lightMap` has no effect: {} is hidden", fields.element.title());
        let warning = Diagnostic::warning(message).at(span, "");
        fields.diagnostics.push(warning.help("copies have no light maps of their own"));
    }
    check(fields, shape?, side, span)?;
    Some(LightMap { side, inside })
}

/// Reports texture coordinates that are not fit for a light map; `None` if they can't be used.
fn check(fields: &mut Fields<'_, '_, '_>, shape: &Shape, side: u32, span: Span) -> Option<()> {
    let title = fields.element.title();
    let faces = match shape.unwrapped() {
        Ok(Unwrapped::Faces(faces)) => faces,
        Ok(Unwrapped::Sphere) => return Some(()),
        Err(why) => {
            let message = format!("{title} can't have a light map: {why}");
            let error = Diagnostic::error(message).at(span, "");
            let help = "planes, rectangles, triangles and spheres have texture coordinates that fit, \
                        and so have meshes that were unwrapped";
            fields.diagnostics.push(error.help(help));
            return None;
        }
    };
    let side = side.min(MOST_CHECKED);
    let Some(layout) = Layout::new(&faces, side) else {
        let message = format!("{title} can't have a light map: its texture coordinates pile up");
        let label = format!("{} triangles in {side} x {side} texels", faces.len());
        let error = Diagnostic::error(message).at(span, label);
        fields.diagnostics.push(error.help(UNWRAP));
        return None;
    };
    let all = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let covered = all.filter(|&(x, y)| layout.is_covered(x, y)).count();
    if covered == 0 {
        let message = format!("{title} can't have a light map: no triangle lies in it");
        let error = Diagnostic::error(message).at(span, "");
        fields.diagnostics.push(error.help(UNWRAP));
        return None;
    }
    let is_outside = |c: f32| !(-TOLERANCE..=1.0 + TOLERANCE).contains(&c);
    let outside = faces.iter().filter(|face| face.as_flattened().iter().any(|&c| is_outside(c)));
    let outside = outside.count();
    if outside > 0 {
        let are = if outside == 1 { "triangle is" } else { "triangles are" };
        let message = format!("the light map of {title} does not hold all of it");
        let label = format!("{outside} {are} partly or wholly outside of it");
        fields.diagnostics.push(Diagnostic::warning(message).at(span, label).help(UNWRAP));
    }
    let overlapping = layout.overlapping();
    if overlapping > 0 {
        let message = format!("triangles overlap in the light map of {title}");
        let percent = (100.0 * overlapping as f64 / covered as f64).max(0.1);
        let label = format!("in {percent:.1} % of its texels, which show the light of one of them");
        fields.diagnostics.push(Diagnostic::warning(message).at(span, label).help(UNWRAP));
    }
    Some(())
}
