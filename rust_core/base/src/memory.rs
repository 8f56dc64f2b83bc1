//! Available memory. Rust aborts the process if an allocation fails. Large allocations are therefore estimated beforehand, and
//! refused if they do not fit.
//!
//! Available memory is the least of these figures of Linux:
//!
//! - `MemAvailable`;
//! - the remainder of the limits of the control groups (version 2 or 1);
//! - the remainder of the limits of the process on its address space and data.

use std::fs::read_to_string;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Size below which allocations are not checked [bytes].
pub const SMALL: usize = 1 << 20;

/// Memory that a checked allocation leaves for those that are not checked [bytes].
pub const HEADROOM: usize = 1 << 24;

/// Memory available without swapping [bytes], if the system reports it.
pub fn available() -> Option<u64> {
    let read = |path: &str| read_to_string(path).unwrap_or_default();
    let free = number_after(&read("/proc/meminfo"), "MemAvailable:").map(|kilobytes| 1024 * kilobytes);
    let (limits, status) = (read("/proc/self/limits"), read("/proc/self/status"));
    let left = |limit: &str, used: &str| {
        let used = 1024 * number_after(&status, used)?;
        Some(number_after(&limits, limit)?.saturating_sub(used))
    };
    let process = [left("Max address space", "VmSize:"), left("Max data size", "VmData:")];
    let groups = groups(&read("/proc/self/cgroup")).into_iter().map(|group| group.left(&|path| read_to_string(path).ok()));
    groups.chain(process).chain([free]).flatten().min()
}

/// Refuses an allocation that does not fit: `needed` bytes in total, of which `held` bytes are already held and will be reused.
///
/// # Errors
/// [`Error::Memory`] if the new bytes exceed [`SMALL`], and the available memory less [`HEADROOM`].
pub fn check(what: &str, needed: usize, held: usize, hint: impl FnOnce() -> String) -> Result<()> {
    if needed.saturating_sub(held) <= SMALL {
        return Ok(());
    }
    match available().map(|free| free.saturating_sub(HEADROOM as u64).saturating_add(held as u64)) {
        Some(available) if needed as u64 > available => Err(refusal(what, needed, available, hint)),
        _ => Ok(()),
    }
}

/// Returns the error for `needed` bytes that are not available.
pub fn refusal(what: &str, needed: usize, available: u64, hint: impl FnOnce() -> String) -> Error {
    Error::Memory { what: what.to_owned(), needed: needed as u64, available, hint: hint() }
}

/// Parses the number after a label at the beginning of a line; None for `unlimited`.
fn number_after(text: &str, label: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(label))?.split_whitespace().next()?.parse().ok()
}

/// Memory files of a control group.
struct ControlGroup {
    folder: PathBuf,
    limit: &'static str,
    usage: &'static str,
    /// Name of the file cache within the usage; the cache is reclaimed when memory runs short.
    files: &'static str,
}

impl ControlGroup {
    /// Remaining memory [bytes], if there is a limit.
    fn left(&self, read: &dyn Fn(&Path) -> Option<String>) -> Option<u64> {
        let number = |name: &str| read(&self.folder.join(name))?.trim().parse::<u64>().ok();
        let (limit, usage) = (number(self.limit)?, number(self.usage)?);
        let files = number_after(&read(&self.folder.join("memory.stat")).unwrap_or_default(), self.files).unwrap_or(0);
        Some(limit.saturating_sub(usage.saturating_sub(files)))
    }
}

/// Control groups of the process and their ancestors, from the text of `/proc/self/cgroup`. A container often sees its own group
/// at the root.
fn groups(text: &str) -> Vec<ControlGroup> {
    let mut groups = Vec::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next()) else { continue };
        let (root, limit, usage, files) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max", "memory.current", "inactive_file "),
            _ if controllers.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file ")
            }
            _ => continue,
        };
        for ancestor in Path::new(path.trim_start_matches('/')).ancestors() {
            groups.push(ControlGroup { folder: Path::new(root).join(ancestor), limit, usage, files });
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_where_there_are_any() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max data size             unlimited            unlimited            bytes     \n\
                      Max address space         4294967296           unlimited            bytes     \n";
        assert_eq!(number_after(limits, "Max address space"), Some(4 << 30));
        assert_eq!(number_after(limits, "Max data size"), None);
        assert_eq!(number_after("MemFree: 1 kB\nMemAvailable:   17 kB\n", "MemAvailable:"), Some(17));
    }

    #[test]
    fn a_group_leaves_its_limit_without_what_is_used_but_for_files() {
        let read = |path: &Path| {
            let text = match path.to_str()? {
                "/sys/fs/cgroup/a/b/memory.max" | "/sys/fs/cgroup/memory.max" => "max\n",
                "/sys/fs/cgroup/a/memory.current" => "700\n",
                "/sys/fs/cgroup/a/memory.stat" => "anon 100\ninactive_file 300\n",
                "/sys/fs/cgroup/memory/memory.limit_in_bytes" => "900\n",
                "/sys/fs/cgroup/a/memory.max" | "/sys/fs/cgroup/memory/memory.usage_in_bytes" => "1000\n",
                _ => return None,
            };
            Some(text.to_owned())
        };
        let left = |text: &str| groups(text).iter().filter_map(|group| group.left(&read)).min();
        assert_eq!(left("0::/a/b\n"), Some(600));
        assert_eq!(left("0::/\n"), None);
        assert_eq!(left("5:cpu:/x\n4:memory,hugetlb:/x/y\n"), Some(0));
        assert_eq!(left(""), None);
    }

    #[test]
    fn what_fits_passes_and_what_does_not_is_refused_with_both_figures() {
        let hint = || "take less".to_owned();
        assert_eq!(check("lists", SMALL, 0, hint), Ok(()));
        let Some(available) = available() else { return };
        let error = check("lists", usize::MAX, 0, hint).unwrap_err().to_string();
        assert!(error.starts_with("lists: needs ") && error.ends_with(" are available (take less)"), "{error}");
        assert!(available > 0 && error.contains("GB"), "{error}");
        let said = refusal("lists", 40_000_000_000, 3_900_000, hint).to_string();
        assert_eq!(said, "lists: needs 40.0 GB, 3.9 MB are available (take less)");
    }
}
