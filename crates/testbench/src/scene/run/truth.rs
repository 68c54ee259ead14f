//! What is true in an episode, as it is written down.

use super::*;
use crate::geometry::Pose;
use crate::scene::build::{BuiltPerson, BuiltRobot};
use crate::scene::person::{hand_end, hands_of};
use crate::viewer::Viewer;

impl Run {
    /// The largest forces of people and of other things on each robot since the last row.
    pub(super) fn gather_forces(&mut self) {
        let built = &self.built;
        let is_person = |shape: &usize| built.people.iter().any(|p| p.shapes.contains(shape));
        for (robot, [of_people, of_others]) in built.robots.iter().zip(&mut self.forces) {
            let (mut people, mut others) = (0.0, 0.0);
            for touch in &self.touches {
                let own = touch
                    .shapes
                    .map(|shape| robot.added.shapes.contains(&shape));
                let other = match own {
                    [true, false] => touch.shapes[1],
                    [false, true] => touch.shapes[0],
                    _ => continue,
                };
                if is_person(&other) {
                    people += touch.normal_newtons;
                } else if !built.ground.contains(&other) {
                    others += touch.normal_newtons;
                }
            }
            *of_people = f64::max(*of_people, people);
            *of_others = f64::max(*of_others, others);
        }
    }

    /// Writes down the truth.
    pub(super) fn record(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.now_secs();
        let distances = self.distances();
        let grippers = self.actuators.iter().filter_map(|it| it.gripper.as_ref());
        let attached: Vec<(&str, &str)> = grippers.filter_map(|it| it.attached()).collect();
        let declared = self.witness.tell(
            &self.prepared.data,
            &self.built.layout,
            self.physics.as_mut(),
            &self.touches,
            &attached,
        );
        for (index, to_people) in distances.iter().enumerate() {
            let mut row = self.robot_row(index, to_people);
            let name = &self.prepared.data.robots[index].name;
            row.extend(self.declared_of(name, &declared));
            let topic = self.recorder.topics.robots[index];
            self.recorder.row(topic, now_secs, &row, watch)?;
        }
        for index in 0..self.people.len() {
            let nearest = distances.iter().map(|of_robot| of_robot[index]);
            let mut row = self.person_row(index, nearest.fold(f64::NAN, f64::min));
            let name = &self.prepared.data.people[index].name;
            row.extend(self.declared_of(name, &declared));
            let topic = self.recorder.topics.people[index];
            self.recorder.row(topic, now_secs, &row, watch)?;
        }
        self.record_arms(watch)?;
        let row = [
            self.script.done() as f64,
            f64::from(u8::from(self.script.is_done())),
        ];
        let topic = self.recorder.topics.test;
        self.recorder.row(topic, now_secs, &row, watch)?;
        for (block, topic) in self
            .witness
            .blocks
            .iter()
            .zip(&self.recorder.topics.declared.clone())
        {
            if let Some(topic) = topic {
                let row = &declared[block.signals.clone()];
                self.recorder.row(*topic, now_secs, row, watch)?;
            }
        }
        let physics = self.physics.as_ref();
        let (data, built) = (&self.prepared.data, &self.built);
        self.grips
            .look(now_secs, data, built, physics, &self.touches);
        self.forces.fill([0.0; 2]);
        if let Some(viewer) = watch.viewer() {
            self.show(now_secs, viewer);
        }
        Ok(())
    }

    /// Writes down what groups and grippers are at.
    fn record_arms(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.now_secs();
        let physics = self.physics.as_ref();
        let (data, built) = (&self.prepared.data, &self.built);
        for (actuator, topic) in self
            .actuators
            .iter()
            .zip(&self.recorder.topics.arms.clone())
        {
            let row = match (&actuator.group, &actuator.gripper) {
                (Some(group), _) => group.row(physics),
                (None, Some(gripper)) => gripper.row(data, built, physics, &self.touches),
                (None, None) => continue,
            };
            if let Some(topic) = topic {
                self.recorder.row(*topic, now_secs, &row, watch)?;
            }
        }
        Ok(())
    }

    /// What is declared of a robot's or a person's own topic.
    fn declared_of(&self, name: &str, declared: &[f64]) -> Vec<f64> {
        let blocks = self.witness.blocks.iter();
        let own = blocks.filter(|block| block.topic.strip_prefix("/truth/") == Some(name));
        own.flat_map(|block| declared[block.signals.clone()].to_vec())
            .collect()
    }

    /// Tells a viewer where the bodies are.
    fn show(&self, now_secs: f64, viewer: &mut dyn Viewer) {
        let bodies = 0..self.built.layout.bodies.len();
        let poses: Vec<Pose> = bodies.map(|body| self.physics.body_pose(body)).collect();
        viewer.see(now_secs, &|| self.built.geometry(), &poses);
    }

    /// The distance between the surfaces of each robot and each person.
    fn distances(&mut self) -> Vec<Vec<f64>> {
        let longest_m = self.prepared.data.simulation.longest_distance_m;
        let (built, physics) = (&self.built, &mut self.physics);
        let of_robot = |robot: &BuiltRobot| {
            let mut of_person = |person: &BuiltPerson| {
                let mut least_m = longest_m;
                for own in robot.added.shapes.clone() {
                    for theirs in person.shapes.clone() {
                        let distance_m = physics.distance_m(own, theirs, least_m);
                        least_m = least_m.min(distance_m);
                    }
                }
                least_m
            };
            built.people.iter().map(&mut of_person).collect()
        };
        built.robots.iter().map(of_robot).collect()
    }

    fn robot_row(&self, index: usize, distances: &[f64]) -> Vec<f64> {
        let robot = &self.built.robots[index];
        let pose = self.physics.body_pose(robot.added.root);
        let twist = self.physics.body_twist(robot.added.root);
        let [x, y, z] = pose.position_m;
        let nearest_m = distances.iter().copied().fold(f64::NAN, f64::min);
        let mut row = vec![
            x,
            y,
            z,
            yaw_of(pose.orientation),
            twist.linear_m_s[0].hypot(twist.linear_m_s[1]),
            twist.angular_rad_s[2],
            nearest_m,
            self.forces[index][0],
            self.forces[index][1],
        ];
        for joint in &self.prepared.data.robots[index].recorded_joints {
            let state = robot.added.joints.get(joint);
            let state = state.map_or(Default::default(), |joint| self.physics.joint(*joint));
            row.extend([state.position, state.velocity]);
        }
        row
    }

    fn person_row(&self, index: usize, distance_m: f64) -> Vec<f64> {
        let walker = &self.people[index];
        let stance = &walker.stance;
        let flag = |value: bool| f64::from(u8::from(value));
        let mut row = vec![
            stance.x_m,
            stance.y_m,
            stance.heading_rad,
            stance.speed_m_s,
            distance_m,
            walker.activity as u8 as f64,
            flag(walker.is_reacting()),
            flag(walker.distracted),
            flag(walker.has_arrived()),
        ];
        let body = &self.built.people[index];
        if let Some(hands) = hands_of(walker.body, body.height_m, stance) {
            row.extend(hands.as_flattened());
        }
        if body.compliant.is_some() {
            let hands = body.bodies.end - 2..body.bodies.end;
            let end = |hand| hand_end(&self.physics.body_pose(hand), body.height_m);
            row.extend(hands.flat_map(end));
        }
        if let Some(taking) = &self.takings[index] {
            row.push(flag(taking.holds()));
        }
        row
    }
}
