//! Groups of joints at work: from commands, goals and trajectories to the targets of drives.
//!
//! Definition: a group has a reference `r(t)` for its joints. Without a profile it is what is commanded. With one, a command is
//! a goal: the joints go on a straight way in joint space, or the tool point on a straight line, by one profile
//! ([`super::profile`]) for all joints, so that they begin and end together and every joint keeps to its limits. A goal that
//! comes on the way is taken up as soon as the group has braked on it.
//!
//! The drive of a joint has the torque `k (r - q) + d (r' - q')`, in the mode `impedance` more by what the robot's own links
//! weigh at the joint: `g(q)`, the sum of `m g` times the joint's effect on the height of each centre of mass. Both engines
//! have servos of the form `k (u - q) - d q'`, which they integrate implicitly; they are given `u = r + (d r' + g) / k`.
//!
//! What is not reachable is not gone to: the group stays, and tells how far the best pose is from the goal.

mod tool;

use robot_model::Model;

use super::build::BuiltRobot;
use super::data::{Group, GroupMode, GroupWaypoint, JointGroup, Trajectory};
use super::profile::{Limits, Profile};
use crate::geometry::{Pose, Vector, add, cross, norm, rotate, scale, subtract};
use crate::physics::{JointKind, Layout, Physics};
use tool::{Tool, roll_pitch_yaw, there};

/// A joint of a group.
#[derive(Debug, Clone)]
struct Jointed {
    /// Its place in the layout.
    joint: usize,
    body: usize,
    anchor_m: Vector,
    axis: Vector,
    is_slide: bool,
    range: Option<[f64; 2]>,
    /// The bodies beyond it: mass and centre of mass.
    beyond: Vec<(usize, f64, Vector)>,
}

/// Where a group is to go.
#[derive(Debug, Clone, PartialEq)]
struct Target {
    place: Place,
    line: bool,
    /// Speed on a line.
    speed_m_s: f64,
    /// Shares of the limits of speed and acceleration.
    scaling: [f64; 2],
}

#[derive(Debug, Clone, PartialEq)]
enum Place {
    Joints(Vec<f64>),
    Tool(Vector, Option<Vector>),
}

/// A way from 0 to 1.
#[derive(Debug, Clone)]
struct Moving {
    /// Positions of the joints at equal distances; between them cubic.
    knots: Vec<Vec<f64>>,
    profile: Profile,
    limits: Limits,
    since_secs: f64,
}

/// A trajectory that is gone along.
#[derive(Debug, Clone, PartialEq)]
struct Course {
    trajectory: usize,
    /// The next waypoint.
    next: usize,
    /// Until when it rests where it is.
    rests_until_secs: f64,
}

/// How a trajectory came to its end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ended {
    pub(super) trajectory: String,
    /// The waypoint that is out of reach, if there is one, and the distance and the angle that are left to it.
    pub(super) out_of_reach: Option<(usize, [f64; 2])>,
}

/// A group in an episode.
#[derive(Debug, Clone)]
pub(super) struct Grouping {
    group: Group,
    limits: JointGroup,
    joints: Vec<Jointed>,
    tool: Option<Tool>,
    gravity_m_s2: f64,
    pub(super) trajectories: Vec<Trajectory>,
    pub(super) reference: Vec<f64>,
    speed: Vec<f64>,
    moving: Option<Moving>,
    waiting: Option<Target>,
    /// The goal that was commanded last.
    goal: Option<Target>,
    course: Option<Course>,
    /// Distance and angle that the last goal was out of reach by.
    left: [f64; 2],
    /// Whether the last goal or trajectory was not gone to, being out of reach.
    has_failed: bool,
}

