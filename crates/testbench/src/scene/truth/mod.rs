//! What is true in a scene, for whoever asks: signals that are recorded because something reads them.
//!
//! A scene always records where its robots and people are. Everything else that a requirement may speak of (poses,
//! velocities, distances, contacts, grasps, regions, energies, joints) is declared by its use: who names
//! `/truth/arm/hand.speed` gets it, and what nobody names costs nothing. Names are those of [`names`], quantities those of
//! [`quantity`], with units and frames; the row of a topic is written at `record_hz`.
//!
//! Frames: `world`, or that of the body that is named, whose origin is the link's (an object's centre, if it is a plain one).
//! Speeds are magnitudes; velocities have components, which are signed.

pub(super) mod contact;
pub(super) mod grasp;
mod listing;
mod motion;
mod names;
mod quantity;
mod region;
mod things;
mod witness;

use std::collections::BTreeSet;

use trace::{Field, Trace};

pub use listing::{TruthPattern, TruthTopic, TruthVocabulary};
pub use names::UnknownTruth;
pub(super) use witness::Witness;

use self::names::{Lexicon, Quantity, Signal};
use self::quantity::OfJoint;
use self::things::Things;
use super::build::Built;
use super::data::SceneData;
use crate::bench::ScenarioError;
use crate::physics::{Layout, Physics};

/// The signals that are recorded besides those that always are.
#[derive(Debug, Clone)]
pub(super) struct Declared {
    things: Things,
    /// By topic, then by field.
    signals: Vec<Signal>,
}

/// A topic of its own, or fields behind those that a topic always has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub(super) topic: String,
    pub(super) fields: Vec<Field>,
    /// Places among the signals.
    pub(super) signals: std::ops::Range<usize>,
}

impl Declared {
    /// Looks names up. Those that `always` has are recorded anyway.
    ///
    /// # Errors
    /// The first name that there is not.
    pub(super) fn new(
        data: &SceneData,
        built: &Built,
        always: &Trace,
        names: &BTreeSet<String>,
    ) -> Result<Self, UnknownTruth> {
        let things = Things::new(data, built);
        let lexicon = Lexicon {
            data,
            layout: &built.layout,
            things: &things,
            always,
        };
        let asked = names.iter().filter(|name| always.signal(name).is_none());
        let mut signals = asked
            .map(|name| lexicon.parse(name))
            .collect::<Result<Vec<Signal>, _>>()?;
        signals.sort_by(|a, b| (&a.topic, &a.field.name).cmp(&(&b.topic, &b.field.name)));
        Ok(Self { things, signals })
    }

    /// Whether a name begins with a thing of the scene, be what follows known or not.
    pub(super) fn tells_of(&self, name: &str) -> bool {
        let rest = name.strip_prefix("/truth/");
        let thing = rest.and_then(|rest| rest.split(['.', '/']).next());
        thing.is_some_and(|thing| self.things.thing(thing).is_some())
    }

    /// The signals by topic.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        for (index, signal) in self.signals.iter().enumerate() {
            match blocks.last_mut().filter(|it| it.topic == signal.topic) {
                Some(block) => {
                    block.fields.push(signal.field.clone());
                    block.signals.end = index + 1;
                }
                None => blocks.push(Block {
                    topic: signal.topic.clone(),
                    fields: vec![signal.field.clone()],
                    signals: index..index + 1,
                }),
            }
        }
        blocks
    }

    /// Asks for what links bear, where torques of joints are read.
    pub(super) fn ask_wrenches(&self, layout: &mut Layout) {
        let joints = self
            .signals
            .iter()
            .filter_map(|signal| match signal.quantity {
                Quantity::Joint(joint, OfJoint::Torque) => Some(layout.joints[joint].body),
                _ => None,
            });
        let asked: BTreeSet<usize> = joints.chain(layout.wrenches.iter().copied()).collect();
        layout.wrenches = asked.into_iter().collect();
    }

    /// An engine that does not know what links bear cannot tell torques of joints.
    ///
    /// # Errors
    /// [`ScenarioError::Value`] naming such a signal.
    pub(super) fn check_engine(
        &self,
        layout: &Layout,
        physics: &dyn Physics,
    ) -> Result<(), ScenarioError> {
        let is_unknown = |signal: &&Signal| match signal.quantity {
            Quantity::Joint(joint, OfJoint::Torque) => {
                physics.wrench(layout.joints[joint].body).is_none()
            }
            _ => false,
        };
        let Some(signal) = self.signals.iter().find(is_unknown) else {
            return Ok(());
        };
        let (engine, _) = physics.engine();
        let problem = format!(
            "is of a link that is fixed to the world, whose forces {engine} does not compute; use MuJoCo, or read `drive_torque`"
        );
        let name = format!("{}.{}", signal.topic, signal.field.name);
        Err(ScenarioError::value(&name, &problem))
    }
}
