//! Force limits by body region, for power and force limiting.
//!
//! Source: ISO/TS 15066:2016, annex A, table A.2: greatest permissible force of a quasi-static contact
//! (a clamped body part) for each of the twelve body regions. In a transient contact (a body part that
//! can recoil, shorter than about half a second) twice the force is permissible, except at skull and
//! face, where no transient contact is. The specification calls its values the result of present
//! knowledge, subject to change; compare them with the edition that applies before they decide
//! anything. Its limits of pressure are not reproduced here, since they depend on the place within a
//! region: they have to be given.
//!
//! The values were written down from memory and then held against two public sources that are
//! independent of each other: a calculator of permissible speeds (STIMBA Safety, "PFL calculator",
//! safety.stimba.sk/en/pfl, after ISO 10218-2:2025, annex A), and a transcription of table A.2 among
//! the constants of a public research project. Chest, abdomen, pelvis, upper arms, lower arms and
//! hands are the same in both. Back and shoulders stands in the first alone; skull, face, thighs and
//! lower legs in the second alone, which also says that skull and face have no transient contact; no
//! source was found for the neck. Other public pages print other numbers. The numbers of clauses were
//! not checked.

/// A region of the body with its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyRegion {
    /// The name, for example `hands and fingers`.
    pub name: &'static str,
    /// The greatest permissible force of a quasi-static contact in newton.
    pub quasi_static_force_n: f64,
    /// By which factor a transient contact may exceed that; `None` where no transient contact is
    /// permissible.
    pub transient_factor: Option<f64>,
}

impl BodyRegion {
    /// The greatest permissible force of a transient contact in newton; `None` where none is.
    #[must_use]
    pub fn transient_force_n(&self) -> Option<f64> {
        self.transient_factor
            .map(|factor| factor * self.quasi_static_force_n)
    }
}

const fn region(
    name: &'static str,
    quasi_static_force_n: f64,
    transient_factor: Option<f64>,
) -> BodyRegion {
    BodyRegion {
        name,
        quasi_static_force_n,
        transient_factor,
    }
}

/// The regions, from head to foot.
pub const BODY_REGIONS: [BodyRegion; 12] = [
    region("skull and forehead", 130.0, None),
    region("face", 65.0, None),
    region("neck", 150.0, Some(2.0)),
    region("back and shoulders", 210.0, Some(2.0)),
    region("chest", 140.0, Some(2.0)),
    region("abdomen", 110.0, Some(2.0)),
    region("pelvis", 180.0, Some(2.0)),
    region("upper arms and elbow joints", 150.0, Some(2.0)),
    region("lower arms and wrist joints", 160.0, Some(2.0)),
    region("hands and fingers", 140.0, Some(2.0)),
    region("thighs and knees", 220.0, Some(2.0)),
    region("lower legs", 130.0, Some(2.0)),
];
