//! All truth that a scene can tell, as a table for who writes requirements.

use super::Declared;
use super::names::{GROUPS, Lexicon};
use super::quantity::{
    DISTANCES, Frame, OF_CONTACT, OF_JOINT, OF_REGION, PLAIN, Told, unit_of_slide,
};
use super::things::Part;
use crate::physics::JointKind;
use crate::scene::build::Built;
use crate::scene::data::SceneData;

/// What truth a scene can tell: any topic with any of its quantities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TruthVocabulary {
    /// Robots, objects and people, and their parts.
    pub topics: Vec<TruthTopic>,
    /// Quantities, with `OTHER`, `JOINT` and `REGION` for what they name.
    pub quantities: Vec<TruthPattern>,
    /// What can stand for `OTHER`: parts with dots, and groups.
    pub others: Vec<String>,
    /// What can stand for `REGION`.
    pub regions: Vec<String>,
}

/// Something that truth is told of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TruthTopic {
    /// `/truth/THING`, or `/truth/THING/PART`.
    pub topic: String,
    /// `robot`, `object` or `person`, and whether it is a part.
    pub kind: String,
    /// Joints, with the unit of their positions.
    pub joints: Vec<(String, String)>,
}

/// A quantity, or several that differ in what they name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TruthPattern {
    /// As it stands behind a topic and a dot.
    pub name: String,
    /// Its unit; `bool` and `name` for what is none.
    pub unit: String,
    /// `world`, `body` (of the topic), or none.
    pub frame: Option<String>,
    /// What it is.
    pub meaning: String,
}

impl Declared {
    /// Everything that there is.
    pub(in crate::scene) fn vocabulary(&self, data: &SceneData, built: &Built) -> TruthVocabulary {
        let lexicon = Lexicon {
            data,
            layout: &built.layout,
            things: &self.things,
            always: &trace::Trace::new(),
        };
        let parts = self.things.parts();
        let groups = GROUPS.map(str::to_owned);
        TruthVocabulary {
            topics: parts
                .clone()
                .map(|part| self.topic(&lexicon, part))
                .collect(),
            quantities: patterns(),
            others: parts.map(Part::dotted).chain(groups).collect(),
            regions: data.regions.iter().map(|it| it.name.clone()).collect(),
        }
    }

    fn topic(&self, lexicon: &Lexicon<'_>, part: &Part) -> TruthTopic {
        let things = self.things.list.iter();
        let mut things = things.filter(|thing| part.is_whole && thing.name == part.label);
        let joints = things
            .next()
            .map(|thing| &thing.joints)
            .into_iter()
            .flatten();
        let joints = joints.map(|(name, joint)| {
            let unit = match lexicon.layout.joints[*joint].kind {
                JointKind::Slide => unit_of_slide("rad"),
                JointKind::Hinge | JointKind::Ball => "rad",
            };
            (name.clone(), unit.to_owned())
        });
        let kind = part.kind.word();
        TruthTopic {
            topic: part.topic(),
            kind: match part.is_whole {
                true => kind.to_owned(),
                false => format!("part of a {kind}"),
            },
            joints: joints.collect(),
        }
    }
}

fn patterns() -> Vec<TruthPattern> {
    let plain = PLAIN.iter().map(|told| pattern(told, told.name.to_owned()));
    let joints = OF_JOINT.iter();
    let joints = joints.map(|told| pattern(told, format!("JOINT.{}", told.name)));
    let distances = DISTANCES.iter();
    let distances = distances.map(|told| pattern(told, format!("{}.OTHER", told.name)));
    let contacts = OF_CONTACT.iter();
    let contacts = contacts.map(|told| pattern(told, format!("contact.OTHER.{}", told.name)));
    let regions = OF_REGION.iter();
    let regions = regions.map(|told| pattern(told, format!("{}.REGION", told.name)));
    let all = plain.chain(joints).chain(distances).chain(contacts);
    all.chain(regions).collect()
}

fn pattern<Q>(told: &Told<Q>, name: String) -> TruthPattern {
    let is_name = ["grasped_by", "own_body", "other_body"].contains(&told.name);
    TruthPattern {
        name,
        unit: match (told.unit, is_name) {
            ("", true) => "name".to_owned(),
            ("", false) => "bool".to_owned(),
            (unit, _) => unit.to_owned(),
        },
        frame: match told.frame {
            Frame::None => None,
            Frame::World => Some("world".to_owned()),
            Frame::Body => Some("body".to_owned()),
        },
        meaning: told.meaning.to_owned(),
    }
}
