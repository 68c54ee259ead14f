//! From a signal's name to what it is, and from a misspelt one to the nearest names.
//!
//! `/truth/THING.QUANTITY` or `/truth/THING/PART.QUANTITY`, where a quantity may name another thing or part with dots
//! (`distance_to.anna.left_forearm`), a joint (`elbow.drive_torque`) or a region (`in.tray`).

use trace::{Field, Trace, nearest_few};

use super::quantity::{
    DISTANCES, OF_CONTACT, OF_JOINT, OF_REGION, OfContact, OfJoint, OfRegion, PLAIN, PRESSURE,
    Plain, Told, field_of, refusal, unit_of_slide,
};
use super::things::{Kind, Part, Place, Thing, Things};
use crate::physics::{JointKind, Layout};
use crate::scene::data::SceneData;

/// How many similar names are told.
const SIMILAR: usize = 4;

/// What a signal is of another thing, of several, or of itself alone.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Quantity {
    Plain(Plain),
    Joint(usize, OfJoint),
    /// To the nearest of these shapes.
    Distance(Vec<usize>),
    /// To the nearest of these frames.
    OriginDistance(Vec<Place>),
    /// With these shapes.
    Contact(Vec<usize>, OfContact),
    Region(usize, OfRegion),
}

/// A signal that is to be recorded.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Signal {
    pub(super) topic: String,
    pub(super) field: Field,
    pub(super) part: Part,
    pub(super) quantity: Quantity,
}

/// A name of truth that a scene does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownTruth {
    /// The name.
    pub name: String,
    /// What is wrong with it.
    pub reason: String,
    /// The nearest names that there are, nearest first.
    pub similar: Vec<String>,
}

