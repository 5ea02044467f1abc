//! A camera that goes around something, as a segment of its own.

use glam::{DQuat, DVec3};
use slo_scene::CamSegment;
use slo_scene::animation::View;
use slo_scene::edit::{Edit, Outline, numbers};

use super::{PLACES, scaling};

/// Degree of the curve. It misses the circle by less than a millionth of its radius.
const DEGREE: usize = 12;

/// Adds a segment behind the last one: the camera goes once around a point in so many seconds, from where
/// it is. Returns the changes, and the video time at which it starts.
///
/// # Errors
/// The text holds no camera, or the camera is at the axis.
pub(crate) fn orbit(
    text: &str,
    segments: &[CamSegment],
    view: &View,
    center: DVec3,
    seconds: f64,
) -> Result<(Vec<Edit>, f64), String> {
    let outline = Outline::new(text);
    let scale = scaling(&outline);
    let camera = outline.first("Camera");
    let part = camera.and_then(|camera| camera.parts("CamSegment").last());
    let part = part.ok_or("the camera stands in a file that the scene includes")?;
    let last = segments.iter().max_by(|a, b| a.video[1].total_cmp(&b.video[1]));
    let last = last.ok_or("the scene has no segment")?;
    let sky = view.sky.normalize_or(DVec3::Z);
    let arm = view.position - center;
    if arm.cross(sky).length() < 1e-6 * arm.length().max(1e-12) {
        return Err("the camera looks straight down at what it should go around".into());
    }
    let is_taken = |name: &str| segments.iter().any(|segment| segment.name == name);
    let free = |i: usize| if i == 1 { "orbit".to_owned() } else { format!("orbit_{i}") };
    let name = (1..).map(free).find(|name| !is_taken(name)).ok_or("there are too many")?;
    let vector = |of: DVec3| numbers(&of.to_array(), PLACES);
    let number = |of: f64| numbers(&[of], PLACES);
    let line_start = text[..part.range().start].rfind('\n').map_or(0, |i| i + 1);
    let line = &text[line_start..];
    let indent = &line[..line.len() - line.trim_start_matches([' ', '\t']).len()];
    let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let next = format!("{newline}{indent}    ");
    let start = last.video[1];
    let end = start + seconds;
    let rate = (last.scene[1] - last.scene[0]) / (last.video[1] - last.video[0]).max(1e-9);
    let scene = [last.scene[1], last.scene[1] + rate * seconds];
    let mut segment = format!("CamSegment {name} {{");
    segment += &format!("{next}videoStart {} videoEnd {}", number(start), number(end));
    segment += &format!(" sceneStart {} sceneEnd {}", number(scene[0]), number(scene[1]));
    for point in circle(arm, sky) {
        segment += &format!("{next}addPosition {{ {} }}", vector((center + point) / scale));
    }
    segment += &format!("{next}addTarget {{ {} }}", vector(center / scale));
    segment += &format!("{next}skyStart {{ {} }} fovStart {}", vector(view.sky), number(view.fov));
    if view.lens_radius > 0.0 {
        let radius = number(view.lens_radius / scale);
        let dof = number(arm.length() / scale);
        segment += &format!("{next}lensRadiusStart {radius} dofStart {dof}");
    }
    if last.blur_duration > 0.0 {
        segment += &format!("{next}blurDuration {}", number(last.blur_duration));
    }
    segment += &format!("{newline}{indent}}}");
    Ok((vec![part.follow(&segment)], start))
}

/// Control points of a curve that turns an arm once around an axis, evenly.
fn circle(arm: DVec3, axis: DVec3) -> Vec<DVec3> {
    // The curve meets the circle where this is exact, close to its ends too.
    let node = |i: usize| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * i as f64 / DEGREE as f64);
    let nodes: Vec<f64> = (0..=DEGREE).map(node).collect();
    let turned = |t: &f64| DQuat::from_axis_angle(axis, std::f64::consts::TAU * t) * arm;
    let mut points: Vec<DVec3> = nodes.iter().map(turned).collect();
    let mut rows: Vec<Vec<f64>> = nodes.iter().map(|t| bernstein(*t)).collect();
    // Gauss's elimination; the matrix is totally positive, so it needs no pivots.
    for i in 0..=DEGREE {
        for j in i + 1..=DEGREE {
            let factor = rows[j][i] / rows[i][i];
            let (above, below) = rows.split_at_mut(j);
            below[0].iter_mut().zip(&above[i]).for_each(|(below, above)| *below -= factor * above);
            let way = points[i] * factor;
            points[j] -= way;
        }
    }
    for i in (0..=DEGREE).rev() {
        let known = (i + 1..=DEGREE).fold(DVec3::ZERO, |sum, k| sum + points[k] * rows[i][k]);
        points[i] = (points[i] - known) / rows[i][i];
    }
    points
}

/// Weights of the control points at a parameter.
fn bernstein(t: f64) -> Vec<f64> {
    let mut weights = vec![1.0];
    for _ in 0..DEGREE {
        let mut next = vec![0.0; weights.len() + 1];
        for (i, weight) in weights.iter().enumerate() {
            next[i] += weight * (1.0 - t);
            next[i + 1] += weight * t;
        }
        weights = next;
    }
    weights
}

#[cfg(test)]
mod tests {
    use slo_scene::animation::view_at;
    use slo_scene::edit::applied;
    use slo_scene::{Files, load};

    use super::*;

    const TEXT: &str = "Scaling twice { 2 }
settings s {}
Camera c { fps 10 Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
    CamSegment only { # the first
        videoStart 0 videoEnd 2 sceneStart 0 sceneEnd 1
        addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 0.4 lensRadiusStart .1 dofStart 4
    } # its end
}
light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
";

    #[test]
    fn the_camera_goes_around_evenly() {
        let scene = |text: &str| {
            let loaded = load("scene.txt", text, &Files::built_in("", &[]));
            loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)))
        };
        let camera = scene(TEXT).camera;
        let view = view_at(&camera.segments[0], 0.0);
        let center = DVec3::new(1.0, 0.0, 0.5);
        let (edits, start) = orbit(TEXT, &camera.segments, &view, center, 4.0).unwrap();
        assert_eq!(start, 2.0);
        let text = applied(TEXT, edits).unwrap();
        assert!(
            text.contains(
                "    } # its end\n    CamSegment orbit {\n        videoStart 2 videoEnd 6"
            ),
            "{text}"
        );
        let orbit = &scene(&text).camera.segments[1];
        assert_eq!((orbit.video, orbit.scene), ([2.0, 6.0], [1.0, 3.0]));
        for i in 0..=40 {
            let t = f64::from(i) / 40.0;
            let seen = view_at(orbit, t);
            let arm = DQuat::from_rotation_z(std::f64::consts::TAU * t) * (view.position - center);
            assert!((seen.position - center - arm).length() < 2e-3, "{t}: {seen:?}");
            assert!((seen.target - center).length() < 1e-6);
        }
    }
}
