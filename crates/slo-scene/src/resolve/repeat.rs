//! `repeat`: motion beyond the key frames.

use crate::animation::KeyFrames;
use crate::attributes::{FARTHEST, Fields};
use crate::description::{Camera, KeyFrame};
use crate::diagnostics::Diagnostic;
use crate::settings::Repeat;

/// How the motion of some key frames goes on; reports cycles without a length, and those that lead too
/// far while the camera looks.
pub(super) fn repeat(
    fields: &mut Fields<'_, '_, '_>,
    key_frames: &[KeyFrame],
    camera: Option<&Camera>,
) -> Option<Repeat> {
    let repeat: Repeat = fields.one_of("repeat")?;
    let place = fields.get("repeat")?.keyword.span;
    let title = fields.element.title();
    let [first, .., last] = key_frames else {
        // Key frames that are broken were reported.
        if fields.all("addKframe").len() < 2 {
            let message = format!("the cycle of {title} has no length");
            let error = Diagnostic::error(message).at(place, "this takes two key frames or more");
            let help =
                "write `addKframe { time t ... }` for the start and for the end of the cycle";
            fields.diagnostics.push(error.help(help));
        }
        return None;
    };
    let path = KeyFrames::new(key_frames).ok()?.repeated(Some(repeat));
    if first.time == last.time {
        return None; // Two key frames at one time were reported.
    }
    for time in camera?.segments.iter().flat_map(|segment| segment.scene) {
        if path.pose(time).translation.abs().max_element() >= FARTHEST {
            let message = format!("{title} is more than {FARTHEST:e} away at time {time}");
            let label = "too far for the arithmetic of the renderer";
            fields.diagnostics.push(Diagnostic::error(message).at(place, label));
            break;
        }
    }
    Some(repeat)
}
