//! Checks whether there is room for the results of a run, on the disk and in memory.

use std::path::Path;

use super::memory;
use super::memory::Left;
use crate::cli::base::{Exit, Problem, Terminal, megabytes};
use slo_picture::film::{Features, Fixed, Pixel, Spread, Subject};
use slo_picture::output::memory_to_write;
use slo_scene::OutputFormat;

/// Bytes of working memory per thread, and bytes for everything small.
const PER_THREAD: u64 = 4 << 20;
const REST: u64 = 4 << 20;

/// Bytes that a run needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Maximum disk space of the pictures and of a checkpoint.
    pub(crate) disk: u64,
    /// Memory of the film.
    film: u64,
    /// Memory of what the rays of each pixel take, if they are counted.
    costs: u64,
    /// Memory for writing the files that are made from a film, while the film is in memory.
    pub(crate) end: u64,
}

impl Needs {
    /// Computes the needs of `pictures` pictures.
    pub(crate) fn of(
        subject: &Subject,
        format: OutputFormat,
        pictures: usize,
        beside: Beside,
    ) -> Self {
        let region = subject.region.len() as u64;
        let spreads = if subject.with_spreads { size_of::<Spread>() } else { 0 };
        let (features, surfaces) = match subject.with_features {
            true => (size_of::<Features>(), 2),
            false => (0, 0),
        };
        // Each named group has sums of its own, and the group of all other light a layer too.
        let (groups, lights) = match &subject.light_groups {
            Some(groups) => (groups.len() * size_of::<[Fixed; 3]>(), groups.len() as u64 + 1),
            None => (0, 0),
        };
        let hits = subject.first_hits.bytes();
        let images = 1 + surfaces + lights + subject.first_hits.images() + beside.images;
        let each = (size_of::<Pixel>() + spreads + features + groups + hits) as u64;
        let film = subject.area.len() as u64 * each;
        let costs = beside.counted_pixels.saturating_mul(BYTES_OF_COSTS);
        let value = u64::from(format.value_bytes());
        let picture = region.saturating_mul(3 * value * images).saturating_add(4096);
        let disk = picture.saturating_mul(pictures as u64).saturating_add(film);
        let size = [subject.region.width(), subject.region.height()];
        let encoding = memory_to_write(format, size, images);
        let map = if beside.maps { region.saturating_mul(BYTES_OF_A_MAP) } else { 0 };
        let kept = if beside.states { film } else { 0 };
        let end = encoding.max(map).max(kept).saturating_add(REST);
        Self { disk, film, costs, end }
    }

    /// Returns the bytes of memory without which there is no picture.
    pub(crate) fn memory(&self) -> u64 {
        self.film.saturating_add(self.costs).saturating_add(self.end).saturating_add(self.work())
    }

    /// Returns the bytes of memory that threads work with.
    pub(crate) fn work(&self) -> u64 {
        rayon::current_num_threads() as u64 * PER_THREAD
    }

    /// Returns the needs if the states of `frames` frames are kept until the end.
    pub(crate) fn with_states(self, frames: usize) -> Self {
        let more = self.film.saturating_mul(frames.saturating_sub(1) as u64);
        Self { disk: self.disk.saturating_add(more), ..self }
    }

    /// Warns if there is less room than needed.
    ///
    /// # Errors
    /// There is not enough memory for a picture.
    pub(crate) fn check(&self, outdir: &Path, terminal: Terminal) -> Result<(), Problem> {
        let left = memory::left();
        if left.is_some_and(|left| left.bytes < self.memory()) {
            return Err(self.too_large_for(left));
        }
        if let Some(free) = free_on_disk(outdir).filter(|free| *free < self.disk) {
            terminal.warn(format_args!(
                "the disk of the output folder has {} left, but all pictures may take up to {}",
                megabytes(free),
                megabytes(self.disk)
            ));
        }
        let all = self.memory().saturating_add(self.film);
        if let Some(left) = left.filter(|left| left.bytes < all) {
            terminal.warn(format_args!(
                "{left}; the picture and the copy for its checkpoints may take up to {}",
                megabytes(all)
            ));
        }
        Ok(())
    }

    /// Makes the problem that there is not enough memory for the picture.
    pub(crate) fn too_large(&self) -> Problem {
        self.too_large_for(memory::left())
    }

