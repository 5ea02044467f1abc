//! Lights: what several kinds of them say, and whether they go together.

use super::{key_frames, oddities, repeat};
use crate::attributes::Fields;
use crate::description::Camera;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::light::{Light, LightKind, ReadLight};
use crate::material::Palette;

/// A light, with the place that it is defined at; `None` if something is wrong, which is reported.
pub(super) fn light<'a>(
    read: ReadLight,
    fields: &mut Fields<'_, 'a, '_>,
    palette: &mut Palette<'_, 'a>,
    camera: Option<&Camera>,
) -> Option<(Light, Span)> {
    let key_frames = key_frames::key_frames(fields);
    if let Some(camera) = camera {
        oddities::check_key_times(fields, &key_frames, camera);
    }
    let repeat = repeat::repeat(fields, &key_frames, camera);
    let mut flag = |name| fields.count(name, 0, 1).is_none_or(|flag| flag.value == 1);
    let (camera_visible, solid) = (flag("camera_visible"), flag("solid"));
    let group = fields.word("light_group").map(|group| group.text.to_owned());
    let kind = read(fields, palette)?;
    let name = fields.element.name.text.to_owned();
    let light = Light { name, kind, key_frames, repeat, camera_visible, solid, group };
    Some((light, fields.element.head()))
}

/// Reports all that is around the scene beside the first environment; `background` is where it is
/// written.
pub(super) fn check_sky(
    lights: &[(Light, Span)],
    background: Option<Span>,
    diagnostics: &mut Diagnostics,
) {
    let is_environment = |light: &Light| matches!(light.kind, LightKind::Environment(_));
    let mut environments = lights.iter().filter(|(light, _)| is_environment(light));
    let Some((_, first)) = environments.next() else { return };
    for (_, other) in environments {
        let error = Diagnostic::error("the scene has more than one `environment`");
        diagnostics.push(error.at(*other, "one too many").also(*first, "first here"));
    }
    if let Some(background) = background {
        let error = Diagnostic::error("the scene has a `background` and an `environment`")
            .at(*first, "this stands in place of a `background`")
            .also(background, "this is all around too");
        diagnostics.push(error.help("leave one of the two out"));
    }
}
