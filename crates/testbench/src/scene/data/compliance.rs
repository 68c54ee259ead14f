//! How a compliant person gives way, in a scene's file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::{key_of, within};
use crate::bench::ScenarioError;

/// How a compliant person's body gives way.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compliance {
    /// How hard arms and hands are held where they are wanted, in N/m.
    #[serde(default = "arm")]
    pub arm_n_m: Distribution,
    /// How hard head, trunk and legs are, in N/m.
    #[serde(default = "posture")]
    pub posture_n_m: Distribution,
    /// How damped all of them are; 1 is critical.
    #[serde(default = "damped")]
    pub damping_ratio: Distribution,
    /// The largest force with which a part of an arm is held.
    #[serde(default = "arm_strength")]
    pub arm_strength_newtons: Distribution,
    /// The largest force with which head, chest, abdomen or a leg is held.
    #[serde(default = "strength")]
    pub posture_strength_newtons: Distribution,
    /// The push, over all of the body, beyond which the person steps back.
    #[serde(default = "balance")]
    pub balance_newtons: Distribution,
    /// How much of an impact's energy the skin takes, in s/m: its force is larger by this share for each m/s of approach.
    #[serde(default = "super::zero")]
    pub dissipation_s_m: Distribution,
    /// Effective masses of regions of the body, over those of ISO/TS 15066: `head`, `chest`, `abdomen`, `upper_arm`,
    /// `forearm`, `hand`, `leg`.
    #[serde(default)]
    pub mass_kg: BTreeMap<String, Distribution>,
    /// Spring constants of their skin in N/mm, over those of ISO/TS 15066.
    #[serde(default)]
    pub skin_n_mm: BTreeMap<String, Distribution>,
}

impl Default for Compliance {
    fn default() -> Self {
        Self {
            arm_n_m: arm(),
            posture_n_m: posture(),
            damping_ratio: damped(),
            arm_strength_newtons: arm_strength(),
            posture_strength_newtons: strength(),
            balance_newtons: balance(),
            dissipation_s_m: super::zero(),
            mass_kg: BTreeMap::new(),
            skin_n_mm: BTreeMap::new(),
        }
    }
}

fn arm() -> Distribution {
    Distribution::Constant(300.0)
}
fn posture() -> Distribution {
    Distribution::Constant(1000.0)
}
fn damped() -> Distribution {
    Distribution::Constant(0.7)
}
fn arm_strength() -> Distribution {
    Distribution::Constant(80.0)
}
fn strength() -> Distribution {
    Distribution::Constant(300.0)
}
fn balance() -> Distribution {
    Distribution::Constant(60.0)
}

/// A region of the body by ISO/TS 15066:2016, annex A: the effective mass of what is moved with it, and the spring constant of
/// what lies over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene) struct Region {
    pub(in crate::scene) name: &'static str,
    pub(in crate::scene) mass_kg: f64,
    pub(in crate::scene) skin_n_mm: f64,
    pub(in crate::scene) is_arm: bool,
}

const fn region(name: &'static str, mass_kg: f64, skin_n_mm: f64, is_arm: bool) -> Region {
    Region {
        name,
        mass_kg,
        skin_n_mm,
        is_arm,
    }
}

/// The regions that a compliant person has. The head is taken as skull and forehead, which are its stiffest, legs as thighs.
pub(in crate::scene) const REGIONS: [Region; 7] = [
    region("head", 4.4, 150.0, false),
    region("chest", 40.0, 25.0, false),
    region("abdomen", 40.0, 10.0, false),
    region("upper_arm", 3.0, 30.0, true),
    region("forearm", 2.0, 40.0, true),
    region("hand", 0.6, 75.0, true),
    region("leg", 75.0, 50.0, false),
];

impl Compliance {
    /// The numbers that are drawn for an episode besides those by region, with their keys and ranges.
    fn numbers(&self) -> [(&'static str, &Distribution, f64, f64); 7] {
        [
            ("arm_n_m", &self.arm_n_m, 1.0, 1e5),
            ("posture_n_m", &self.posture_n_m, 1.0, 1e6),
            ("damping_ratio", &self.damping_ratio, 0.0, 10.0),
            ("arm_strength_newtons", &self.arm_strength_newtons, 0.0, 1e4),
            (
                "posture_strength_newtons",
                &self.posture_strength_newtons,
                0.0,
                1e4,
            ),
            ("balance_newtons", &self.balance_newtons, 1.0, 1e4),
            ("dissipation_s_m", &self.dissipation_s_m, 0.0, 10.0),
        ]
    }

    pub(super) fn check(&self, person: &str) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("person", person, &format!("compliance.{field}"));
        for (field, distribution, low, high) in self.numbers() {
            within(&key(field), distribution, low, high)?;
        }
        let of_regions = [
            ("mass_kg", &self.mass_kg, 0.1, 200.0),
            ("skin_n_mm", &self.skin_n_mm, 0.1, 1000.0),
        ];
        for (table, regions, low, high) in of_regions {
            for (name, distribution) in regions {
                let key = key(&format!("{table}.{name}"));
                if !REGIONS.iter().any(|region| region.name == name) {
                    let known = REGIONS.map(|region| region.name).join(", ");
                    let problem =
                        format!("names a region that the body does not have; it has {known}");
                    return Err(ScenarioError::value(&key, &problem));
                }
                within(&key, distribution, low, high)?;
            }
        }
        Ok(())
    }
}
