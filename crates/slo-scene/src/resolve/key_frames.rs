//! `addKframe`: the position of an object over time.

use glam::DVec3;

use super::turns::{Turned, Written, even, turned};
use crate::animation::{KeyFrames, have_orientation};
use crate::attributes::{Bound, Field, Fields};
use crate::description::{KeyFrame, Placement};
use crate::diagnostics::Diagnostic;

/// The key frames of an object or a lamp, in order of time.
pub(super) fn key_frames(fields: &mut Fields<'_, '_, '_>) -> Vec<KeyFrame> {
    let blocks = fields.all("addKframe");
    let mut written: Vec<_> = blocks.into_iter().filter_map(|b| key_frame(fields, b)).collect();
    sort(&mut written, fields);
    if written.iter().any(|w| w.turned.iter().any(|turned| turned.turn.is_some())) {
        return even(&written, fields);
    }
    check_orientations(&written, fields);
    written.into_iter().map(|w| w.key_frame).collect()
}

fn key_frame<'t, 'a>(fields: &mut Fields<'t, 'a, '_>, field: Field<'t, 'a>) -> Option<Written> {
    let mut fields = fields.open(field)?;
    let time = fields.number("time", Bound::Any);
    let said = ["pre", "key", "nex"].map(|name| placement(&mut fields, name));
    let time = time?;
    let [pre, key, nex] = [0, 1, 2].map(|i| said[i].0);
    let key_frame = KeyFrame { time: time.value, pre, key, nex };
    let turned = said.map(|(_, turned)| turned);
    Some(Written { key_frame, turned, time: time.span, keyword: field.keyword.span })
}

fn placement(fields: &mut Fields<'_, '_, '_>, name: &str) -> (Placement, Turned) {
    let field = fields.get(name);
    let Some(mut fields) = field.and_then(|field| fields.open(field)) else {
        return Default::default();
    };
    let placement = Placement {
        pivot: fields.point("pivot").map(|f| f.value),
        up: fields.direction("up").map(|f| f.value),
        right: fields.direction("right").map(|f| f.value),
        scale: fields.factors("scale"),
    };
    (placement, turned(&mut fields))
}

fn sort(written: &mut [Written], fields: &mut Fields<'_, '_, '_>) {
    let disorder = written.windows(2).find(|pair| pair[1].key_frame.time < pair[0].key_frame.time);
    if let Some([before, after]) = disorder {
        let message = format!("key frames of {} are not in order of time", fields.element.title());
        fields.diagnostics.push(
            Diagnostic::warning(message)
                .at(after.time, "earlier than the key frame before it")
                .also(before.time, "")
                .help("they are used in order of time"),
        );
    }
    written.sort_by(|a, b| a.key_frame.time.total_cmp(&b.key_frame.time));
    for pair in written.windows(2).filter(|p| p[0].key_frame.time == p[1].key_frame.time) {
        let (first, again) = (pair[0].time.min(pair[1].time), pair[0].time.max(pair[1].time));
        let message = format!("{} has two key frames at one time", fields.element.title());
        fields
            .diagnostics
            .push(Diagnostic::error(message).at(again, "the same time").also(first, "first here"));
    }
}

/// Up and right of a control point, with everything filled in.
#[derive(Clone, Copy)]
struct Orientation {
    up: DVec3,
    right: DVec3,
}

impl Orientation {
    fn is_flat(self) -> bool {
        !have_orientation(self.right, self.up)
    }

    fn third_toward(self, other: Self) -> Self {
        let third = |a: DVec3, b: DVec3| a + (b - a) / 3.0;
        Self { up: third(self.up, other.up), right: third(self.right, other.right) }
    }

    /// With what a handle says instead.
    fn with(self, handle: Placement) -> Self {
        Self { up: handle.up.unwrap_or(self.up), right: handle.right.unwrap_or(self.right) }
    }
}

/// Reports key frames without an orientation, and warns if it is lost between two.
fn check_orientations(written: &[Written], fields: &mut Fields<'_, '_, '_>) {
    let mut last = Orientation { up: DVec3::Z, right: DVec3::X };
    let complete = |one: &Written| {
        last = last.with(one.key_frame.key);
        last
    };
    let keys: Vec<_> = written.iter().map(complete).collect();
    let flat: Vec<_> =
        (0..keys.len()).filter_map(|i| Some((i, flat_part(written, &keys, i)?))).collect();
    for (i, part) in &flat {
        report_flat(fields, &written[*i], part);
    }
    if flat.is_empty() {
        warn_of_collapse(fields, written);
    }
}

/// The control point of a key frame whose up and right are parallel.
fn flat_part(written: &[Written], keys: &[Orientation], i: usize) -> Option<&'static str> {
    if keys[i].is_flat() {
        return Some("key");
    }
    let neighbour = |at: Option<usize>| at.and_then(|at| keys.get(at)).unwrap_or(&keys[i]);
    let key_frame = &written[i].key_frame;
    let handles = [
        ("pre", key_frame.pre, neighbour(i.checked_sub(1))),
        ("nex", key_frame.nex, neighbour(Some(i + 1))),
    ];
    handles.into_iter().find_map(|(name, handle, toward)| {
        let is_given = handle.up.is_some() || handle.right.is_some();
        (is_given && keys[i].third_toward(*toward).with(handle).is_flat()).then_some(name)
    })
}

fn report_flat(fields: &mut Fields<'_, '_, '_>, written: &Written, which: &str) {
    let time = written.key_frame.time;
    let message = format!(
        "up is parallel to right in `{which}` of the key frame at time {time} of {}",
        fields.element.title()
    );
    fields.diagnostics.push(
        Diagnostic::error(message)
            .at(written.keyword, "together they must span a plane")
            .help("what a key frame leaves out stays as in the key frame before it; initially up is z and right is x"),
    );
}

/// Warns if up and right become parallel between two keys.
fn warn_of_collapse(fields: &mut Fields<'_, '_, '_>, written: &[Written]) {
    let key_frames: Vec<_> = written.iter().map(|w| w.key_frame).collect();
    let Ok(path) = KeyFrames::new(&key_frames) else { return };
    let jumps = path.jumps([f64::NEG_INFINITY, f64::INFINITY]);
    for jump in jumps.iter().filter(|jump| jump.collapse) {
        let (from, to) = (&written[jump.key], &written[jump.key + 1]);
        let message =
            format!("{} loses its orientation between key frames", fields.element.title());
        fields.diagnostics.push(
            Diagnostic::warning(message)
                .at(
                    to.keyword,
                    format!("on the way here, at time {:.3}, up and right are parallel", jump.time),
                )
                .also(from.keyword, "from here")
                .help("put a key frame between them: a turn takes at least one per 90 degrees"),
        );
    }
}
