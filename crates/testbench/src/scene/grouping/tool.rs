//! The tool point of a group: where it is, and where its joints have to be for it to be elsewhere.
//!
//! A straight line is a row of poses at most [`LINE_M`] and [`LINE_RAD`] apart, each reached from the joints of the one before by
//! [`robot_model::inverse`]; where that leads to another branch of the arm's solutions, or nowhere, the line ends.

use std::sync::Arc;

use robot_model::Model;
use robot_model::inverse::{Chain, Goal, Reached};

use crate::geometry::{
    Pose, Vector, add, from_roll_pitch_yaw, norm, rotate, rotation_between, scale, subtract,
    turned_by,
};
use crate::scene::build::BuiltRobot;
use crate::scene::data::JointGroup;

/// Points of a line are at most so far apart.
const LINE_M: f64 = 0.002;
/// And turned against each other by at most this.
const LINE_RAD: f64 = 0.01;
/// More than this from point to point is another branch of the arm's solutions.
const JUMP: f64 = 0.35;

/// The tool point of a group.
#[derive(Debug, Clone)]
pub(super) struct Tool {
    pub(super) model: Arc<Model>,
    pub(super) chain: Chain,
    /// The body of the robot's root, and where the description has it.
    pub(super) root: usize,
    root_in_model: Pose,
    /// For each position of the model its joint in the layout.
    joints: Vec<(usize, usize)>,
}

impl Tool {
    pub(super) fn new(data: &JointGroup, robot: &BuiltRobot, model: &Model) -> Option<Self> {
        let point = data.tool.as_ref()?;
        let root = model.roots().next()?;
        let link = match &point.link {
            Some(link) => model.link(link)?,
            None => root,
        };
        let own = data.group.joints.iter().map(|name| model.joint(name));
        let named = model.joints.iter().enumerate();
        let joints = named.filter_map(|(index, joint)| {
            let place = model.position_start(index)?;
            Some((place, *robot.added.joints.get(&joint.name)?))
        });
        let tool = point.pose();
        Some(Self {
            chain: Chain {
                joints: own.collect::<Option<_>>()?,
                link,
                tool: robot_model::Pose {
                    position_m: tool.position_m,
                    rotation: tool.orientation,
                },
            },
            root: robot.added.root,
            root_in_model: ours(&model.links[root].pose_in_parent),
            joints: joints.collect(),
            model: Arc::new(model.clone()),
        })
    }

    /// All positions of the model, with those that are known.
    pub(super) fn all(&self, position: &dyn Fn(usize) -> Option<f64>) -> Vec<f64> {
        let mut all = self.model.reference_positions();
        for (place, joint) in &self.joints {
            if let Some(position) = position(*joint) {
                all[*place] = position;
            }
        }
        all
    }

    /// The description's frame in the world, for where its root is.
    fn frame(&self, root: &Pose) -> Pose {
        let origin = Pose {
            position_m: [0.0; 3],
            orientation: crate::geometry::IDENTITY,
        };
        root.then(&origin.seen_from(&self.root_in_model))
    }

    /// Where the tool is in the world.
    pub(super) fn pose(&self, root: &Pose, all: &[f64]) -> Pose {
        let tool = self.model.tool_pose(&self.chain, all).unwrap_or_default();
        self.frame(root).then(&ours(&tool))
    }

    /// A place in the world as a goal.
    pub(super) fn goal(&self, root: &Pose, place: Vector, turn: Option<Vector>) -> Goal {
        self.goal_of(root, place, turn.map(from_roll_pitch_yaw))
    }

    fn goal_of(&self, root: &Pose, place: Vector, turn: Option<[f64; 4]>) -> Goal {
        let in_world = Pose {
            position_m: place,
            orientation: turn.unwrap_or(crate::geometry::IDENTITY),
        };
        let goal = in_world.seen_from(&self.frame(root));
        Goal {
            position_m: goal.position_m,
            rotation: turn.map(|_| goal.orientation),
        }
    }

