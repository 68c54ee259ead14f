//! JSON Schemas of a study's files, made from the types that parse them.
//!
//! They say which keys a file has, of which types, and what they mean; what two keys say together is checked when the study is
//! loaded.

use schemars::Schema;

/// The files of a study that this crate reads, each with its schema.
pub fn all() -> Vec<(&'static str, Schema)> {
    vec![
        ("study.toml", schemars::schema_for!(crate::About)),
        ("parameters.toml", crate::parameters::schema()),
        ("vocabulary.toml", crate::vocabulary::schema()),
        ("requirements.toml", crate::requirements::schema()),
        ("ledger.toml", crate::ledger::schema()),
        ("finding.toml", crate::finding::schema()),
        (crate::looks::LOOKS, schemars::schema_for!(evidence::Looks)),
    ]
}
