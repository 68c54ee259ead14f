//! What a physics engine can take of a tree's masses, decided once for who looks at a description and for who simulates it.
//!
//! Definition: let `I₁ <= I₂ <= I₃` be principal moments about the centre of mass. A rigid body has `0 < I₁` and
//! `I₃ <= I₁ + I₂`; MuJoCo 3.17 refuses a body for which the latter is false by a rounding, and one that moves, has a mass
//! or moments below 1e-15, and nothing rigidly fixed to it that has more.
//!
//! | given | simulated |
//! |---|---|
//! | no mass and no moments, the idiom of a frame | nothing |
//! | a mass and no moments, a point | as it is; it cannot be all that moves |
//! | `I₃` beyond `I₁ + I₂` by at most 1e-4 of itself (descriptions print four digits) | all moments raised by as much |
//! | a moment of 0, a rod without thickness, or one below 0 by a rounding | raised to 1e-6 of the largest |
//! | any other that no body has | the mean of the moments about every axis, as MuJoCo's `balanceinertia` |

use crate::diagnostics::Problem;
use crate::model::{Format, JointKind, Model};
use crate::pose::Pose;
use crate::reader::Loaded;
use crate::shape::Inertial;

/// Relative excess that rounding in descriptions explains.
pub(crate) const ROUNDING: f64 = 1e-4;

/// The share of the largest moment to which one that is missing is raised.
const THINNEST: f64 = 1e-6;

/// A share of the largest moment that is none: what rounding leaves of it.
const NO_AXIS: f64 = 1e-12;

/// By which share of the largest moment the sum of the others exceeds it after raising.
const MARGIN: f64 = 1e-9;

/// What MuJoCo wants of a body that moves, kg and kg m².
const LEAST: f64 = 1e-15;

/// What was wrong with an inertia that is simulated otherwise than it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unphysical {
    /// The largest moment exceeds the sum of the others, by no more than rounding.
    Rounded,
    /// A moment is 0 where the others are not.
    Thin,
    /// No rigid body is like it.
    Impossible,
}

impl Inertial {
    /// What is simulated of it, and why that is not what is given; `None` of what weighs nothing.
    #[must_use]
    pub fn simulated(&self) -> (Option<Self>, Option<Unphysical>) {
        let [low, middle, high] = self.principal_moments_kg_m2();
        if low == 0.0 && high == 0.0 {
            return ((self.mass_kg > 0.0).then_some(*self), None);
        }
        let excess = high - low - middle;
        if low < -ROUNDING * high.abs() || excess > ROUNDING * high {
            let mean = ((low + middle + high) / 3.0).max(0.0);
            let even = self.with_moments([mean; 3]);
            return (Some(even), Some(Unphysical::Impossible));
        }
        if low < NO_AXIS * high {
            let by_kg_m2 = (THINNEST * high - low).max(excess + MARGIN * high);
            return (Some(self.raised(by_kg_m2)), Some(Unphysical::Thin));
        }
        // What engines make of products has roundings of its own; moments as given have none.
        let has_products = self.tensor_kg_m2[3..] != [0.0; 3];
        let slack = if has_products { NO_AXIS * high } else { 0.0 };
        if excess > -slack {
            let raised = self.raised(excess.max(0.0) + MARGIN * high);
            return (
                Some(raised),
                (excess > slack).then_some(Unphysical::Rounded),
            );
        }
        (Some(*self), None)
    }

    /// The same with more about every axis.
    fn raised(&self, by_kg_m2: f64) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.tensor_kg_m2;
        let tensor_kg_m2 = [xx + by_kg_m2, yy + by_kg_m2, zz + by_kg_m2, xy, xz, yz];
        Self {
            tensor_kg_m2,
            ..*self
        }
    }

    /// The same with these moments about the principal axes of [`Inertial::principal_axes`].
    #[must_use]
    pub(crate) fn with_moments(&self, [x, y, z]: [f64; 3]) -> Self {
        let (_, rotation) = self.principal_axes();
        let own = Self {
            mass_kg: self.mass_kg,
            centre_m: [0.0; 3],
            tensor_kg_m2: [x, y, z, 0.0, 0.0, 0.0],
        };
        own.placed(&Pose {
            position_m: self.centre_m,
            rotation,
        })
    }
}

impl Model {
    /// Whether a link can move against its parent. A root of URDF has no joint and is free, unless `fixed` to the world;
    /// elsewhere the description says it.
    #[must_use]
    pub fn moves(&self, link: usize, fixed: bool) -> bool {
        let found = &self.links[link];
        let is_root = found.parent.is_none();
        if is_root && found.kinematic {
            return false;
        }
        let mut kinds = self.joints_of(link).map(|joint| joint.kind);
        let is_free = is_root && !fixed;
        kinds.any(|kind| match kind {
            JointKind::Fixed => false,
            JointKind::Free => is_free,
            JointKind::Revolute | JointKind::Prismatic | JointKind::Ball => true,
        }) || (is_free && self.format == Format::Urdf)
    }

    /// Links that move and cannot be simulated: neither they nor what is rigidly fixed to them has a mass and moments.
    #[must_use]
    pub fn unmovable(&self, fixed: bool) -> Vec<usize> {
        let moves: Vec<bool> = (0..self.links.len())
            .map(|link| self.moves(link, fixed))
            .collect();
        let mut bears: Vec<bool> = self
            .links
            .iter()
            .map(|link| link.inertial.is_some_and(|it| is_massive(&it)))
            .collect();
        // Parents come before their children.
        for link in (0..self.links.len()).rev() {
            if let Some(parent) = self.links[link].parent
                && bears[link]
                && !moves[link]
            {
                bears[parent] = true;
            }
        }
        (0..self.links.len())
            .filter(|link| moves[*link] && !bears[*link])
            .collect()
    }
}

fn is_massive(inertial: &Inertial) -> bool {
    inertial
        .simulated()
        .0
        .is_some_and(|it| it.mass_kg >= LEAST && it.principal_moments_kg_m2()[0] >= LEAST)
}

impl Loaded {
    /// Why a simulation refuses the description, its root `fixed` to the world or not; empty if it runs.
    #[must_use]
    pub fn refusals(&self, fixed: bool) -> Vec<Problem> {
        let problem = |link: usize| {
            let found = &self.model.links[link];
            let what = match found.inertial {
                None => "no mass",
                Some(inertial) if inertial.mass_kg < LEAST => "no mass",
                Some(_) => "a mass but no moments of inertia",
            };
            let is_base = found.parent.is_none() && !self.model.moves(link, true);
            let fixing = if is_base {
                ", or fix the robot's base to the world"
            } else {
                ""
            };
            Some(Problem {
                place: self.places.get(link)?.clone(),
                message: format!(
                    "link {} moves and has {what}, nor has what is fixed to it",
                    found.name
                ),
                remedy: format!("give it a mass above 0 and moments of inertia above 0{fixing}"),
            })
        };
        self.model
            .unmovable(fixed)
            .into_iter()
            .filter_map(problem)
            .collect()
    }
}
