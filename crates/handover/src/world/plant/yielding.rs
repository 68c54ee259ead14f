//! Dry friction and stops of joints, as soft as the engine's.
//!
//! Definition (the engine's documentation, "Computation", constraint model): each of them wants a joint's
//! acceleration `a` to be `a_ref` and pushes with `D (a_ref - a)`, where `D = d / ((1 - d) w)`, `w` is the
//! joint's inverse inertia with all angles 0 and `d` the impedance.
//!
//! * Dry friction of at most `f`: `a_ref = -B v`, `B = 2 / (d_max T)`, `d = 0.9`; the push is cut off at
//!   `-f` and `f`.
//! * A stop that is passed by `p > 0`: `a_ref = -B v + K d p` away from it, `K = 1 / (d_max T)^2`, `d`
//!   from 0.9 to `d_max = 0.95` over a millimetre or thousandth of a radian (`solimp` as it comes); the
//!   push is never towards the stop.
//!
//! `M a = tau + pushes` is what minimises a convex function that is quadratic where it is known which
//! pushes are cut off, so that is found by solving and looking again: Newton's method, with a search along
//! each direction once whole steps have not come to an end. Cost: a solution with the factor of `M + D`,
//! which is made anew when the inertia is or another push is cut off.

use super::branches::Branches;

/// The engine's `solimp` and `solreffriction` as they come.
const IMPEDANCE: [f64; 2] = [0.9, 0.95];
const WIDTH: f64 = 1e-3;
const FRICTION_SECS: f64 = 0.02;
/// So often it looks again, and so often with whole steps; more than two are rare.
const MOST_LOOKS: usize = 100;
const WHOLE_STEPS: usize = 4;

/// A joint's dry friction and stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    pub(super) friction_nm: f64,
    pub(super) range_rad: [f64; 2],
    pub(super) stop_secs: f64,
    pub(super) inverse_inertia: f64,
}

/// How a push acts: where it is not cut off, and what it is where it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Zone {
    /// It follows the acceleration.
    #[default]
    Soft,
    /// Friction at its most, with its sign; or a stop that does not push (0).
    Cut(f64),
}

/// A push that wants an acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Push {
    wanted: f64,
    stiffness: f64,
    least_nm: f64,
    most_nm: f64,
}

impl Push {
    fn of_friction(limits: &Limits, speed_rad_s: f64) -> Self {
        let damping = 2.0 / (IMPEDANCE[1] * FRICTION_SECS);
        Self {
            wanted: -damping * speed_rad_s,
            stiffness: stiffness(IMPEDANCE[0], limits),
            least_nm: -limits.friction_nm,
            most_nm: limits.friction_nm,
        }
    }

    /// Of the stop that is passed, if one is.
    fn of_stop(limits: &Limits, angle_rad: f64, speed_rad_s: f64) -> Option<Self> {
        let [low, high] = limits.range_rad;
        let (sign, passed_rad) = match () {
            () if angle_rad < low => (1.0, low - angle_rad),
            () if angle_rad > high => (-1.0, angle_rad - high),
            () => return None,
        };
        let rate = 1.0 / (IMPEDANCE[1] * limits.stop_secs);
        let impedance = impedance(passed_rad);
        Some(Self {
            wanted: -2.0 * rate * speed_rad_s + sign * rate * rate * impedance * passed_rad,
            stiffness: stiffness(impedance, limits),
            least_nm: f64::min(0.0, sign * f64::INFINITY),
            most_nm: f64::max(0.0, sign * f64::INFINITY),
        })
    }

    fn newton_metres(&self, acceleration: f64) -> f64 {
        let soft = self.stiffness * (self.wanted - acceleration);
        soft.clamp(self.least_nm, self.most_nm)
    }

    fn zone(&self, acceleration: f64) -> Zone {
        let soft = self.stiffness * (self.wanted - acceleration);
        match self.newton_metres(acceleration) {
            push if push == soft => Zone::Soft,
            push => Zone::Cut(push),
        }
    }
}

fn stiffness(impedance: f64, limits: &Limits) -> f64 {
    impedance / ((1.0 - impedance) * limits.inverse_inertia)
}

fn impedance(passed_rad: f64) -> f64 {
    let share = (passed_rad / WIDTH).min(1.0);
    let risen = match share <= 0.5 {
        true => 2.0 * share * share,
        false => 1.0 - 2.0 * (1.0 - share) * (1.0 - share),
    };
    IMPEDANCE[0] + risen * (IMPEDANCE[1] - IMPEDANCE[0])
}

