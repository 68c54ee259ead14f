//! What of a robot's or a thing's description a simulation does not have.
//!
//! A simulation of a robot that is described in URDF, SDF or MJCF is a simulation of what was understood of the
//! description. What was not (a closed chain, a mesh that is missing, a drive of a particular simulator) can move any
//! number that comes out, so it belongs to the evidence and not only to the log of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Something in a description that is not simulated as it is described.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub struct DescriptionGap {
    /// The file, by its path in the study.
    pub file: String,
    /// Line, from 1; absent where what is left out has no one place.
    pub line: Option<u32>,
    /// Column in characters, from 1.
    pub column: Option<u32>,
    /// The element or attribute, as a path of the innermost names; empty for what is probably wrong.
    pub element: String,
    /// What was left out or approximated.
    pub what: String,
    /// What it concerns: `motion`, `contact`, `sensing`, `control`, `looks`, `nothing`, or `doubt` where the
    /// description is probably wrong.
    pub effect: String,
    /// What follows from it, or what to do about it.
    pub consequence: String,
}

impl DescriptionGap {
    /// Whether it can move a number: not if it only concerns looks, or nothing that is physical.
    pub fn can_matter(&self) -> bool {
        !matches!(self.effect.as_str(), "looks" | "nothing")
    }

    /// How many gaps concern what, as `2 motion, 1 contact`, in the order of the words.
    pub fn in_short(gaps: &[Self]) -> String {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for gap in gaps {
            *counts.entry(gap.effect.as_str()).or_default() += 1;
        }
        let counts = counts
            .iter()
            .map(|(effect, count)| format!("{count} {effect}"));
        counts.collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for DescriptionGap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        if !self.element.is_empty() {
            write!(f, ": {}", self.element)?;
        }
        write!(f, ": {} ({}: {})", self.what, self.effect, self.consequence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_say_where_they_are_and_are_counted_by_what_they_concern() {
        let gap = |effect: &str, line| DescriptionGap {
            file: "arm.urdf".into(),
            line,
            column: line.map(|_| 5),
            element: "mesh".into(),
            what: "hand.stl cannot be read".into(),
            effect: effect.into(),
            consequence: "nothing touches it".into(),
        };
        let gaps = [
            gap("motion", Some(7)),
            gap("looks", None),
            gap("motion", None),
        ];
        assert_eq!(
            gaps[0].to_string(),
            "arm.urdf:7:5: mesh: hand.stl cannot be read (motion: nothing touches it)"
        );
        assert!(gaps[1].to_string().starts_with("arm.urdf: mesh: "));
        assert_eq!(DescriptionGap::in_short(&gaps), "1 looks, 2 motion");
        assert_eq!(gaps.iter().filter(|gap| gap.can_matter()).count(), 2);
    }
}
