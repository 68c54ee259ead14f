//! The human: enacts an abstract test, moves head and hand, pulls, and takes the object.
//!
//! Head and hand are moved along given paths; on the object the human acts by force alone. While
//! pulling, that force grows over the onset to its drawn value and lasts for the pull's duration.
//! Once the robot's hand opens, or the object has come along by more than the length of a pull, the
//! human's hand holds on: a damped spring to where the grip was (limited in force) and a damped
//! spring that keeps the object's attitude.

use testbench::Stream;
use testbench::geometry::{
    IDENTITY, Pose, Quaternion, Vector, about, add, cross, norm, rotate, rotation_between, scale,
    subtract,
};

use super::plant::ObjectState;
use crate::scenario::{
    AbstractTest, Human as Body, HumanDraws, HumanParameters, HumanSignal, RobotSignal,
};

/// What the human sees and hears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct View {
    pub(crate) now_secs: f64,
    /// The announcement is being or has been made.
    pub(crate) announced: bool,
    /// The robot's hand is opening to hand over.
    pub(crate) robot_lets_go: bool,
    pub(crate) object: Pose,
}

/// What is drawn for the human in an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Draws {
    head_m: Vector,
    yaw_error_rad: f64,
    yaw_error_when_away_rad: f64,
    pull_newtons: Vector,
}

impl Draws {
    fn draw(body: &Body, draws: &HumanDraws, stream: &mut Stream) -> Self {
        let mut head_m = body.head_position_m;
        head_m[2] += draws.head_height_offset_m.draw(stream);
        Self {
            head_m,
            yaw_error_rad: draws.yaw_error_rad.draw(stream),
            yaw_error_when_away_rad: draws.yaw_error_when_away_rad.draw(stream),
            pull_newtons: [
                draws.pull_forward_newtons.draw(stream),
                0.0,
                draws.pull_up_newtons.draw(stream),
            ],
        }
    }
}

/// A force and torque on the object, world frame, at its centre of mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Wrench {
    pub(crate) force_newtons: Vector,
    pub(crate) torque_nm: Vector,
}

/// The hand's way from one place to another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reach {
    from_m: Vector,
    to_m: Vector,
    began_secs: f64,
}

/// The human in one episode.
#[derive(Debug, Clone)]
pub(crate) struct Human {
    body: Body,
    test: AbstractTest,
    draws: Draws,
    timing: Stream,
    next_action: usize,
    act_at_secs: Option<f64>,
    waiting_since_secs: f64,
    given_up: bool,
    applied: HumanParameters,
    activated: bool,
    ready: bool,
    reach: Reach,
    hand_is_out: bool,
    has_pulled: bool,
    pull_began_secs: Option<f64>,
    pulled_from_m: Option<Vector>,
    held: Option<Pose>,
    last_object_m: Vector,
}

impl Human {
    pub(crate) fn new(
        body: &Body,
        test: &AbstractTest,
        draws: &HumanDraws,
        stream: &mut Stream,
        timing: Stream,
    ) -> Self {
        let rest = body.hand_rest_m;
        Self {
            body: body.clone(),
            test: test.clone(),
            draws: Draws::draw(body, draws, stream),
            timing,
            next_action: 0,
            act_at_secs: None,
            waiting_since_secs: 0.0,
            given_up: false,
            applied: HumanParameters::default(),
            activated: false,
            ready: false,
            reach: Reach {
                from_m: rest,
                to_m: rest,
                began_secs: 0.0,
            },
            hand_is_out: false,
            has_pulled: false,
            pull_began_secs: None,
            pulled_from_m: None,
            held: None,
            last_object_m: rest,
        }
    }