/// The pushes of all joints.
#[derive(Debug, Clone)]
pub(super) struct Yielding {
    limits: Vec<Limits>,
    pushes: Vec<[Option<Push>; 2]>,
    zones: Vec<[Zone; 2]>,
    /// What the factor was made with.
    softened: Vec<f64>,
    factor: Vec<f64>,
    accelerations: Vec<f64>,
    before: Vec<f64>,
    is_current: bool,
}

impl Yielding {
    /// One entry for each joint.
    pub(super) fn new(limits: Vec<Limits>) -> Self {
        let count = limits.len();
        Self {
            pushes: vec![[None; 2]; count],
            zones: vec![[Zone::Soft; 2]; count],
            softened: vec![0.0; count],
            factor: vec![0.0; count * count],
            accelerations: vec![0.0; count],
            before: vec![0.0; count],
            is_current: false,
            limits,
        }
    }

    /// The inertia is another.
    pub(super) fn renew(&mut self) {
        self.is_current = false;
    }

    /// Adds the pushes to what else turns the joints; `state` gives a joint's angle and speed. Says whether
    /// they were found.
    pub(super) fn push(
        &mut self,
        branches: &Branches,
        inertia: &[f64],
        state: impl Fn(usize) -> (f64, f64),
        torques_nm: &mut [f64],
    ) -> bool {
        for (joint, limits) in self.limits.iter().enumerate() {
            let (angle_rad, speed_rad_s) = state(joint);
            self.pushes[joint] = [
                (limits.friction_nm > 0.0).then(|| Push::of_friction(limits, speed_rad_s)),
                Push::of_stop(limits, angle_rad, speed_rad_s),
            ];
        }
        if self.pushes.iter().flatten().all(Option::is_none) {
            return true;
        }
        let found = (0..MOST_LOOKS).any(|looks| {
            self.before.copy_from_slice(&self.accelerations);
            self.solve(branches, inertia, torques_nm);
            let is_there = !self.look();
            if !is_there && looks >= WHOLE_STEPS {
                self.search(branches, inertia, torques_nm);
                self.look();
            }
            is_there
        });
        for (joint, pushes) in self.pushes.iter().enumerate() {
            let acceleration = self.accelerations[joint];
            let pushes = pushes.iter().flatten();
            torques_nm[joint] += pushes
                .map(|push| push.newton_metres(acceleration))
                .sum::<f64>();
        }
        found
    }

    /// Finds the accelerations with every push in its zone.
    fn solve(&mut self, branches: &Branches, inertia: &[f64], torques_nm: &[f64]) {
        let count = branches.count();
        self.accelerations.copy_from_slice(torques_nm);
        for (joint, (pushes, zones)) in self.pushes.iter().zip(&self.zones).enumerate() {
            let mut soft = 0.0;
            for (push, zone) in pushes.iter().zip(zones) {
                let Some(push) = push else { continue };
                match zone {
                    Zone::Soft => {
                        soft += push.stiffness;
                        self.accelerations[joint] += push.stiffness * push.wanted;
                    }
                    Zone::Cut(push_nm) => self.accelerations[joint] += push_nm,
                }
            }
            self.is_current &= soft == self.softened[joint];
            self.softened[joint] = soft;
        }
        if !self.is_current {
            self.factor.copy_from_slice(inertia);
            for (joint, soft) in self.softened.iter().enumerate() {
                self.factor[joint * count + joint] += soft;
            }
            branches.factorise(&mut self.factor);
            self.is_current = true;
        }
        branches.solve(&self.factor, &mut self.accelerations);
    }

