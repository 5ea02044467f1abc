//! Memory that the program can have: by limits on the process and on its control group, and by
//! what the machine has left.

use std::fmt::{self, Display};
use std::sync::OnceLock;

use crate::cli::base::megabytes;

/// Memory that the tightest of all limits leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Left {
    /// Bytes that the program can still take.
    pub(crate) bytes: u64,
    /// The tightest limit.
    of: Limit,
}

/// What can limit the memory of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(not(target_os = "linux"), allow(dead_code))]
enum Limit {
    /// The address space of the process.
    AddressSpace,
    /// The memory that the process writes to.
    Data,
    /// The memory of all processes of a control group.
    Group,
    /// The memory that other processes have left.
    Machine,
    /// What the command line allows.
    Option,
}

/// Most bytes that the command line allows the program.
static ALLOWED: OnceLock<u64> = OnceLock::new();

/// Limits the memory of the program to so many bytes, if there is a number, and has everything that
/// allocates by the size of an input ask first.
pub(crate) fn limit(bytes: Option<u64>) {
    if let Some(bytes) = bytes {
        let _ = ALLOWED.set(bytes);
    }
    slo_scene::memory::ask_first(|| {
        let left = left()?;
        Some(slo_scene::memory::Left { bytes: left.bytes, said: left.to_string() })
    });
}

/// What the command line allows, and of that what the program has not taken yet.
fn allowed(used: u64) -> Option<Left> {
    let bytes = ALLOWED.get()?.saturating_sub(used);
    Some(Left { bytes, of: Limit::Option })
}

impl Left {
    /// Whether it is the command line that limits the program.
    pub(crate) fn is_of_option(self) -> bool {
        self.of == Limit::Option
    }

    /// Whether the program is limited in the memory that it may reserve, not in what it may use.
    pub(crate) fn is_of_address_space(self) -> bool {
        self.of == Limit::AddressSpace
    }
}

impl Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let of = match self.of {
            Limit::AddressSpace => "the limit on the address space (`ulimit -v`)",
            Limit::Data => "the limit on data (`ulimit -d`)",
            Limit::Group => "the memory limit of the control group",
            Limit::Machine => "the memory of the machine",
            Limit::Option => "the limit of `--memory-limit`",
        };
        write!(f, "{of} leaves {}", megabytes(self.bytes))
    }
}