    fn too_large_for(&self, left: Option<Left>) -> Problem {
        let needs = megabytes(self.memory());
        let message = match left {
            Some(left) => format!("the picture needs {needs} of memory, but {left}"),
            None => format!("the picture needs {needs} of memory"),
        };
        let problem = Problem::new(Exit::Failed, message)
            .with_help("make it smaller with `--size`, or render a region of it with `--region`");
        let problem = match left.is_some_and(|left| left.is_of_option()) {
            true => problem.with_help("fewer `--threads` take less; or raise `--memory-limit`"),
            false => problem,
        };
        match left.is_some_and(|left| left.is_of_address_space()) {
            true => problem.with_help(
                "fewer `--threads`, or MALLOC_ARENA_MAX=1 in the environment, take less of the \
                 address space",
            ),
            false => problem,
        }
    }
}

/// Files that are written beside pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Beside {
    pub(crate) maps: bool,
    /// Sums of samples. New ones are compared with existing ones.
    pub(crate) states: bool,
    /// Layers of the picture's file that need nothing of the film but its pixels.
    pub(crate) images: u64,
    /// Pixels whose rays are counted one by one.
    pub(crate) counted_pixels: u64,
}

/// Bytes per pixel while a map is made.
const BYTES_OF_A_MAP: u64 = 28;
/// Bytes per pixel while rays are counted, with the copy that becomes a map.
const BYTES_OF_COSTS: u64 = 32;

/// Returns the bytes that are free on the disk of a folder. Returns `None` if the system does not
/// report them or does not answer: a file server may be gone.
#[cfg(unix)]
fn free_on_disk(folder: &Path) -> Option<u64> {
    use std::sync::mpsc;
    use std::time::Duration;
    /// How long the system may take to report the free space of a disk.
    const PATIENCE: Duration = Duration::from_secs(2);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.to_owned();
    let (tell, told) = mpsc::channel();
    let ask = move || {
        // A folder that does not exist yet will lie on the disk of the nearest existing folder
        // above it.
        let there = folder.ancestors().find(|folder| folder.is_dir()).unwrap_or(Path::new("."));
        let free = rustix::fs::statvfs(there).ok();
        let _ = tell.send(free.and_then(|free| free.f_bavail.checked_mul(free.f_frsize)));
    };
    std::thread::Builder::new().name("disk".into()).spawn(ask).ok()?;
    told.recv_timeout(PATIENCE).ok()?
}

#[cfg(not(unix))]
fn free_on_disk(_: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_picture::film::{Area, FirstHitLayers, PlaceLayers};

    #[test]
    fn needs_grow_with_pixels_and_pictures() {
        let area = Area::whole(100, 100);
        let recipe = String::new();
        let mut subject = Subject {
            recipe,
            area,
            region: area,
            samples: None,
            with_spreads: false,
            with_features: false,
            light_groups: None,
            first_hits: FirstHitLayers::default(),
        };
        let none = Beside::default();
        let needs = Needs::of(&subject, OutputFormat::Png16, 10, none);
        assert_eq!((needs.film, needs.end), (10_000 * 56, 60_000 + REST));
        assert!(needs.memory() > needs.film + needs.end);
        let maps = Needs::of(&subject, OutputFormat::Png8, 10, Beside { maps: true, ..none });
        assert_eq!(maps.end, 280_000 + REST);
        let states = Needs::of(&subject, OutputFormat::Png8, 10, Beside { states: true, ..none });
        assert_eq!(states.end, 560_000 + REST);
        assert_eq!(needs.disk, 10 * (60_000 + 4096) + 10_000 * 56);
        let counted = Beside { counted_pixels: 10_000, ..none };
        let counted = Needs::of(&subject, OutputFormat::Png16, 10, counted);
        assert_eq!(counted.memory(), needs.memory() + 320_000);
        subject.with_features = true;
        let needs = Needs::of(&subject, OutputFormat::Exr, 1, none);
        assert_eq!((needs.film, needs.end), (10_000 * 104, 360_000 + REST));
        assert_eq!(needs.disk, 360_000 + 4096 + 10_000 * 104);
        subject.first_hits.places = PlaceLayers { depth: true, ..PlaceLayers::default() };
        let more = Needs::of(&subject, OutputFormat::Exr, 1, Beside { images: 1, ..none });
        assert_eq!((more.film, more.end), (10_000 * 136, 600_000 + REST));
    }

    #[cfg(unix)]
    #[test]
    fn the_disk_tells_its_room_also_for_folders_that_are_to_be() {
        let folder = tempfile::tempdir().unwrap();
        assert!(free_on_disk(folder.path()).is_some_and(|free| free > 0));
        assert!(free_on_disk(&folder.path().join("a/b")).is_some_and(|free| free > 0));
        assert!(free_on_disk(Path::new("")).is_some());
    }
}
