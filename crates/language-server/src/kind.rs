//! What kind of text a file is, by its name.

use std::path::Path;

/// How names of models end.
pub const MODELS: [&str; 8] = ["prism", "pm", "nm", "sm", "mdp", "dtmc", "ctmc", "pta"];
/// How names of property files end.
pub const PROPERTIES: [&str; 5] = ["props", "prop", "pctl", "csl", "ltl"];
/// The files of a study that are read whole when it is loaded.
pub const OF_STUDY: [&str; 6] = [
    "study.toml",
    "parameters.toml",
    "vocabulary.toml",
    "requirements.toml",
    "ledger.toml",
    "looks.toml",
];

/// A kind of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A model in the PRISM language.
    Model,
    /// Properties in the PRISM language.
    Properties,
    /// A file in TOML, perhaps of a study.
    Toml,
    /// Something else.
    Other,
}

impl Kind {
    /// The kind of a file; `language` is what the editor calls it.
    #[must_use]
    pub fn of(path: &Path, language: Option<&str>) -> Self {
        let ending = path.extension().and_then(|it| it.to_str()).unwrap_or("");
        let ending = ending.to_ascii_lowercase();
        if PROPERTIES.contains(&ending.as_str()) {
            Self::Properties
        } else if MODELS.contains(&ending.as_str()) {
            Self::Model
        } else if ending == "toml" {
            Self::Toml
        } else {
            match language {
                Some("prism") => Self::Model,
                Some("prism-properties") => Self::Properties,
                Some("toml") => Self::Toml,
                _ => Self::Other,
            }
        }
    }
}

/// The kind of a study's file in TOML, as `corroborate schema` calls it: by its name, or by that of its folder.
#[must_use]
pub fn schema_name(path: &Path) -> Option<&'static str> {
    let name = path.file_name()?.to_str()?;
    let folder = path.parent().and_then(Path::file_name);
    let folder = folder.and_then(|it| it.to_str()).unwrap_or("");
    if !name.ends_with(".toml") {
        return None;
    }
    match folder {
        "variants" => return Some("variant.toml"),
        "regressions" => return Some("finding.toml"),
        _ => {}
    }
    let known = [
        "study.toml",
        "parameters.toml",
        "vocabulary.toml",
        "requirements.toml",
        "ledger.toml",
        "looks.toml",
        "topics.toml",
        "ros2.toml",
    ];
    if let Some(known) = known.iter().find(|it| **it == name) {
        return Some(known);
    }
    let prefixes = [
        ("exploration", "exploration.toml"),
        ("calibration", "calibration.toml"),
        ("rare", "rare.toml"),
        ("scenario", "scenario.toml"),
        ("scene", "scene.toml"),
    ];
    let found = prefixes.iter().find(|(prefix, _)| name.starts_with(prefix));
    found.map(|(_, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_a_file_holds() {
        let kind = |name: &str| Kind::of(Path::new(name), None);
        assert_eq!(kind("a/b.prism"), Kind::Model);
        assert_eq!(kind("B.NM"), Kind::Model);
        assert_eq!(kind("b.pctl"), Kind::Properties);
        assert_eq!(kind("b.txt"), Kind::Other);
        assert_eq!(
            Kind::of(Path::new("Untitled-1"), Some("prism")),
            Kind::Model
        );
        assert_eq!(
            schema_name(Path::new("s/variants/slow.toml")),
            Some("variant.toml")
        );
        assert_eq!(
            schema_name(Path::new("s/scene-refined.toml")),
            Some("scene.toml")
        );
        assert_eq!(schema_name(Path::new("s/Cargo.toml")), None);
    }
}
