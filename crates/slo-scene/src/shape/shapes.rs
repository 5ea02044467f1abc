//! `addShape` and `shapes`: the files of a mesh that changes its shape.

use crate::attributes::schema::{Schema, number, word};
use crate::attributes::{Field, Fields};
use crate::diagnostics::{Diagnostic, Span};
use crate::settings::Bound;

/// `addShape`
pub(super) const ADD_SHAPE: Schema =
    Schema::new("addShape", &[number("time").required(), word("filename", "PATH").required()]);

/// `shapes`
pub(super) const SHAPES: Schema = Schema::new(
    "shapes",
    &[
        word("filename", "PATH").required(),
        number("first").required(),
        number("last").required(),
        number("fps").required(),
        number("time"),
    ],
);

/// Most files of `shapes`.
const MOST_FILES: u32 = 1_000_000;

/// Most digits of a number in a path.
const MOST_DIGITS: usize = 9;

/// What a mesh says of its shapes.
pub(super) struct Written {
    /// Times, ascending, and paths: two or more.
    pub(super) keys: Vec<(f64, String)>,
    /// Where each path stands.
    pub(super) places: Vec<Span>,
}

/// The shapes of a mesh. `None` if it has none, `Some(None)` if something is wrong with them, which
/// is reported.
pub(super) fn written_shapes(fields: &mut Fields<'_, '_, '_>) -> Option<Option<Written>> {
    let (added, numbered) = (fields.all("addShape"), fields.get("shapes"));
    match (&added[..], numbered) {
        ([], None) => None,
        ([], Some(numbered)) => Some(numbered_shapes(fields, numbered)),
        (_, None) => Some(added_shapes(fields, &added)),
        ([first, ..], Some(_)) => {
            let message = format!("{} has `addShape` and `shapes`", fields.element.title());
            let error =
                Diagnostic::error(message).at(first.keyword.span, "one of the two is too much");
            fields.diagnostics.push(error);
            Some(None)
        }
    }
}

fn added_shapes<'t, 'a>(
    fields: &mut Fields<'t, 'a, '_>,
    added: &[Field<'t, 'a>],
) -> Option<Written> {
    let mut written = Written { keys: Vec::new(), places: Vec::new() };
    let mut times = Vec::new();
    for field in added {
        let mut shape = fields.open(*field)?;
        let (time, path) = (shape.number("time", Bound::Any), shape.word("filename"));
        let (time, path) = (time?, path?);
        written.keys.push((time.value, path.text.to_owned()));
        written.places.push(path.span);
        times.push(time);
    }
    let title = fields.element.title();
    if let [only] = added {
        let message = format!("{title} has a single `addShape`");
        let error = Diagnostic::error(message).at(only.keyword.span, "");
        let help = "two or more are needed; a mesh that keeps its shape has a `filename`";
        fields.diagnostics.push(error.help(help));
        return None;
    }
    if let Some([before, after]) = times.array_windows().find(|[a, b]| b.value <= a.value) {
        let message = format!("shapes of {title} are not in order of time");
        let label = if after.value == before.value { "the same time" } else { "earlier" };
        let error = Diagnostic::error(message).at(after.span, label);
        fields.diagnostics.push(error.also(before.span, "than the shape before it"));
        return None;
    }
    Some(written)
}

fn numbered_shapes<'t, 'a>(
    fields: &mut Fields<'t, 'a, '_>,
    field: Field<'t, 'a>,
) -> Option<Written> {
    let mut shapes = fields.open(field)?;
    let path = shapes.word("filename");
    let first = shapes.count("first", 0, MOST_FILES);
    let last = shapes.count("last", 0, MOST_FILES);
    let fps = shapes.number("fps", Bound::Positive);
    let has_time = shapes.get("time").is_some();
    let time = if has_time { shapes.number("time", Bound::Any)?.value } else { 0.0 };
    let (path, first, last, fps) = (path?, first?, last?, fps?);
    let Some(parts) = around_number(path.text) else {
        let message = format!("`{}` has no place for a number", path.text);
        let help = "write `#` for each digit: `body_####.slo` stands for body_0001.slo and so on";
        shapes.diagnostics.push(Diagnostic::error(message).at(path.span, "").help(help));
        return None;
    };
    if last.value <= first.value {
        let error = Diagnostic::error("`last` must be more than `first`").at(last.span, "");
        shapes.diagnostics.push(error.also(first.span, ""));
        return None;
    }
    let key =
        |number: u32| (time + f64::from(number - first.value) / fps.value, numbered(parts, number));
    let keys: Vec<_> = (first.value..=last.value).map(key).collect();
    Some(Written { places: vec![path.span; keys.len()], keys })
}

/// What stands before a number in a path, its least number of digits, and what stands behind it.
fn around_number(path: &str) -> Option<(&str, usize, &str)> {
    let start = path.find('#')?;
    let end = path[start..].find(|c| c != '#').map_or(path.len(), |len| start + len);
    let digits = end - start;
    (digits <= MOST_DIGITS && !path[end..].contains('#')).then_some((
        &path[..start],
        digits,
        &path[end..],
    ))
}

fn numbered((before, digits, behind): (&str, usize, &str), number: u32) -> String {
    format!("{before}{number:0digits$}{behind}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fill_their_place() {
        let path = |text: &str, number| around_number(text).map(|parts| numbered(parts, number));
        assert_eq!(path("a/body_####.slo", 7).as_deref(), Some("a/body_0007.slo"));
        assert_eq!(path("#", 12).as_deref(), Some("12"));
        assert_eq!(path("##x", 1234).as_deref(), Some("1234x"));
        for wrong in ["body.slo", "", "#_#.slo", "##########.ply"] {
            assert_eq!(path(wrong, 1), None, "{wrong}");
        }
    }
}
