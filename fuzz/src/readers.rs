//! Readers that several fuzzers use.

use slo_accel::glam::Vec3;
use slo_accel::{Accelerator, Coherence, Hits, Isa, Rays, Scratch, Sections, Structure};
use slo_scene::{Files, load, texture};

use crate::pieces::{Numbers, files};
use crate::{file, folder, within_limits};

/// A texture in a file of any format.
pub(crate) fn texture(data: &[u8]) {
    within_limits(data, |data| {
        if let Ok(loaded) = texture::load("a.png", &mut &data[..]) {
            let texture = loaded.texture;
            let [width, height] = [texture.width(), texture.height()];
            assert!(width > 0 && height > 0);
            texture.texel_rgba(width - 1, height - 1);
        }
    });
}

/// A scene of another program. Others than the first file of the input lie beside it.
pub(crate) fn import(name: &str, data: &[u8]) {
    within_limits(data, |data| {
        let (first, others) = files(data);
        for (name, bytes) in &others {
            let is_plain =
                name.len() < 100 && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'.');
            if is_plain && name.starts_with(|c: char| c.is_ascii_alphanumeric()) {
                file(name, bytes);
            }
        }
        let Ok(imported) = slo_import::import(&file(name, first), false) else { return };
        for (path, _) in &imported.files {
            assert!(!path.starts_with('/') && !path.contains(".."), "{path} leaves the folder");
        }
        let files = Files::in_memory("", imported.files);
        let loaded = load("scene.txt", &imported.text, &files);
        loaded.diagnostics.render(false);
    });
    for entry in std::fs::read_dir(folder()).into_iter().flatten().flatten() {
        let _ = std::fs::remove_file(entry.path());
    }
}

/// Sections of a structure in memory.
struct Kept<'d>(Vec<&'d [u8]>);

impl Sections for Kept<'_> {
    fn length(&self, section: usize) -> Option<usize> {
        self.0.get(section).map(|bytes| bytes.len())
    }

    fn read(&self, section: usize, to: &mut [u8]) -> bool {
        to.copy_from_slice(self.0[section]);
        true
    }
}

/// A hierarchy that is restored from what a file of the cache says. Rays through it must not fail.
pub(crate) fn restored_structure(data: &[u8]) {
    let mut numbers = Numbers::of(data);
    let count = 1 + numbers.below(40);
    let triangle = |i: usize| {
        let at = Vec3::new((i % 5) as f32, (i / 5) as f32, (i % 3) as f32);
        [at, at + Vec3::X, at + Vec3::Y]
    };
    let triangles: Vec<_> = (0..count).map(triangle).collect();
    let built = Structure::build(Accelerator::Bvh, triangles.clone(), Isa::best());
    let kept = built.kept().expect("a hierarchy can be kept");
    // The bytes of a sound hierarchy, some of them changed, or any bytes.
    let mut sections: Vec<Vec<u8>> = kept.iter().map(|section| section.to_vec()).collect();
    let (nodes, ids) = match numbers.byte() {
        0 => {
            let rest = &data[data.len().min(3)..];
            let (nodes, ids) = rest.split_at(rest.len() / 2);
            (nodes.to_vec(), ids.to_vec())
        }
        _ => {
            while !numbers.is_empty() {
                let section = usize::from(numbers.byte()) % 2;
                let length = sections[section].len();
                let at = numbers.below(length);
                if let Some(byte) = sections[section].get_mut(at) {
                    *byte = numbers.byte();
                }
            }
            (sections.remove(0), sections.remove(0))
        }
    };
    let kept = Kept(vec![&nodes, &ids]);
    let Ok(structure) = Structure::restore(Accelerator::Bvh, triangles, Isa::best(), &kept) else {
        return;
    };
    let mut rays = Rays::with_capacity(16);
    for i in 0..16 {
        let from = Vec3::new(i as f32 * 0.37, i as f32 * 0.29, 9.0);
        rays.push(from, Vec3::new(0.01, -0.02, -1.0), f32::INFINITY);
    }
    let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
    for coherence in [Coherence::Coherent, Coherence::Incoherent] {
        structure.intersect(&rays, coherence, &mut hits, &mut scratch);
        structure.occluded(&rays, coherence, &mut Vec::new(), &mut scratch);
    }
}
