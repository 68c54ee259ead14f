//! Where programs of a study that are written in Python find modules: our client first, then what the user's own path names.

use std::ffi::{OsStr, OsString};
use std::path::Path;

/// As the environment says: `CORROBORATE_CLIENTS` names the folder of our clients, `PYTHONPATH` is the user's own. Without our
/// clients the user's stays as it is.
pub fn of_environment() -> Option<OsString> {
    let clients = std::env::var_os("CORROBORATE_CLIENTS")?;
    joined(
        &clients,
        &std::env::var_os("PYTHONPATH").unwrap_or_default(),
    )
}

fn joined(clients: &OsStr, theirs: &OsStr) -> Option<OsString> {
    let ours = Path::new(clients).join("python");
    let paths = std::iter::once(ours).chain(std::env::split_paths(theirs));
    std::env::join_paths(paths.filter(|path| !path.as_os_str().is_empty())).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_client_comes_before_what_the_user_has() {
        let path = |theirs: &str| joined("clients".as_ref(), theirs.as_ref());
        assert_eq!(path(""), Some("clients/python".into()));
        assert_eq!(path("a::b"), Some("clients/python:a:b".into()));
    }
}