    /// Draws anew what has had no effect yet: the pull if it never began, the errors of gaze if gaze
    /// was never applied, and the delays to come. One that is already running stays.
    pub(crate) fn draw_anew(&mut self, draws: &HumanDraws, stream: &mut Stream, timing: Stream) {
        let anew = Draws::draw(&self.body, draws, stream);
        let mut drawn = Draws {
            head_m: self.draws.head_m,
            ..anew
        };
        if self.has_pulled {
            drawn.pull_newtons = self.draws.pull_newtons;
        }
        if self.applied.gaze.is_some() {
            drawn.yaw_error_rad = self.draws.yaw_error_rad;
            drawn.yaw_error_when_away_rad = self.draws.yaw_error_when_away_rad;
        }
        self.draws = drawn;
        self.timing = timing;
    }

    /// Lets the human look, act and move.
    pub(crate) fn update(&mut self, view: &View) {
        self.last_object_m = view.object.position_m;
        self.act(view);
        self.move_hand(view);
        self.hold(view);
    }

    /// "activate" has been sent.
    pub(crate) fn activated(&self) -> bool {
        self.activated
    }

    /// "ready" has been sent.
    pub(crate) fn ready(&self) -> bool {
        self.ready
    }

    /// What the abstract test has the human apply now: gaze, pressure, location.
    pub(crate) fn applied(&self) -> [bool; 3] {
        [
            self.applied.gaze,
            self.applied.pressure,
            self.applied.location,
        ]
        .map(|parameter| parameter == Some(true))
    }

    /// Whether the human has stopped waiting for a signal that did not come.
    pub(crate) fn has_given_up(&self) -> bool {
        self.given_up
    }

    /// Whether the human holds the object.
    pub(crate) fn holds_object(&self) -> bool {
        self.held.is_some()
    }

    /// The pull at `now_secs`, in newtons, world frame.
    pub(crate) fn pull_newtons(&self, now_secs: f64) -> Vector {
        let Some(began) = self.pull_began_secs else {
            return [0.0; 3];
        };
        let since = now_secs - began;
        if since > self.body.pull_secs || self.held.is_some() || !self.hand_is_out {
            return [0.0; 3];
        }
        scale(
            (since / self.body.pull_onset_secs).clamp(0.0, 1.0),
            self.draws.pull_newtons,
        )
    }

    /// Where the centre of the hand is: on the way of the last movement, by minimum jerk (Flash
    /// and Hogan 1985).
    pub(crate) fn hand_m(&self, now_secs: f64) -> Vector {
        let Reach {
            from_m,
            to_m,
            began_secs,
        } = self.reach;
        let t = ((now_secs - began_secs) / self.body.reach_secs).clamp(0.0, 1.0);
        let share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        add(from_m, scale(share, subtract(to_m, from_m)))
    }

    /// The head, its x axis along the face. Looking at the object turns it there, but for an error;
    /// before that the human looks straight at the robot.
    pub(crate) fn head(&self) -> Pose {
        let head_m = self.draws.head_m;
        let to_object = subtract(self.last_object_m, head_m);
        let towards_rad = to_object[1].atan2(to_object[0]);
        let yaw_rad = match self.applied.gaze {
            None => std::f64::consts::PI,
            Some(true) => towards_rad + self.draws.yaw_error_rad,
            Some(false) => towards_rad + self.draws.yaw_error_when_away_rad,
        };
        Pose {
            position_m: head_m,
            orientation: about([0.0, 0.0, 1.0], yaw_rad),
        }
    }

    /// Carries out the actions whose time has come.
    fn act(&mut self, view: &View) {
        while !self.given_up && self.next_action < self.test.actions.len() {
            let action = self.test.actions[self.next_action].clone();
            let timing = &mut self.timing;
            let at = *self
                .act_at_secs
                .get_or_insert_with(|| view.now_secs + action.after_secs.draw(timing));
            if view.now_secs + 1e-9 < at {
                return;
            }
            if action.receive_signal == Some(RobotSignal::Announcement) && !view.announced {
                self.given_up = view.now_secs - self.waiting_since_secs >= self.body.patience_secs;
                return;
            }
            match action.send_signal {
                Some(HumanSignal::Activate) => self.activated = true,
                Some(HumanSignal::Ready) => self.ready = true,
                None => {}
            }
            if let Some(parameters) = action.set_param {
                self.apply(parameters, view.now_secs);
            }
            self.next_action += 1;
            self.act_at_secs = None;
            self.waiting_since_secs = view.now_secs;
        }
    }

