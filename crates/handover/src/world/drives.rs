//! The embedded joint drives: they turn a target into a setpoint that moves smoothly.
//!
//! Each joint follows a trapezoidal speed profile of its own: with distance `d` to go, the wanted
//! speed is `sign(d) min(v, sqrt(2 a |d|))`, approached with at most the acceleration `a`. The
//! setpoint goes to the joint's position servo in the physics engine at every time step.

/// The setpoint of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Setpoint {
    position_rad: f64,
    speed_rad_s: f64,
}

impl Setpoint {
    /// How fast it moves.
    pub(crate) fn speed_rad_s(&self) -> f64 {
        self.speed_rad_s
    }

    /// A setpoint at rest.
    pub(crate) fn at(position_rad: f64) -> Self {
        Self {
            position_rad,
            speed_rad_s: 0.0,
        }
    }

    /// Where the servo is sent now.
    pub(crate) fn position_rad(&self) -> f64 {
        self.position_rad
    }

    /// Moves on by one time step towards `target_rad`.
    pub(crate) fn advance(&mut self, target_rad: f64, limits: Limits, time_step_secs: f64) {
        let to_go = target_rad - self.position_rad;
        let change = limits.acceleration_rad_s2 * time_step_secs;
        if to_go.abs() <= change * time_step_secs && self.speed_rad_s.abs() <= change {
            *self = Self::at(target_rad);
            return;
        }
        // Braking is judged one step ahead, else a joint would overshoot by a step's way; the last
        // stretch, shorter than that step, is taken in proportion to what is left.
        let braking = (2.0 * limits.acceleration_rad_s2 * to_go.abs()).sqrt() - change;
        let speed = braking.max(to_go.abs() / (4.0 * time_step_secs) * f64::from(braking <= 0.0));
        let wanted = to_go.signum() * speed.min(limits.speed_rad_s);
        self.speed_rad_s += (wanted - self.speed_rad_s).clamp(-change, change);
        self.position_rad += self.speed_rad_s * time_step_secs;
    }
}

/// How fast a setpoint may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Largest speed.
    pub(crate) speed_rad_s: f64,
    /// Largest acceleration.
    pub(crate) acceleration_rad_s2: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        speed_rad_s: 0.26,
        acceleration_rad_s2: 1.0,
    };

    #[test]
    fn a_move_takes_the_time_of_the_trapezoid_and_stops_at_its_target() {
        // Distance 1: v / a to speed up and to brake, (d - v² / a) / v between: d / v + v / a.
        let mut setpoint = Setpoint::at(0.2);
        let (mut steps, mut fastest) = (0, 0.0_f64);
        while setpoint != Setpoint::at(1.2) && steps < 10_000 {
            setpoint.advance(1.2, LIMITS, 0.002);
            fastest = fastest.max(setpoint.speed_rad_s.abs());
            assert!(setpoint.position_rad() <= 1.2 + 1e-9, "overshoot");
            steps += 1;
        }
        let expected_secs = 1.0 / 0.26 + 0.26;
        assert!(
            (f64::from(steps) * 0.002 - expected_secs).abs() < 0.03,
            "{steps} steps"
        );
        assert!(fastest <= 0.26 + 1e-12);
    }
}