    /// Goes only so far from the accelerations before towards those that were solved for as the convex
    /// function falls: its slope on the way, `d . (M a - tau - pushes)`, grows from below 0.
    fn search(&mut self, branches: &Branches, inertia: &[f64], torques_nm: &[f64]) {
        const HALVES: usize = 60;
        let ways = self.accelerations.iter().zip(&self.before);
        let way: Vec<f64> = ways.map(|(to, from)| to - from).collect();
        let (at_start, along) = [&self.before, &way]
            .map(|vector| branches.product(inertia, vector))
            .into();
        let slope = |share: f64| -> f64 {
            let joints = self.pushes.iter().enumerate();
            let of_joints = joints.map(|(joint, pushes)| {
                let acceleration = self.before[joint] + share * way[joint];
                let pushes = pushes.iter().flatten();
                let push_nm: f64 = pushes.map(|it| it.newton_metres(acceleration)).sum();
                let left_nm = at_start[joint] + share * along[joint] - torques_nm[joint] - push_nm;
                way[joint] * left_nm
            });
            of_joints.sum()
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVES {
            let middle = (low + high) / 2.0;
            match slope(middle) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        for ((now, from), way) in self.accelerations.iter_mut().zip(&self.before).zip(&way) {
            *now = from + high * way;
        }
    }

    /// Puts every push into the zone where the accelerations have it; says whether one has changed.
    fn look(&mut self) -> bool {
        let mut has_changed = false;
        let rows = self.pushes.iter().zip(&mut self.zones);
        for ((pushes, zones), acceleration) in rows.zip(&self.accelerations) {
            for (push, zone) in pushes.iter().zip(zones) {
                let now = push.map_or(Zone::Soft, |push| push.zone(*acceleration));
                has_changed |= push.is_some() && now != *zone;
                *zone = now;
            }
        }
        has_changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits {
            friction_nm: 0.01,
            range_rad: [-1.0, 0.0],
            stop_secs: 0.02,
            inverse_inertia: 10.0,
        }
    }

    /// One joint of 0.1 kg m2 under a torque: the push on it, and its acceleration.
    fn alone(angle_rad: f64, speed_rad_s: f64, torque_nm: f64) -> (f64, f64) {
        let branches = Branches::new(vec![None]);
        let mut yielding = Yielding::new(vec![limits()]);
        let mut torques_nm = [torque_nm];
        let state = |_| (angle_rad, speed_rad_s);
        assert!(yielding.push(&branches, &[0.1], state, &mut torques_nm));
        (torques_nm[0] - torque_nm, torques_nm[0] / 0.1)
    }

    #[test]
    fn friction_holds_what_is_less_and_slows_down_what_is_more() {
        let (push_nm, acceleration) = alone(-0.5, 0.0, 0.005);
        // D = 0.9 / (0.1 * 10) = 0.9, against 0.1 kg m2: nine tenths of the torque are held.
        assert!((push_nm + 0.0045).abs() < 1e-12, "{push_nm}");
        assert!((acceleration - 0.005).abs() < 1e-12);
        assert!((alone(-0.5, 0.0, 0.05).0 + 0.01).abs() < 1e-12);
        assert!((alone(-0.5, -1.0, 0.0).0 - 0.01).abs() < 1e-12);
    }

    #[test]
    fn pushes_are_found_where_whole_steps_go_round_in_circles() {
        // Joints that press each other to and fro over their stops and against their friction: what is
        // left of `M a = tau + pushes` is rounding.
        let branches = Branches::new(vec![None, Some(0), Some(1), Some(0), Some(3)]);
        let rows = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [0.3, 0.4, 0.0, 0.0, 0.0],
            [0.1, 0.15, 0.1, 0.0, 0.0],
            [-0.3, 0.0, 0.0, 0.4, 0.0],
            [-0.1, 0.0, 0.0, 0.15, 0.1],
        ];
        let inertia: Vec<f64> = rows.into_iter().flatten().collect();
        let mut yielding = Yielding::new(vec![limits(); 5]);
        let mut draw = 1_u32;
        for _ in 0..2000 {
            let mut next = |spread: f64| {
                draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                spread * (f64::from(draw >> 8) / f64::from(1 << 24) - 0.5)
            };
            let torques_nm: [f64; 5] = std::array::from_fn(|_| next(1.0));
            let states: [(f64, f64); 5] = std::array::from_fn(|_| (next(0.004), next(0.2)));
            let mut pushed_nm = torques_nm;
            yielding.renew();
            assert!(yielding.push(&branches, &inertia, |joint| states[joint], &mut pushed_nm));
            let taken_nm = branches.product(&inertia, &yielding.accelerations);
            for (taken, pushed) in taken_nm.iter().zip(pushed_nm) {
                assert!((taken - pushed).abs() < 1e-9, "{taken} {pushed}");
            }
        }
    }

    #[test]
    fn a_stop_pushes_back_and_never_holds() {
        let (push_nm, _) = alone(0.002, 0.0, 0.3);
        assert!(push_nm < -0.2, "{push_nm}");
        // Well inside, or on the way back faster than the stop wants: friction alone.
        assert!((alone(-0.1, 0.0, -0.3).0 - 0.01).abs() < 1e-12);
        assert!((alone(1e-4, -1.0, -0.3).0 - 0.01).abs() < 1e-12);
    }
}
