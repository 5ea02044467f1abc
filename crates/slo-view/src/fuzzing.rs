//! What a browser sends, and what the program makes of it, without a server: for fuzzing.

use glam::DVec3;
use hyper::Request;
use slo_scene::Mesh;
use slo_scene::edit::{Edit, applied};

use crate::changes;
use crate::command::{Command, TextEdit};
use crate::document;
use crate::merging::{Catalog, merge};
use crate::sculpting::{Sculpted, named, renamed, together, uses, y_up};
use crate::server::Guard;

/// Reads the body of a request; returns a text as the request changes it.
pub fn request(text: &str, body: &[u8]) -> Option<String> {
    let Command::Edit(edit) = Command::read(&serde_json::from_slice(body).ok()?)? else {
        return None;
    };
    let edits: Result<Vec<Edit>, String> = match &edit {
        TextEdit::Set(field) => changes::set(text, field),
        TextEdit::Hide(name) => changes::hide(text, name),
        TextEdit::Remove(name) => changes::remove(text, name),
        TextEdit::Copy(name) => changes::copy(text, name),
        TextEdit::Add(new) => {
            changes::add(text, new, DVec3::ONE, 0.5, None).map(|(edits, _)| edits)
        }
        TextEdit::KeyFrame(name) => changes::key_frame(text, name, 0.5, [DVec3::X; 3]),
    };
    applied(text, edits.ok()?)
}

/// Takes everything of another scene over into a text.
pub fn taken(own: &str, other: &str) -> Option<String> {
    let none = |path: &str| Err(format!("there is no `{path}`"));
    let here = Catalog::of(own.to_owned(), "", &none).ok()?;
    let other = Catalog::of(other.to_owned(), "b/", &none).ok()?;
    let all: Vec<usize> = (0..other.things.len()).collect();
    applied(own, merge(&here, &other, "b/c.txt", &all).ok()?.edits)
}

/// Whether a request with an address and headers, one on each line, is answered. `TOKEN` stands for the
/// token of the server.
pub fn admits(head: &[u8]) -> bool {
    let Some((guard, token)) = Guard::apart() else { return false };
    let head = String::from_utf8_lossy(head).replace("TOKEN", &token);
    let mut lines = head.lines();
    let mut request = Request::builder().uri(lines.next().unwrap_or_default());
    for (name, value) in lines.filter_map(|line| line.split_once(": ")) {
        request = request.header(name, value);
    }
    request.body(()).is_ok_and(|request| guard.admit(&request).is_ok())
}

/// Brings the changes of two people together, if they are in different lines.
pub fn merged(base: &str, ours: &str, theirs: &str) -> Option<String> {
    document::differences(base, ours);
    document::merged(base, ours, theirs)
}

/// Moves vertices of a mesh, each with all that lie where it does. Returns the file that saving would write;
/// `None` if a coordinate is not finite.
pub fn sculpted(mesh: &Mesh, is_y_up: bool, moves: &[(u32, DVec3)]) -> Option<Vec<u8>> {
    let mut sculpted = Sculpted::new(mesh, 1.0, is_y_up);
    for (vertex, to) in moves {
        let all = together(mesh, *vertex).into_iter().map(|vertex| (vertex, *to));
        sculpted = sculpted.with(all);
        assert!(sculpted.position(*vertex).is_none_or(|at| at == *to || to.is_nan()));
    }
    sculpted.to_file().ok()
}

/// A text in which the mesh of a name, and then all that uses its old file, has a new file.
pub fn with_new_file(text: &str, name: &str) -> Option<String> {
    let changed = applied(text, named(text, name, "new 2.slo").ok()?).expect("it fits the text");
    y_up(&changed, name);
    let old = uses(text, name)?;
    applied(&changed, renamed(&changed, old, "new_3.slo").0)
}
