//! The axis of a round shape.

use glam::DVec3;

use crate::attributes::{Fields, SHORTEST};
use crate::diagnostics::Diagnostic;

/// Two points that are apart.
pub(super) fn axis(fields: &mut Fields<'_, '_, '_>, from: &str, to: &str) -> Option<[DVec3; 2]> {
    let (start, end) = (fields.point(from), fields.point(to));
    let (start, end) = (start?, end?);
    if end.value.distance(start.value) < SHORTEST {
        let message = format!("{} has no height", fields.element.title());
        fields.diagnostics.push(
            Diagnostic::error(message)
                .at(end.span, format!("`{to}` is the same point as `{from}`"))
                .also(start.span, format!("`{from}`")),
        );
        return None;
    }
    Some([start.value, end.value])
}
