//! How people move: along waypoints, to a robot, after it, and what they do when it comes near.
//!
//! A person is a point with a heading. It turns towards where it wants to go at a limited rate and
//! changes its speed at a limited acceleration. Each update covers one period of the scene's
//! `people_hz`.
//!
//! A waypoint at which the person stays, the last or one with a pause, is walked to no faster than the person can still stop at it, `d` away:
//! `v = min(sqrt(2 a d + (a T / 2)^2) - a T / 2, d / T)` in updates of the length `T`. It is reached when the person stands there. One that
//! is only passed counts as reached from nearby.

mod company;
mod replay;

use replay::Replay;

pub(super) use company::{PersonSeen, Surroundings};

use stimulus::Distribution;

use super::data::{Activity, ArmAngles, ArmPose, Hesitation, Person, PersonBody, ReactionKind};
use super::draws::Draws;
use super::person::{Arms, Stance};

/// Nearer than this a waypoint counts as reached: one that is passed, or one at which the person stands.
const REACHED_M: f64 = 0.15;
/// Nearer than this a person stops.
const AT_IT_M: f64 = 1e-3;
/// Slower than this a person stands.
const STANDS_M_S: f64 = 0.01;
/// How far a person who approaches stays from the robot's root, beyond the person's own radius.
const TOUCHING_M: f64 = 0.3;
/// How far behind a person follows.
const BEHIND_M: f64 = 1.0;
/// A robot is away again beyond this multiple of the distance at which the person reacts.
const AWAY: f64 = 1.2;

/// What a person sees of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RobotSeen {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) yaw_rad: f64,
}

/// The numbers of a person that an episode draws.
#[derive(Debug, Clone, PartialEq)]
struct Drawn {
    acceleration_m_s2: f64,
    turn_rate_rad_s: f64,
    radius_m: f64,
    waypoints: Vec<(f64, f64, f64)>,
    reaction: Option<(ReactionKind, f64, f64, f64)>,
    /// How the arms are held while reacting.
    reaction_arms: Option<ArmPose>,
    arm_rate_rad_s: f64,
    /// Arms that reach, carry, withdraw.
    arms: [Arms; 3],
    /// How far the person keeps clear of people and of robots.
    clear_m: Option<[f64; 2]>,
}

/// When a person stands still on the way.
#[derive(Debug, Clone)]
struct Hesitating {
    data: Hesitation,
    key: String,
    draws: Draws,
    /// How many there were, and when the next one begins and ends.
    count: u64,
    next_secs: [f64; 2],
}

impl Hesitating {
    fn new(data: &Hesitation, person: &str, draws: Draws) -> Self {
        let mut new = Self {
            data: data.clone(),
            key: super::data::key_of("person", person, "hesitation"),
            draws,
            count: 0,
            next_secs: [0.0; 2],
        };
        new.plan(0.0);
        new
    }

    /// The next one, counted from a time.
    fn plan(&mut self, from_secs: f64) {
        let (key, count) = (&self.key, self.count);
        let drawn = |field: &str, of: &Distribution| {
            self.draws.number(&format!("{key}.{count}.{field}"), of)
        };
        let begins_secs = from_secs + drawn("every_secs", &self.data.every_secs);
        self.next_secs = [
            begins_secs,
            begins_secs + drawn("lasts_secs", &self.data.lasts_secs),
        ];
        self.count += 1;
    }

    /// Whether the person stands still now.
    fn holds(&mut self, now_secs: f64) -> bool {
        while now_secs >= self.next_secs[1] {
            self.plan(self.next_secs[1]);
        }
        now_secs >= self.next_secs[0]
    }
}

impl Drawn {
    fn arms(&self, pose: ArmPose) -> Arms {
        match pose {
            ArmPose::Swing => Arms::SWINGING,
            ArmPose::Reach => self.arms[0],
            ArmPose::Carry => self.arms[1],
            ArmPose::Withdraw => self.arms[2],
        }
    }
}

