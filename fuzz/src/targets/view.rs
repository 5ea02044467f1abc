//! What a browser sends to `slo-rt view`: addresses, headers, requests that change the text.

use crate::{pieces, within_limits};
use slo_view::fuzzing;

const SCENE: &str = include_str!("../../seeds/splits.txt");

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let (body, files) = pieces::files(data);
        let text = files.first().map(|(_, text)| String::from_utf8_lossy(text));
        fuzzing::request(text.as_deref().unwrap_or(SCENE), body);
        fuzzing::admits(body);
        if let [(_, one), (_, other), ..] = &files[..] {
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            fuzzing::merged(&text(body), &text(one), &text(other));
            fuzzing::taken(&text(one), &text(other));
        }
    });
}
