//! Grippers and tool changers at work.
//!
//! Definition: a parallel gripper's fingers ([`super::fingers`]) follow a width that goes to the commanded one at a limited speed,
//! with at most the commanded force. An under-actuated gripper's joints have the torques `radius times tension` and springs. A
//! suction cup looks along its axis for the nearest loose thing, a tool changer for the nearest tool; what they find is attached
//! ([`super::attachment`]), as is what `attach = "when-grasped"` holds between two fingers.
//!
//! A suction cup that pulls with more than its holding force `H` along its axis, or is sheared by more than friction times what
//! is left of `H`, comes off, and sucks again only after it was switched off.

use super::attachment::Attachment;
use super::build::Built;
use super::data::{Gripper, GripperKind, SceneData};
use super::fingers::{FOLLOWS_SECS, Finger, driven, fingers_of};
use super::truth::grasp::grasp;
use crate::geometry::{Pose, Vector, dot, norm, rotate, scale, subtract};
use crate::physics::{Layout, Motion, Physics, Touch};

/// Something that can be held.
#[derive(Debug, Clone, PartialEq)]
struct Holdable {
    name: String,
    /// None of what cannot be attached, since it does not move freely.
    body: Option<usize>,
    shapes: std::ops::Range<usize>,
}

/// A gripper in an episode.
#[derive(Debug, Clone)]
pub(super) struct Gripping {
    robot: usize,
    robot_name: String,
    kind: GripperKind,
    attaches: bool,
    joints: Vec<usize>,
    /// What tells the width, those that follow among them.
    fingers: Vec<Finger>,
    /// Those of them that have servos, in the order of the drives.
    driven: Vec<Finger>,
    /// The body and the frame of the cup or flange; of a gripper with fingers the palm.
    mount: (usize, Pose),
    holdable: Vec<Holdable>,
    width_m: f64,
    /// Whether it is closed, sucks or is locked, and whether it was torn off since it was switched on.
    is_on: bool,
    is_spent: bool,
    holding: Option<(usize, Attachment)>,
    /// Bodies to which forces were applied in the last step.
    pulled: Vec<usize>,
}

impl Gripping {
    pub(super) fn new(gripper: &Gripper, robot: usize, data: &SceneData, built: &Built) -> Self {
        let added = &built.robots[robot].added;
        let joints: Vec<usize> = gripper
            .joints()
            .iter()
            .filter_map(|name| added.joints.get(name).copied())
            .collect();
        let fingers = fingers_of(&gripper.kind, &joints, &built.layout);
        let point = gripper.tool_point();
        let point = data
            .tool_points
            .iter()
            .find(|it| Some(it.name.as_str()) == point);
        let mount = match point {
            Some(point) => {
                let body = built.robots[robot].body(point.link.as_deref());
                (body.unwrap_or(added.root), point.pose())
            }
            None => {
                let finger = joints.first().map(|joint| built.layout.joints[*joint].body);
                let palm = finger.and_then(|finger| built.layout.bodies[finger].parent);
                let here = Pose {
                    position_m: [0.0; 3],
                    orientation: crate::geometry::IDENTITY,
                };
                (palm.unwrap_or(added.root), here)
            }
        };
        Self {
            robot,
            robot_name: gripper.robot.clone(),
            attaches: gripper.attaches_when_grasped(),
            width_m: start_width_m(
                &gripper.kind,
                &fingers,
                &built.robots[robot].start,
                &built.layout,
            ),
            driven: driven(&fingers, &built.driven_elsewhere(gripper, robot, data)),
            fingers,
            kind: gripper.kind.clone(),
            joints,
            mount,
            holdable: holdable(gripper, data, built),
            is_on: false,
            is_spent: false,
            holding: None,
            pulled: Vec::new(),
        }
    }

    /// What a controller's fields are before anything is commanded.
    pub(super) fn start(&self) -> Vec<f64> {
        match &self.kind {
            GripperKind::Parallel {
                force_limit_newtons,
                ..
            } => vec![self.width_m, *force_limit_newtons],
            _ => vec![0.0],
        }
    }

