//! The camera as text.

use glam::DVec3;
use slo_scene::CamSegment;
use slo_scene::edit::{Edit, Outline, Part, numbers};

use super::{PLACES, scaling};

/// How far numbers of the text may be from those of the scene, as a share of their size.
const TOLERANCE: f64 = 1e-3;

/// Returns the changes of a text that make one segment of the camera another one.
///
/// # Errors
/// The text does not hold the segment, because it stands in an included file.
pub(crate) fn camera(
    text: &str,
    before: &CamSegment,
    after: &CamSegment,
) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let scale = scaling(&outline);
    let camera = outline.first("Camera");
    let segment = camera.and_then(|camera| {
        camera.parts("CamSegment").find(|segment| segment.name() == Some(&before.name))
    });
    let segment = segment.filter(|segment| holds(segment, before, scale)).ok_or(
        "the camera stands in a file that the scene includes, so it can't be changed from here",
    )?;
    let mut edits = Vec::new();
    points(&segment, "addPosition", [&before.positions, &after.positions], scale, &mut edits);
    points(&segment, "addTarget", [&before.targets, &after.targets], scale, &mut edits);
    if before.sky != after.sky {
        edits.extend(segment.set_vector("skyStart", &vector(after.sky[0])));
        if segment.value("skyEnd").is_some() || after.sky[0] != after.sky[1] {
            edits.extend(segment.set_vector("skyEnd", &vector(after.sky[1])));
        }
    }
    ends(&segment, ["fovStart", "fovEnd"], [before.fov, after.fov], 1.0, &mut edits);
    let lens = [before.lens_radius, after.lens_radius];
    ends(&segment, ["lensRadiusStart", "lensRadiusEnd"], lens, scale, &mut edits);
    let is_open = after.lens_radius.iter().any(|radius| *radius > 0.0);
    let lacks_focus = is_open && segment.value("dofStart").is_none();
    let old = if lacks_focus { [f64::NAN; 2] } else { before.dof };
    ends(&segment, ["dofStart", "dofEnd"], [old, after.dof], scale, &mut edits);
    if before.blur_duration != after.blur_duration {
        edits.extend(segment.set("blurDuration", &numbers(&[after.blur_duration], PLACES)));
    }
    Ok(edits)
}

/// Whether a text holds this segment.
fn holds(segment: &Part<'_, '_>, known: &CamSegment, scale: f64) -> bool {
    let first =
        segment.numbers("addPosition").and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let is_near = |first: [f64; 3], known: DVec3| {
        (DVec3::from(first) * scale - known).length() <= TOLERANCE * (1.0 + known.length())
    };
    let count = segment.names().filter(|name| *name == "addPosition").count();
    count == known.positions.len()
        && first.zip(known.positions.first()).is_some_and(|(first, known)| is_near(first, *known))
}

fn vector(of: DVec3) -> String {
    numbers(&of.to_array(), PLACES)
}

fn points(
    segment: &Part<'_, '_>,
    name: &str,
    [before, after]: [&[DVec3]; 2],
    scale: f64,
    edits: &mut Vec<Edit>,
) {
    for (i, (before, after)) in before.iter().zip(after).enumerate() {
        if before != after {
            edits.extend(segment.set_one(name, i, &vector(*after / scale)));
        }
    }
}

/// Changes the numbers of the start and the end of a segment.
fn ends(
    segment: &Part<'_, '_>,
    [start, end]: [&str; 2],
    [before, after]: [[f64; 2]; 2],
    scale: f64,
    edits: &mut Vec<Edit>,
) {
    if before == after {
        return;
    }
    let word = |value: f64| numbers(&[value / scale], PLACES);
    edits.extend(segment.set(start, &word(after[0])));
    if segment.value(end).is_some() || after[0] != after[1] {
        edits.extend(segment.set(end, &word(after[1])));
    }
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;

    use super::*;

    const TEXT: &str = "Scaling { 10 }
Camera c { fps 25 Film f { width 16 } # a film
    CamSegment s {
        videoStart 0 videoEnd 1
        addPosition { 0 -5 1 } addPosition { 1 -5 1 } # from the left
        addTarget { 0 0 0 } fovStart .4 fovEnd .5
    }
}
";

    fn segment() -> CamSegment {
        CamSegment {
            name: "s".into(),
            video: [0.0, 1.0],
            scene: [0.0, 1.0],
            positions: vec![DVec3::new(0.0, -50.0, 10.0), DVec3::new(10.0, -50.0, 10.0)],
            targets: vec![DVec3::ZERO],
            sky: [DVec3::Z; 2],
            fov: [0.4, 0.5],
            dof: [1.0; 2],
            lens_radius: [0.0; 2],
            blur_duration: 0.0,
        }
    }

    #[test]
    fn a_moved_path_is_a_change_of_a_few_numbers() {
        let mut after = segment();
        after.positions.iter_mut().for_each(|point| point.z += 5.0);
        after.fov = [0.2, 0.25];
        let edits = camera(TEXT, &segment(), &after).unwrap();
        let expected = TEXT
            .replace("{ 0 -5 1 }", "{ 0 -5 1.5 }")
            .replace("{ 1 -5 1 }", "{ 1 -5 1.5 }")
            .replace("fovStart .4 fovEnd .5", "fovStart 0.2 fovEnd 0.25");
        assert_eq!(applied(TEXT, edits).unwrap(), expected);
    }

    #[test]
    fn what_the_text_lacks_is_added() {
        let mut after = segment();
        (after.lens_radius, after.dof, after.blur_duration) = ([0.5; 2], [45.0; 2], 0.02);
        let edits = camera(TEXT, &segment(), &after).unwrap();
        let text = applied(TEXT, edits).unwrap();
        for line in [
            "        lensRadiusStart 0.05\n",
            "        dofStart 4.5\n",
            "        blurDuration 0.02\n",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }

    #[test]
    fn another_camera_is_left_alone() {
        let mut before = segment();
        before.positions[0].x += 1.0;
        assert!(camera(TEXT, &before, &segment()).is_err());
        assert!(camera("include camera.txt", &segment(), &segment()).is_err());
    }
}
