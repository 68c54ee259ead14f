//! Assets and tools: what a piece of evidence rests on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What an asset is for. The first two are the paper's assets (section 2.2).
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum AssetRole {
    /// A formal model, a scenario or a parameter set: how the system behaves.
    SystemModel,
    /// A property, a monitor or a vocabulary: what the system shall do.
    RequirementModel,
    /// A table or recording of what was observed.
    Data,
}

/// A file, or a named part of one, on which evidence rests.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Asset {
    /// What the asset is for.
    pub role: AssetRole,
    /// Path relative to the study's folder, with `/` between folders.
    pub path: String,
    /// BLAKE3 hash of the content, in hexadecimal.
    pub hash: String,
}

/// A program and its version, with the settings that can move a number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Tool {
    /// For example `corroborate checker` or `MuJoCo`.
    pub name: String,
    /// The version as the tool states it.
    pub version: String,
    /// Settings such as the method, its precision or the time step.
    pub settings: String,
}