impl Grouping {
    pub(super) fn new(
        data: &JointGroup,
        robot: &BuiltRobot,
        layout: &Layout,
        model: &Model,
        trajectories: Vec<Trajectory>,
    ) -> Self {
        let group = data.group.clone();
        let joints: Vec<Jointed> = group
            .joints
            .iter()
            .filter_map(|name| robot.added.joints.get(name))
            .map(|joint| Jointed::new(*joint, layout))
            .collect();
        let start = |joint: &Jointed| {
            let given = robot.start.iter().rev().find(|(it, _)| *it == joint.joint);
            given.map_or(0.0, |(_, position)| *position)
        };
        let reference: Vec<f64> = joints.iter().map(start).collect();
        Self {
            tool: Tool::new(data, robot, model),
            gravity_m_s2: layout.gravity_m_s2,
            trajectories,
            speed: vec![0.0; reference.len()],
            reference,
            joints,
            group,
            limits: data.clone(),
            moving: None,
            waiting: None,
            goal: None,
            course: None,
            left: [0.0; 2],
            has_failed: false,
        }
    }

    /// What a controller's fields are before anything is commanded: the positions at the beginning and the tool's pose there.
    pub(super) fn start(&self, layout: &Layout) -> Vec<f64> {
        match self.group.mode {
            GroupMode::Position | GroupMode::Impedance => {
                let mut start = self.reference.clone();
                if let Some(tool) = &self.tool {
                    let root = layout.bodies[tool.root].pose;
                    let all = tool.all(&|joint| self.start_of(joint));
                    let pose = tool.pose(&root, &all);
                    start.extend(pose.position_m);
                    start.extend(roll_pitch_yaw(pose.orientation));
                    start.push(0.0);
                }
                start
            }
            GroupMode::Velocity | GroupMode::Torque => vec![0.0; self.joints.len()],
        }
    }

    fn start_of(&self, joint: usize) -> Option<f64> {
        let place = self.joints.iter().position(|it| it.joint == joint)?;
        Some(self.reference[place])
    }

    /// Fields were commanded: `is_pose` if some of them are of the tool's pose.
    pub(super) fn command(&mut self, commanded: &[f64], is_pose: bool) {
        if self.group.profile.is_none() {
            return;
        }
        let count = self.joints.len();
        let target = match (is_pose, commanded.get(count..count + 7)) {
            (true, Some([x, y, z, roll, pitch, yaw, line])) => Target {
                place: Place::Tool([*x, *y, *z], Some([*roll, *pitch, *yaw])),
                line: *line != 0.0,
                speed_m_s: self.group.line_speed_m_s,
                scaling: [1.0; 2],
            },
            _ => Target {
                place: Place::Joints(commanded[..count].to_vec()),
                line: false,
                speed_m_s: self.group.line_speed_m_s,
                scaling: [1.0; 2],
            },
        };
        // Who commands the same goal again and again wants it once.
        if self.goal.as_ref() != Some(&target) {
            self.goal = Some(target.clone());
            self.course = None;
            self.waiting = Some(target);
        }
    }

    /// Begins a trajectory; whether it has it.
    pub(super) fn begin(&mut self, name: &str, now_secs: f64) -> bool {
        let found = self.trajectories.iter().position(|it| it.name == name);
        let Some(trajectory) = found else {
            return false;
        };
        self.goal = None;
        self.waiting = None;
        self.course = Some(Course {
            trajectory,
            next: 0,
            rests_until_secs: now_secs,
        });
        true
    }

