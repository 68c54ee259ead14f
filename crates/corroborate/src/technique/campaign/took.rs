//! How long the parts of a campaign took that were interrupted.
//!
//! A campaign that is finished has its time among its costs, and leaves nothing here. What cannot be read or written costs no
//! result: then the time of that part is not known, and not counted. Neither is that of a part whose process was killed.

use std::path::{Path, PathBuf};

/// Seconds, as a text. Its name is that of no recording.
fn file(folder: &Path) -> PathBuf {
    folder.join(".wall-secs")
}

/// Seconds of the parts before this one.
pub(super) fn kept(folder: &Path) -> f64 {
    let text = std::fs::read_to_string(file(folder)).unwrap_or_default();
    let secs: f64 = text.trim().parse().unwrap_or(0.0);
    if secs.is_finite() { secs.max(0.0) } else { 0.0 }
}

/// Keeps the seconds of all parts so far.
pub(super) fn keep(folder: &Path, secs: f64) {
    let _ = std::fs::write(file(folder), format!("{secs}\n"));
}

/// A finished campaign keeps none.
pub(super) fn forget(folder: &Path) {
    let _ = std::fs::remove_file(file(folder));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_until_the_campaign_is_finished() {
        let folder = std::env::temp_dir().join(format!("corroborate-took-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        assert_eq!(kept(&folder), 0.0);
        keep(&folder, 12.5);
        assert_eq!(kept(&folder), 12.5);
        keep(&folder, f64::NAN);
        assert_eq!(kept(&folder), 0.0);
        forget(&folder);
        assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0);
        std::fs::remove_dir(folder).expect("removed");
    }
}
