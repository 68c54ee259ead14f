//! `<joint>`.

use super::Context;
use super::bodies::unnamed;
use crate::diagnostics::Effect;
use crate::model::{Joint, JointKind, Model};
use crate::pose::{Pose, rotate};
use crate::xml::Element;

const KNOWN: [&str; 13] = [
    "type",
    "pos",
    "axis",
    "range",
    "limited",
    "ref",
    "springref",
    "damping",
    "frictionloss",
    "stiffness",
    "armature",
    "actuatorfrcrange",
    "actuatorfrclimited",
];

impl Context<'_, '_, '_> {
    /// A joint of a body, given in a frame.
    pub(super) fn joint(
        &mut self,
        given: &Element,
        frame: &Pose,
        class: Option<&str>,
        own: usize,
        model: &mut Model,
    ) {
        let element = self.defaults.applied(self.reader, given, class);
        self.ignored(&element, &KNOWN, Effect::Motion);
        let kind = match element.get("type").unwrap_or("hinge") {
            "hinge" => JointKind::Revolute,
            "slide" => JointKind::Prismatic,
            "ball" => JointKind::Ball,
            "free" => {
                self.free(given, own, model);
                if let Some(joint) = model.joints.last_mut().filter(|joint| joint.link == own) {
                    let mut made = joint.clone();
                    self.numbers(&element, &mut made);
                    made.limits = None;
                    made.reference = 0.0;
                    *joint = made;
                }
                return;
            }
            other => {
                let message = format!("a joint is of type {other}");
                self.reader
                    .problem(&element.place, message, "use hinge, slide, ball or free");
                return;
            }
        };
        let name = given
            .get("name")
            .map_or_else(|| unnamed(model), str::to_owned);
        if model.joint(&name).is_some() {
            let message = format!("two joints are called {name}");
            self.reader
                .problem(&element.place, message, "rename one of them");
        }
        let mut joint = Joint::new(name, own, kind);
        let anchor = self
            .reader
            .attribute::<3>(&element, "pos")
            .unwrap_or_default();
        joint.anchor_m = frame.apply(anchor);
        let axis = self
            .reader
            .attribute::<3>(&element, "axis")
            .unwrap_or([0.0, 0.0, 1.0]);
        let axis = self.reader.axis(&element.place, "joint@axis", axis);
        joint.axis = rotate(frame.rotation, axis);
        self.numbers(&element, &mut joint);
        model.joints.push(joint);
    }

    fn numbers(&mut self, element: &Element, joint: &mut Joint) {
        let is_slide = joint.kind == JointKind::Prismatic;
        let compiler = self.compiler.clone();
        let angle = |number: f64| {
            if is_slide {
                number
            } else {
                compiler.radians(number)
            }
        };
        joint.reference = angle(self.reader.number(element, "ref").unwrap_or(0.0));
        joint.spring_reference = angle(self.reader.number(element, "springref").unwrap_or(0.0));
        joint.damping = self.first(element, "damping");
        joint.stiffness = self.first(element, "stiffness");
        joint.friction = self.reader.number(element, "frictionloss").unwrap_or(0.0);
        joint.armature = self.reader.number(element, "armature").unwrap_or(0.0);
        if self.is_limited(element, "limited", "range") {
            let range = self.reader.attribute::<2>(element, "range");
            joint.limits = range.map(|range| range.map(angle));
            if let Some([low, high]) = joint.limits
                && low > high
            {
                let message = format!("joint {} has its range upside down", joint.name);
                self.reader
                    .problem(&element.place, message, "give the lower end first");
            }
        }
        if self.is_limited(element, "actuatorfrclimited", "actuatorfrcrange")
            && let Some([low, high]) = self.reader.attribute::<2>(element, "actuatorfrcrange")
        {
            joint.effort_limit = Some(low.abs().max(high.abs()));
        }
    }

    /// A coefficient; further ones (of higher powers) are a gap.
    fn first(&mut self, element: &Element, name: &str) -> f64 {
        let Some(attribute) = element.attribute(name) else {
            return 0.0;
        };
        let what = format!("joint@{name}");
        let numbers = self
            .reader
            .numbers(&attribute.place, &what, &attribute.value);
        let numbers = numbers.unwrap_or_default();
        if numbers.iter().skip(1).any(|number| *number != 0.0) {
            let ignored = "coefficients of higher powers are ignored";
            let consequence = "the force is linear";
            self.reader
                .gap(&attribute.place, what, ignored, Effect::Motion, consequence);
        }
        numbers.first().copied().unwrap_or(0.0)
    }

    /// Whether a range counts: as said, or (if automatic) because it is given and not empty.
    pub(super) fn is_limited(&mut self, element: &Element, flag: &str, range: &str) -> bool {
        match element.get(flag) {
            Some("true") => true,
            Some("false") => false,
            _ => {
                let given = self.reader.attribute::<2>(element, range);
                self.compiler.automatic_limits && given.is_some_and(|[low, high]| low != high)
            }
        }
    }
}
