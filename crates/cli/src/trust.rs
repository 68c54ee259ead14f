//! Which studies the user allows to run the programs that they name, as the environment says it.

use host::Trust;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Below the user's folder for what programs keep.
const RECORDS: &str = "corroborate/trust";

/// What was said for this call, the folders of `CORROBORATE_TRUST`, and where records are: below `XDG_STATE_HOME`, else below
/// `~/.local/state` (XDG Base Directory Specification 0.8).
pub fn of_environment(is_given: bool) -> Trust {
    Trust {
        is_given,
        readable: Vec::new(),
        folders: folders(std::env::var_os("CORROBORATE_TRUST")),
        records: records(std::env::var_os("XDG_STATE_HOME"), std::env::var_os("HOME")),
    }
}

/// Relative ones would mean another folder wherever one stands, a stranger's study among them.
fn folders(named: Option<OsString>) -> Vec<PathBuf> {
    let named = named.unwrap_or_default();
    std::env::split_paths(&named)
        .filter(|it| it.is_absolute())
        .collect()
}

fn records(state: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |it: Option<OsString>| it.map(PathBuf::from).filter(|it| it.is_absolute());
    let state = absolute(state);
    let state = state.or_else(|| absolute(home).map(|it| it.join(Path::new(".local/state"))));
    state.map(|it| it.join(RECORDS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_absolute_folders_count() {
        assert_eq!(
            folders(Some("/a:b:./c::/d".into())),
            [PathBuf::from("/a"), PathBuf::from("/d")]
        );
        assert!(folders(None).is_empty());
    }

    #[test]
    fn records_are_below_the_users_state() {
        let at = |state: &str, home: &str| records(Some(state.into()), Some(home.into()));
        assert_eq!(at("/s", "/h"), Some("/s/corroborate/trust".into()));
        let of_home = Some(PathBuf::from("/h/.local/state/corroborate/trust"));
        assert_eq!(at("", "/h"), of_home);
        assert_eq!(at("relative", "/h"), of_home);
        assert_eq!(at("", ""), None);
    }
}