    /// Brings the reference to `now_secs`; how a trajectory ended, if one did.
    fn lead(&mut self, physics: &dyn Physics, now_secs: f64) -> Option<Ended> {
        let is_new = self.waiting.is_some() || self.course.as_ref().is_some_and(|it| it.next == 0);
        if let Some(moving) = self.moving.as_mut().filter(|it| is_new && !it.is_braked()) {
            moving.brake(now_secs);
        }
        if let Some(moving) = &self.moving {
            (self.reference, self.speed) = moving.at(now_secs);
            if !moving.is_over(now_secs) {
                return None;
            }
            self.moving = None;
            self.speed.fill(0.0);
            if let Some(course) = &mut self.course {
                let waypoints = &self.trajectories[course.trajectory].waypoints;
                let rests = course.next.checked_sub(1).and_then(|at| waypoints.get(at));
                course.rests_until_secs = now_secs + rests.map_or(0.0, |it| it.wait_secs);
            }
        }
        if let Some(target) = self.waiting.take() {
            self.set_out(&target, physics, now_secs);
            return None;
        }
        let course = self.course.as_mut()?;
        if now_secs + 1e-9 < course.rests_until_secs {
            return None;
        }
        let next = course.next;
        course.next += 1;
        self.go_on(next, physics, now_secs)
    }

    /// Sets out for the next waypoint of the trajectory. At the first, from where the group then is, all are tried, so that none
    /// begins that cannot be gone to its end.
    fn go_on(&mut self, next: usize, physics: &dyn Physics, now_secs: f64) -> Option<Ended> {
        let course = self.course.as_ref()?;
        let trajectory = self.trajectories[course.trajectory].clone();
        let ended = |out_of_reach: Option<(usize, [f64; 2])>| {
            let trajectory = trajectory.name.clone();
            Some(Ended {
                trajectory,
                out_of_reach,
            })
        };
        let Some(waypoint) = trajectory.waypoints.get(next) else {
            self.course = None;
            return ended(None);
        };
        let mut failed = None;
        if next == 0 {
            let root = self.tool.as_ref().map(|tool| physics.body_pose(tool.root));
            let others = |joint: usize| Some(physics.joint(joint).position);
            failed = self.out_of_reach(&trajectory, root.as_ref(), &others);
        }
        if failed.is_none() {
            let target = Target::of(waypoint, &trajectory, &self.group);
            if self.set_out(&target, physics, now_secs) {
                return None;
            }
            failed = Some((next, self.left));
        }
        if let Some((_, left)) = failed {
            (self.left, self.has_failed) = (left, true);
        }
        self.course = None;
        ended(failed)
    }

    /// Sets out for a goal; `false` if it is out of reach.
    fn set_out(&mut self, target: &Target, physics: &dyn Physics, now_secs: f64) -> bool {
        let root = self.tool.as_ref().map(|tool| physics.body_pose(tool.root));
        let is_own = |joint: usize| self.start_of(joint);
        let all = |joint: usize| is_own(joint).unwrap_or_else(|| physics.joint(joint).position);
        match self.way(target, root.as_ref(), &|joint| Some(all(joint))) {
            Ok(knots) => {
                (self.left, self.has_failed) = ([0.0; 2], false);
                self.moving = self.moving(knots, target, now_secs);
                true
            }
            Err(left) => {
                (self.left, self.has_failed) = (left, true);
                false
            }
        }
    }

    /// The way from the reference to a goal, or how far it is out of reach.
    fn way(
        &self,
        target: &Target,
        root: Option<&Pose>,
        position: &dyn Fn(usize) -> Option<f64>,
    ) -> Result<Vec<Vec<f64>>, [f64; 2]> {
        match (&target.place, &self.tool, root) {
            (Place::Joints(goal), ..) => {
                let left = self.beyond_ranges(goal);
                match left == [0.0; 2] {
                    true => Ok(vec![self.reference.clone(), goal.clone()]),
                    false => Err(left),
                }
            }
            (Place::Tool(place, turn), Some(tool), Some(root)) => {
                let all = tool.all(position);
                match target.line {
                    true => tool.line(root, *place, *turn, all),
                    false => {
                        let goal = tool.goal(root, *place, *turn);
                        let reached = tool.model.inverse(&tool.chain, &goal, &all);
                        let reached = there(reached)?;
                        Ok(vec![self.reference.clone(), reached])
                    }
                }
            }
            _ => Err([f64::NAN; 2]),
        }
    }