/// A person in an episode.
#[derive(Debug, Clone)]
pub(super) struct Walker {
    pub(super) body: PersonBody,
    pub(super) stance: Stance,
    pub(super) activity: Activity,
    pub(super) distracted: bool,
    /// The speed that the person walks at when nothing hinders.
    pub(super) walking_m_s: f64,
    pub(super) velocity_m_s: [f64; 2],
    /// How the arms are held when nothing is reacted to.
    arms: ArmPose,
    again: bool,
    /// The number of the person's group.
    group: Option<usize>,
    hesitating: Option<Hesitating>,
    drawn: Drawn,
    next: usize,
    pause_until_secs: f64,
    near_since_secs: Option<f64>,
    reacting: bool,
    aside_m: Option<[f64; 2]>,
    /// The recording that is replayed in place of walking.
    replay: Option<Replay>,
}

impl Walker {
    /// The person at the beginning of an episode.
    pub(super) fn new(person: &Person, radius_m: f64, draws: Draws) -> Self {
        let drawn = |field: &str, d: &Distribution| draws.of("person", &person.name, field, d);
        let waypoint = |(index, point): (usize, &super::data::Waypoint)| {
            let of = |field: &str, d: &Distribution| drawn(&format!("waypoint.{index}.{field}"), d);
            (
                of("x_m", &point.x_m),
                of("y_m", &point.y_m),
                of("pause_secs", &point.pause_secs),
            )
        };
        let reaction = person.reaction.as_ref().map(|reaction| {
            (
                reaction.kind,
                drawn("reaction.within_m", &reaction.within_m),
                drawn("reaction.delay_secs", &reaction.delay_secs),
                drawn("reaction.aside_m", &reaction.aside_m),
            )
        });
        let held = |name: &str, angles: &ArmAngles| {
            let of = |field: &str, d: &Distribution| drawn(&format!("{name}.{field}"), d);
            Arms::held(
                of("shoulder_rad", &angles.shoulder_rad),
                of("elbow_rad", &angles.elbow_rad),
            )
        };
        let numbers = Drawn {
            acceleration_m_s2: drawn("acceleration_m_s2", &person.acceleration_m_s2),
            turn_rate_rad_s: drawn("turn_rate_rad_s", &person.turn_rate_rad_s),
            radius_m,
            waypoints: person.waypoints.iter().enumerate().map(waypoint).collect(),
            reaction,
            reaction_arms: person.reaction.as_ref().and_then(|reaction| reaction.arms),
            arm_rate_rad_s: drawn("arm_rate_rad_s", &person.arm_rate_rad_s),
            arms: [
                held("reach", &person.reach),
                held("carry", &person.carry),
                held("withdraw", &person.withdraw),
            ],
            clear_m: person.avoidance.as_ref().map(|avoidance| {
                [
                    drawn("avoidance.people_m", &avoidance.people_m),
                    drawn("avoidance.robots_m", &avoidance.robots_m),
                ]
            }),
        };
        let probability = drawn("distracted_probability", &person.distracted_probability);
        let name = format!("person.{}.is_distracted", person.name);
        let mut walker = Self {
            body: person.body,
            stance: Stance {
                x_m: drawn("x_m", &person.x_m),
                y_m: drawn("y_m", &person.y_m),
                heading_rad: drawn("heading_rad", &person.heading_rad),
                speed_m_s: 0.0,
                walked_m: 0.0,
                arms: numbers.arms(person.arms),
                hand: None,
                figure: None,
            },
            arms: person.arms,
            activity: person.activity,
            distracted: draws.stream(&name).chance(probability),
            walking_m_s: drawn("speed_m_s", &person.speed_m_s),
            velocity_m_s: [0.0; 2],
            again: person.again,
            group: None,
            hesitating: person
                .hesitation
                .as_ref()
                .map(|it| Hesitating::new(it, &person.name, draws)),
            drawn: numbers,
            next: 0,
            pause_until_secs: 0.0,
            near_since_secs: None,
            reacting: false,
            aside_m: None,
            replay: None,
        };
        walker.replay = Replay::new(person, &walker.stance, draws);
        if let Some(replay) = &walker.replay {
            walker.stance = replay.stance(&walker.stance);
        }
        walker
    }

    /// The same in a group.
    pub(super) fn in_group(self, group: Option<usize>) -> Self {
        Self { group, ..self }
    }

    /// Whether the last waypoint has been reached, or the recording is over.
    pub(super) fn has_arrived(&self) -> bool {
        if let Some(replay) = &self.replay {
            return replay.is_over();
        }
        !self.drawn.waypoints.is_empty() && self.next >= self.drawn.waypoints.len()
    }

    /// Whether the person reacts to a robot.
    pub(super) fn is_reacting(&self) -> bool {
        self.reacting
    }

