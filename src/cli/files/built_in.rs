//! The built-in scene, with all files that it refers to. The binary alone can render it anywhere.

/// Folder of the scene in the repository; its paths start there.
pub(crate) const FOLDER: &str = "scenes";

/// Path of the scene among [`FILES`].
pub(crate) const PATH: &str = "scenes/default.txt";

/// Embeds files of the repository, by their paths from the root.
macro_rules! embedded {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!("../../../", $path)))),*]
    };
}

/// Every file of the scene. Another mesh or texture is one more line.
pub(crate) const FILES: &[(&str, &[u8])] = embedded![
    "scenes/default.txt",
    "meshes/backdrop.slo",
    "meshes/board_dark.slo",
    "meshes/board_frame.slo",
    "meshes/board_inlay.slo",
    "meshes/board_light.slo",
    "meshes/king.slo",
    "meshes/knight.slo",
    "meshes/pawn.slo",
    "meshes/queen.slo",
    "meshes/sheet.slo",
    "textures/backdrop.png",
    "textures/boxwood.png",
    "textures/walnut.png",
];

/// Returns the text of the scene.
pub(crate) fn text() -> &'static [u8] {
    FILES.iter().find(|(path, _)| *path == PATH).map_or(&[], |(_, bytes)| bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::{Files, load};

    #[test]
    fn it_loads_without_a_warning() {
        let loaded = load(PATH, text(), &Files::built_in(FOLDER, FILES));
        assert_eq!(loaded.diagnostics.render(false), "");
        assert!(loaded.scene.is_some());
    }

    #[test]
    fn every_path_is_there_once() {
        let mut paths: Vec<_> = FILES.iter().map(|(path, _)| path).collect();
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), FILES.len());
    }
}
