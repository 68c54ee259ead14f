//! `<actuator>`, `<equality>`, `<contact>` and `<sensor>`.

use super::Context;
use crate::actuator::{Actuator, ActuatorKind, Coupling};
use crate::diagnostics::Effect;
use crate::model::Model;
use crate::pose::Pose;
use crate::sensor::{Noise, Sensor, SensorKind};
use crate::xml::Element;

impl Context<'_, '_, '_> {
    pub(super) fn contact(&mut self, element: &Element, model: &mut Model) {
        for child in &element.children {
            if child.name != "exclude" {
                self.reader.passed_over("contact", child, Effect::Contact);
                continue;
            }
            let names = ["body1", "body2"].map(|end| self.reader.required(child, end).to_owned());
            match names.clone().map(|name| model.link(&name)) {
                [Some(first), Some(second)] => model.no_contact.push([first, second]),
                // The world has no link if it has no geoms.
                _ if names.contains(&"world".to_owned()) => {}
                _ => {
                    let what = format!("no bodies {} and {} exist", names[0], names[1]);
                    let consequence = "the pair is not excluded";
                    self.reader.gap(
                        &child.place,
                        "contact/exclude",
                        what,
                        Effect::Contact,
                        consequence,
                    );
                }
            }
        }
    }

    pub(super) fn equality(&mut self, element: &Element, model: &mut Model) {
        for given in &element.children {
            let child = self.defaults.applied(self.reader, given, None);
            let is_active = child.get("active") != Some("false");
            if child.name != "joint" || !is_active {
                self.reader.passed_over("equality", given, Effect::Motion);
                continue;
            }
            let known = ["joint1", "joint2", "polycoef", "active"];
            self.ignored(&child, &known, Effect::Motion);
            let follower = self.joint_called(&child, "joint1", model);
            let leader = child
                .get("joint2")
                .map(|_| self.joint_called(&child, "joint2", model));
            let polynomial = match child.attribute("polycoef") {
                Some(found) => self.reader.numbers(&found.place, "polycoef", &found.value),
                None => Some(vec![0.0, 1.0]),
            };
            if let (Some(joint), Some(numbers)) = (follower, polynomial)
                && leader != Some(None)
            {
                // Those that are not given keep their defaults: 0 1 0 0 0.
                let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
                for (coefficient, number) in coefficients.iter_mut().zip(numbers) {
                    *coefficient = number;
                }
                model.couplings.push(Coupling {
                    joint,
                    leader: leader.flatten(),
                    coefficients,
                });
            }
        }
    }

    /// The joint that an attribute names; a problem if there is none.
    fn joint_called(&mut self, element: &Element, attribute: &str, model: &Model) -> Option<usize> {
        let name = self.reader.required(element, attribute);
        let found = model.joint(name);
        if found.is_none() {
            let message = format!(
                "{}@{attribute} names {name}, which does not exist",
                element.name
            );
            self.reader
                .problem(&element.place, message, "correct the name");
        }
        found
    }

    pub(super) fn actuators(&mut self, element: &Element, model: &mut Model) {
        for given in &element.children {
            let child = self.defaults.applied(self.reader, given, None);
            if child.get("joint").is_none() {
                self.reader.passed_over("actuator", given, Effect::Control);
                continue;
            }
            let Some(joint) = self.joint_called(&child, "joint", model) else {
                continue;
            };
            let Some(kind) = self.drive(given, &child) else {
                continue;
            };
            let gear = child.attribute("gear");
            let gear = gear.and_then(|gear| self.reader.numbers(&gear.place, "gear", &gear.value));
            let name = given.get("name").map_or_else(
                || format!("actuator_{}", model.actuators.len()),
                str::to_owned,
            );
            let actuator = Actuator {
                name,
                joint,
                kind,
                gear: gear.and_then(|gear| gear.first().copied()).unwrap_or(1.0),
                command_range: self.command_range(&child, model, joint),
                force_range: self.range(&child, "forcelimited", "forcerange"),
            };
            model.actuators.push(actuator);
        }
    }

    fn range(&mut self, element: &Element, flag: &str, range: &str) -> Option<[f64; 2]> {
        let limited = self.is_limited(element, flag, range);
        limited.then(|| self.reader.attribute::<2>(element, range))?
    }

    /// The range of commands: given, or the joint's range about its middle times `inheritrange`.
    fn command_range(
        &mut self,
        element: &Element,
        model: &Model,
        joint: usize,
    ) -> Option<[f64; 2]> {
        if let Some(factor) = self.reader.number(element, "inheritrange")
            && factor > 0.0
            && let Some([low, high]) = model.joints[joint].limits
        {
            let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * factor);
            return Some([middle - half, middle + half]);
        }
        self.range(element, "ctrllimited", "ctrlrange")
    }

    /// What a drive's command means; `None` after a gap.
    fn drive(&mut self, given: &Element, element: &Element) -> Option<ActuatorKind> {
        const SHARED: [&str; 7] = [
            "joint",
            "gear",
            "ctrlrange",
            "ctrllimited",
            "forcerange",
            "forcelimited",
            "inheritrange",
        ];
        let own: &[&str] = match element.name.as_str() {
            "motor" => &[],
            "position" => &["kp", "kv"],
            "velocity" => &["kv"],
            "general" => &["gaintype", "gainprm", "biastype", "biasprm", "dyntype"],
            _ => {
                self.reader.passed_over("actuator", given, Effect::Control);
                return None;
            }
        };
        self.ignored(given, &[&SHARED[..], own].concat(), Effect::Control);
        let mut number = |name: &str| self.reader.number(element, name);
        match element.name.as_str() {
            "motor" => Some(ActuatorKind::Effort),
            "position" => Some(ActuatorKind::Position {
                kp: Some(number("kp").unwrap_or(1.0)),
                kv: Some(number("kv").unwrap_or(0.0)),
            }),
            "velocity" => Some(ActuatorKind::Velocity {
                kv: Some(number("kv").unwrap_or(1.0)),
            }),
            _ => self.general(given, element),
        }
    }

    fn general(&mut self, given: &Element, element: &Element) -> Option<ActuatorKind> {
        let plain = |name: &str, default: &str, known: &[&str]| {
            known.contains(&element.get(name).unwrap_or(default))
        };
        let is_affine = element.get("biastype") == Some("affine");
        let supported = plain("dyntype", "none", &["none"])
            && plain("gaintype", "fixed", &["fixed"])
            && plain("biastype", "none", &["none", "affine"]);
        if !supported {
            self.reader.passed_over("actuator", given, Effect::Control);
            return None;
        }
        let mut list = |name: &str| {
            let attribute = element.attribute(name)?;
            self.reader
                .numbers(&attribute.place, name, &attribute.value)
        };
        let gain = list("gainprm")
            .and_then(|gain| gain.first().copied())
            .unwrap_or(1.0);
        let given = list("biasprm").unwrap_or_default();
        let mut bias = [0.0; 3];
        for (coefficient, number) in bias.iter_mut().zip(given.iter().filter(|_| is_affine)) {
            *coefficient = *number;
        }
        Some(ActuatorKind::Affine { gain, bias })
    }

    pub(super) fn sensors(&mut self, element: &Element, model: &mut Model) {
        for child in &element.children {
            self.ignored(
                child,
                &["joint", "site", "body", "noise", "objtype", "objname"],
                Effect::Sensing,
            );
            let joint = child.get("joint").and_then(|name| model.joint(name));
            let site = child.get("site").or_else(|| child.get("objname"));
            let mark = model
                .marks
                .iter()
                .find(|mark| Some(mark.name.as_str()) == site);
            let body = child.get("body").and_then(|name| model.link(name));
            let kind = match (child.name.as_str(), joint) {
                ("jointpos", Some(joint)) => SensorKind::JointPosition { joint },
                ("jointvel", Some(joint)) => SensorKind::JointVelocity { joint },
                ("jointactuatorfrc", Some(joint)) => SensorKind::JointEffort { joint },
                (other, _) => {
                    let what = format!("sensors of type {other} are known by name only");
                    let consequence = "it measures nothing here";
                    self.reader
                        .gap(&child.place, "sensor", what, Effect::Sensing, consequence);
                    SensorKind::Other(other.to_owned())
                }
            };
            let link = joint.map(|joint| model.joints[joint].link);
            let pose_in_link = mark.map_or(Pose::IDENTITY, |mark| mark.pose_in_link);
            let link = link.or(mark.and_then(|mark| mark.link)).or(body);
            let noise = self
                .reader
                .number(child, "noise")
                .filter(|noise| *noise > 0.0);
            let noise = noise.map(|standard_deviation| Noise {
                standard_deviation,
                ..Noise::default()
            });
            model.sensors.push(Sensor {
                name: child
                    .get("name")
                    .map_or_else(|| format!("sensor_{}", model.sensors.len()), str::to_owned),
                kind,
                link,
                pose_in_link,
                rate_hz: None,
                noise: noise
                    .map(|noise| (String::new(), noise))
                    .into_iter()
                    .collect(),
            });
        }
    }
}
