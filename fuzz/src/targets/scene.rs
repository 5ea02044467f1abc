//! A scene text with the files that it names: everything up to a resolved scene.

use crate::{pieces, within_limits};
use slo_scene::{Files, load};

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let (text, files) = pieces::files(data);
        let loaded = load("scene.txt", text, &Files::in_memory("", files));
        assert_eq!(loaded.scene.is_none(), loaded.diagnostics.has_errors());
        let plain = loaded.diagnostics.render(false);
        assert!(!plain.contains('\u{1b}'), "no escape of the text reaches the terminal");
    });
}