    /// Brings the drives on their way for the coming step.
    pub(super) fn act(
        &mut self,
        physics: &mut dyn Physics,
        drives: std::ops::Range<usize>,
        wanted: &[f64],
        strength: f64,
        step_secs: f64,
    ) {
        match &self.kind {
            GripperKind::Parallel {
                width_m,
                force_limit_newtons,
                speed_m_s,
                ..
            } => {
                let most = speed_m_s * step_secs;
                let wanted_m = wanted[0].clamp(0.0, *width_m);
                // Fingers that something stopped open from where they are, and let go of what is attached.
                if wanted_m > self.width_m {
                    let stands_m = width_of(&self.fingers, *width_m, physics);
                    self.width_m = self.width_m.max(stands_m.min(wanted_m));
                    self.holding = None;
                }
                let way = (wanted_m - self.width_m).clamp(-most, most);
                self.is_on = wanted_m <= self.width_m;
                self.width_m += way;
                let share = (wanted[1] / force_limit_newtons).clamp(0.0, 1.0);
                let ahead_m = FOLLOWS_SECS * way / step_secs;
                for (finger, drive) in self.driven.iter().zip(drives) {
                    physics.set_drive_strength(drive, strength * share);
                    physics.set_drive(drive, finger.at(self.width_m + ahead_m, *width_m));
                }
            }
            GripperKind::UnderActuated {
                pulley_radii_m,
                tension_limit_newtons,
                ..
            } => {
                let tension = wanted[0].clamp(0.0, *tension_limit_newtons);
                self.is_on = tension > 0.0;
                for (place, drive) in drives.enumerate() {
                    physics.set_drive(drive, pulley_radii_m[place] * tension);
                }
                if !self.is_on {
                    self.holding = None;
                }
            }
            GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => {
                self.is_on = wanted[0] >= 0.5;
                if !self.is_on {
                    self.is_spent = false;
                    self.holding = None;
                }
            }
        }
    }

    /// Forces of the last step act no longer.
    pub(super) fn let_go(&mut self, physics: &mut dyn Physics) {
        for body in self.pulled.drain(..) {
            physics.apply(body, [0.0; 3], [0.0; 3]);
        }
    }

    /// Forces of the coming step.
    pub(super) fn pull(&mut self, physics: &mut dyn Physics) {
        if let Some((_, attachment)) = &mut self.holding {
            attachment.pull(physics);
            self.pulled.extend([attachment.holder, attachment.held]);
        }
    }

    /// After a step: attaches what there is to be attached, and lets go of what tore off. `taken` has the bodies that others
    /// hold.
    pub(super) fn feel(
        &mut self,
        data: &SceneData,
        built: &Built,
        physics: &dyn Physics,
        touches: &[Touch],
        taken: &[usize],
    ) {
        if let Some((_, attachment)) = &self.holding {
            if self.is_torn(physics, attachment.force_newtons) {
                self.is_spent = true;
                self.holding = None;
            }
            return;
        }
        if !self.is_on || self.is_spent {
            return;
        }
        let found = match &self.kind {
            GripperKind::Parallel { .. } | GripperKind::UnderActuated { .. } if self.attaches => {
                self.grasped(data, built, touches)
            }
            GripperKind::Parallel { .. } | GripperKind::UnderActuated { .. } => None,
            GripperKind::Suction { reach_m, .. } => self.sucked(built, physics, *reach_m),
            GripperKind::ToolChanger { reach_m, .. } => self.nearest(physics, *reach_m),
        };
        let held = found.and_then(|found| Some((found, self.holdable[found].body?)));
        if let Some((found, held)) = held.filter(|(_, held)| !taken.contains(held)) {
            let attachment = Attachment::new(&built.layout, physics, self.mount.0, held);
            self.holding = Some((found, attachment));
        }
    }

    /// The bodies that it holds attached.
    pub(super) fn taken(&self) -> Option<usize> {
        self.holding.as_ref().map(|(_, it)| it.held)
    }

    /// The robot and what is attached to it.
    pub(super) fn attached(&self) -> Option<(&str, &str)> {
        let (found, _) = self.holding.as_ref()?;
        Some((&self.robot_name, &self.holdable[*found].name))
    }

    fn frame(&self, physics: &dyn Physics) -> Pose {
        physics.body_pose(self.mount.0).then(&self.mount.1)
    }

    /// Whether a cup comes off with this force on what it holds.
    fn is_torn(&self, physics: &dyn Physics, force_newtons: Vector) -> bool {
        let GripperKind::Suction {
            holding_force_newtons,
            friction,
            ..
        } = &self.kind
        else {
            return false;
        };
        let axis = rotate(self.frame(physics).orientation, [0.0, 0.0, 1.0]);
        let pull = -dot(force_newtons, axis);
        let shear = norm(subtract(force_newtons, scale(-pull, axis)));
        pull > *holding_force_newtons || shear > friction * (holding_force_newtons - pull)
    }

    fn grasped(&self, data: &SceneData, built: &Built, touches: &[Touch]) -> Option<usize> {
        let own = &built.robots[self.robot].added.shapes;
        self.holdable.iter().position(|it| {
            let fingers = grasp(
                &built.layout,
                touches,
                &|shape| own.contains(&shape),
                &|shape| it.shapes.contains(&shape),
                data.truth.grasp_newtons,
            );
            fingers.is_some()
        })
    }

