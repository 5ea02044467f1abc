//! Whether there is room for what a run makes: on the disk and in memory.

use std::path::Path;
use std::process::{Command, Stdio};

use super::summary::megabytes;
use super::terminal::Terminal;
use crate::film::{Features, Layer, Pixel, Spread, Subject};
use crate::scene::OutputFormat;

/// Bytes that a run needs at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Needs {
    /// Of pictures, and of a checkpoint.
    pub(super) disk: u64,
    /// Of the film, and of the copy that a checkpoint is written from.
    pub(super) memory: u64,
}

impl Needs {
    /// For so many pictures.
    pub(super) fn of(subject: &Subject, format: OutputFormat, pictures: usize) -> Self {
        let region = subject.region.len() as u64;
        let spreads = if subject.with_spreads { size_of::<Spread>() } else { 0 };
        let (features, images) = match subject.with_features {
            true => (size_of::<Features>(), 1 + Layer::ALL.len() as u64),
            false => (0, 1),
        };
        let film = subject.area.len() as u64 * (size_of::<Pixel>() + spreads + features) as u64;
        let value = match format {
            OutputFormat::Png8 => 1,
            OutputFormat::Png16 => 2,
            OutputFormat::Exr => 4,
        };
        let picture = region.saturating_mul(3 * value * images).saturating_add(4096);
        let disk = picture.saturating_mul(pictures as u64).saturating_add(film);
        Self { disk, memory: film.saturating_mul(2) }
    }

    /// The same where the states of so many frames are kept until the end.
    pub(super) fn with_states(self, frames: usize) -> Self {
        let film = self.memory / 2;
        let more = film.saturating_mul(frames.saturating_sub(1) as u64);
        Self { disk: self.disk.saturating_add(more), ..self }
    }

    /// Warns where there is less than that.
    pub(super) fn check(&self, outdir: &Path, terminal: Terminal) {
        if let Some(free) = free_on_disk(outdir).filter(|free| *free < self.disk) {
            terminal.warn(format_args!(
                "the output folder has {} left; all pictures take up to {}",
                megabytes(free),
                megabytes(self.disk)
            ));
        }
        if let Some(free) = free_memory().filter(|free| *free < self.memory) {
            terminal.warn(format_args!(
                "{} of memory are free; the picture alone takes up to {}",
                megabytes(free),
                megabytes(self.memory)
            ));
        }
    }
}

/// Bytes that are left where a folder is, as POSIX's `df` tells; `None` where there is none.
fn free_on_disk(folder: &Path) -> Option<u64> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // A folder that is still to be made will lie where the nearest one above it does.
    let there = folder.ancestors().find(|folder| folder.is_dir()).unwrap_or(Path::new("."));
    let mut df = Command::new("df");
    df.arg("-Pk").arg("--").arg(there).stdin(Stdio::null()).stderr(Stdio::null());
    free_of(&String::from_utf8_lossy(&df.output().ok()?.stdout))
}

fn free_of(df: &str) -> Option<u64> {
    let kibibytes: u64 = df.lines().nth(1)?.split_whitespace().nth(3)?.parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Bytes of memory that a program can have, where the system tells.
fn free_memory() -> Option<u64> {
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Area;

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
        };
        let needs = Needs::of(&subject, OutputFormat::Png16, 10);
        assert_eq!(needs.memory, 2 * 10_000 * 56);
        assert_eq!(needs.disk, 10 * (60_000 + 4096) + 10_000 * 56);
        subject.with_features = true;
        let needs = Needs::of(&subject, OutputFormat::Exr, 1);
        assert_eq!(needs.disk, 360_000 + 4096 + 10_000 * 104);
    }

    #[test]
    fn df_is_understood() {
        let df = "Filesystem 1024-blocks Used Available Capacity Mounted on\n\
                  /dev/sda1 1000 400 600 40% /home\n";
        assert_eq!(free_of(df), Some(600 * 1024));
        assert_eq!(free_of("df: no\n"), None);
        assert_eq!(free_of(""), None);
    }
}