    fn apply(&mut self, parameters: HumanParameters, now_secs: f64) {
        self.applied = HumanParameters {
            gaze: parameters.gaze.or(self.applied.gaze),
            pressure: parameters.pressure.or(self.applied.pressure),
            location: parameters.location.or(self.applied.location),
        };
        match parameters.pressure {
            Some(true) => {
                self.pull_began_secs = Some(now_secs);
                self.has_pulled = true;
            }
            Some(false) => self.pull_began_secs = None,
            None => {}
        }
    }

    /// Starts a movement of the hand when it should be elsewhere. A dropped object is left alone.
    fn move_hand(&mut self, view: &View) {
        let reachable = view.object.position_m[2] >= self.body.reach_lowest_object_m;
        let wanted_out = self.applied.location == Some(true) && (reachable || self.held.is_some());
        if wanted_out == self.hand_is_out {
            return;
        }
        self.hand_is_out = wanted_out;
        let to_m = if wanted_out {
            add(view.object.position_m, self.body.hand_on_object_m)
        } else {
            self.body.hand_rest_m
        };
        self.reach = Reach {
            from_m: self.hand_m(view.now_secs),
            to_m,
            began_secs: view.now_secs,
        };
    }

    /// Takes hold of the object when the robot lets go of it, or when it comes along with the pull,
    /// and the hand is there.
    fn hold(&mut self, view: &View) {
        if norm(self.pull_newtons(view.now_secs)) == 0.0 {
            self.pulled_from_m = None;
        } else if self.pulled_from_m.is_none() {
            self.pulled_from_m = Some(view.object.position_m);
        }
        let came_along = self.pulled_from_m.is_some_and(|from_m| {
            norm(subtract(view.object.position_m, from_m)) > self.body.pull_travel_m
        });
        let arrived = view.now_secs - self.reach.began_secs >= self.body.reach_secs;
        let let_go = view.robot_lets_go && self.hand_is_out && arrived;
        if self.held.is_none() && (let_go || came_along) {
            self.held = Some(view.object);
        }
    }

    /// Whether the hand does anything to the object, so that [`Human::wrench`] is worth asking.
    pub(crate) fn acts_on_object(&self) -> bool {
        self.held.is_some() || self.pull_began_secs.is_some()
    }

    /// What the hand does to the object at `now_secs`.
    pub(crate) fn wrench(&self, now_secs: f64, object: &ObjectState) -> Wrench {
        let Some(held) = self.held else {
            let force_newtons = self.pull_newtons(now_secs);
            let lever = rotate(object.pose.orientation, [0.0, 0.0, self.body.pull_line_m]);
            return Wrench {
                force_newtons,
                torque_nm: cross(lever, force_newtons),
            };
        };
        let away = subtract(held.position_m, object.pose.position_m);
        let force = add(
            scale(self.body.hold_stiffness_n_m, away),
            scale(-self.body.hold_damping_ns_m, object.velocity_m_s),
        );
        let turned = rotation_between(object.pose.orientation, held.orientation);
        let torque_nm = add(
            scale(self.body.hold_torque_nm_rad, turned),
            scale(-self.body.hold_torque_damping_nms_rad, object.spin_rad_s),
        );
        Wrench {
            force_newtons: limited(force, self.body.hold_limit_newtons),
            torque_nm,
        }
    }
}

/// The vector, shortened to `limit` if it is longer.
fn limited(vector: Vector, limit: f64) -> Vector {
    let length = norm(vector);
    if length > limit {
        scale(limit / length, vector)
    } else {
        vector
    }
}

/// The attitude of a hand that does not turn.
pub(crate) const HAND_ATTITUDE: Quaternion = IDENTITY;

#[cfg(test)]
mod tests;
