//! A file of the cache, with its checksums or put right, and what is made of its sections.

use crate::{folder, readers, within_limits};
use slo_scene::cache::{Cache, Key};

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let cache = Cache::new(folder(), 1 << 30, |_| {});
        let key = Key::new("fuzz", 1, &[]);
        // Damage in a file that was whole.
        let (begin, change) = data.split_at(data.len().min(9));
        cache.put(&key, &[change, begin]);
        let name = std::fs::read_dir(folder()).expect("a folder").flatten();
        let name =
            name.map(|entry| entry.path()).find(|path| path.to_string_lossy().contains("fuzz-"));
        if let (Some(path), [kind, at @ ..]) = (name, begin) {
            let mut file = std::fs::read(&path).expect("a file");
            let place = at.iter().fold(0, |all, byte| all * 31 + usize::from(*byte)) % file.len();
            match kind % 4 {
                0 => file.truncate(place),
                1 => file[place] ^= at.first().copied().unwrap_or(0),
                2 => file.extend(at),
                _ => drop(file.splice(place..(place + 8).min(file.len()), at.iter().copied())),
            }
            std::fs::write(&path, file).expect("a file");
        }
        let read =
            |entry: &slo_scene::cache::Entry| entry.values::<u32>(0).zip(entry.values::<u8>(1));
        if let Some((_, bytes)) = cache.get(&key, read) {
            assert_eq!(bytes, begin, "damage goes unnoticed");
        }
    });
    within_limits(data, readers::restored_structure);
}