    /// How far positions are outside of their ranges: in metres, in radians.
    fn beyond_ranges(&self, positions: &[f64]) -> [f64; 2] {
        let mut left = [0.0_f64; 2];
        for (joint, position) in self.joints.iter().zip(positions) {
            let Some([low, high]) = joint.range else {
                continue;
            };
            let beyond = (low - position).max(position - high);
            let kind = usize::from(!joint.is_slide);
            left[kind] = left[kind].max(beyond);
        }
        left
    }

    /// The movement along a way; none if there is no way to go.
    fn moving(&self, knots: Vec<Vec<f64>>, target: &Target, now_secs: f64) -> Option<Moving> {
        let limits = self.limits_along(&knots, target)?;
        Some(Moving {
            profile: Profile::over(1.0, &limits),
            knots,
            limits,
            since_secs: now_secs,
        })
    }

    /// Limits of the way's parameter, so that every joint keeps to its own: on a line `q'' = q_ss s'^2 + q_s s''` has half of the
    /// acceleration for each part.
    fn limits_along(&self, knots: &[Vec<f64>], target: &Target) -> Option<Limits> {
        let [of_speed, of_acceleration] = target.scaling;
        let count = (knots.len() - 1) as f64;
        let is_straight = knots.len() == 2;
        let share = if is_straight { 1.0 } else { 0.5 };
        let jerks = self.group.jerk_limit.as_ref();
        let (mut speed, mut acceleration, mut jerk) = (f64::MAX, f64::MAX, f64::MAX);
        for joint in 0..self.joints.len() {
            let at = |knot: usize| knots[knot][joint];
            let pairs = (1..knots.len()).map(|knot| (at(knot) - at(knot - 1)).abs() * count);
            let slope = pairs.fold(0.0, f64::max);
            let bends = (2..knots.len())
                .map(|knot| (at(knot) - 2.0 * at(knot - 1) + at(knot - 2)).abs() * count * count);
            let bend = bends.fold(0.0, f64::max);
            let fastest = of_speed * self.limits.velocity_limit[joint];
            let limit = self.group.acceleration_limit.as_ref()?.of(joint) * of_acceleration;
            if slope > 0.0 {
                speed = speed.min(fastest / slope);
                acceleration = acceleration.min(share * limit / slope);
                jerk = jerk.min(jerks.map_or(f64::MAX, |it| it.of(joint) / slope));
            }
            if bend > 0.0 {
                speed = speed.min((0.5 * limit / bend).sqrt());
            }
        }
        if let (true, Some(tool)) = (target.line, &self.tool) {
            let length_m = tool.length_m(knots);
            if length_m > 0.0 {
                speed = speed.min(of_speed * target.speed_m_s / length_m);
                let largest = of_acceleration * self.group.line_acceleration_m_s2;
                acceleration = acceleration.min(largest / length_m);
            }
        }
        (speed < f64::MAX).then(|| Limits {
            speed,
            acceleration,
            jerk: jerks.map(|_| jerk),
        })
    }

    /// Brings the drives on their way for the step that begins now; how a trajectory ended, if one did.
    pub(super) fn act(
        &mut self,
        physics: &mut dyn Physics,
        drives: std::ops::Range<usize>,
        wanted: &[f64],
        now_secs: f64,
    ) -> Option<Ended> {
        let mut ended = None;
        match (self.group.mode, self.group.profile) {
            (GroupMode::Position | GroupMode::Impedance, None) => {
                self.reference.copy_from_slice(&wanted[..self.joints.len()]);
            }
            (GroupMode::Position | GroupMode::Impedance, Some(_)) => {
                ended = self.lead(physics, now_secs);
            }
            (GroupMode::Velocity, _) => {
                let limits = self.limits.velocity_limit.iter();
                for ((kept, wanted), limit) in self.speed.iter_mut().zip(wanted).zip(limits) {
                    *kept = wanted.clamp(-limit, *limit);
                }
            }
            (GroupMode::Torque, _) => {}
        }
        for (joint, drive) in drives.enumerate() {
            let target = match self.group.mode {
                GroupMode::Torque => wanted[joint],
                GroupMode::Velocity => self.speed[joint],
                GroupMode::Position => self.led(joint, 0.0),
                GroupMode::Impedance => self.led(joint, self.weight_at(joint, physics)),
            };
            physics.set_drive(drive, target);
        }
        ended
    }

