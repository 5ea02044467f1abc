//! Moved, turned and scaled things as text.

use glam::{DMat3, DQuat, DVec3};
use slo_scene::edit::{Edit, Outline, Part, number, numbers};

use super::motion::{Motion, angles_of, axis_of};
use super::placed::Placed;
use crate::changes::{PLACES, find, scaling};

/// Digits of degrees behind the point.
const DEGREE_PLACES: usize = 3;
/// How far the time of a key frame may be from that of the frame.
const SAME_TIME: f64 = 1e-6;

/// Returns the changes of a text that move, turn or scale a thing that is somewhere.
///
/// If it has one key frame, or one at this time, this is changed. A move at another time moves the
/// whole path. Without key frames, a move changes the corners or the centre that the text names, and
/// everything else adds a key frame.
///
/// # Errors
/// The text does not hold the thing, or it can't be placed so.
pub(crate) fn edits(
    text: &str,
    name: &str,
    placed: &Placed,
    motion: Motion,
) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let part = find(&outline, name)?;
    let scale = scaling(&outline);
    let frames: Vec<Part<'_, '_>> = part.parts("addKframe").collect();
    if frames.is_empty() {
        return match motion {
            Motion::Move(way) => moved_points(&part, in_parent(placed, way)? / scale),
            _ => added_frame(&part, placed, motion, scale),
        };
    }
    let is_now = |frame: &&Part<'_, '_>| {
        let time = frame.numbers("time").and_then(|time| time.first().copied());
        time.is_some_and(|time| (time - placed.time).abs() < SAME_TIME)
    };
    let now = if frames.len() == 1 { frames.first() } else { frames.iter().find(is_now) };
    match (now, motion) {
        (Some(now), _) => frame_of(now, &frames, placed, motion, scale),
        (None, Motion::Move(way)) => moved_path(&frames, in_parent(placed, way)? / scale),
        _ => Err(format!("`{name}` moves here: add a key frame first, by `Key frame here`")),
    }
}

/// A way of scene space, in the space that the thing hangs in.
fn in_parent(placed: &Placed, way: DVec3) -> Result<DVec3, String> {
    let way = placed.parent.linear.inverse() * way;
    if way.is_finite() { Ok(way) } else { Err("what it hangs in is flat".into()) }
}

/// The attributes that say where an element is.
fn points_of(keyword: &str) -> &'static [&'static str] {
    match keyword {
        "sphere" | "lamp_disc" => &["center"],
        "plane" | "lamp_point" | "light_point" => &["position"],
        "lamp_spot" => &["position", "target"],
        "triangle" | "rectangle" | "box" | "lamp_rectangle" | "light_rectangle" => {
            &["vertex0", "vertex1", "vertex2"]
        }
        "cylinder" => &["base", "top"],
        "cone" => &["base", "apex"],
        _ => &[],
    }
}

fn vector(of: DVec3) -> String {
    numbers(&of.to_array(), PLACES)
}

/// The three numbers of an attribute.
fn point(part: &Part<'_, '_>, name: &str) -> Option<DVec3> {
    Some(DVec3::from(<[f64; 3]>::try_from(part.numbers(name)?).ok()?))
}

/// Moves an element without key frames.
fn moved_points(part: &Part<'_, '_>, way: DVec3) -> Result<Vec<Edit>, String> {
    let names = points_of(part.keyword());
    if names.is_empty() {
        return match part.keyword() {
            "lamp_sun" | "environment" => Err("it is everywhere, so it can't be moved".into()),
            _ if way == DVec3::ZERO => Ok(Vec::new()),
            _ => Ok(vec![part.add(&frame(&format!("pivot {{ {} }}", vector(way))))]),
        };
    }
    let mut edits = Vec::new();
    for name in names {
        let at = point(part, name).ok_or_else(|| format!("its `{name}` can't be read"))?;
        edits.extend(part.set_vector(name, &vector(at + way)));
    }
    Ok(edits)
}

fn frame(placement: &str) -> String {
    format!("addKframe {{ time 0 key {{ {placement} }} }}")
}

