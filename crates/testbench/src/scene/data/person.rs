//! People in a scene's file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::compliance::Compliance;
use super::{Capture, key_of, within, zero};
use crate::bench::ScenarioError;
use crate::scene::capture::Recording;

/// A person: a body that walks where its behaviour says; whatever pushes it, unless it is compliant.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// Name.
    pub name: String,
    /// One capsule, or limbs, which may give way.
    #[serde(default)]
    pub body: PersonBody,
    /// How a compliant body gives way.
    #[serde(default)]
    pub compliance: Option<Compliance>,
    /// Height, soles to crown.
    #[serde(default = "tall")]
    pub height_m: Distribution,
    /// Radius of the capsule or the trunk.
    #[serde(default = "stout")]
    pub radius_m: Distribution,
    /// What clothes and skin are made of: one of the scene's materials.
    pub material: Option<String>,
    /// Where the person stands at first.
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub x_m: Distribution,
    /// Where the person stands at first.
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub y_m: Distribution,
    /// Where the person faces at first, from the x axis to the left.
    #[serde(default = "zero")]
    pub heading_rad: Distribution,
    /// Walking speed.
    #[serde(default = "walking")]
    pub speed_m_s: Distribution,
    /// How fast the walking speed changes.
    #[serde(default = "brisk")]
    pub acceleration_m_s2: Distribution,
    /// How fast the person turns.
    #[serde(default = "nimble")]
    pub turn_rate_rad_s: Distribution,
    /// What the person does at first; a test can change it.
    #[serde(default)]
    pub activity: Activity,
    /// An object that the person takes when it is offered.
    #[serde(default)]
    pub takes: Option<Takes>,
    /// A recording of the person's motion, which the activity `walk` replays in place of walking; for bodies with limbs.
    #[serde(default)]
    pub capture: Option<Capture>,
    /// The same as it is replayed, once its file is read.
    #[serde(skip)]
    pub(in crate::scene) recording: Option<Arc<Recording>>,
    /// Where the activity `walk` leads, in order.
    #[serde(default, rename = "waypoint")]
    pub waypoints: Vec<Waypoint>,
    /// Whether the person starts again at the first waypoint after the last, or the recording from its beginning.
    #[serde(default)]
    pub again: bool,
    /// What the person does about a robot that is near.
    #[serde(default)]
    pub reaction: Option<Reaction>,
    /// How the person keeps clear of others on the way; walks straight on without it.
    #[serde(default)]
    pub avoidance: Option<Avoidance>,
    /// The group that the person walks with: who lags behind is waited for, and all keep together.
    pub group: Option<String>,
    /// How often and how long the person stands still on the way.
    #[serde(default)]
    pub hesitation: Option<Hesitation>,
    /// Probability that the person is distracted, and reacts to nothing, from the start.
    #[serde(default = "zero")]
    pub distracted_probability: Distribution,
    /// How the arms are held at first; a test can change it.
    #[serde(default)]
    pub arms: ArmPose,
    /// How fast shoulders and elbows turn from one way of holding the arms to another.
    #[serde(default = "nimble")]
    pub arm_rate_rad_s: Distribution,
    /// What the arms do when they reach.
    #[serde(default = "ArmAngles::reach")]
    pub reach: ArmAngles,
    /// What they do when they carry.
    #[serde(default = "ArmAngles::carry")]
    pub carry: ArmAngles,
    /// What they do when they withdraw.
    #[serde(default = "ArmAngles::withdraw")]
    pub withdraw: ArmAngles,
}

/// An object that a person takes when it is offered: the nearer hand reaches for it, holds it and draws it to the chest, pulling with no
/// more than its grip. `PERSON.took` is an event for tests, `/truth/PERSON.holding` tells it.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Takes {
    /// The object: one that is loose.
    pub object: String,
    /// It is offered while it is nearer than this to a shoulder; arms are 0.44 of the height long.
    #[serde(default = "near")]
    pub within_m: Distribution,
    /// How long it is offered before the hand sets out.
    #[serde(default = "quick")]
    pub delay_secs: Distribution,
    /// How fast the hand moves.
    #[serde(default = "a_step")]
    pub hand_speed_m_s: Distribution,
    /// The force with which the hand pulls at most.
    #[serde(default = "firm")]
    pub grip_newtons: Distribution,
}

/// Where the joints of both arms go, with 0 for an arm that hangs straight down.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmAngles {
    /// The upper arm, forwards.
    pub shoulder_rad: Distribution,
    /// The forearm against the upper arm, forwards.
    pub elbow_rad: Distribution,
}

impl ArmAngles {
    fn new(shoulder_rad: f64, elbow_rad: f64) -> Self {
        Self {
            shoulder_rad: Distribution::Constant(shoulder_rad),
            elbow_rad: Distribution::Constant(elbow_rad),
        }
    }

    fn reach() -> Self {
        Self::new(1.3, 0.2)
    }

