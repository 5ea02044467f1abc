//! The `Camera` element: film and segments.

use glam::DVec3;

use super::{oddities, settings};
use crate::attributes::schema::{Attribute, Schema, attributes, inner, number, point};
use crate::attributes::{Bound, Field, Fields, Found};
use crate::description::{CamSegment, Camera};
use crate::diagnostics::{Diagnostic, Span};
use crate::settings::{Entries, Film};

/// `Camera`
pub(super) const CAMERA: Schema = Schema::new(
    "Camera",
    &[number("fps").required(), inner(&FILM).required(), inner(&CAM_SEGMENT).required().repeated()],
);

const FILM_ATTRIBUTES: [Attribute; Film::ENTRIES.len()] = attributes(Film::ENTRIES);
const FILM: Schema = Schema::new("Film", &FILM_ATTRIBUTES);

const CAM_SEGMENT: Schema = Schema::new(
    "CamSegment",
    &[
        number("videoStart").required(),
        number("videoEnd").required(),
        number("sceneStart"),
        number("sceneEnd"),
        point("addPosition").required().repeated(),
        point("addTarget").required().repeated(),
        point("skyStart"),
        point("skyEnd"),
        number("fovStart").required(),
        number("fovEnd"),
        number("dofStart"),
        number("dofEnd"),
        number("lensRadiusStart"),
        number("lensRadiusEnd"),
        number("blurDuration"),
    ],
);

/// Most control points of one curve: the time of a frame grows with them.
const MOST_CONTROL_POINTS: usize = 10_000;

/// Sine between the view and the sky below which the camera has no right-hand side.
const LEAST_SINE: f64 = 1e-9;

/// Half-height of view, at distance 1, past which an angle was probably meant: 169 degrees.
const WIDEST_VIEW: f64 = 10.0;

/// `Camera`
pub(super) fn camera(fields: &mut Fields<'_, '_, '_>) -> Option<Camera> {
    let fps = fields.number("fps", Bound::Positive);
    let film = fields.get("Film").and_then(|field| read_inner(fields, field, film));
    let segments: Vec<_> = fields.all("CamSegment");
    let segments: Vec<_> = segments
        .into_iter()
        .filter_map(|field| Some((read_inner(fields, field, segment)?, field.keyword.span)))
        .collect();
    let segments = in_order(segments, fields);
    Some(Camera { fps: fps?.value, film: film?, segments })
}