/// How a thing is after a motion about its anchor: where its origin is, its rotation and its scale.
fn after(placed: &Placed, motion: Motion) -> Result<(DVec3, DMat3, DVec3), String> {
    let (mut rotation, mut scale) = (placed.rotation(), placed.scale());
    match motion {
        Motion::Move(way) => {
            return Ok((placed.pose.translation + in_parent(placed, way)?, rotation, scale));
        }
        Motion::Turn(axis, degrees) => {
            let axis = in_parent(placed, axis)?.normalize_or(axis);
            let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
            rotation = DMat3::from_quat(turn) * rotation;
        }
        Motion::Scale(factors) => scale *= factors,
    }
    let held = placed.pose.point(placed.anchor);
    Ok((held - rotation * (scale * placed.anchor), rotation, scale))
}

/// Turns or scales an element without key frames, by a key frame.
fn added_frame(
    part: &Part<'_, '_>,
    placed: &Placed,
    motion: Motion,
    scale: f64,
) -> Result<Vec<Edit>, String> {
    let (pivot, rotation, factors) = after(placed, motion)?;
    let mut words = Vec::new();
    if pivot.length() > 1e-9 * (1.0 + placed.anchor.length()) {
        words.push(format!("pivot {{ {} }}", vector(pivot / scale)));
    }
    let is_same = match motion {
        Motion::Turn(_, degrees) => {
            words.push(format!("turn_deg {{ {} }}", degrees_of(angles_of(&rotation))));
            degrees == 0.0
        }
        _ => {
            words.push(format!("scale {{ {} }}", vector(factors)));
            factors == DVec3::ONE
        }
    };
    Ok(if is_same { Vec::new() } else { vec![part.add(&frame(&words.join(" ")))] })
}

fn degrees_of(angles: DVec3) -> String {
    angles.to_array().map(|angle| number(angle, DEGREE_PLACES)).join(" ")
}

/// Changes one key frame.
fn frame_of(
    now: &Part<'_, '_>,
    all: &[Part<'_, '_>],
    placed: &Placed,
    motion: Motion,
    scale: f64,
) -> Result<Vec<Edit>, String> {
    let (pivot, rotation, factors) = after(placed, motion)?;
    let has = |name: &str| {
        let blocks = |frame: &Part<'_, '_>| {
            ["pre", "key", "nex"]
                .into_iter()
                .filter_map(|block| frame.part(block))
                .any(|block| block.names().any(|attribute| attribute == name))
        };
        all.iter().any(blocks)
    };
    let key = now.part("key");
    let mut words: Vec<(&str, String)> = Vec::new();
    let before = key.and_then(|key| point(&key, "pivot")).map(|pivot| pivot * scale);
    let moves = (pivot - placed.pose.translation).length() > 1e-9 * (1.0 + pivot.length());
    if moves {
        // The numbers of the text, as far as there are any, and not those that were computed.
        let to = before.map_or(pivot, |before| before + (pivot - placed.pose.translation));
        words.push(("pivot", vector(to / scale)));
    }
    match motion {
        Motion::Turn(_, degrees) if degrees != 0.0 => {
            if has("turn") {
                let (axis, degrees) = axis_of(&rotation);
                let turn = format!(
                    "axis {{ {} }} angle_deg {}",
                    vector(axis),
                    number(degrees, DEGREE_PLACES)
                );
                words.push(("turn", turn));
            } else if has("up") || has("right") {
                words.push(("up", vector(rotation.z_axis)));
                words.push(("right", vector(rotation.x_axis)));
            } else {
                words.push(("turn_deg", degrees_of(angles_of(&rotation))));
            }
        }
        Motion::Scale(by) if by != DVec3::ONE => words.push(("scale", vector(factors))),
        _ => {}
    }
    let Some(key) = key else {
        let inside: Vec<_> =
            words.iter().map(|(name, value)| format!("{name} {{ {value} }}")).collect();
        let key = format!("key {{ {} }}", inside.join(" "));
        return Ok(if words.is_empty() { Vec::new() } else { vec![now.add(&key)] });
    };
    let mut edits: Vec<Edit> =
        words.iter().flat_map(|(name, value)| key.set_vector(name, value)).collect();
    // The handles of the path move along.
    let way = (pivot - placed.pose.translation) / scale;
    for handle in ["pre", "nex"].into_iter().filter_map(|name| now.part(name)) {
        if let (true, Some(at)) = (moves, point(&handle, "pivot")) {
            edits.extend(handle.set_vector("pivot", &vector(at + way)));
        }
    }
    Ok(edits)
}

