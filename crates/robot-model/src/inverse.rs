//! Inverse kinematics: positions of a chain's joints at which a point of a tool has a pose.
//!
//! Definition: given joints `q` of a tree, a link with a tool's frame `T(q)` and a goal `G`, find `q` within the joints' limits
//! with the error `e = (p_G - p_T, w r)` equal to 0: `r` is the rotation vector that takes `T`'s orientation to `G`'s, `w` a
//! length (`TURN_M`) by which angles count against distances. A goal without an orientation has no `r`.
//!
//! Source: damped least squares with the damping of Levenberg and Marquardt, (JᵀJ + λ diag) Δq = Jᵀe, after S. R. Buss,
//! "Introduction to Inverse Kinematics with Jacobian Transpose, Pseudoinverse and Damped Least Squares methods" (2009).
//!
//! Deviation: a joint at its limit that would leave it is taken out of the step (active set); where a start does not lead to
//! the goal, further ones are taken from a Halton sequence within the limits, always the same. The Jacobian is taken by
//! central differences of [`Model::poses`], so that every joint that it knows is right.
//!
//! Cost: a start has at most `ROUNDS` rounds of `2 n + 2` forward kinematics, and there are at most `STARTS` starts.
//!
//! Guarantee: what is told as reached was computed forwards again and is within [`WITHIN_M`] and [`WITHIN_RAD`]. What is not
//! reached is not proven to be out of reach; the distance that is left is that of the best pose found.

use crate::model::{JointKind, Model};
use crate::pose::{Pose, Quaternion, conjugate, length, multiply, subtract};

/// A radian counts as so many metres.
const TURN_M: f64 = 0.3;
/// A goal is reached within this distance.
pub const WITHIN_M: f64 = 1e-6;
/// And within this angle.
pub const WITHIN_RAD: f64 = 1e-6;
/// Rounds of a start.
const ROUNDS: usize = 150;
/// Starts, of which the first is the one that is given.
const STARTS: u32 = 48;
/// Difference of a joint's position for the Jacobian.
const STEP: f64 = 1e-6;
/// Joints without limits begin within this of 0.
const FREE_RAD: f64 = std::f64::consts::PI;

/// A chain of joints and the tool at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The joints that may move, as places in [`Model::joints`]; turns and slides only.
    pub joints: Vec<usize>,
    /// The link that carries the tool.
    pub link: usize,
    /// The tool's frame in the link's.
    pub tool: Pose,
}

/// Where a tool is to be, in the frame in which [`Model::poses`] gives links.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Where its origin is to be.
    pub position_m: [f64; 3],
    /// How it is to be turned; as it comes if `None`.
    pub rotation: Option<Quaternion>,
}

/// The best that was found for a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Positions of the chain's joints, in its order.
    pub positions: Vec<f64>,
    /// How far the tool is from its goal.
    pub distance_m: f64,
    /// By how much it is turned against its goal; 0 for a goal without an orientation.
    pub angle_rad: f64,
}

impl Reached {
    /// Whether that is the goal.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.distance_m <= WITHIN_M && self.angle_rad <= WITHIN_RAD
    }

    fn error(&self) -> f64 {
        self.distance_m.hypot(TURN_M * self.angle_rad)
    }
}

/// One search: the model with the positions of all its joints, of which the chain's are changed.
struct Search<'a> {
    model: &'a Model,
    chain: &'a Chain,
    goal: &'a Goal,
    all: Vec<f64>,
    /// Where the positions of the chain's joints are in `all`.
    places: Vec<usize>,
    limits: Vec<[f64; 2]>,
}

impl Model {
    /// Where the tool of a chain is; `all` lists the positions of all joints. `None` if their number is wrong.
    #[must_use]
    pub fn tool_pose(&self, chain: &Chain, all: &[f64]) -> Option<Pose> {
        let poses = self.poses(all).ok()?;
        Some(poses.get(chain.link)?.then(&chain.tool))
    }

    /// Searches positions of a chain's joints, beginning with those in `all`, at which its tool is at a goal. `None` if `all`
    /// has a wrong number of positions or the chain names what is not a turn or slide of the model.
    #[must_use]
    pub fn inverse(&self, chain: &Chain, goal: &Goal, all: &[f64]) -> Option<Reached> {
        let mut search = Search::new(self, chain, goal, all)?;
        let start = search.start();
        let mut best = search.descend(start)?;
        for number in 1..STARTS {
            if best.is_there() {
                break;
            }
            let start = search.scattered(number);
            let found = search.descend(start)?;
            if found.error() < best.error() {
                best = found;
            }
        }
        Some(best)
    }

