//! Files beside a scene, which the page offers.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Most files of a kind that are offered.
const MOST_FILES: usize = 200;
/// How often folders are looked at, at most: a scene is loaded again at each step of a drag.
const PAUSE: Duration = Duration::from_secs(2);
const MESHES: [&str; 3] = [".slo", ".obj", ".ply"];
const SCENES: [&str; 1] = [".txt"];

/// Files in the folder of a scene, and in the folders in it, as the scene writes their paths.
#[derive(Debug, Default)]
pub(super) struct Offers {
    pub(super) meshes: Vec<String>,
    pub(super) scenes: Vec<String>,
    looked: Option<Instant>,
}

impl Offers {
    /// Looks at the folders again, unless that was done just now.
    pub(super) fn renew(&mut self, scene: &Path) {
        if self.looked.is_some_and(|looked| looked.elapsed() < PAUSE) {
            return;
        }
        self.looked = Some(Instant::now());
        (self.meshes, self.scenes) = (Vec::new(), Vec::new());
        let folder = scene.parent().unwrap_or(Path::new(""));
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        for name in self.look(folder, "") {
            self.look(&folder.join(&name), &format!("{name}/"));
        }
        let own = scene.file_name().map(PathBuf::from);
        self.scenes.retain(|name| Some(PathBuf::from(name)) != own);
        self.meshes.sort();
        self.scenes.sort();
    }

    /// Notes the files of a folder; returns the folders in it.
    fn look(&mut self, folder: &Path, before: &str) -> Vec<String> {
        let mut folders = Vec::new();
        for entry in folder.read_dir().into_iter().flatten().flatten().take(10 * MOST_FILES) {
            let Ok(name) = entry.file_name().into_string() else { continue };
            let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
            let list = match entry.file_type() {
                Ok(kind) if kind.is_dir() => {
                    folders.push(name);
                    continue;
                }
                Ok(_) if ends(&MESHES) => &mut self.meshes,
                Ok(_) if ends(&SCENES) => &mut self.scenes,
                _ => continue,
            };
            if list.len() < MOST_FILES {
                list.push(format!("{before}{name}"));
            }
        }
        folders
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn meshes_and_scenes_are_offered() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene.txt");
        fs::create_dir(folder.path().join("men")).unwrap();
        for name in ["scene.txt", "b.txt", "a.ply", "men/knight.slo", "men/c.txt", "x.png"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let mut offers = Offers::default();
        offers.renew(&scene);
        assert_eq!(offers.meshes, ["a.ply", "men/knight.slo"]);
        assert_eq!(offers.scenes, ["b.txt", "men/c.txt"]);
        fs::write(folder.path().join("d.ply"), "").unwrap();
        offers.renew(&scene);
        assert_eq!(offers.meshes.len(), 2, "not looked at again so soon");
    }
}