    /// Changes how the arms are held.
    pub(super) fn hold_arms(&mut self, arms: ArmPose) {
        self.arms = arms;
    }

    /// Draws what is still to be drawn under another seed.
    pub(super) fn draw_anew(&mut self, draws: Draws) {
        if let Some(hesitating) = &mut self.hesitating {
            hesitating.draws = draws;
        }
    }

    /// Moves on by `period_secs`.
    pub(super) fn update(&mut self, now_secs: f64, period_secs: f64, around: Surroundings<'_>) {
        if self.replay.is_some() {
            return self.replay_on(now_secs, period_secs);
        }
        let nearest = self.nearest(around.robots);
        self.notice(now_secs, nearest);
        self.move_arms(period_secs);
        let (mut goal, mut speed_m_s) = self.wish(now_secs, period_secs, nearest);
        let hesitates = |it: &mut Hesitating| it.holds(now_secs);
        if self.hesitating.as_mut().is_some_and(hesitates) {
            (goal, speed_m_s) = (None, 0.0);
        }
        if let Some(goal) = goal.filter(|_| self.aside_m.is_some() && self.reacting) {
            return self.sidestep(goal, speed_m_s, period_secs);
        }
        if let Some(there) = goal.filter(|_| self.drawn.clear_m.is_some() || self.group.is_some()) {
            let is_after_robots = matches!(self.activity, Activity::Approach | Activity::Follow);
            let (toward, wished) =
                self.among_others(there, speed_m_s, around, is_after_robots || self.reacting);
            (goal, speed_m_s) = (Some(toward), wished);
        }
        self.walk(goal, speed_m_s, period_secs);
    }

    /// A push of more than the balance moves the person along it: at walking speed from twice the balance on.
    pub(super) fn step_back(&mut self, newtons: [f64; 2], balance_newtons: f64, secs: f64) {
        let size = newtons[0].hypot(newtons[1]);
        if size <= balance_newtons {
            return;
        }
        let share = ((size - balance_newtons) / balance_newtons).min(1.0);
        let speed_m_s = share * self.walking_m_s;
        let [x_m_s, y_m_s] = newtons.map(|part| part / size * speed_m_s);
        self.stance.x_m += x_m_s * secs;
        self.stance.y_m += y_m_s * secs;
        if let Some(replay) = &mut self.replay {
            replay.shift([x_m_s * secs, y_m_s * secs]);
        }
        self.velocity_m_s = [self.velocity_m_s[0] + x_m_s, self.velocity_m_s[1] + y_m_s];
    }

    /// Arms go where they are wanted, at their rate.
    fn move_arms(&mut self, period_secs: f64) {
        let reacting = self.drawn.reaction_arms.filter(|_| self.reacting);
        let goal = self.drawn.arms(reacting.unwrap_or(self.arms));
        let most_rad = self.drawn.arm_rate_rad_s * period_secs;
        self.stance.arms = self.stance.arms.towards(goal, most_rad);
    }