    fn carry() -> Self {
        Self::new(0.2, 1.4)
    }

    fn withdraw() -> Self {
        Self::new(-0.6, 2.2)
    }
}

/// How a person's body is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PersonBody {
    /// One upright capsule.
    #[default]
    Capsule,
    /// Trunk, head, arms of two parts and legs, which swing as the person walks.
    Articulated,
    /// The same with hands, each part with the mass and the skin of its region of the body: they give way to what pushes them.
    Compliant,
}

impl PersonBody {
    /// Whether there are arms with hands.
    pub(in crate::scene) fn has_arms(self) -> bool {
        match self {
            Self::Capsule => false,
            Self::Articulated | Self::Compliant => true,
        }
    }
}

/// What a person does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activity {
    /// Stands.
    Stand,
    /// Walks along the waypoints.
    #[default]
    Walk,
    /// Walks up to the nearest robot, as far as touching it.
    Approach,
    /// Walks after the nearest robot, a step behind.
    Follow,
}

impl Activity {
    /// The names as tests and recordings have them.
    pub const NAMES: [(Self, &'static str); 4] = [
        (Self::Stand, "stand"),
        (Self::Walk, "walk"),
        (Self::Approach, "approach"),
        (Self::Follow, "follow"),
    ];
}

/// How arms are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ArmPose {
    /// They swing as the person walks.
    #[default]
    Swing,
    /// They are stretched forwards.
    Reach,
    /// They hold something before the chest.
    Carry,
    /// They are drawn back to the trunk, elbows behind it.
    Withdraw,
}

impl ArmPose {
    /// The names as tests have them.
    pub const NAMES: [(Self, &'static str); 4] = [
        (Self::Swing, "swing"),
        (Self::Reach, "reach"),
        (Self::Carry, "carry"),
        (Self::Withdraw, "withdraw"),
    ];
}

/// A point to walk to.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub struct Waypoint {
    /// Where it is in the world.
    pub x_m: Distribution,
    /// Where it is in the world.
    pub y_m: Distribution,
    /// How long the person stays there.
    #[serde(default = "zero")]
    pub pause_secs: Distribution,
}

/// How a person keeps clear of others on the way.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Avoidance {
    /// The distance from another person, surface to surface, at which staying clear is as strong as going on.
    #[serde(default = "clear_of_people")]
    pub people_m: Distribution,
    /// The same from a robot's root.
    #[serde(default = "clear_of_robots")]
    pub robots_m: Distribution,
}

/// How often and how long a person stands still on the way.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hesitation {
    /// The time from one to the next, drawn anew for each.
    pub every_secs: Distribution,
    /// How long each lasts, drawn anew.
    pub lasts_secs: Distribution,
}

/// What a person does about a robot that is near.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// What.
    pub kind: ReactionKind,
    /// When the robot's root is nearer than this to the person's middle.
    pub within_m: Distribution,
    /// How long the person takes to notice.
    #[serde(default = "quick")]
    pub delay_secs: Distribution,
    /// How the person holds the arms meanwhile; as before if left out.
    pub arms: Option<ArmPose>,
    /// How far aside the person steps.
    #[serde(default = "a_step")]
    pub aside_m: Distribution,
}

/// Kinds of reaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReactionKind {
    /// Goes on with the activity; only the arms may react.
    GoesOn,
    /// Stands until the robot is farther away.
    Stops,
    /// Walks at half the speed until it is.
    Yields,
    /// Walks beside the way, away from the robot's line.
    StepsAside,
    /// Walks up to it.
    Approaches,
}

fn tall() -> Distribution {
    Distribution::Constant(1.75)
}
fn stout() -> Distribution {
    Distribution::Constant(0.22)
}
fn walking() -> Distribution {
    Distribution::Constant(1.2)
}
fn brisk() -> Distribution {
    Distribution::Constant(2.0)
}
fn nimble() -> Distribution {
    Distribution::Constant(3.0)
}
fn near() -> Distribution {
    Distribution::Constant(0.7)
}
fn firm() -> Distribution {
    Distribution::Constant(20.0)
}
fn quick() -> Distribution {
    Distribution::Constant(0.4)
}
fn clear_of_people() -> Distribution {
    Distribution::Constant(0.3)
}
fn clear_of_robots() -> Distribution {
    Distribution::Constant(0.6)
}
fn a_step() -> Distribution {
    Distribution::Constant(0.6)
}