    /// As [`Model::inverse`], from the given positions alone: for the next point of a way.
    #[must_use]
    pub fn inverse_nearby(&self, chain: &Chain, goal: &Goal, all: &[f64]) -> Option<Reached> {
        let mut search = Search::new(self, chain, goal, all)?;
        let start = search.start();
        search.descend(start)
    }
}

impl<'a> Search<'a> {
    fn new(model: &'a Model, chain: &'a Chain, goal: &'a Goal, all: &[f64]) -> Option<Self> {
        if all.len() != model.position_size() || chain.link >= model.links.len() {
            return None;
        }
        let single = |joint: &usize| {
            let kind = model.joints.get(*joint)?.kind;
            let is_single = matches!(kind, JointKind::Revolute | JointKind::Prismatic);
            is_single.then(|| model.position_start(*joint)).flatten()
        };
        let places: Option<Vec<usize>> = chain.joints.iter().map(single).collect();
        let limits = chain.joints.iter().map(|joint| {
            let limits = model.joints[*joint].limits;
            limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
        });
        Some(Self {
            model,
            chain,
            goal,
            all: all.to_vec(),
            places: places?,
            limits: limits.collect(),
        })
    }

    /// The given positions, within the limits.
    fn start(&self) -> Vec<f64> {
        let given = self.places.iter().zip(&self.limits);
        given
            .map(|(place, [low, high])| self.all[*place].clamp(*low, *high))
            .collect()
    }

    /// Another start: a point of a Halton sequence within the limits.
    fn scattered(&self, number: u32) -> Vec<f64> {
        let limits = self.limits.iter().enumerate();
        limits
            .map(|(index, [low, high])| {
                let (low, high) = (low.max(-FREE_RAD), high.min(FREE_RAD));
                let (low, high) = (low.min(high), high.max(low));
                low + (high - low) * radical_inverse(number, PRIMES[index % PRIMES.len()])
            })
            .collect()
    }

    fn tool_at(&mut self, positions: &[f64]) -> Option<Pose> {
        for (place, position) in self.places.iter().zip(positions) {
            self.all[*place] = *position;
        }
        self.model.tool_pose(self.chain, &self.all)
    }

    /// The error as numbers that are all lengths.
    fn error_of(&self, tool: &Pose) -> Vec<f64> {
        let mut error = subtract(self.goal.position_m, tool.position_m).to_vec();
        if let Some(goal) = self.goal.rotation {
            error.extend(rotation_vector(tool.rotation, goal).map(|angle| TURN_M * angle));
        }
        error
    }

    fn reached(&self, positions: Vec<f64>, tool: &Pose) -> Reached {
        let turn = self.goal.rotation;
        Reached {
            positions,
            distance_m: length(subtract(self.goal.position_m, tool.position_m)),
            angle_rad: turn.map_or(0.0, |goal| length(rotation_vector(tool.rotation, goal))),
        }
    }

    /// Goes down from a start until the error vanishes or does not get smaller any more.
    fn descend(&mut self, mut at: Vec<f64>) -> Option<Reached> {
        let mut tool = self.tool_at(&at)?;
        let mut error = self.error_of(&tool);
        let mut damping = 1e-3;
        for _ in 0..ROUNDS {
            if self.reached(Vec::new(), &tool).error() < 1e-9 {
                break;
            }
            let jacobian = self.jacobian(&at)?;
            let mut is_better = false;
            while damping < 1e8 {
                let next = self.step(&at, &jacobian, &error, damping);
                let moved = self.tool_at(&next)?;
                let left = self.error_of(&moved);
                if squared(&left) < squared(&error) * (1.0 - 1e-12) {
                    (at, tool, error) = (next, moved, left);
                    damping = (damping * 0.2).max(1e-12);
                    is_better = true;
                    break;
                }
                damping *= 5.0;
            }
            if !is_better {
                break;
            }
        }
        Some(self.reached(at, &tool))
    }

