//! What the C library does with memory that is given back: the program's only `unsafe` code beside the
//! binding to the physics engine, as the C library's setting has no safe face.
//!
//! Each simulated episode makes a model, its data and a trace, mostly in blocks of a few hundred kilobytes,
//! and gives them back. As it comes, the GNU C library asks the system for the first block of a size, and
//! once that was given back keeps all of that size for itself (`man mallopt`, `M_MMAP_THRESHOLD`, "dynamic
//! mmap threshold"): parallel episodes then hold 2.9 MiB each where 1.9 are enough. It is a setting of the whole process, so
//! that no library makes it.

#![allow(unsafe_code)]

/// Blocks of this size and above go back to the system.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE_BYTES: libc::c_int = 64 * 1024;

/// From now on, gives large blocks back to the system as soon as they are free; says whether the C
/// library does so. It costs a system call each, so things stay as they are where the physics library is
/// not loaded.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn give_large_blocks_back() -> bool {
    // SAFETY: `mallopt` takes two numbers and sets a parameter under the allocator's own lock, so that any
    // thread may call it at any time; blocks that were handed out before stay as they are.
    unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE_BYTES) == 1 }
}

/// Other C libraries decide that for themselves.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn give_large_blocks_back() -> bool {
    false
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests {
    use super::*;

    /// Blocks that were asked for from the system one by one, as the C library counts them.
    fn blocks_from_system() -> usize {
        // SAFETY: it only reads the allocator's counters.
        unsafe { libc::mallinfo2() }.hblks
    }

    #[test]
    fn large_blocks_come_from_the_system_after_others_were_given_back_to_it() {
        assert!(give_large_blocks_back());
        // As it comes, the C library would keep what is of this size from here on.
        drop(vec![1_u8; 16 << 20]);
        let before = blocks_from_system();
        // So many that what other tests do meanwhile is no matter.
        let blocks: Vec<Vec<u8>> = (0..1000).map(|_| vec![0_u8; 200_000]).collect();
        assert!(blocks_from_system() >= before + 900, "{before}");
        drop(blocks);
        assert!(blocks_from_system() < before + 100, "{before}");
    }
}
