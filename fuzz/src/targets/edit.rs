//! Changes of a scene text.

use crate::within_limits;
use slo_scene::edit::{Outline, applied};

/// Bytes of a text of which only one element is changed.
const LONG: usize = 100_000;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let text = String::from_utf8_lossy(data);
        let outline = Outline::new(&text);
        // Each change reads the text once more.
        let elements = if text.len() < LONG { 8 } else { 1 };
        for part in outline.elements().take(elements) {
            let name = part.names().next().unwrap_or("color").to_owned();
            let changes = [
                part.set(&name, "1 2 3"),
                part.set_one(&name, 1, "7"),
                part.set_vector("pivot", "0 0 1"),
                vec![part.add("radius 1")],
                vec![part.follow("sphere a { }")],
                vec![part.remove()],
            ];
            for edits in changes {
                let changed = applied(&text, edits).expect("the changes fit the text");
                Outline::new(&changed);
            }
            for inner in part.parts(&name).take(8) {
                let _ = (inner.line(), inner.own_numbers(), inner.value(&name));
                applied(&text, vec![inner.remove()]).expect("the change fits the text");
            }
        }
    });
}
