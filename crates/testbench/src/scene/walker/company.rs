//! How people keep clear of others on the way, and together with their group.
//!
//! # Definition
//! Who walks at speed `v` towards a goal in direction `e` wishes for the velocity
//!
//! ```text
//! w = v e + sum over others of  v exp((c - d) / B) f (n + t / 2) + v min(1/2, (g - G) / G) u   if g > G
//! ```
//!
//! `d` the distance of the surfaces (of a robot, of its root), `c` that at which keeping clear is as strong as going on, `n` the
//! direction away from the other, `t` the direction to the right of the way there, `f` from 1 for what lies ahead to 0.2 for what lies behind.
//! `u` leads to the middle of the group, `g` away, in which half of `c` is kept. The speed wished for is at most `v`.
//!
//! # Source
//! D. Helbing and P. Molnar, "Social force model for pedestrian dynamics" (1995), with its falloff `B` of 0.3 m; groups:
//! M. Moussaid, N. Perozo, S. Garnier, D. Helbing and G. Theraulaz (2010). Deviation: of velocities instead of accelerations, which the
//! walker limits; with a part to the right, so that two who meet head-on pass each other. There are no walls.
//!
//! # Guarantee
//! None of what people do: a declared stand-in with parameters, whose effect is tested (who meets passes, groups stay together).

use super::Walker;
use crate::scene::walker::RobotSeen;

/// The falloff of keeping clear.
const FALLOFF_M: f64 = 0.3;
/// How much of it is left for what lies behind.
const BEHIND: f64 = 0.2;
/// How far from the middle of the group nobody minds.
const TOGETHER_M: f64 = 0.8;

/// A person as others see them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene) struct PersonSeen {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) radius_m: f64,
    pub(super) group: Option<usize>,
}

/// What there is around a person.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) struct Surroundings<'a> {
    pub(in crate::scene) robots: &'a [RobotSeen],
    /// All people, and which of them the person is.
    pub(in crate::scene) people: &'a [PersonSeen],
    pub(in crate::scene) own: usize,
}

impl Walker {
    /// As others see the person.
    pub(in crate::scene) fn seen(&self) -> PersonSeen {
        PersonSeen {
            x_m: self.stance.x_m,
            y_m: self.stance.y_m,
            radius_m: self.drawn.radius_m,
            group: self.group,
        }
    }

    /// The velocity that is wished for on the way to a goal, as a point to walk to and a speed. Robots that are the goal are not
    /// kept clear of.
    pub(super) fn among_others(
        &self,
        goal: [f64; 2],
        speed_m_s: f64,
        around: Surroundings<'_>,
        is_after_robots: bool,
    ) -> ([f64; 2], f64) {
        let here = [self.stance.x_m, self.stance.y_m];
        let way = minus(goal, here);
        let left_m = size(way);
        if left_m == 0.0 || speed_m_s == 0.0 {
            return (goal, speed_m_s);
        }
        let ahead = way.map(|part| part / left_m);
        let mut wish = ahead;
        let mut clear = |other: [f64; 2], of_surfaces_m: f64, clear_m: f64| {
            let away = minus(here, other);
            let apart_m = size(away);
            if apart_m == 0.0 {
                return;
            }
            let away = away.map(|part| part / apart_m);
            let strength = ((clear_m - (apart_m - of_surfaces_m)) / FALLOFF_M).exp();
            // 1 straight ahead, 0 behind.
            let facing = (1.0 - dot(away, ahead)) / 2.0;
            let strength = strength * (BEHIND + (1.0 - BEHIND) * facing);
            let right = [away[1], -away[0]].map(|part| -part);
            for axis in [0, 1] {
                wish[axis] += strength * (away[axis] + right[axis] / 2.0);
            }
        };
        if let Some([people_m, robots_m]) = self.drawn.clear_m {
            let others = around.people.iter().enumerate();
            for (_, other) in others.filter(|(place, _)| *place != around.own) {
                let is_own_group = self.group.is_some() && self.group == other.group;
                let clear_m = people_m * if is_own_group { 0.5 } else { 1.0 };
                let surfaces_m = self.drawn.radius_m + other.radius_m;
                clear([other.x_m, other.y_m], surfaces_m, clear_m);
            }
            if !is_after_robots {
                for robot in around.robots {
                    clear([robot.x_m, robot.y_m], self.drawn.radius_m, robots_m);
                }
            }
        }
        if let Some(middle) = self.middle_of_group(around) {
            let to_them = minus(middle, here);
            let apart_m = size(to_them);
            if apart_m > TOGETHER_M {
                let share = ((apart_m - TOGETHER_M) / TOGETHER_M).min(0.5);
                for axis in [0, 1] {
                    wish[axis] += share * to_them[axis] / apart_m;
                }
            }
        }
        let wished = size(wish);
        let toward = [0, 1].map(|axis| here[axis] + wish[axis]);
        (toward, speed_m_s * wished.min(1.0))
    }

    /// The middle of the group's other members.
    fn middle_of_group(&self, around: Surroundings<'_>) -> Option<[f64; 2]> {
        let group = self.group?;
        let people = around.people.iter().enumerate();
        let members: Vec<&PersonSeen> = people
            .filter(|(place, it)| *place != around.own && it.group == Some(group))
            .map(|(_, it)| it)
            .collect();
        if members.is_empty() {
            return None;
        }
        let many = members.len() as f64;
        Some([
            members.iter().map(|it| it.x_m).sum::<f64>() / many,
            members.iter().map(|it| it.y_m).sum::<f64>() / many,
        ])
    }
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn size(vector: [f64; 2]) -> f64 {
    vector[0].hypot(vector[1])
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
