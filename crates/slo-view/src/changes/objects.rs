//! Things as text: hidden, copied, removed, with another key frame.

use glam::DVec3;
use slo_scene::edit::{Edit, Outline, Part, numbers};
use slo_scene::format::written;

use super::{PLACES, scaling};

/// The element of an object or a lamp; `None` if it stands in an included file.
pub(crate) fn thing<'t, 'a>(outline: &'t Outline<'a>, name: &str) -> Option<Part<'t, 'a>> {
    let others = ["Scaling", "settings", "Camera", "phong_info", "texture"];
    outline.elements().find(|part| {
        let keyword = part.keyword();
        part.name() == Some(name) && !others.contains(&keyword) && !keyword.starts_with("material_")
    })
}

/// The same, or why it can't be changed.
pub(crate) fn find<'t, 'a>(outline: &'t Outline<'a>, name: &str) -> Result<Part<'t, 'a>, String> {
    thing(outline, name).ok_or_else(|| {
        format!("`{name}` stands in a file that the scene includes, not in its text")
    })
}

/// Leaves an object out of the picture.
pub(crate) fn hide(text: &str, name: &str) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let part = find(&outline, name)?;
    if ["light_", "lamp_", "environment"].iter().any(|lamp| part.keyword().starts_with(lamp)) {
        return Err("lamps can't be hidden; remove it, or make it dark".into());
    }
    Ok(part.set("hidden", "1"))
}

/// Takes a thing out of the scene.
pub(crate) fn remove(text: &str, name: &str) -> Result<Vec<Edit>, String> {
    Ok(vec![find(&Outline::new(text), name)?.remove()])
}

/// Writes a thing once more, behind itself, with a name of its own.
pub(crate) fn copy(text: &str, name: &str) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let part = find(&outline, name)?;
    let is_taken = |name: &str| outline.elements().any(|part| part.name() == Some(name));
    let free = (2..).map(|i| format!("{name}_{i}")).find(|name| !is_taken(name));
    let free = free.ok_or("there are too many copies")?;
    let whole = &text[part.range()];
    let block = whole.find('{').ok_or("its text can't be read")?;
    let copy = format!("{} {} {}", part.keyword(), written(&free), &whole[block..]);
    Ok(vec![part.follow(&copy)])
}

/// Adds a key frame to an object: where it is in its parent at a scene time, with the axes x and z.
pub(crate) fn key_frame(
    text: &str,
    name: &str,
    time: f64,
    [pivot, right, up]: [DVec3; 3],
) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let part = find(&outline, name)?;
    let vector = |of: DVec3| numbers(&of.to_array(), PLACES);
    let pivot = pivot / scaling(&outline);
    let key = format!(
        "addKframe {{ time {} key {{ pivot {{ {} }} up {{ {} }} right {{ {} }} }} }}",
        numbers(&[time], PLACES),
        vector(pivot),
        vector(up),
        vector(right)
    );
    let time_of =
        |frame: &Part<'_, '_>| frame.numbers("time").and_then(|time| time.first().copied());
    let is_there = |frame: Part<'_, '_>| time_of(&frame).is_some_and(|at| (at - time).abs() < 1e-6);
    if part.parts("addKframe").any(is_there) {
        return Err("there is a key frame at this time already".into());
    }
    let before = part.parts("addKframe").filter(|frame| time_of(frame).is_some_and(|at| at < time));
    Ok(vec![match before.last() {
        Some(before) => before.follow(&key),
        // The first of all: before the others, if there are any.
        None => match part.part("addKframe") {
            Some(first) => precede(text, &first, &key),
            None => part.add(&key),
        },
    }])
}

/// Adds something in front of a block, on a line of its own if the block begins one.
fn precede(text: &str, part: &Part<'_, '_>, what: &str) -> Edit {
    let at = part.range().start;
    let line = text[..at].rfind('\n').map_or(0, |i| i + 1);
    let indent = &text[line..at];
    let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let text = match indent.trim().is_empty() {
        true => format!("{what}{newline}{indent}"),
        false => format!("{what} "),
    };
    Edit { range: at..at, text }
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;

    use super::*;

    const TEXT: &str = "# A ball
sphere ball {
    radius 1 # small
    addKframe { time 0 key { pivot { 0 0 0 } } }
    addKframe { time 2 key { pivot { 1 0 0 } } }
}
lamp_point lamp { power 5 }
box ball_2 {}
";

    fn check(edits: Result<Vec<Edit>, String>, old: &str, new: &str) {
        assert_eq!(applied(TEXT, edits.unwrap()).unwrap(), TEXT.replace(old, new));
    }

    #[test]
    fn things_are_hidden_and_removed() {
        let end = "1 0 0 } } }\n";
        check(hide(TEXT, "ball"), end, &format!("{end}    hidden 1\n"));
        assert!(hide(TEXT, "lamp").is_err() && hide(TEXT, "none").is_err());
        check(remove(TEXT, "lamp"), "lamp_point lamp { power 5 }\n", "");
    }

    #[test]
    fn copies_have_names_of_their_own() {
        let ball = &TEXT[TEXT.find("sphere").unwrap()..TEXT.find("lamp_point").unwrap()];
        let copied = ball.replace("sphere ball", "sphere ball_3");
        check(copy(TEXT, "ball"), ball, &format!("{ball}{copied}"));
    }

    #[test]
    fn key_frames_stand_in_order() {
        let key =
            |time| key_frame(TEXT, "ball", time, [DVec3::new(0.5, 0.0, 0.0), DVec3::X, DVec3::Z]);
        let line = |time| {
            format!(
                "    addKframe {{ time {time} key {{ pivot {{ 0.5 0 0 }} up {{ 0 0 1 }} right {{ 1 0 0 }} }} }}\n"
            )
        };
        let (first, last) = ("{ 0 0 0 } } }\n", "{ 1 0 0 } } }\n");
        check(key(1.0), first, &format!("{first}{}", line("1")));
        check(key(3.0), last, &format!("{last}{}", line("3")));
        let small = "# small\n";
        check(key(-1.0), small, &format!("{small}{}", line("-1")));
        assert!(key(2.0).is_err());
    }
}
