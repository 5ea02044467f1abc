//! The names of new mesh files in the text.

use slo_scene::edit::{Edit, Outline, Target};
use slo_scene::format::written;

use crate::changes::find;

/// Returns the change of a text by which one mesh is that of another file, which holds it as it is shown.
///
/// # Errors
/// The text does not hold it, or it is no mesh of a file.
pub(crate) fn named(text: &str, name: &str, file: &str) -> Result<Vec<Edit>, String> {
    let outline = Outline::new(text);
    let part = find(&outline, name)?;
    if part.keyword() != "mesh" {
        return Err(format!("`{name}` is no mesh"));
    }
    if part.value("filename").is_none() {
        return Err(format!("`{name}` changes its shape, so its vertices can't be moved here"));
    }
    let mut edits = part.set("filename", &written(file));
    edits.extend(part.without("filename", 1));
    // The file has this size already.
    edits.extend(part.without("fit", 0));
    Ok(edits)
}

/// The path of the first file of a mesh, as the text has it.
pub(crate) fn uses<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    find(&Outline::new(text), name).ok()?.value("filename")
}

/// Whether y is up in the file of a mesh.
pub(crate) fn y_up(text: &str, name: &str) -> bool {
    find(&Outline::new(text), name).ok().and_then(|part| part.value("axes")) == Some("Y_UP")
}

/// Returns the change of a text by which all that uses a file uses another one; and how many do.
pub(crate) fn renamed(text: &str, from: &str, to: &str) -> (Vec<Edit>, usize) {
    let outline = Outline::new(text);
    let links = outline.elements().flat_map(|part| part.links());
    let uses = links.filter(|link| link.target == Target::File && link.word == from);
    let edits: Vec<_> =
        uses.map(|link| Edit { range: link.range, text: written(to).to_string() }).collect();
    let count = edits.len();
    (edits, count)
}

/// Returns a name for a new mesh file that is like the name of another one.
pub(crate) fn free_name(like: &str, is_free: impl Fn(&str) -> bool) -> String {
    let file = like.rsplit('/').next().unwrap_or_default();
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let stem = match stem.rsplit_once('_') {
        Some((before, number)) if !before.is_empty() && number.parse::<u32>().is_ok() => before,
        _ => stem,
    };
    let stem = if stem.is_empty() { "mesh" } else { stem };
    let names = (2u64..).map(|i| format!("{stem}_{i}.slo"));
    names.into_iter().find(|name| is_free(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;

    use super::*;

    const TEXT: &str = "# Men
mesh \"a knight\" { filename men/knight.slo filename base.obj # both
    fit { 2 } axes Y_UP material red }
mesh pawn { filename base.obj material red }
mesh flag { addShape { time 0 filename a.slo } addShape { time 1 filename b.slo } material red }
sphere ball { radius 1 material red }
";

    #[test]
    fn one_mesh_gets_the_new_file() {
        let edits = named(TEXT, "a knight", "a knight_2.slo").unwrap();
        let text = applied(TEXT, edits).unwrap();
        let old = "{ filename men/knight.slo filename base.obj # both\n    fit { 2 } axes";
        let new = "{ filename \"a knight_2.slo\" # both\n    axes";
        assert_eq!(text, TEXT.replace(old, new));
        assert_eq!((uses(TEXT, "pawn"), y_up(TEXT, "pawn")), (Some("base.obj"), false));
        assert!(y_up(TEXT, "a knight"));
        for name in ["flag", "ball", "none"] {
            assert!(named(TEXT, name, "x.slo").is_err(), "{name}");
        }
        let (edits, count) = renamed(TEXT, "base.obj", "b.slo");
        assert_eq!(count, 2);
        assert_eq!(applied(TEXT, edits).unwrap(), TEXT.replace("base.obj", "b.slo"));
    }

    #[test]
    fn names_are_counted() {
        let taken = ["knight_2.slo", "knight_3.slo"];
        let free = |like: &str| free_name(like, |name| !taken.contains(&name));
        assert_eq!(free("men/knight.obj"), "knight_4.slo");
        assert_eq!(free("knight_2.slo"), "knight_4.slo");
        assert_eq!(free("_7.slo"), "_7_2.slo");
        assert_eq!(free(""), "mesh_2.slo");
    }
}