    fn sucked(&self, built: &Built, physics: &dyn Physics, reach_m: f64) -> Option<usize> {
        let frame = self.frame(physics);
        let axis = rotate(frame.orientation, [0.0, 0.0, 1.0]);
        let own = &built.robots[self.robot].added.shapes;
        let seen = |shape: usize| !own.contains(&shape);
        let hit = physics.ray(frame.position_m, axis, reach_m, &seen)?;
        self.holdable
            .iter()
            .position(|it| it.shapes.contains(&hit.shape))
    }

    fn nearest(&self, physics: &dyn Physics, reach_m: f64) -> Option<usize> {
        let at = self.frame(physics).position_m;
        let far = |it: &Holdable| {
            let place = it.body.map(|body| physics.body_pose(body).position_m);
            place.map_or(f64::INFINITY, |place| norm(subtract(place, at)))
        };
        let all = self.holdable.iter().map(far).enumerate();
        let within = all.filter(|(_, distance_m)| *distance_m <= reach_m);
        within
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(place, _)| place)
    }

    /// The row of its topic.
    pub(super) fn row(
        &self,
        data: &SceneData,
        built: &Built,
        physics: &dyn Physics,
        touches: &[Touch],
    ) -> Vec<f64> {
        let attached = self.holding.as_ref();
        let held = match attached {
            Some((found, _)) => Some(*found),
            None if self.joints.is_empty() => None,
            None => self.grasped(data, built, touches),
        };
        let mut row = vec![
            held.map_or(0.0, |found| (found + 1) as f64),
            f64::from(u8::from(attached.is_some())),
            attached.map_or(f64::NAN, |(_, it)| it.newtons()),
        ];
        if let GripperKind::Parallel { width_m, .. } = self.kind {
            row.push(width_of(&self.fingers, width_m, physics));
        }
        row
    }
}

/// The width at which fingers stand: the mean of what each says.
fn width_of(fingers: &[Finger], widest_m: f64, physics: &dyn Physics) -> f64 {
    let widths = fingers
        .iter()
        .map(|finger| finger.width_m(physics.joint(finger.joint).position, widest_m));
    widths.sum::<f64>() / fingers.len().max(1) as f64
}

/// The width at which the fingers begin.
fn start_width_m(
    kind: &GripperKind,
    fingers: &[Finger],
    start: &[(usize, f64)],
    layout: &Layout,
) -> f64 {
    let (GripperKind::Parallel { width_m, .. }, Some(first)) = (kind, fingers.first()) else {
        return 0.0;
    };
    let given = start.iter().rev().find(|(it, _)| *it == first.joint);
    let otherwise = layout.joints[first.joint].reference;
    let position = given.map_or(otherwise, |(_, position)| *position);
    first.width_m(position, *width_m).clamp(0.0, *width_m)
}

/// Names of what a gripper can hold, with `nothing` first.
pub(super) fn names_of(gripper: &Gripper, data: &SceneData) -> Vec<String> {
    let names = holdable_names(&gripper.kind, &gripper.robot, data);
    let names = names.into_iter().map(str::to_owned);
    std::iter::once("nothing".to_owned()).chain(names).collect()
}

/// What is loose of a scene: objects, or the tools of a changer.
fn holdable_names<'a>(kind: &GripperKind, own: &str, data: &'a SceneData) -> Vec<&'a str> {
    let is_loose = |file: bool, fixed: bool, heavy: bool| if file { !fixed } else { heavy };
    let objects = data.objects.iter();
    let objects = objects
        .filter(|it| is_loose(it.file.is_some(), it.fixed, it.mass_kg.is_some()))
        .map(|it| it.name.as_str());
    let GripperKind::ToolChanger { tools, .. } = kind else {
        return objects.collect();
    };
    let robots = data.robots.iter().filter(|it| !it.fixed && it.name != own);
    let all = objects.chain(robots.map(|it| it.name.as_str()));
    all.filter(|name| tools.iter().any(|tool| tool == name))
        .collect()
}

/// Where in the layout they are.
fn holdable(gripper: &Gripper, data: &SceneData, built: &Built) -> Vec<Holdable> {
    let of = |name: &str| {
        let object = data.objects.iter().position(|it| it.name == name);
        let robot = data.robots.iter().position(|it| it.name == name);
        match (object, robot) {
            (Some(object), _) => {
                let at = &built.objects[object];
                (at.body, at.shapes.clone())
            }
            (None, Some(robot)) => {
                let at = &built.robots[robot].added;
                (Some(at.root), at.shapes.clone())
            }
            (None, None) => (None, 0..0),
        }
    };
    let names = holdable_names(&gripper.kind, &gripper.robot, data).into_iter();
    names
        .map(|name| {
            let (body, shapes) = of(name);
            let is_free = |body: &usize| built.layout.bodies[*body].motion == Motion::Free;
            Holdable {
                name: name.to_owned(),
                body: body.filter(is_free),
                shapes,
            }
        })
        .collect()
}
