//! Files as assets of evidence.

use diagnostic::Problem;
use evidence::{Asset, AssetRole};
use host::store::hash_of;
use std::path::Path;

/// A file of a study's folder, with the hash of what is in it.
///
/// # Errors
/// `cannot-read`.
pub fn asset(folder: &Path, role: AssetRole, path: &Path) -> Result<Asset, Problem> {
    let full = folder.join(path);
    let bytes = host::files::read_file(&full, u64::MAX - 1)?;
    Ok(Asset {
        role,
        path: path.to_string_lossy().replace('\\', "/"),
        hash: hash_of(&bytes),
    })
}