    /// Positions of the joints at points of a straight line to a place.
    pub(super) fn line(
        &self,
        root: &Pose,
        place: Vector,
        turn: Option<Vector>,
        mut all: Vec<f64>,
    ) -> Result<Vec<Vec<f64>>, [f64; 2]> {
        let from = self.pose(root, &all);
        let way = subtract(place, from.position_m);
        let turning = turn.map_or([0.0; 3], |turn| {
            rotation_between(from.orientation, from_roll_pitch_yaw(turn))
        });
        let pieces = (norm(way) / LINE_M).max(norm(turning) / LINE_RAD).ceil();
        let pieces = (pieces as usize).max(2);
        let own = |all: &[f64]| -> Vec<f64> {
            let places = self.chain.joints.iter();
            let places = places.filter_map(|joint| self.model.position_start(*joint));
            places.map(|place| all[place]).collect()
        };
        let mut knots = vec![own(&all)];
        let end = self.goal(root, place, turn);
        for piece in 1..=pieces {
            let share = piece as f64 / pieces as f64;
            let at = add(from.position_m, scale(share, way));
            let turned = turn.map(|_| turned_by(from.orientation, scale(share, turning)));
            let goal = self.goal_of(root, at, turned);
            let reached = self.model.inverse_nearby(&self.chain, &goal, &all);
            let before = own(&all);
            let next = there(reached).ok().filter(|next| {
                let pairs = next.iter().zip(&before);
                pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) < JUMP
            });
            let Some(next) = next else {
                return Err(self.left(&all, &end));
            };
            for (joint, position) in self.chain.joints.iter().zip(&next) {
                if let Some(place) = self.model.position_start(*joint) {
                    all[place] = *position;
                }
            }
            knots.push(next);
        }
        Ok(knots)
    }

    /// How far the tool is from a goal.
    fn left(&self, all: &[f64], goal: &Goal) -> [f64; 2] {
        let tool = self.model.tool_pose(&self.chain, all).unwrap_or_default();
        let angle = goal
            .rotation
            .map_or(0.0, |goal| norm(rotation_between(tool.rotation, goal)));
        [norm(subtract(goal.position_m, tool.position_m)), angle]
    }

    /// The length of the tool's way.
    pub(super) fn length_m(&self, knots: &[Vec<f64>]) -> f64 {
        let mut all = self.model.reference_positions();
        let mut at = |knot: &Vec<f64>| {
            for (joint, position) in self.chain.joints.iter().zip(knot) {
                if let Some(place) = self.model.position_start(*joint) {
                    all[place] = *position;
                }
            }
            let tool = self.model.tool_pose(&self.chain, &all).unwrap_or_default();
            tool.position_m
        };
        let places: Vec<Vector> = knots.iter().map(&mut at).collect();
        places
            .windows(2)
            .map(|pair| norm(subtract(pair[1], pair[0])))
            .sum()
    }
}

fn ours(pose: &robot_model::Pose) -> Pose {
    Pose {
        position_m: pose.position_m,
        orientation: pose.rotation,
    }
}

/// The positions, or how far they are from the goal.
pub(super) fn there(reached: Option<Reached>) -> Result<Vec<f64>, [f64; 2]> {
    let reached = reached.ok_or([f64::NAN; 2])?;
    match reached.is_there() {
        true => Ok(reached.positions),
        false => Err([reached.distance_m, reached.angle_rad]),
    }
}

/// Roll, pitch and yaw about the fixed axes, of an orientation.
pub(super) fn roll_pitch_yaw(orientation: [f64; 4]) -> Vector {
    let x = rotate(orientation, [1.0, 0.0, 0.0]);
    let y = rotate(orientation, [0.0, 1.0, 0.0]);
    let z = rotate(orientation, [0.0, 0.0, 1.0]);
    [
        y[2].atan2(z[2]),
        (-x[2]).clamp(-1.0, 1.0).asin(),
        x[1].atan2(x[0]),
    ]
}