impl std::fmt::Display for UnknownTruth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` {}", self.name, self.reason)?;
        match self.similar.as_slice() {
            [] => write!(f, "; `corroborate inspect STUDY` lists what there is"),
            similar => write!(f, "; did you mean {}?", similar.join(", ")),
        }
    }
}

impl std::error::Error for UnknownTruth {}

/// What names are looked up in.
pub(super) struct Lexicon<'a> {
    pub(super) data: &'a SceneData,
    pub(super) layout: &'a Layout,
    pub(super) things: &'a Things,
    /// What is recorded in any case.
    pub(super) always: &'a Trace,
}

/// Groups of things that can stand for another one.
pub(super) const GROUPS: [&str; 5] = ["people", "robots", "objects", "ground", "anything"];

impl Lexicon<'_> {
    /// The thing, the part and the quantity that a name consists of, if it begins as one of truth does.
    pub(super) fn parse(&self, name: &str) -> Result<Signal, UnknownTruth> {
        let unknown = |reason: &str, similar: Vec<String>| UnknownTruth {
            name: name.to_owned(),
            reason: reason.to_owned(),
            similar,
        };
        let Some(part) = self.part_of(name) else {
            let reason = "does not begin with a thing of the scene";
            return Err(unknown(reason, self.similar_topics(name)));
        };
        let field = &name[part.topic().len() + 1..];
        match self.quantity(part, field) {
            Ok((field, quantity)) => Ok(Signal {
                topic: part.topic(),
                field,
                part: part.clone(),
                quantity,
            }),
            Err(Some(reason)) => Err(unknown(&reason, Vec::new())),
            Err(None) => {
                let mut fields = self.fields_of(part);
                let always = self.always.channel(&part.topic()).into_iter();
                let always = always.flat_map(|channel| &channel.fields);
                fields.extend(always.map(|field| field.name.clone()));
                let near = nearest_few(field, fields.iter().map(String::as_str), SIMILAR);
                let similar = near.iter().map(|it| format!("{}.{it}", part.topic()));
                let reason = format!("is not a quantity of {}", part.label);
                Err(unknown(&reason, similar.collect()))
            }
        }
    }

    /// The part whose topic a name begins with: the longest that fits.
    pub(super) fn part_of(&self, name: &str) -> Option<&Part> {
        let fits = |part: &&Part| {
            let rest = name.strip_prefix(&part.topic());
            rest.is_some_and(|rest| rest.starts_with('.') && rest.len() > 1)
        };
        let parts = self.things.parts().filter(fits);
        parts.max_by_key(|part| part.label.len())
    }

    /// The same quantity of the topics that are nearest.
    fn similar_topics(&self, name: &str) -> Vec<String> {
        let (topic, field) = name.split_once('.').unwrap_or((name, "x"));
        let topics: Vec<String> = self.things.parts().map(Part::topic).collect();
        let near = nearest_few(topic, topics.iter().map(String::as_str), SIMILAR);
        near.iter()
            .map(|topic| format!("{topic}.{field}"))
            .collect()
    }

    /// `Err(Some(reason))` for what there is not, with what to do; `Err(None)` for what is not known.
    fn quantity(&self, part: &Part, field: &str) -> Result<(Field, Quantity), Option<String>> {
        if let Some(told) = PLAIN.iter().find(|told| told.name == field) {
            if let Some(reason) = refusal(told.quantity, part) {
                return Err(Some(reason.to_owned()));
            }
            let field = match told.quantity {
                Plain::GraspedBy => Field::enumeration(field, self.holders()),
                _ => field_of(told, field, told.unit, part),
            };
            return Ok((field, Quantity::Plain(told.quantity)));
        }
        if let Some(rest) = field.strip_prefix("contact.") {
            return self.contact(part, field, rest);
        }
        if let Some((name, rest)) = field.split_once('.') {
            if let Some(told) = DISTANCES.iter().find(|told| told.name == name) {
                return self.distance(part, told, field, rest);
            }
            if let Some(told) = OF_REGION.iter().find(|told| told.name == name) {
                return self.region(part, told, field, rest);
            }
        }
        self.joint(part, field)
    }

    fn contact(
        &self,
        part: &Part,
        field: &str,
        rest: &str,
    ) -> Result<(Field, Quantity), Option<String>> {
        let (other, name) = rest.rsplit_once('.').ok_or(None)?;
        if name == "pressure" {
            return Err(Some(PRESSURE.to_owned()));
        }
        let told = OF_CONTACT
            .iter()
            .find(|told| told.name == name)
            .ok_or(None)?;
        let (shapes, never_yields) = self.others(part, other).ok_or(None)?;
        if part.shapes.is_empty() || shapes.is_empty() {
            return Err(Some(
                "is not available: one of them has no surface".to_owned(),
            ));
        }
        if part.never_yields && never_yields {
            let reason = "is not available: neither of them gives way, so no engine computes a contact; use `distance_to`";
            return Err(Some(reason.to_owned()));
        }
        let owned = match told.quantity {
            OfContact::OwnBody | OfContact::OtherBody => {
                Field::enumeration(field, self.things.owners.clone())
            }
            _ => field_of(told, field, told.unit, part),
        };
        Ok((owned, Quantity::Contact(shapes, told.quantity)))
    }

    fn distance(
        &self,
        part: &Part,
        told: &Told<bool>,
        field: &str,
        other: &str,
    ) -> Result<(Field, Quantity), Option<String>> {
        let recorded = field_of(told, field, told.unit, part);
        if !told.quantity {
            let origins = self.origins(part, other).ok_or(None)?;
            return Ok((recorded, Quantity::OriginDistance(origins)));
        }
        let (shapes, _) = self.others(part, other).ok_or(None)?;
        if part.shapes.is_empty() || shapes.is_empty() {
            let reason = "is not available: one of them has no surface; use `origin_distance_to`";
            return Err(Some(reason.to_owned()));
        }
        Ok((recorded, Quantity::Distance(shapes)))
    }

    fn region(
        &self,
        part: &Part,
        told: &Told<OfRegion>,
        field: &str,
        region: &str,
    ) -> Result<(Field, Quantity), Option<String>> {
        let regions = &self.data.regions;
        let place = regions.iter().position(|known| known.name == region);
        let place = place.ok_or(None)?;
        if told.quantity == OfRegion::WhollyIn && part.shapes.is_empty() {
            return Err(Some(
                "is not available: it has no surface; use `in`".to_owned(),
            ));
        }
        let recorded = field_of(told, field, told.unit, part);
        Ok((recorded, Quantity::Region(place, told.quantity)))
    }

    fn joint(&self, part: &Part, field: &str) -> Result<(Field, Quantity), Option<String>> {
        let (name, quantity) = field.rsplit_once('.').ok_or(None)?;
        let told = OF_JOINT.iter().find(|told| told.name == quantity);
        let (told, thing) = told.zip(self.thing_of(part)).ok_or(None)?;
        let joint = *thing.joints.get(name).ok_or(None)?;
        let plan = &self.layout.joints[joint];
        if told.quantity == OfJoint::LimitDistance && plan.range.is_none() {
            return Err(Some("is not available: the joint has no limits".to_owned()));
        }
        let of_body = self.layout.joints.iter().filter(|it| it.body == plan.body);
        if told.quantity == OfJoint::Torque && of_body.count() > 1 {
            let reason =
                "is not available: the joint is one of several of its link, which bear together";
            return Err(Some(reason.to_owned()));
        }
        let unit = match plan.kind {
            JointKind::Slide => unit_of_slide(told.unit),
            JointKind::Hinge | JointKind::Ball => told.unit,
        };
        let recorded = field_of(told, field, unit, part);
        Ok((recorded, Quantity::Joint(joint, told.quantity)))
    }

    /// The thing that a whole is.
    fn thing_of(&self, part: &Part) -> Option<&Thing> {
        let things = self.things.list.iter();
        things
            .clone()
            .find(|thing| part.is_whole && thing.name == part.label)
    }

    /// Who can grasp.
    fn holders(&self) -> Vec<String> {
        let things = self.things.list.iter();
        let holders = things.filter(|thing| thing.kind != Kind::Object);
        let holders = holders.map(|thing| thing.name.clone());
        std::iter::once("nobody".to_owned())
            .chain(holders)
            .collect()
    }

    /// Shapes of another part, or of all of a group but the thing's own, and whether none of them gives way.
    fn others(&self, part: &Part, other: &str) -> Option<(Vec<usize>, bool)> {
        if let Some(other) = self.things.parts().find(|it| it.dotted() == other) {
            let is_own = |shape: &&usize| part.shapes.contains(shape);
            let shapes = other.shapes.iter().filter(|shape| !is_own(shape));
            return Some((shapes.copied().collect(), other.never_yields));
        }
        let is_own = |thing: &Thing| part.label.split('/').next() == Some(thing.name.as_str());
        let wholes = self.things.list.iter().filter(|thing| !is_own(thing));
        let of_kind = |kind: Option<Kind>| {
            let found = wholes.clone();
            let found = found.filter(move |thing| kind.is_none_or(|kind| thing.kind == kind));
            found.map(Thing::whole)
        };
        let kind = match other {
            "people" => Some(Kind::Person),
            "robots" => Some(Kind::Robot),
            "objects" => Some(Kind::Object),
            "ground" => return Some((self.things.ground.clone(), true)),
            "anything" => None,
            _ => return None,
        };
        let mut shapes: Vec<usize> = of_kind(kind).flat_map(|it| it.shapes.clone()).collect();
        if kind.is_none() {
            shapes.extend(&self.things.ground);
        }
        Some((shapes, of_kind(kind).all(|it| it.never_yields)))
    }

    fn origins(&self, part: &Part, other: &str) -> Option<Vec<Place>> {
        if let Some(other) = self.things.parts().find(|it| it.dotted() == other) {
            return Some(vec![other.place]);
        }
        let kind = match other {
            "people" => Kind::Person,
            "robots" => Kind::Robot,
            "objects" => Kind::Object,
            _ => return None,
        };
        let wholes = self.things.list.iter().filter(|thing| thing.kind == kind);
        let wholes = wholes.filter(|thing| part.label.split('/').next() != Some(&thing.name));
        let origins: Vec<Place> = wholes.map(|thing| thing.whole().place).collect();
        (!origins.is_empty()).then_some(origins)
    }

    /// All quantities that a part has.
    pub(super) fn fields_of(&self, part: &Part) -> Vec<String> {
        let plain = PLAIN.iter().map(|told| told.name.to_owned());
        let regions = self.data.regions.iter().flat_map(|region| {
            let of_region = OF_REGION.iter();
            of_region.map(|told| format!("{}.{}", told.name, region.name))
        });
        let joints = self.thing_of(part).into_iter();
        let joints = joints
            .flat_map(|thing| thing.joints.keys())
            .flat_map(|joint| {
                let of_joint = OF_JOINT.iter();
                of_joint.map(move |told| format!("{joint}.{}", told.name))
            });
        let others = self.things.parts().map(Part::dotted);
        let others = others.chain(GROUPS.map(str::to_owned)).flat_map(|other| {
            let distances = DISTANCES
                .iter()
                .map(|told| format!("{}.{other}", told.name));
            let contacts = OF_CONTACT.iter();
            let contacts = contacts.map(|told| format!("contact.{other}.{}", told.name));
            distances.chain(contacts).collect::<Vec<_>>()
        });
        let all = plain.chain(regions).chain(joints).chain(others);
        all.filter(|field| self.quantity(part, field).is_ok())
            .collect()
    }
}
