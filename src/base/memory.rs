//! Available memory. It is compared with the requirements of a scene before any allocation.

use std::sync::OnceLock;

/// Memory to assume if the system does not report it: 16 GiB, or 2 GiB on a 32-bit system.
const UNKNOWN: u64 = if usize::BITS > 32 { 16 << 30 } else { 2 << 30 };

/// Returns the memory of the machine `[bytes]`, or a lower limit by a control group or `ulimit -v`.
pub(crate) fn total() -> u64 {
    static TOTAL: OnceLock<u64> = OnceLock::new();
    *TOTAL.get_or_init(|| system::limits().into_iter().flatten().min().unwrap_or(UNKNOWN))
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs;
    use std::path::Path;

    pub fn limits() -> [Option<u64>; 3] {
        [physical(), control_group(), process()]
    }

    fn physical() -> Option<u64> {
        // SAFETY: `sysconf` only returns a number.
        let of = |name| u64::try_from(unsafe { libc::sysconf(name) }).ok();
        of(libc::_SC_PHYS_PAGES)?.checked_mul(of(libc::_SC_PAGESIZE)?)
    }

    fn process() -> Option<u64> {
        let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
        // SAFETY: the call writes only to `limit`.
        let is_known = unsafe { libc::getrlimit(libc::RLIMIT_AS, &raw mut limit) } == 0;
        (is_known && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur)
    }

    /// Returns the smallest memory limit of this process's control group (version 1 or 2) and its parents.
    fn control_group() -> Option<u64> {
        let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
        groups.lines().filter_map(|line| least_of(line, Path::new("/sys/fs/cgroup"))).min()
    }

    /// Smallest limit for a line of `/proc/self/cgroup`, such as `0::/user.slice` or `4:memory:/user.slice`.
    pub(super) fn least_of(line: &str, root: &Path) -> Option<u64> {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        let (root, file) = match controllers {
            "" => (root.to_owned(), "memory.max"),
            _ if controllers.split(',').any(|it| it == "memory") => (root.join("memory"), "memory.limit_in_bytes"),
            _ => return None,
        };
        let folder = root.join(path.trim_start_matches('/'));
        let folders = folder.ancestors().take_while(|folder| folder.starts_with(&root));
        // Without a limit, the file contains the word `max` or a number larger than any memory.
        folders.filter_map(|folder| fs::read_to_string(folder.join(file)).ok()?.trim().parse().ok()).min()
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    pub fn limits() -> [Option<u64>; 1] {
        [None]
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn total_memory_is_plausible() {
        assert!((1 << 20..1 << 60).contains(&total()), "{}", total());
    }

    #[test]
    fn the_tightest_control_group_counts() {
        let root = tempfile::tempdir().unwrap();
        let inner = root.path().join("outer/inner");
        fs::create_dir_all(&inner).unwrap();
        fs::create_dir_all(root.path().join("memory/old")).unwrap();
        fs::write(root.path().join("outer/memory.max"), "5000\n").unwrap();
        fs::write(inner.join("memory.max"), "max\n").unwrap();
        fs::write(root.path().join("memory/old/memory.limit_in_bytes"), "7000\n").unwrap();
        let least = |line| system::least_of(line, root.path());
        assert_eq!(least("0::/outer/inner"), Some(5000));
        assert_eq!(least("0::/"), None);
        assert_eq!(least("4:cpu,memory:/old"), Some(7000));
        assert_eq!(least("5:cpu:/old"), None);
    }
}
