//! The memory that is free: of the machine, and within the control groups of the process, as Linux tells them.
//!
//! A group's limit holds for all that its processes hold; pages of files that nobody reads at the moment are given up for
//! it, so they count as free.
//!
//! Source: `proc(5)`; the Linux kernel's documentation of control groups, versions 1 and 2, "memory".

use std::path::Path;

/// Bytes that the process may take besides what it holds; nothing if that is not told.
pub fn available_bytes() -> Option<u64> {
    available_under(Path::new("/"))
}

/// The same by files below a folder.
fn available_under(root: &Path) -> Option<u64> {
    let machine = std::fs::read_to_string(root.join("proc/meminfo")).ok();
    let machine = machine.and_then(|text| Some(number_after(&text, "MemAvailable:")? * 1024));
    let groups = std::fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let groups = groups.lines().filter_map(|line| left_in_group(root, line));
    groups.chain(machine).min()
}

/// What a group of the process and those around it leave; `line` is as in `/proc/self/cgroup`.
fn left_in_group(root: &Path, line: &str) -> Option<u64> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (controllers, path) = (parts.next()?, parts.next()?);
    let (folder, files) = match controllers {
        "" => (
            "sys/fs/cgroup",
            ["memory.max", "memory.current", "inactive_file "],
        ),
        names if names.split(',').any(|name| name == "memory") => (
            "sys/fs/cgroup/memory",
            [
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
                "total_inactive_file ",
            ],
        ),
        _ => return None,
    };
    // Within a container, the path may be the one outside it, and only the root is seen.
    let own = Path::new(path.trim_start_matches('/'));
    own.ancestors()
        .filter_map(|group| left_in(&root.join(folder).join(group), files))
        .min()
}

fn left_in(group: &Path, [limit, held, reclaimable]: [&str; 3]) -> Option<u64> {
    let number = |file: &str| {
        let text = std::fs::read_to_string(group.join(file)).ok()?;
        text.trim().parse::<u64>().ok()
    };
    let limit = number(limit)?;
    let stat = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let reclaimable = number_after(&stat, reclaimable).unwrap_or(0);
    let held = number(held).unwrap_or(0).saturating_sub(reclaimable);
    Some(limit.saturating_sub(held))
}

/// The number that follows a word at the start of a line.
fn number_after(text: &str, word: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(word))?;
    rest.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::TempDir::new().expect("a temporary folder");
        for (file, text) in files {
            let path = root.path().join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, text).expect("written");
        }
        root
    }

    const MEMORY: (&str, &str) = (
        "proc/meminfo",
        "MemTotal: 9000 kB\nMemAvailable:    4000 kB\n",
    );

    #[test]
    fn the_least_that_machine_and_groups_leave() {
        let plain = machine(&[MEMORY]);
        assert_eq!(available_under(plain.path()), Some(4_096_000));
        let second = machine(&[
            MEMORY,
            ("proc/self/cgroup", "0::/user/job\n"),
            ("sys/fs/cgroup/user/job/memory.max", "max\n"),
            ("sys/fs/cgroup/user/memory.max", "1000000\n"),
            ("sys/fs/cgroup/user/memory.current", "600000\n"),
            (
                "sys/fs/cgroup/user/memory.stat",
                "anon 1\ninactive_file 200000\n",
            ),
        ]);
        assert_eq!(available_under(second.path()), Some(600_000));
        // Only the root is seen of a group whose path is that outside the container.
        let first = machine(&[
            MEMORY,
            (
                "proc/self/cgroup",
                "5:devices:/x\n4:cpu,memory:/docker/abc\n",
            ),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "3000000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "1000000\n"),
        ]);
        assert_eq!(available_under(first.path()), Some(2_000_000));
        assert_eq!(available_under(machine(&[]).path()), None);
    }
}
