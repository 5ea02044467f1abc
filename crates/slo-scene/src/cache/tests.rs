use std::sync::{Arc, Mutex};

use super::*;

/// A cache in a folder of its own, with the warnings that it gave.
struct Tried {
    folder: tempfile::TempDir,
    cache: Cache,
    warnings: Arc<Mutex<Vec<String>>>,
}

impl Tried {
    fn new(most: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let warnings = Arc::new(Mutex::new(Vec::new()));
        let to = warnings.clone();
        let warn = move |text: &str| to.lock().unwrap().push(text.to_owned());
        let cache = Cache::new(&folder.path().join("cache"), most, warn);
        Self { folder, cache, warnings }
    }

    fn get(&self, key: &Key) -> Option<(Vec<u32>, Vec<u8>)> {
        self.cache.get(key, |entry| Some((entry.values(0)?, entry.values(1)?)))
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.folder.path().join("cache")).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }

    fn warned(&self) -> usize {
        self.warnings.lock().unwrap().len()
    }
}

fn key(name: &str) -> Key {
    Key::new("thing", 1, &[name.as_bytes()])
}

const WORDS: [u32; 3] = [1, 2, u32::MAX];

fn put(tried: &Tried, key: &Key, rest: &[u8]) {
    tried.cache.put(key, &[bytemuck::cast_slice(&WORDS), rest]);
}

#[test]
fn what_was_put_is_found_under_its_key() {
    let tried = Tried::new(1 << 30);
    // More than a chunk.
    let long: Vec<u8> = (0..5_000_000u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
    assert_eq!(tried.get(&key("a")), None);
    put(&tried, &key("a"), &long);
    put(&tried, &key("b"), &[]);
    assert_eq!(tried.get(&key("a")), Some((WORDS.to_vec(), long)));
    assert_eq!(tried.get(&key("b")), Some((WORDS.to_vec(), vec![])));
    assert_eq!(tried.get(&key("c")), None);
    assert_eq!(tried.cache.uses(), Uses { found: 2, made: 2 });
    assert_eq!((tried.warned(), tried.files().len()), (0, 2));
}

#[test]
fn keys_differ_by_all_that_they_are_made_of() {
    let keys = [
        Key::new("a", 1, &[b"x", b"yz"]),
        Key::new("a", 1, &[b"xy", b"z"]),
        Key::new("a", 2, &[b"x", b"yz"]),
        Key::new("b", 1, &[b"x", b"yz"]),
        Key::new("a", 1, &[b"x", b"yz", b""]),
    ];
    for (i, a) in keys.iter().enumerate() {
        assert!(keys[..i].iter().all(|b| a.hash() != b.hash() && a.name() != b.name()));
    }
    let bytes: Vec<u8> = (0..3_000_000u32).map(|i| (i % 251) as u8).collect();
    let mut other = bytes.clone();
    other[2_999_999] ^= 1;
    assert_ne!(hash_of(&bytes), hash_of(&other));
    assert_ne!(hash_of(&bytes), hash_of(&bytes[..2_999_999]));
}

#[test]
fn damaged_files_are_reported_and_made_again() {
    let tried = Tried::new(1 << 30);
    put(&tried, &key("a"), b"rest");
    let [path] = &tried.files()[..] else { panic!("one file") };
    let sound = fs::read(path).unwrap();
    let mut number = 0;
    let mut check = |bytes: &[u8]| {
        fs::write(path, bytes).unwrap();
        assert_eq!(tried.get(&key("a")), None);
        number += 1;
        assert_eq!(tried.warned(), number);
    };
    for at in 0..sound.len() {
        let mut damaged = sound.clone();
        damaged[at] ^= 1 << (at % 8);
        check(&damaged);
    }
    for length in [0, 1, 40, sound.len() - 1] {
        check(&sound[..length]);
    }
    check(&[&sound[..], b"more"].concat());
    check(b"notes of somebody else, which are as long as the head of a file is or longer");
    // Lengths that would need more memory than there is.
    let mut huge = sound.clone();
    huge[48..56].copy_from_slice(&u64::MAX.to_le_bytes());
    check(&huge);
    huge[48..56].copy_from_slice(&2u64.to_le_bytes());
    huge[56..64].copy_from_slice(&(u64::MAX - 7).to_le_bytes());
    check(&huge);
    put(&tried, &key("a"), b"rest");
    assert_eq!(tried.get(&key("a")), Some((WORDS.to_vec(), b"rest".to_vec())));
}

#[test]
fn a_file_under_another_key_is_not_used() {
    let tried = Tried::new(1 << 30);
    put(&tried, &key("a"), b"rest");
    fs::rename(tried.cache.path(&key("a")), tried.cache.path(&key("b"))).unwrap();
    assert_eq!(tried.get(&key("b")), None);
    assert_eq!(tried.warned(), 1);
}

#[cfg(unix)]
#[test]
fn a_pipe_under_the_name_of_a_file_is_not_waited_for() {
    let tried = Tried::new(1 << 30);
    put(&tried, &key("a"), b"rest");
    let path = tried.cache.path(&key("a"));
    fs::remove_file(&path).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&path).status();
    if made.is_ok_and(|status| status.success()) {
        assert_eq!(tried.get(&key("a")), None);
        assert_eq!(tried.warned(), 1);
    }
}

#[test]
fn a_smaller_limit_holds_even_if_nothing_is_written() {
    let mut tried = Tried::new(1 << 20);
    let rest = vec![7; 200];
    for name in ["a", "b", "c"] {
        put(&tried, &key(name), &rest);
    }
    tried.cache.most = 700;
    tried.cache.since = Mutex::default();
    assert!(tried.get(&key("c")).is_some());
    assert!(tried.files().len() < 3);
}

#[test]
fn what_was_not_used_for_the_longest_time_is_removed() {
    let mut tried = Tried::new(1 << 20);
    let rest = vec![7; 200];
    for (name, age) in [("a", 3), ("b", 5), ("c", 4)] {
        put(&tried, &key(name), &rest);
        let file = File::options().append(true).open(tried.cache.path(&key(name))).unwrap();
        file.set_modified(SystemTime::now() - 24 * age * RECENTLY).unwrap();
    }
    // It is used now.
    assert!(tried.get(&key("b")).is_some());
    let abandoned = tried.folder.path().join(format!("cache/x{TEMPORARY_END}"));
    fs::write(&abandoned, "").unwrap();
    let file = File::options().append(true).open(&abandoned).unwrap();
    file.set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
    tried.cache.most = 1000;
    put(&tried, &key("d"), &rest);
    let is_there = |name| tried.get(&key(name)).is_some();
    assert_eq!(["a", "b", "c", "d"].map(is_there), [false, true, false, true]);
    assert!(!abandoned.exists());
    put(&tried, &key("e"), &[0; 2000]);
    assert!(!is_there("e") && is_there("d"));
}

#[test]
fn a_folder_that_cannot_be_written_is_a_warning() {
    let tried = Tried::new(1 << 20);
    fs::write(tried.folder.path().join("cache"), "a file").unwrap();
    put(&tried, &key("a"), b"");
    put(&tried, &key("b"), b"");
    assert_eq!(tried.get(&key("a")), None);
    assert_eq!(tried.warned(), 1);
}

#[test]
fn many_writers_and_readers_get_along() {
    let tried = Tried::new(1 << 30);
    let long = vec![9; 3 << 20];
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..5 {
                    put(&tried, &key("a"), &long);
                    assert_eq!(tried.get(&key("a")), Some((WORDS.to_vec(), long.clone())));
                }
            });
        }
    });
    assert_eq!((tried.warned(), tried.files().len()), (0, 1));
}
