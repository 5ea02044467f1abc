//! States, parts and checkpoints; their checksum is put right.

use crate::{file, within_limits};
use slo_picture::film::Merger;
use slo_picture::output;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let whole = [data, blake3::hash(data).as_bytes()].concat();
        let path = file("state", &whole);
        let state = output::read_state(&path);
        let Ok((subject, _)) = output::read_subject(&path) else {
            assert!(state.is_err());
            return;
        };
        output::find_state(&path, &subject);
        output::made_by_others(&path);
        let Ok(state) = state else { return };
        let again = path.with_file_name("again");
        output::write_state(&again, &state).expect("it can be written");
        assert_eq!(std::fs::read(&again).expect("it was written"), whole);
        if let Ok(mut merger) = Merger::new(&subject, 64) {
            let _ = merger.add(0, &state).and_then(|()| merger.finish());
        }
        state.film.image();
    });
}
