use std::fs::{self, File, FileTimes};
use std::path::Path;
use std::sync::Barrier;
use std::time::{Duration, Instant, SystemTime};

use super::claim::{Claim, Claims, Taken};
use super::left::Left;
use super::note::{Note, path_of};
use super::pulse::Sign;
use crate::cli::values::SHORTEST_LEASE;

const PICTURE: &str = "ball_00001.png";
/// Hash of what the picture is rendered from.
const RECIPE: &str = "0123456789abcdef";

/// Long enough for a thread that is delayed by a busy machine.
const LEASE: Duration = Duration::from_secs(5);

fn claims() -> Claims {
    Claims::new(LEASE).unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn taken(claims: &Claims, picture: &Path) -> Option<Claim> {
    match claims.take(picture, RECIPE).unwrap() {
        Taken::Mine(claim) => Some(claim),
        Taken::Theirs(_) | Taken::Other { .. } => None,
    }
}

/// Tries to take the claim for `most` at most.
fn wait(claims: &Claims, picture: &Path, most: Duration) -> Option<Claim> {
    let start = Instant::now();
    loop {
        let claim = taken(claims, picture);
        if claim.is_some() || start.elapsed() > most {
            return claim;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Makes a claim whose owner is dead, as `kill -9` leaves it.
fn abandoned(picture: &Path) -> Note {
    let note = Note::new(SHORTEST_LEASE, RECIPE);
    note.write(&mut File::create_new(path_of(picture)).unwrap()).unwrap();
    note
}

#[test]
fn one_process_has_a_frame_until_it_lets_go() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(PICTURE);
    let (one, other) = (claims(), claims());
    let claim = taken(&one, &picture).unwrap();
    assert!(wait(&other, &picture, LEASE + LEASE / 2).is_none(), "it is alive");
    assert!(!claim.is_lost());
    drop(claim);
    let claim = taken(&other, &picture).unwrap();
    assert_eq!(claim.dead, None);
    drop(claim);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn of_all_that_wait_for_a_dead_one_one_takes_over() {
    for round in 0..3 {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join(PICTURE);
        let dead = abandoned(&picture);
        // The times of files do not matter.
        let future = SystemTime::now() + Duration::from_secs(1 << 30);
        let file = File::options().write(true).open(path_of(&picture)).unwrap();
        file.set_times(FileTimes::new().set_modified(future)).unwrap();
        let start = Barrier::new(8);
        let winners: Vec<Claim> = std::thread::scope(|scope| {
            let race = || {
                let claims = claims();
                assert!(taken(&claims, &picture).is_none());
                start.wait();
                let claim = wait(&claims, &picture, LEASE);
                // No thread leaves before the last one has tried.
                start.wait();
                claim
            };
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(race)).collect();
            threads.into_iter().filter_map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!(winners.len(), 1, "round {round}");
        assert_eq!(winners[0].dead, Some(dead.worker), "round {round}");
        drop(winners);
        assert!(names(folder.path()).is_empty(), "round {round}: {:?}", names(folder.path()));
    }
}

#[test]
fn an_heir_that_died_before_its_renaming_is_in_nobodys_way() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(PICTURE);
    let dead = abandoned(&picture);
    let heir = format!("{}.{}", path_of(&picture).display(), dead.token);
    Note::new(SHORTEST_LEASE, RECIPE).write(&mut File::create_new(heir).unwrap()).unwrap();
    let claims = Claims::new(SHORTEST_LEASE).unwrap();
    drop(wait(&claims, &picture, 10 * LEASE).unwrap());
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_claim_without_words_is_taken_over_too() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(PICTURE);
    let claims = claims();
    File::create_new(path_of(&picture)).unwrap();
    let Taken::Theirs(Some(worker)) = claims.take(&picture, RECIPE).unwrap() else {
        panic!("it is taken")
    };
    assert_eq!(worker.to_string(), "process 0 on another machine");
    let (note, sign) = claims.pulse.look(&path_of(&picture)).unwrap().unwrap();
    assert_eq!(sign, Sign::Unknown);
    drop(claims.take_over(&path_of(&picture), &note, RECIPE).unwrap().unwrap());
    assert_eq!(names(folder.path()), [".slo-rt-ball_00001.png.claim"]);
}

#[test]
fn who_was_taken_for_dead_hears_of_it_and_touches_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(PICTURE);
    let (one, other) = (claims(), claims());
    let claim = taken(&one, &picture).unwrap();
    let note = Note::read(&path_of(&picture)).unwrap();
    let changed = Note { beats: 9, ..note.clone() };
    assert!(other.take_over(&path_of(&picture), &changed, RECIPE).unwrap().is_none());
    let heir = loop {
        let note = Note::read(&path_of(&picture)).unwrap();
        if let Some(heir) = other.take_over(&path_of(&picture), &note, RECIPE).unwrap() {
            break heir;
        }
    };
    let start = Instant::now();
    while !claim.is_lost() {
        assert!(start.elapsed() < 10 * LEASE);
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(claim);
    assert_eq!(Note::read(&path_of(&picture)).unwrap(), heir.1);
}

#[test]
fn a_claim_of_another_version_is_told_from_ours() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(PICTURE);
    let (one, other) = (claims(), claims());
    let claim = taken(&one, &picture).unwrap();
    let start = Instant::now();
    loop {
        let Taken::Other { worker, is_alive } = other.take(&picture, "fedcba").unwrap() else {
            panic!("it is another version's")
        };
        assert_eq!(worker, Note::read(&path_of(&picture)).unwrap().worker);
        if is_alive {
            break;
        }
        assert!(start.elapsed() < 10 * LEASE);
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(claim);
    // A dead claim of another version is soon replaced.
    abandoned(&picture);
    let start = Instant::now();
    let claim = loop {
        match other.take(&picture, "fedcba").unwrap() {
            Taken::Mine(claim) => break claim,
            Taken::Other { is_alive, .. } => assert!(!is_alive),
            Taken::Theirs(_) => panic!("it is another version's"),
        }
        assert!(start.elapsed() < 10 * LEASE);
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(claim.dead.is_some());
}

#[test]
fn claims_that_were_dead_long_before_are_swept_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = [PICTURE, "ball_00002.png"].map(|name| folder.path().join(name));
    for picture in [&old, &new] {
        abandoned(picture);
    }
    let file = File::options().write(true).open(path_of(&old)).unwrap();
    file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
    let left = Left::look(folder.path(), [&*old, &*new].into_iter());
    left.sweep();
    assert_eq!(names(folder.path()), [".slo-rt-ball_00002.png.claim"]);
}

#[test]
fn claims_that_nobody_holds_are_swept_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let dead = abandoned(&at(PICTURE));
    let heir = format!(".slo-rt-{PICTURE}.claim.{}", dead.token);
    dead.write(&mut File::create_new(at(&heir)).unwrap()).unwrap();
    let claims = Claims::new(SHORTEST_LEASE).unwrap();
    let live = taken(&claims, &at("ball_00002.png")).unwrap();
    abandoned(&at("ball_00003.png"));
    let pictures = [at(PICTURE), at("ball_00002.png")];
    let left = Left::look(folder.path(), pictures.iter().map(|path| &**path));
    std::thread::sleep(2 * SHORTEST_LEASE);
    left.sweep();
    let mut names = names(folder.path());
    names.sort();
    assert_eq!(names, [".slo-rt-ball_00002.png.claim", ".slo-rt-ball_00003.png.claim"]);
    assert!(!live.is_lost());
}