impl Person {
    /// The numbers that are drawn for an episode, with their keys and ranges.
    pub(in crate::scene) fn numbers(&self) -> [(&'static str, &Distribution, f64, f64); 16] {
        [
            ("height_m", &self.height_m, 0.5, 3.0),
            ("radius_m", &self.radius_m, 0.05, 1.0),
            ("x_m", &self.x_m, -1e4, 1e4),
            ("y_m", &self.y_m, -1e4, 1e4),
            ("heading_rad", &self.heading_rad, -10.0, 10.0),
            ("speed_m_s", &self.speed_m_s, 0.0, 12.0),
            ("acceleration_m_s2", &self.acceleration_m_s2, 1e-2, 100.0),
            ("turn_rate_rad_s", &self.turn_rate_rad_s, 1e-2, 100.0),
            (
                "distracted_probability",
                &self.distracted_probability,
                0.0,
                1.0,
            ),
            ("arm_rate_rad_s", &self.arm_rate_rad_s, 1e-2, 100.0),
            ("reach.shoulder_rad", &self.reach.shoulder_rad, -1.6, 3.2),
            ("reach.elbow_rad", &self.reach.elbow_rad, 0.0, 2.7),
            ("carry.shoulder_rad", &self.carry.shoulder_rad, -1.6, 3.2),
            ("carry.elbow_rad", &self.carry.elbow_rad, 0.0, 2.7),
            (
                "withdraw.shoulder_rad",
                &self.withdraw.shoulder_rad,
                -1.6,
                3.2,
            ),
            ("withdraw.elbow_rad", &self.withdraw.elbow_rad, 0.0, 2.7),
        ]
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("person", &self.name, field);
        for (field, distribution, low, high) in self.numbers() {
            within(&key(field), distribution, low, high)?;
        }
        match (&self.compliance, self.body) {
            (Some(compliance), PersonBody::Compliant) => compliance.check(&self.name)?,
            (Some(_), _) => {
                let problem = "gives way only with `body = \"compliant\"`";
                return Err(ScenarioError::value(&key("compliance"), problem));
            }
            (None, _) => {}
        }
        if let Some(takes) = &self.takes {
            within(&key("takes.within_m"), &takes.within_m, 0.0, 3.0)?;
            within(&key("takes.delay_secs"), &takes.delay_secs, 0.0, 60.0)?;
            within(
                &key("takes.hand_speed_m_s"),
                &takes.hand_speed_m_s,
                1e-2,
                10.0,
            )?;
            within(&key("takes.grip_newtons"), &takes.grip_newtons, 0.1, 1e3)?;
            if self.body != PersonBody::Articulated {
                let problem =
                    "needs hands that are led; the person's `body` is then \"articulated\"";
                return Err(ScenarioError::value(&key("takes"), problem));
            }
        }
        if let Some(capture) = &self.capture {
            let mut wrong = capture.check(&self.name);
            wrong.extend(self.beside_capture());
            ScenarioError::all(wrong)?;
        }
        if let Some(avoidance) = &self.avoidance {
            within(&key("avoidance.people_m"), &avoidance.people_m, 0.0, 10.0)?;
            within(&key("avoidance.robots_m"), &avoidance.robots_m, 0.0, 10.0)?;
        }
        if let Some(hesitation) = &self.hesitation {
            let (every, lasts) = (&hesitation.every_secs, &hesitation.lasts_secs);
            within(&key("hesitation.every_secs"), every, 1e-2, 1e6)?;
            within(&key("hesitation.lasts_secs"), lasts, 0.0, 1e4)?;
        }
        for (index, point) in self.waypoints.iter().enumerate() {
            let key = |field: &str| key(&format!("waypoint.{index}.{field}"));
            within(&key("x_m"), &point.x_m, -1e4, 1e4)?;
            within(&key("y_m"), &point.y_m, -1e4, 1e4)?;
            within(&key("pause_secs"), &point.pause_secs, 0.0, 1e4)?;
        }
        let Some(reaction) = &self.reaction else {
            return Ok(());
        };
        within(&key("reaction.within_m"), &reaction.within_m, 0.0, 1e3)?;
        within(&key("reaction.delay_secs"), &reaction.delay_secs, 0.0, 60.0)?;
        within(&key("reaction.aside_m"), &reaction.aside_m, 0.0, 10.0)
    }

    /// What has no meaning for a person who is replayed.
    fn beside_capture(&self) -> Vec<ScenarioError> {
        let mut wrong = Vec::new();
        let mut tell = |field: &str, problem: &str| {
            wrong.push(ScenarioError::value(
                &key_of("person", &self.name, field),
                problem,
            ));
        };
        if !self.body.has_arms() {
            let problem =
                "has no limbs to be moved; with `capture` it is \"articulated\" or \"compliant\"";
            tell("body", problem);
        }
        if !matches!(self.activity, Activity::Stand | Activity::Walk) {
            let problem = "is of people who find their way; with `capture` it is \"walk\" (replayed) or \"stand\"";
            tell("activity", problem);
        }
        for (field, is_given) in [
            ("waypoint", !self.waypoints.is_empty()),
            ("reaction", self.reaction.is_some()),
            ("avoidance", self.avoidance.is_some()),
            ("group", self.group.is_some()),
            ("hesitation", self.hesitation.is_some()),
            ("takes", self.takes.is_some()),
        ] {
            if is_given {
                tell(
                    field,
                    "is not used with `capture`: the recording is replayed as it is",
                );
            }
        }
        wrong
    }
}