    /// The target of a servo that has the reference's speed and a torque besides.
    fn led(&self, joint: usize, torque: f64) -> f64 {
        let number = |numbers: &Option<super::data::PerJoint>| {
            numbers.as_ref().map_or(0.0, |numbers| numbers.of(joint))
        };
        let (stiffness, damping) = (number(&self.group.stiffness), number(&self.group.damping));
        let besides = damping * self.speed[joint] + torque;
        match besides == 0.0 {
            true => self.reference[joint],
            false => self.reference[joint] + besides / stiffness,
        }
    }

    /// What bears the weight of the robot's own links at a joint.
    fn weight_at(&self, joint: usize, physics: &dyn Physics) -> f64 {
        let joint = &self.joints[joint];
        let pose = physics.body_pose(joint.body);
        let axis = rotate(pose.orientation, joint.axis);
        let anchor = pose.position_m;
        let anchor = add(anchor, rotate(pose.orientation, joint.anchor_m));
        let beyond = joint.beyond.iter().map(|(body, mass_kg, centre_m)| {
            let pose = physics.body_pose(*body);
            let centre = add(pose.position_m, rotate(pose.orientation, *centre_m));
            let way = match joint.is_slide {
                true => axis,
                false => cross(axis, subtract(centre, anchor)),
            };
            mass_kg * self.gravity_m_s2 * way[2]
        });
        beyond.sum()
    }

    /// Whether it is on its way.
    pub(super) fn is_moving(&self) -> bool {
        self.moving.is_some()
    }

    /// Distance and angle by which the last goal was out of reach.
    pub(super) fn left(&self) -> [f64; 2] {
        self.left
    }

    /// The row of its topic.
    pub(super) fn row(&self, physics: &dyn Physics) -> Vec<f64> {
        let mut row = Vec::new();
        for (joint, reference) in self.joints.iter().zip(&self.reference) {
            let state = physics.joint(joint.joint);
            let told = match self.group.mode {
                GroupMode::Position | GroupMode::Impedance => *reference,
                GroupMode::Velocity | GroupMode::Torque => f64::NAN,
            };
            row.extend([state.position, state.velocity, told]);
        }
        row.push(f64::from(u8::from(self.is_moving())));
        row.extend(self.left);
        row.push(f64::from(u8::from(self.has_failed)));
        row
    }

    /// The first waypoint of each trajectory that cannot be reached from the beginning: its key and what is left.
    pub(super) fn unreachable(&self, layout: &Layout) -> Vec<(String, [f64; 2])> {
        let root = self.tool.as_ref().map(|tool| layout.bodies[tool.root].pose);
        let found = self.trajectories.iter().filter_map(|trajectory| {
            let (place, left) = self.out_of_reach(trajectory, root.as_ref(), &|_| None)?;
            let key = format!("trajectory.{}.waypoint.{place}", trajectory.name);
            Some((key, left))
        });
        found.collect()
    }

    /// The first waypoint of a trajectory that cannot be reached from where the group is, one after another; `others` has the
    /// positions of the robot's other joints.
    fn out_of_reach(
        &self,
        trajectory: &Trajectory,
        root: Option<&Pose>,
        others: &dyn Fn(usize) -> Option<f64>,
    ) -> Option<(usize, [f64; 2])> {
        let mut then = self.clone();
        for (place, waypoint) in trajectory.waypoints.iter().enumerate() {
            let target = Target::of(waypoint, trajectory, &self.group);
            let position = |joint: usize| then.start_of(joint).or_else(|| others(joint));
            match then.way(&target, root, &position) {
                Ok(knots) => {
                    if let Some(end) = knots.last() {
                        then.reference.clone_from(end);
                    }
                }
                Err(left) => return Some((place, left)),
            }
        }
        None
    }
}

