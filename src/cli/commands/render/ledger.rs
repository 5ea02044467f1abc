//! What a run with a time for all frames has learnt about the frames. It is stored on disk, so
//! that the next run can use the rest of the time.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::schedule::Known;
use crate::cli::options::Job;
use slo_picture::output::{Recipe, open_regular, write_atomically};
use slo_scene::SceneDescription;

/// The ledger, a file in the output folder.
pub(super) struct Ledger {
    path: PathBuf,
    /// Hash of everything that the frames are made from.
    of: String,
}

impl Ledger {
    pub(super) fn new(job: &Job, scene: &SceneDescription) -> Self {
        let prefix = &scene.camera.film.prefix;
        let recipe = Recipe { scene, frame: 0 }.to_json();
        Self {
            path: job.outdir.join(format!(".slo-rt-{prefix}.total-time")),
            of: blake3::hash(recipe.as_bytes()).to_hex().to_string(),
        }
    }

    /// Reads what is known, by frame number. Returns nothing if the file belongs to another scene
    /// or is damaged.
    pub(super) fn read(&self) -> BTreeMap<i64, Known> {
        let text = open_regular(&self.path).and_then(io::read_to_string).unwrap_or_default();
        let value: Value = serde_json::from_str(&text).unwrap_or_default();
        let frames = value["frames"].as_object().filter(|_| value["of"] == *self.of);
        let known = |(frame, numbers): (&String, &Value)| {
            let numbers: Vec<f64> =
                numbers.as_array()?.iter().map(Value::as_f64).collect::<Option<_>>()?;
            Some((frame.parse().ok()?, Known::from_numbers(numbers.try_into().ok()?)?))
        };
        frames.into_iter().flatten().filter_map(known).collect()
    }

    /// Writes what is known. A failure is ignored, because nothing else is lost.
    pub(super) fn write<'a>(&self, known: impl Iterator<Item = (i64, &'a Known)>) {
        let line = |(frame, known): (i64, &Known)| (frame.to_string(), json!(known.to_numbers()));
        let frames: Map<String, Value> = known.map(line).collect();
        let text = json!({ "of": self.of, "frames": frames }).to_string();
        let _ = write_atomically(&self.path, |file| file.write_all(text.as_bytes()));
    }

    /// Removes the ledger when the run is over.
    pub(super) fn remove(&self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// How many frames the ledger at `path` knows, whatever scene it belongs to.
pub(crate) fn frames_of_ledger(path: &Path) -> usize {
    let text = open_regular(path).and_then(io::read_to_string).unwrap_or_default();
    let value: Value = serde_json::from_str(&text).unwrap_or_default();
    let of = value["of"].as_str().unwrap_or_default().to_owned();
    Ledger { path: path.to_owned(), of }.read().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_for_the_same_scene() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ledger");
        let ledger = Ledger { path, of: "this".into() };
        assert!(ledger.read().is_empty());
        let numbers = [7.0, 0.25, 40.5, 40.5, 0.1, 0.01, 0.02, 1.5, 1.75];
        let known = Known::from_numbers(numbers).unwrap();
        ledger.write([(-5, &known), (12, &known)].into_iter());
        assert_eq!(ledger.read(), BTreeMap::from([(-5, known), (12, known)]));
        let other = Ledger { of: "that".into(), path: ledger.path.clone() };
        assert!(other.read().is_empty());
        fs::write(&ledger.path, r#"{"of":"this","frames":{"1":[1],"x":[],"2":7}}"#).unwrap();
        assert!(ledger.read().is_empty());
        ledger.remove();
        assert!(!ledger.path.exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_in_its_place_keeps_nobody_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ledger");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert!(Ledger { path, of: "this".into() }.read().is_empty());
    }
}