/// Reads an element in this one.
fn read_inner<'t, 'a, T>(
    fields: &mut Fields<'t, 'a, '_>,
    field: Field<'t, 'a>,
    read: fn(&mut Fields<'_, '_, '_>) -> Option<T>,
) -> Option<T> {
    read(&mut fields.open(field)?)
}

fn film(fields: &mut Fields<'_, '_, '_>) -> Option<Film> {
    let mut film = Film::default();
    let known = settings::read(fields, &mut film);
    check_prefix(fields);
    let is_whole = Film::ENTRIES.iter().all(|e| !e.is_required || known.contains(&e.name));
    is_whole.then_some(film)
}

fn check_prefix(fields: &mut Fields<'_, '_, '_>) {
    let Some(word) = fields.word("prefix") else { return };
    if word.text.contains(|c: char| matches!(c, '/' | '\\' | ':') || c.is_control()) {
        fields.diagnostics.push(
            Diagnostic::error("`prefix` is part of a file's name and can't name a folder")
                .at(word.span, "")
                .help("set the folder with --outdir"),
        );
    }
}

fn segment(fields: &mut Fields<'_, '_, '_>) -> Option<CamSegment> {
    let video = video_range(fields);
    let scene = scene_range(fields, video);
    let [positions, targets] = ["addPosition", "addTarget"].map(|name| curve(fields, name));
    let sky = sky(fields);
    check_view(fields, &positions, &targets, sky);
    let fov = from_to(fields, |f, name| f.number(name, Bound::Positive), ["fovStart", "fovEnd"]);
    let mut ends = fov.into_iter().flatten().collect::<Vec<_>>();
    ends.dedup();
    ends.into_iter().for_each(|fov| warn_of_wide_view(fields, fov));
    let (dof, lens_radius) = lens(fields);
    let blur_duration = fields.number("blurDuration", Bound::NotNegative);
    if let (Some(Found { value, span }), Some(video)) = (blur_duration, video) {
        oddities::check_shutter(fields, value, span, video);
    }
    Some(CamSegment {
        name: fields.element.name.text.to_owned(),
        video: video?,
        scene: scene?,
        positions: positions.iter().map(|f| f.value).collect(),
        targets: targets.iter().map(|f| f.value).collect(),
        sky,
        fov: fov.map(|f| f.map(|f| f.value))?,
        dof,
        lens_radius,
        blur_duration: blur_duration.map_or(0.0, |f| f.value),
    })
}

fn video_range(fields: &mut Fields<'_, '_, '_>) -> Option<[f64; 2]> {
    let [start, end] = ["videoStart", "videoEnd"].map(|name| fields.number(name, Bound::Any));
    let (start, end) = (start?, end?);
    if end.value <= start.value {
        let message = format!("{} ends before it begins", fields.element.title());
        fields.diagnostics.push(
            Diagnostic::error(message)
                .at(end.span, "`videoEnd` must be more than `videoStart`")
                .also(start.span, "`videoStart`"),
        );
        return None;
    }
    Some([start.value, end.value])
}

/// The control points of a curve.
fn curve(fields: &mut Fields<'_, '_, '_>, name: &str) -> Vec<Found<DVec3>> {
    let points = fields.points(name);
    if let Some(first) = points.get(MOST_CONTROL_POINTS) {
        let message = format!(
            "{} has {} control points `{name}`, more than {MOST_CONTROL_POINTS}",
            fields.element.title(),
            points.len()
        );
        let help = "one Bézier curve passes near all of them: cut a long path into segments";
        let error = Diagnostic::error(message).at(first.span, "the first one too many");
        fields.diagnostics.push(error.help(help));
    }
    points
}

/// Scene time: as given; `sceneEnd` missing: at the speed of the video; both missing: video time.
fn scene_range(fields: &mut Fields<'_, '_, '_>, video: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let start = fields.number("sceneStart", Bound::Any);
    let end = fields.number("sceneEnd", Bound::Any);
    let [video_start, video_end] = video?;
    let start = start.map_or(video_start, |f| f.value);
    Some([start, end.map_or(start + (video_end - video_start), |f| f.value)])
}

/// Two attributes; if the second is missing, it is as the first.
fn from_to<T: Copy>(
    fields: &mut Fields<'_, '_, '_>,
    get: impl Fn(&mut Fields<'_, '_, '_>, &str) -> Option<T>,
    [start, end]: [&str; 2],
) -> Option<[T; 2]> {
    let has_end = fields.get(end).is_some();
    let (start, end) = (get(fields, start), get(fields, end));
    Some([start?, if has_end { end? } else { start? }])
}

fn sky(fields: &mut Fields<'_, '_, '_>) -> [DVec3; 2] {
    let sky = from_to(fields, |f, name| f.direction(name), ["skyStart", "skyEnd"]);
    if fields.get("skyStart").is_none() {
        let end = fields.direction("skyEnd").map_or(DVec3::Z, |f| f.value);
        return [DVec3::Z, end];
    }
    sky.map_or([DVec3::Z; 2], |sky| sky.map(|f| f.value))
}

/// Warns of a view so wide that an angle was probably meant.
fn warn_of_wide_view(fields: &mut Fields<'_, '_, '_>, fov: Found<f64>) {
    if fov.value <= WIDEST_VIEW {
        return;
    }
    let degrees = 2.0 * libm::atan(fov.value).to_degrees();
    let mut warning =
        Diagnostic::warning(format!("this is a view of {degrees:.1} degrees")).at(fov.span, "");
    if fov.value < 180.0 {
        let half = libm::tan(fov.value.to_radians() / 2.0);
        warning = warning.help(format!(
            "the number is half the height of the view at distance 1; for {} degrees write {half:.3}",
            fov.value
        ));
    }
    fields.diagnostics.push(warning);
}

/// Focus distance and lens radius; the plane of focus must lie in front of an open lens.
fn lens(fields: &mut Fields<'_, '_, '_>) -> ([f64; 2], [f64; 2]) {
    let radius =
        end_as_start(fields, Bound::NotNegative, ["lensRadiusStart", "lensRadiusEnd"], 0.0);
    let is_open = radius.iter().any(|r| *r > 0.0);
    if !is_open {
        let dof = end_as_start(fields, Bound::Any, ["dofStart", "dofEnd"], 1.0);
        return (if dof.iter().all(|d| *d > 0.0) { dof } else { [1.0; 2] }, radius);
    }
    if fields.get("dofStart").is_none() && !fields.element.damaged {
        let message = format!("{} has an open lens, but no `dofStart`", fields.element.title());
        let lens = fields.get("lensRadiusStart").or_else(|| fields.get("lensRadiusEnd"));
        let span = lens.map_or(fields.element.head(), |f| f.keyword.span);
        fields.diagnostics.push(
            Diagnostic::error(message)
                .at(span, "the lens is open because of this")
                .help("write `dofStart NUMBER`, the distance of the sharp plane"),
        );
    }
    (end_as_start(fields, Bound::Positive, ["dofStart", "dofEnd"], 1.0), radius)
}

fn end_as_start(
    fields: &mut Fields<'_, '_, '_>,
    bound: Bound,
    [start, end]: [&str; 2],
    default: f64,
) -> [f64; 2] {
    let start = fields.length(start, bound).map_or(default, |f| f.value);
    [start, fields.length(end, bound).map_or(start, |f| f.value)]
}

/// Reports a camera that has no direction of view, or looks straight along its sky, at an end of
/// its path.
fn check_view(
    fields: &mut Fields<'_, '_, '_>,
    positions: &[Found<DVec3>],
    targets: &[Found<DVec3>],
    sky: [DVec3; 2],
) {
    let starts = (positions.first(), targets.first());
    let ends = (positions.last(), targets.last());
    let is_still = positions.len() <= 1 && targets.len() <= 1 && sky[0] == sky[1];
    for ((position, target), sky) in
        [starts, ends].into_iter().zip(sky).take(2 - usize::from(is_still))
    {
        let (Some(position), Some(target)) = (position, target) else { return };
        let view = (target.value - position.value).normalize_or_zero();
        if view == DVec3::ZERO {
            report_view(fields, position.span, target.span, "stands at its own target");
        } else if view.cross(sky.normalize()).length() < LEAST_SINE {
            report_view(fields, position.span, target.span, "looks along its sky");
        }
    }
}

fn report_view(fields: &mut Fields<'_, '_, '_>, position: Span, target: Span, what: &str) {
    let message = format!("the camera of {} {what}", fields.element.title());
    fields
        .diagnostics
        .push(Diagnostic::error(message).at(target, "the target").also(position, "the position"));
}

/// The segments by their start; reports overlaps.
fn in_order(
    mut segments: Vec<(CamSegment, Span)>,
    fields: &mut Fields<'_, '_, '_>,
) -> Vec<CamSegment> {
    segments.sort_by(|(a, _), (b, _)| a.video[0].total_cmp(&b.video[0]));
    for pair in segments.windows(2) {
        let [(a, a_span), (b, b_span)] = pair else { continue };
        if b.video[0] < a.video[1] {
            let message = format!("segments `{}` and `{}` overlap", a.name, b.name);
            fields.diagnostics.push(
                Diagnostic::error(message)
                    .at(*b_span, format!("begins at {} s", b.video[0]))
                    .also(*a_span, format!("ends at {} s", a.video[1])),
            );
        }
    }
    segments.into_iter().map(|(segment, _)| segment).collect()
}