impl Jointed {
    fn new(joint: usize, layout: &Layout) -> Self {
        let plan = &layout.joints[joint];
        let mut is_beyond = vec![false; layout.bodies.len()];
        let mut beyond = Vec::new();
        // Bodies come after their parents.
        for (index, body) in layout.bodies.iter().enumerate().skip(plan.body) {
            let hangs = body.parent.is_some_and(|parent| is_beyond[parent]);
            is_beyond[index] = index == plan.body || hangs;
            if let Some(inertia) = body.inertia.filter(|_| is_beyond[index]) {
                beyond.push((index, inertia.mass_kg, inertia.centre_m));
            }
        }
        Self {
            joint,
            body: plan.body,
            anchor_m: plan.anchor_m,
            axis: scale(1.0 / norm(plan.axis).max(1e-12), plan.axis),
            is_slide: plan.kind == JointKind::Slide,
            range: plan.range,
            beyond,
        }
    }
}

impl Target {
    fn of(waypoint: &GroupWaypoint, trajectory: &Trajectory, group: &Group) -> Self {
        let place = match (&waypoint.joints, waypoint.place()) {
            (Some(joints), _) => Place::Joints(joints.clone()),
            (None, Some((place, turn))) => Place::Tool(place, turn),
            (None, None) => Place::Joints(Vec::new()),
        };
        Self {
            place,
            line: waypoint.line,
            speed_m_s: waypoint.speed_m_s.unwrap_or(group.line_speed_m_s),
            scaling: [trajectory.velocity_scaling, trajectory.acceleration_scaling],
        }
    }
}

impl Moving {
    fn is_braked(&self) -> bool {
        self.profile.is_braked()
    }

    /// Comes to rest on the way as soon as the limits allow.
    fn brake(&mut self, now_secs: f64) {
        self.profile = self
            .profile
            .braked(now_secs - self.since_secs, &self.limits);
        self.since_secs = now_secs;
    }

    fn is_over(&self, now_secs: f64) -> bool {
        now_secs - self.since_secs >= self.profile.duration_secs() - 1e-9
    }

    /// Positions and speeds.
    fn at(&self, now_secs: f64) -> (Vec<f64>, Vec<f64>) {
        let on_way = self.profile.at(now_secs - self.since_secs);
        let along = self.knots.len() - 1;
        if on_way.place >= 1.0 {
            return (
                self.knots[along].clone(),
                vec![0.0; self.knots[along].len()],
            );
        }
        let place = (on_way.place * along as f64).clamp(0.0, along as f64);
        let piece = (place.floor() as usize).min(along - 1);
        let t = place - piece as f64;
        let joints = 0..self.knots[0].len();
        let each = joints.map(|joint| {
            let at = |knot: usize| self.knots[knot.min(along)][joint];
            let (from, to) = (at(piece), at(piece + 1));
            // Slopes at both ends, of the points around them.
            let before = if piece == 0 {
                to - from
            } else {
                (to - at(piece - 1)) / 2.0
            };
            let is_last = piece + 1 == along;
            let behind = if is_last {
                to - from
            } else {
                (at(piece + 2) - from) / 2.0
            };
            let (bend, turn) = (to - from, before + behind);
            let (c2, c3) = (3.0 * bend - before - turn, turn - 2.0 * bend);
            let position = from + t * (before + t * (c2 + t * c3));
            let slope = before + t * (2.0 * c2 + 3.0 * t * c3);
            (position, slope * along as f64 * on_way.speed)
        });
        each.unzip()
    }
}