    fn nearest(&self, robots: &[RobotSeen]) -> Option<(RobotSeen, f64)> {
        let distance = |robot: &RobotSeen| self.distance_m([robot.x_m, robot.y_m]);
        robots
            .iter()
            .map(|robot| (*robot, distance(robot)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn distance_m(&self, [x_m, y_m]: [f64; 2]) -> f64 {
        (x_m - self.stance.x_m).hypot(y_m - self.stance.y_m)
    }

    /// Begins or ends a reaction.
    fn notice(&mut self, now_secs: f64, nearest: Option<(RobotSeen, f64)>) {
        let (Some((kind, within_m, delay_secs, aside_m)), Some((robot, distance_m))) =
            (self.drawn.reaction, nearest)
        else {
            return;
        };
        if self.distracted || distance_m > AWAY * within_m {
            self.near_since_secs = None;
            self.reacting = false;
            self.aside_m = None;
        } else if distance_m <= within_m {
            let since_secs = *self.near_since_secs.get_or_insert(now_secs);
            if !self.reacting && now_secs - since_secs >= delay_secs {
                self.reacting = true;
                if kind == ReactionKind::StepsAside {
                    self.aside_m = Some(self.beside(robot, aside_m));
                }
            }
        }
    }

    /// The point `aside_m` away from the line on which the robot faces, on the person's side of it.
    fn beside(&self, robot: RobotSeen, aside_m: f64) -> [f64; 2] {
        let (sine, cosine) = robot.yaw_rad.sin_cos();
        let [dx, dy] = [self.stance.x_m - robot.x_m, self.stance.y_m - robot.y_m];
        let left_m = dy * cosine - dx * sine;
        let side = if left_m >= 0.0 { aside_m } else { -aside_m };
        [
            self.stance.x_m - side * sine,
            self.stance.y_m + side * cosine,
        ]
    }

    /// Where the person wants to go, and how fast.
    fn wish(
        &mut self,
        now_secs: f64,
        period_secs: f64,
        nearest: Option<(RobotSeen, f64)>,
    ) -> (Option<[f64; 2]>, f64) {
        let stand = (None, 0.0);
        let kind = self.drawn.reaction.filter(|_| self.reacting).map(|r| r.0);
        let activity = match kind {
            Some(ReactionKind::Stops) => return stand,
            Some(ReactionKind::StepsAside) => return (self.aside_m, self.walking_m_s),
            Some(ReactionKind::Approaches) => Activity::Approach,
            Some(ReactionKind::Yields | ReactionKind::GoesOn) | None => self.activity,
        };
        let haste = if kind == Some(ReactionKind::Yields) {
            0.5
        } else {
            1.0
        };
        let speed_m_s = haste * self.walking_m_s;
        let towards = |keep_m: f64| match nearest {
            Some((robot, distance_m)) if distance_m > keep_m => {
                (Some([robot.x_m, robot.y_m]), speed_m_s)
            }
            _ => stand,
        };
        match activity {
            Activity::Stand => stand,
            Activity::Approach => towards(self.drawn.radius_m + TOUCHING_M),
            Activity::Follow => towards(self.drawn.radius_m + BEHIND_M),
            Activity::Walk => match self.waypoint(now_secs) {
                Some(goal) if self.stays_at(self.next) => {
                    let most_m_s = self.stoppable_m_s(self.distance_m(goal), period_secs);
                    (Some(goal), speed_m_s.min(most_m_s))
                }
                Some(goal) => (Some(goal), speed_m_s),
                None => stand,
            },
        }
    }

    /// The waypoint to walk to, none while pausing or after the last.
    fn waypoint(&mut self, now_secs: f64) -> Option<[f64; 2]> {
        if now_secs < self.pause_until_secs {
            return None;
        }
        let (x_m, y_m, pause_secs) = *self.drawn.waypoints.get(self.next)?;
        let left_m = self.distance_m([x_m, y_m]);
        let stands = self.stance.speed_m_s <= STANDS_M_S;
        if left_m > REACHED_M || (self.stays_at(self.next) && !stands) {
            return Some([x_m, y_m]).filter(|_| left_m > AT_IT_M);
        }
        self.next += 1;
        if self.again && self.next == self.drawn.waypoints.len() {
            self.next = 0;
        }
        self.pause_until_secs = now_secs + pause_secs;
        None
    }

    /// Whether the person stays at a waypoint, and does not just pass it.
    fn stays_at(&self, waypoint: usize) -> bool {
        let is_last = waypoint + 1 == self.drawn.waypoints.len() && !self.again;
        let pauses = self.drawn.waypoints.get(waypoint);
        is_last || pauses.is_some_and(|(_, _, pause_secs)| *pause_secs > 0.0)
    }

    /// The speed from which the person can still stop within a distance.
    fn stoppable_m_s(&self, left_m: f64, period_secs: f64) -> f64 {
        let acceleration_m_s2 = self.drawn.acceleration_m_s2;
        let half_m_s = acceleration_m_s2 * period_secs / 2.0;
        let braking_m_s =
            (2.0 * acceleration_m_s2 * left_m + half_m_s * half_m_s).sqrt() - half_m_s;
        braking_m_s.min(left_m / period_secs)
    }

    /// Turns towards the goal and walks forwards, slower while it is aside.
    fn walk(&mut self, goal: Option<[f64; 2]>, speed_m_s: f64, period_secs: f64) {
        let mut wanted_m_s = 0.0;
        if let Some([x_m, y_m]) = goal {
            let bearing_rad = (y_m - self.stance.y_m).atan2(x_m - self.stance.x_m);
            let error_rad = wrapped(bearing_rad - self.stance.heading_rad);
            let most_rad = self.drawn.turn_rate_rad_s * period_secs;
            self.stance.heading_rad =
                wrapped(self.stance.heading_rad + error_rad.clamp(-most_rad, most_rad));
            wanted_m_s = speed_m_s * error_rad.cos().max(0.0);
        }
        self.accelerate(wanted_m_s, period_secs);
        let (sine, cosine) = self.stance.heading_rad.sin_cos();
        self.go([cosine, sine], period_secs);
    }

    /// Moves without turning.
    fn sidestep(&mut self, [x_m, y_m]: [f64; 2], speed_m_s: f64, period_secs: f64) {
        let left_m = self.distance_m([x_m, y_m]);
        // No faster than it can still stop.
        let most_m_s = (2.0 * self.drawn.acceleration_m_s2 * left_m).sqrt();
        self.accelerate(speed_m_s.min(most_m_s), period_secs);
        let speed = self.stance.speed_m_s.min(left_m / period_secs);
        self.stance.speed_m_s = speed;
        let direction = if left_m > 0.0 {
            [
                (x_m - self.stance.x_m) / left_m,
                (y_m - self.stance.y_m) / left_m,
            ]
        } else {
            [0.0; 2]
        };
        self.go(direction, period_secs);
    }

    fn accelerate(&mut self, wanted_m_s: f64, period_secs: f64) {
        let most_m_s = self.drawn.acceleration_m_s2 * period_secs;
        let change = wanted_m_s - self.stance.speed_m_s;
        self.stance.speed_m_s += change.clamp(-most_m_s, most_m_s);
    }

    fn go(&mut self, direction: [f64; 2], period_secs: f64) {
        self.velocity_m_s = direction.map(|part| part * self.stance.speed_m_s);
        self.stance.x_m += self.velocity_m_s[0] * period_secs;
        self.stance.y_m += self.velocity_m_s[1] * period_secs;
        self.stance.walked_m += self.stance.speed_m_s * period_secs;
    }
}

/// An angle in [-π, π).
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(text: &str) -> Person {
        toml::from_str(&format!("name = \"p\"\nx_m = 0.0\ny_m = 0.0\n{text}")).unwrap()
    }

    fn walker(text: &str) -> Walker {
        Walker::new(&person(text), 0.2, Draws { seed: 1 })
    }

    fn run(walker: &mut Walker, secs: f64, robot: Option<RobotSeen>) {
        let robots: Vec<RobotSeen> = robot.into_iter().collect();
        run_all(std::slice::from_mut(walker), secs, &robots);
    }

    fn run_all(walkers: &mut [Walker], secs: f64, robots: &[RobotSeen]) {
        for step in 0..(secs * 100.0) as u32 {
            let people: Vec<PersonSeen> = walkers.iter().map(Walker::seen).collect();
            for (own, walker) in walkers.iter_mut().enumerate() {
                let around = Surroundings {
                    robots,
                    people: &people,
                    own,
                };
                walker.update(f64::from(step) / 100.0, 0.01, around);
            }
        }
    }

    #[test]
    fn waypoints_are_reached_in_the_time_that_speed_and_acceleration_give() {
        let mut p = walker(
            "speed_m_s = 1.0\nacceleration_m_s2 = 2.0\nwaypoint = [{ x_m = 4.0, y_m = 0.0 }]",
        );
        // 0.5 s and 0.25 m to walk, 3.5 s and 3.5 m at 1 m/s, 0.5 s and 0.25 m to stop: 4.5 s.
        run(&mut p, 4.4, None);
        assert!(!p.has_arrived() && p.stance.speed_m_s > 0.1);
        let mut p = walker(
            "speed_m_s = 1.0\nacceleration_m_s2 = 2.0\nwaypoint = [{ x_m = 4.0, y_m = 0.0 }]",
        );
        run(&mut p, 4.6, None);
        assert!(p.has_arrived(), "{:?}", p.stance);
        assert!(p.stance.speed_m_s < 1e-9 && (p.stance.x_m - 4.0).abs() < 2e-3);
    }

    #[test]
    fn who_pauses_stands_at_the_waypoint_and_who_passes_one_does_not_slow_down() {
        let text = |pause: &str| {
            format!(
                "speed_m_s = 1.4\nacceleration_m_s2 = 1.5\nwaypoint = [{{ x_m = 3.0, y_m = 0.0{pause} }}, {{ x_m = 6.0, y_m = 0.0 }}]"
            )
        };
        let slowest = |pause: &str| {
            let mut p = walker(&text(pause));
            let (mut slowest, mut at) = (f64::INFINITY, 0.0);
            for step in 0..600 {
                let people = [p.seen()];
                let around = Surroundings {
                    robots: &[],
                    people: &people,
                    own: 0,
                };
                p.update(f64::from(step) / 100.0, 0.01, around);
                if p.stance.x_m > 1.0
                    && !p.has_arrived()
                    && p.stance.speed_m_s < slowest
                    && p.stance.x_m < 5.0
                {
                    (slowest, at) = (p.stance.speed_m_s, p.stance.x_m);
                }
            }
            (slowest, at)
        };
        let (standing, at) = slowest(", pause_secs = 1.0");
        assert!(
            standing < 1e-9 && (at - 3.0).abs() < 2e-3,
            "{standing} at {at}"
        );
        // One update in which the next waypoint is chosen costs 15 mm/s.
        let (passing, _) = slowest("");
        assert!(passing > 1.38, "{passing}");
    }

    #[test]
    fn who_stops_stops_after_the_delay_and_who_is_distracted_does_not() {
        let text = "speed_m_s = 1.0\nwaypoint = [{ x_m = 9.0, y_m = 0.0 }]\nreaction = { kind = \"stops\", within_m = 2.0, delay_secs = 0.5 }";
        let robot = RobotSeen {
            x_m: 5.0,
            y_m: 0.0,
            yaw_rad: std::f64::consts::PI,
        };
        let mut attentive = walker(text);
        run(&mut attentive, 10.0, Some(robot));
        assert!(attentive.is_reacting() && attentive.stance.speed_m_s == 0.0);
        assert!((3.4..4.0).contains(&attentive.stance.x_m));
        let mut distracted = walker(&format!("distracted_probability = 1.0\n{text}"));
        run(&mut distracted, 10.0, Some(robot));
        assert!(distracted.has_arrived());
    }

    #[test]
    fn who_steps_aside_leaves_the_robots_line() {
        let text = "activity = \"stand\"\nreaction = { kind = \"steps_aside\", within_m = 3.0, aside_m = 0.6 }";
        let mut p = walker(text);
        run(
            &mut p,
            5.0,
            Some(RobotSeen {
                x_m: 2.0,
                y_m: -0.1,
                yaw_rad: std::f64::consts::PI,
            }),
        );
        assert!((p.stance.y_m - 0.6).abs() < 1e-6, "{}", p.stance.y_m);
        assert!(p.stance.speed_m_s.abs() < 1e-6);
    }

    #[test]
    fn arms_withdraw_from_a_robot_at_their_rate_and_swing_again_when_it_is_gone() {
        let text = "activity = \"stand\"\nbody = \"articulated\"\narms = \"reach\"\narm_rate_rad_s = 2.0\nreaction = { kind = \"goes_on\", within_m = 1.0, delay_secs = 0.0, arms = \"withdraw\" }";
        let robot = |x_m: f64| RobotSeen {
            x_m,
            y_m: 0.0,
            yaw_rad: 0.0,
        };
        let mut p = walker(text);
        run(&mut p, 1.0, Some(robot(3.0)));
        assert_eq!(p.stance.arms, Arms::held(1.3, 0.2));
        // From 1.3 to -0.6 rad at 2 rad/s: half a second is not enough, one is.
        run(&mut p, 0.5, Some(robot(0.8)));
        assert!(
            (p.stance.arms.upper_rad - (-1.3 + 1.0)).abs() < 1e-9,
            "{:?}",
            p.stance.arms
        );
        run(&mut p, 0.6, Some(robot(0.8)));
        assert!(p.is_reacting());
        let (now, goal) = (p.stance.arms, Arms::held(-0.6, 2.2));
        assert!((now.upper_rad - goal.upper_rad).abs() < 1e-9);
        assert!((now.fore_rad - goal.fore_rad).abs() < 1e-9);
        p.hold_arms(ArmPose::Swing);
        run(&mut p, 2.0, Some(robot(3.0)));
        assert!((p.stance.arms.swing - 1.0).abs() < 1e-9 && !p.is_reacting());
        assert!((p.stance.arms.fore_rad + 0.2).abs() < 1e-9);
    }

    #[test]
    fn who_approaches_stops_at_the_robot() {
        let mut p = walker("activity = \"approach\"\nspeed_m_s = 1.0");
        run(
            &mut p,
            10.0,
            Some(RobotSeen {
                x_m: 0.0,
                y_m: 3.0,
                yaw_rad: 0.0,
            }),
        );
        assert!((p.stance.y_m - 2.5).abs() < 0.35, "{}", p.stance.y_m);
        assert_eq!(p.stance.speed_m_s, 0.0);
    }

    /// Two who meet head-on pass each other on the right; without avoidance they walk through each other.
    #[test]
    fn who_keeps_clear_passes_who_comes_along() {
        let nearest = |avoidance: &str| {
            let of = |from: f64, to: f64| {
                walker(&format!(
                    "speed_m_s = 1.2\nheading_rad = {:?}\n{avoidance}waypoint = [{{ x_m = {to:?}, y_m = 0.0 }}]",
                    if to > from { 0.0 } else { std::f64::consts::PI }
                ))
            };
            let mut both = [of(0.0, 8.0), of(8.0, 0.0)];
            both[1].stance.x_m = 8.0;
            let mut least = f64::INFINITY;
            for step in 0..1500 {
                let people: Vec<PersonSeen> = both.iter().map(Walker::seen).collect();
                for (own, one) in both.iter_mut().enumerate() {
                    let around = Surroundings {
                        robots: &[],
                        people: &people,
                        own,
                    };
                    one.update(f64::from(step) / 100.0, 0.01, around);
                }
                let [a, b] = [both[0].stance, both[1].stance];
                least = least.min((a.x_m - b.x_m).hypot(a.y_m - b.y_m));
                if step == 320 && !avoidance.is_empty() {
                    assert!(a.y_m < 0.0 && b.y_m > 0.0, "{} {}", a.y_m, b.y_m);
                }
            }
            assert!(both.iter().all(Walker::has_arrived), "{both:?}");
            least - 0.4
        };
        assert!(nearest("") < 0.0);
        let clear_m = nearest("avoidance = { people_m = 0.4 }\n");
        assert!(clear_m > 0.1, "{clear_m}");
    }

    #[test]
    fn who_keeps_clear_walks_around_a_standing_robot() {
        let robot = RobotSeen {
            x_m: 3.0,
            y_m: 0.05,
            yaw_rad: 0.0,
        };
        let mut p =
            walker("speed_m_s = 1.2\navoidance = {}\nwaypoint = [{ x_m = 6.0, y_m = 0.0 }]");
        let mut least = f64::INFINITY;
        for step in 0..1500 {
            let people = [p.seen()];
            let around = Surroundings {
                robots: &[robot],
                people: &people,
                own: 0,
            };
            p.update(f64::from(step) / 100.0, 0.01, around);
            least = least.min(p.distance_m([robot.x_m, robot.y_m]));
        }
        assert!(p.has_arrived() && least > 0.5, "{least}");
    }

    #[test]
    fn a_group_waits_for_who_is_slow() {
        let of = |speed: f64, y: f64| {
            let mut one = walker(&format!(
                "speed_m_s = {speed:?}\nwaypoint = [{{ x_m = 20.0, y_m = {y:?} }}]"
            ));
            one.stance.y_m = y;
            one
        };
        let apart = |group: Option<usize>| {
            let mut both = [of(1.5, 0.0), of(0.8, 0.6)];
            for one in &mut both {
                one.group = group;
            }
            run_all(&mut both, 10.0, &[]);
            both[0].stance.x_m - both[1].stance.x_m
        };
        assert!(apart(None) > 6.0, "{}", apart(None));
        assert!(apart(Some(0)) < 3.0, "{}", apart(Some(0)));
    }

    #[test]
    fn who_hesitates_stands_still_at_the_drawn_times() {
        let mut p = walker(
            "speed_m_s = 1.0\nacceleration_m_s2 = 100.0\nhesitation = { every_secs = 2.0, lasts_secs = 1.0 }\nwaypoint = [{ x_m = 50.0, y_m = 0.0 }]",
        );
        run(&mut p, 9.0, None);
        // Two seconds of three.
        assert!((p.stance.x_m - 6.0).abs() < 0.1, "{}", p.stance.x_m);
    }
}