    /// Columns: how the tool's pose, as the error measures it, changes with each joint.
    fn jacobian(&mut self, at: &[f64]) -> Option<Vec<Vec<f64>>> {
        let mut columns = Vec::with_capacity(at.len());
        let mut moved = at.to_vec();
        for joint in 0..at.len() {
            moved[joint] = at[joint] + STEP;
            let ahead = self.tool_at(&moved)?;
            moved[joint] = at[joint] - STEP;
            let behind = self.tool_at(&moved)?;
            moved[joint] = at[joint];
            let way = subtract(ahead.position_m, behind.position_m);
            let mut column = way.map(|d| d / (2.0 * STEP)).to_vec();
            if self.goal.rotation.is_some() {
                let turn = rotation_vector(behind.rotation, ahead.rotation);
                column.extend(turn.map(|angle| TURN_M * angle / (2.0 * STEP)));
            }
            columns.push(column);
        }
        Some(columns)
    }

    /// The positions after a damped step; what would leave its limits stays at them.
    fn step(&self, at: &[f64], jacobian: &[Vec<f64>], error: &[f64], damping: f64) -> Vec<f64> {
        let mut is_held = vec![false; at.len()];
        loop {
            let change = damped(jacobian, error, damping, &is_held);
            let leaving = (0..at.len()).find(|joint| {
                let [low, high] = self.limits[*joint];
                let (now, by) = (at[*joint], change[*joint]);
                !is_held[*joint] && ((now <= low && by < 0.0) || (now >= high && by > 0.0))
            });
            match leaving {
                Some(joint) => is_held[joint] = true,
                None => {
                    // Far steps of turns lead anywhere.
                    let largest = change.iter().fold(0.0_f64, |most, by| most.max(by.abs()));
                    let share = if largest > 0.5 { 0.5 / largest } else { 1.0 };
                    let moved = at.iter().zip(&change).zip(&self.limits);
                    return moved
                        .map(|((now, by), [low, high])| (now + share * by).clamp(*low, *high))
                        .collect();
                }
            }
        }
    }
}

/// The solution of `(JᵀJ + λ (diag JᵀJ + 1e-6)) x = Jᵀe` in the joints that are not held.
fn damped(jacobian: &[Vec<f64>], error: &[f64], damping: f64, is_held: &[bool]) -> Vec<f64> {
    let free: Vec<usize> = (0..jacobian.len()).filter(|j| !is_held[*j]).collect();
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows: Vec<Vec<f64>> = free
        .iter()
        .map(|a| {
            let mut row: Vec<f64> = free
                .iter()
                .map(|b| inner(&jacobian[*a], &jacobian[*b]))
                .collect();
            row.push(inner(&jacobian[*a], error));
            row
        })
        .collect();
    for (index, row) in rows.iter_mut().enumerate() {
        row[index] += damping * (row[index] + 1e-6);
    }
    let solution = solved(rows);
    let mut change = vec![0.0; jacobian.len()];
    for (joint, by) in free.iter().zip(solution) {
        change[*joint] = by;
    }
    change
}

/// Gauss's elimination with pivots; the last column is the right side. The matrix is positive definite.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let count = rows.len();
    for column in 0..count {
        let largest = (column..count)
            .max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))
            .unwrap_or(column);
        rows.swap(column, largest);
        let pivot = rows[column].clone();
        for row in rows.iter_mut().skip(column + 1) {
            let factor = row[column] / pivot[column];
            for (value, above) in row.iter_mut().zip(&pivot).skip(column) {
                *value -= factor * above;
            }
        }
    }
    let mut solution = vec![0.0; count];
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|c| rows[row][c] * solution[c]).sum();
        solution[row] = (rows[row][count] - known) / rows[row][row];
    }
    solution
}

fn squared(numbers: &[f64]) -> f64 {
    numbers.iter().map(|number| number * number).sum()
}

/// The rotation vector in the outer frame that takes one orientation to another, at most half a turn long.
#[must_use]
pub fn rotation_vector(from: Quaternion, to: Quaternion) -> [f64; 3] {
    let [w, x, y, z] = multiply(to, conjugate(from));
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    let sine = length([x, y, z]);
    let angle_rad = 2.0 * sine.atan2(sign * w);
    // The limit of angle / sine for small turns is 2.
    let factor = if sine > 1e-12 { angle_rad / sine } else { 2.0 };
    [x, y, z].map(|part| sign * factor * part)
}

/// Bases of Halton's sequence.
const PRIMES: [u32; 10] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29];

/// The digits of a number in a base, mirrored at the point.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while number > 0 {
        share /= f64::from(base);
        value += share * f64::from(number % base);
        number /= base;
    }
    value
}
