//! Joints, their couplings and their drives.

use super::{Writer, escaped, list, put};
use crate::actuator::{Actuator, ActuatorKind};
use crate::model::{Joint, JointKind};
use std::fmt::Write;

impl Writer<'_> {
    pub(super) fn joint(&mut self, joint: &Joint) {
        let name = escaped(&joint.name);
        let kind = match joint.kind {
            JointKind::Fixed => return,
            JointKind::Free => {
                let numbers = [
                    ("damping", joint.damping),
                    ("frictionloss", joint.friction),
                    ("armature", joint.armature),
                ];
                put!(self.text, "<joint name=\"{name}\" type=\"free\"");
                self.numbers(&numbers);
                self.text.push_str("/>\n");
                return;
            }
            JointKind::Revolute => "hinge",
            JointKind::Prismatic => "slide",
            JointKind::Ball => "ball",
        };
        let (anchor, axis) = (list(&joint.anchor_m), list(&joint.axis));
        put!(
            self.text,
            "<joint name=\"{name}\" type=\"{kind}\" pos=\"{anchor}\""
        );
        if joint.kind != JointKind::Ball {
            put!(self.text, " axis=\"{axis}\"");
        }
        match joint.limits {
            Some([low, high]) if low < high => {
                put!(self.text, " range=\"{}\"", list(&[low, high]));
            }
            Some(_) => self.notes.push(format!(
                "joint {} has limits that leave it no room; MJCF knows no such limits, so it is unlimited",
                joint.name
            )),
            None => {}
        }
        let numbers = [
            ("ref", joint.reference),
            ("damping", joint.damping),
            ("frictionloss", joint.friction),
            ("stiffness", joint.stiffness),
            ("springref", joint.spring_reference),
            ("armature", joint.armature),
        ];
        self.numbers(&numbers);
        self.text.push_str("/>\n");
    }

    /// Attributes that are not zero.
    fn numbers(&mut self, numbers: &[(&str, f64)]) {
        for (attribute, number) in numbers.iter().filter(|(_, number)| *number != 0.0) {
            put!(self.text, " {attribute}=\"{number}\"");
        }
    }

    pub(super) fn couplings(&mut self) {
        let model = self.model;
        if model.couplings.is_empty() {
            return;
        }
        self.text.push_str("<equality>\n");
        for coupling in &model.couplings {
            let follower = escaped(&model.joints[coupling.joint].name);
            put!(self.text, "<joint joint1=\"{follower}\"");
            if let Some(leader) = coupling.leader {
                put!(
                    self.text,
                    " joint2=\"{}\"",
                    escaped(&model.joints[leader].name)
                );
            }
            put!(
                self.text,
                " polycoef=\"{}\"/>\n",
                list(&coupling.coefficients)
            );
        }
        self.text.push_str("</equality>\n");
    }

    pub(super) fn actuators(&mut self) {
        self.text.push_str("<actuator>\n");
        for actuator in &self.model.actuators {
            self.actuator(actuator);
        }
        self.text.push_str("</actuator>\n");
    }

    fn actuator(&mut self, actuator: &Actuator) {
        let Some((gain, bias)) = affine(actuator.kind) else {
            self.notes.push(format!(
                "actuator {} is left out, since the description does not give the gains of its servo",
                actuator.name
            ));
            return;
        };
        let joint = escaped(&self.model.joints[actuator.joint].name);
        let name = escaped(&actuator.name);
        put!(
            self.text,
            "<general name=\"{name}\" joint=\"{joint}\" gear=\"{}\" gainprm=\"{gain}\"",
            actuator.gear
        );
        if bias != [0.0; 3] {
            put!(
                self.text,
                " biastype=\"affine\" biasprm=\"{}\"",
                list(&bias)
            );
        }
        let ranges = [
            ("ctrlrange", actuator.command_range),
            ("forcerange", actuator.force_range),
        ];
        for (attribute, range) in ranges {
            if let Some([low, high]) = range
                && low < high
            {
                put!(self.text, " {attribute}=\"{}\"", list(&[low, high]));
            }
        }
        self.text.push_str("/>\n");
    }
}

/// Gain and bias of an actuator, if known.
fn affine(kind: ActuatorKind) -> Option<(f64, [f64; 3])> {
    Some(match kind {
        ActuatorKind::Effort => (1.0, [0.0; 3]),
        ActuatorKind::Position { kp, kv } => {
            let kp = kp?;
            (kp, [0.0, -kp, -kv.unwrap_or(0.0)])
        }
        ActuatorKind::Velocity { kv } => {
            let kv = kv?;
            (kv, [0.0, 0.0, -kv])
        }
        ActuatorKind::Affine { gain, bias } => (gain, bias),
    })
}