/// Moves a whole path.
fn moved_path(frames: &[Part<'_, '_>], way: DVec3) -> Result<Vec<Edit>, String> {
    let mut edits = Vec::new();
    for (i, frame) in frames.iter().enumerate() {
        for (name, block) in
            ["pre", "key", "nex"].into_iter().filter_map(|name| Some((name, frame.part(name)?)))
        {
            match point(&block, "pivot") {
                Some(at) => edits.extend(block.set_vector("pivot", &vector(at + way))),
                // What the first key frame leaves out is 0, and what others leave out is inherited.
                None if i == 0 && name == "key" => {
                    edits.extend(block.set_vector("pivot", &vector(way)));
                }
                None => {}
            }
        }
        if i == 0 && frame.part("key").is_none() {
            edits.push(frame.add(&format!("key {{ pivot {{ {} }} }}", vector(way))));
        }
    }
    Ok(edits)
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;
    use slo_scene::{Files, load};

    use super::*;

    const TEXT: &str = "# Things
Scaling twice { 2 }
settings s {}
Camera c { fps 1 Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
    CamSegment s { videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { 0 -9 1 } addTarget { 0 0 0 } fovStart 0.4 } }
lamp_spot spot { power { 9 9 9 } position { 0 0 4 } target { 0 0 0 } angle_deg 40 }
light_rectangle shine { color { 1 1 1 } vertex0 { 0 0 3 } vertex1 { 1 0 3 } vertex2 { 1 1 3 } }
lamp_sun sun { irradiance { 1 1 1 } direction { 0 0 -1 } }
phong_info grey { diffuse { .5 .5 .5 } }
material_phong grey { phong_info grey }
group turned { addKframe { time 0 key { turn_deg { 0 0 90 } } } }
sphere ball { center { 1 0 .5 } radius .5 material grey } # a ball
box crate { vertex0 { 0 0 0 } vertex1 { 2 0 0 } vertex2 { 2 2 0 } height 2 material grey parent turned }
cone tip { base { 0 0 0 } apex { 0 0 1 } radius 1 material grey
    addKframe { time 0 key { pivot { 3 0 0 } turn_deg { 0 0 30 } } }
}
cone old { base { 0 0 0 } apex { 0 0 1 } radius 1 material grey
    addKframe { time 0 key { pivot { 3 0 0 } right { 0 1 0 } } }
}
sphere flies { center { 0 0 0 } radius 1 material grey
    addKframe { time 0 }
    addKframe { time 2 key { pivot { 2 0 0 } } nex { pivot { 3 0 0 } } }
}
";

    /// Moves a thing in a frame; `old` becomes `new` in the text.
    fn check(name: &str, frame: i64, motion: Motion, old: &str, new: &str) {
        let placed = placed(TEXT, name, frame);
        let edits = edits(TEXT, name, &placed, motion).expect(name);
        let text = applied(TEXT, edits).expect("they fit");
        assert!(TEXT.contains(old), "{old}");
        assert_eq!(text, TEXT.replacen(old, new, 1), "{name}");
    }

    fn placed(text: &str, name: &str, frame: i64) -> Placed {
        let loaded = load("scene.txt", text, &Files::built_in("", &[]));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        Placed::of(&scene, name, frame).expect(name)
    }

    #[test]
    fn things_are_moved_by_their_numbers() {
        let up = Motion::Move(DVec3::Z * 3.0);
        check("ball", 0, up, "{ 1 0 .5 }", "{ 1 0 2 }");
        let spot = "position { 0 0 4 } target { 0 0 0 }";
        check("spot", 0, up, spot, "position { 0 0 5.5 } target { 0 0 1.5 }");
        // The space of the box is turned by a quarter about z, so x of the scene is -y.
        let crate_old = "vertex0 { 0 0 0 } vertex1 { 2 0 0 } vertex2 { 2 2 0 }";
        let crate_new = "vertex0 { 0 -1 0 } vertex1 { 2 -1 0 } vertex2 { 2 1 0 }";
        check("crate", 0, Motion::Move(DVec3::X * 2.0), crate_old, crate_new);
        check("tip", 0, Motion::Move(DVec3::X), "pivot { 3 0 0 }", "pivot { 3.5 0 0 }");
        check("ball", 0, Motion::Move(DVec3::ZERO), "ball", "ball");
    }

    #[test]
    fn a_path_moves_as_a_whole_and_a_key_frame_by_itself() {
        let up = Motion::Move(DVec3::Z * 2.0);
        let old =
            "{ time 0 }\n    addKframe { time 2 key { pivot { 2 0 0 } } nex { pivot { 3 0 0 } } }";
        let all = "{ time 0 key { pivot { 0 0 1 } } }\n    addKframe { time 2 key { pivot { 2 0 1 } } nex { pivot { 3 0 1 } } }";
        check("flies", 1, up, old, all);
        let last = "{ time 2 key { pivot { 2 0 1 } } nex { pivot { 3 0 1 } } }";
        check("flies", 2, up, "{ time 2 key { pivot { 2 0 0 } } nex { pivot { 3 0 0 } } }", last);
        check("flies", 0, up, "{ time 0 }", "{ time 0 key { pivot { 0 0 1 } } }");
        let turn = Motion::Turn(DVec3::Z, 10.0);
        let said = edits(TEXT, "flies", &placed(TEXT, "flies", 1), turn).unwrap_err();
        assert!(said.contains("Key frame here"), "{said}");
    }

    #[test]
    fn turns_and_scales_keep_the_middle_in_place() {
        let turn = Motion::Turn(DVec3::Z, 15.0);
        check("tip", 0, turn, "turn_deg { 0 0 30 }", "turn_deg { 0 0 45 }");
        let quarter = Motion::Turn(DVec3::Z, 90.0);
        check("old", 0, quarter, "right { 0 1 0 }", "right { -1 0 0 } up { 0 0 1 }");
        let add = |frame: &str| {
            format!("material grey addKframe {{ time 0 key {{ {frame} }} }} }} # a ball")
        };
        let (old, frame) =
            ("material grey } # a ball", add("pivot { 1 1 0 } turn_deg { 0 0 -90 }"));
        // About the middle of the ball, which stays where it is.
        let back = Motion::Turn(DVec3::Z, -90.0);
        check("ball", 0, back, old, &frame);
        let twice = Motion::Scale(DVec3::splat(2.0));
        check("ball", 0, twice, old, &add("pivot { -1 0 -0.5 } scale { 2 2 2 }"));
        check("tip", 0, twice, "turn_deg { 0 0 30 }", "turn_deg { 0 0 30 } scale { 2 2 2 }");
        let corner = "vertex2 { 1 1 3 } ";
        let frame = "addKframe { time 0 key { pivot { -0.5 -0.5 -3 } scale { 2 2 2 } } } ";
        check("shine", 0, twice, corner, &format!("{corner}{frame}"));
        let middle = |text: &str| placed(text, "ball", 0).at();
        for motion in [turn, twice, Motion::Turn(DVec3::new(0.6, 0.8, 0.0), 77.0)] {
            let edits = edits(TEXT, "ball", &placed(TEXT, "ball", 0), motion).expect("a turn");
            let text = applied(TEXT, edits).expect("they fit");
            assert!((middle(&text) - middle(TEXT)).length() < 1e-4, "{motion:?}: {text}");
        }
    }
}
