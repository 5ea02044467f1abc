//! Changes of a scene text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slo_fuzz::within_limits;
use slo_scene::edit::{Outline, applied};

fuzz_target!(|data: &[u8]| {
    within_limits(data, |data| {
        let text = String::from_utf8_lossy(data);
        let outline = Outline::new(&text);
        for part in outline.elements().take(8) {
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
            for inner in part.parts(&name) {
                let _ = (inner.line(), inner.own_numbers(), inner.value(&name));
                applied(&text, vec![inner.remove()]).expect("the change fits the text");
            }
        }
    });
});