/// Returns the memory that the tightest limit leaves, or `None` if the system does not report it.
#[cfg(target_os = "linux")]
pub(crate) fn left() -> Option<Left> {
    use rustix::process::{Resource, getrlimit};
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let status = read("/proc/self/status").unwrap_or_default();
    let of_process = |resource, used: &str, of| {
        let most = getrlimit(resource).current?;
        Some(Left { bytes: most.saturating_sub(kibibytes(&status, used)?), of })
    };
    let machine = || {
        let info = read("/proc/meminfo")?;
        let swap = kibibytes(&info, "SwapFree:").unwrap_or(0);
        Some(Left { bytes: kibibytes(&info, "MemAvailable:")? + swap, of: Limit::Machine })
    };
    let group = || {
        let bytes = group::left(&read("/proc/self/cgroup")?, "/sys/fs/cgroup", read)?;
        Some(Left { bytes, of: Limit::Group })
    };
    let option = || allowed(kibibytes(&status, "VmRSS:").unwrap_or(0));
    let limits = [
        option(),
        of_process(Resource::As, "VmSize:", Limit::AddressSpace),
        of_process(Resource::Data, "VmData:", Limit::Data),
        group(),
        machine(),
    ];
    limits.into_iter().flatten().min()
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn left() -> Option<Left> {
    allowed(0)
}

/// Returns the number after a name in a file of `/proc`, in bytes.
#[cfg(target_os = "linux")]
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Control groups of versions 1 and 2.
#[cfg(target_os = "linux")]
mod group {
    /// Names in the folder of a group: the file of the limit, the file of the memory in use, and
    /// the entry in `memory.stat` for the memory in use that the system reclaims before it refuses
    /// anything.
    struct Version {
        most: &'static str,
        used: &'static str,
        reclaimable: &'static str,
    }

    const ONE: Version = Version {
        most: "memory.limit_in_bytes",
        used: "memory.usage_in_bytes",
        reclaimable: "total_inactive_file ",
    };
    const TWO: Version =
        Version { most: "memory.max", used: "memory.current", reclaimable: "inactive_file " };

    /// Returns the memory that the tightest limit leaves, among the groups that `groups`
    /// (`/proc/self/cgroup`) names and all groups above them.
    pub(super) fn left(
        groups: &str,
        root: &str,
        read: impl Fn(&str) -> Option<String>,
    ) -> Option<u64> {
        let of_line = |line: &str| {
            let mut fields = line.splitn(3, ':');
            let (_, kinds, path) = (fields.next()?, fields.next()?, fields.next()?);
            let (root, version) = match kinds {
                "" => (root.to_owned(), TWO),
                _ if kinds.split(',').any(|kind| kind == "memory") => {
                    (format!("{root}/memory"), ONE)
                }
                _ => return None,
            };
            let mut path = path.trim_end_matches('/');
            let mut least = None;
            loop {
                let here = left_of(&format!("{root}{path}"), &version, &read);
                least = least.into_iter().chain(here).min();
                match path.rsplit_once('/') {
                    Some((above, _)) => path = above,
                    None => return least,
                }
            }
        };
        groups.lines().filter_map(of_line).min()
    }

    fn left_of(
        folder: &str,
        version: &Version,
        read: &impl Fn(&str) -> Option<String>,
    ) -> Option<u64> {
        let number = |name: &str| read(&format!("{folder}/{name}"))?.trim().parse::<u64>().ok();
        // `max` is no number and means that there is no limit.
        let most = number(version.most)?;
        let used = number(version.used)?;
        let stat = read(&format!("{folder}/memory.stat")).unwrap_or_default();
        let back = stat.lines().find_map(|line| line.strip_prefix(version.reclaimable));
        let back = back.and_then(|bytes| bytes.trim().parse().ok()).unwrap_or(0);
        Some(most.saturating_sub(used.saturating_sub(back)))
    }
}

/// Memory that is reserved early, so that it is available when needed. Nothing is written to it.
pub(crate) struct Reserve(Vec<u8>);

impl Reserve {
    /// Reserves `bytes` bytes, if they are available.
    pub(crate) fn new(bytes: u64) -> Option<Self> {
        let mut reserve = Vec::new();
        reserve.try_reserve_exact(usize::try_from(bytes).ok()?).ok()?;
        Some(Self(reserve))
    }

    /// Returns the memory to the system.
    pub(crate) fn release(self) {
        drop(self.0);
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_proc_are_kibibytes() {
        let text = "MemTotal:  16 kB\nMemAvailable:       3 kB\nSwapFree: x kB\n";
        assert_eq!(kibibytes(text, "MemAvailable:"), Some(3072));
        assert_eq!(kibibytes(text, "SwapFree:"), None);
        assert_eq!(kibibytes(text, "MemFree:"), None);
    }

    #[test]
    fn the_system_tells_what_is_left() {
        assert!(left().is_some_and(|left| left.bytes > 0), "{:?}", left());
    }

    /// Returns the memory that is left according to `files`, whose names omit `/sys/fs/cgroup`.
    fn of(groups: &str, files: &[(&str, &str)]) -> Option<u64> {
        let read = |path: &str| {
            let name = path.strip_prefix("/sys/fs/cgroup").unwrap();
            files.iter().find(|file| file.0 == name).map(|file| file.1.to_owned())
        };
        group::left(groups, "/sys/fs/cgroup", read)
    }

    #[test]
    fn the_smallest_limit_of_all_groups_above_counts() {
        let files = [
            ("/a/memory.max", "5000\n"),
            ("/a/memory.current", "1500\n"),
            ("/a/memory.stat", "anon 7\ninactive_file 500\nactive_file 1\n"),
            ("/a/b/memory.max", "max\n"),
            ("/a/b/memory.current", "1000\n"),
            ("/a/b/c/memory.max", "6000\n"),
            ("/a/b/c/memory.current", "1000\n"),
        ];
        assert_eq!(of("0::/a/b/c\n", &files), Some(4000));
        assert_eq!(of("0::/\n", &files), None);
        assert_eq!(of("0::/\n", &[("/memory.max", "9"), ("/memory.current", "10")]), Some(0));
        // Inside a container, the path is the host's, and the files lie at the root.
        assert_eq!(of("0::/x/y", &[("/memory.max", "9"), ("/memory.current", "2")]), Some(7));
        assert_eq!(of("nonsense", &files), None);
    }

    #[test]
    fn groups_of_the_first_version_are_known() {
        let files = [
            ("/memory/job/memory.limit_in_bytes", "8000"),
            ("/memory/job/memory.usage_in_bytes", "3000"),
            ("/memory/job/memory.stat", "inactive_file 1\ntotal_inactive_file 1000\n"),
            ("/memory/memory.limit_in_bytes", "9223372036854771712"),
            ("/memory/memory.usage_in_bytes", "3000"),
        ];
        assert_eq!(of("3:cpu,cpuacct:/x\n5:memory:/job\n0::/\n", &files), Some(6000));
    }

    #[test]
    fn a_reserve_beyond_all_memory_is_refused() {
        assert!(Reserve::new(u64::MAX).is_none() && Reserve::new(1 << 62).is_none());
        Reserve::new(1 << 20).unwrap().release();
    }
}
