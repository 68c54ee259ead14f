#![doc = include_str!("../README.md")]
//!
//! | file in the pack | holds |
//! |---|---|
//! | `manifest.json` | the statement: every part with its SHA-256, its role, and what the pack does not show |
//! | `manifest.dsse.json` | the same statement, signed; absent in a pack without a signature |
//! | `SHA256SUMS` | the hashes of all parts, for `sha256sum --check` |
//! | `VERIFY.md` | how to check all of this with other tools |

mod check;
mod envelope;
mod guide;
mod key;
mod manifest;
mod name;
mod part;
mod write;
mod zip;

pub use check::{Checked, Fault, Signature, begins_as_pack, check};
pub use key::{Key, PublicKey};
pub use manifest::{Digest, Manifest, NotShown, PartEntry, Predicate, Recording, Sace, Subject};
pub use name::encoded;
pub use part::{Content, Part, Role};
pub use write::{About, Written, write};
pub use zip::MOST_BYTES;

/// The manifest.
pub const MANIFEST: &str = "manifest.json";
/// The manifest in its signed envelope.
pub const ENVELOPE: &str = "manifest.dsse.json";
/// The hashes of all parts.
pub const SUMS: &str = "SHA256SUMS";
/// The page that says how the pack is checked.
pub const GUIDE: &str = "VERIFY.md";

/// The page with which packs of studies begin; nothing in them comes before it.
pub const FIRST: &str = "README.md";

/// A hash in hexadecimal.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
