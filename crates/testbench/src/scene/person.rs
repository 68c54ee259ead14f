//! A person's body: one capsule, or limbs that are moved as the person walks.
//!
//! The lengths of the limbs are the usual fractions of the height (R. Drillis, R. Contini, "Body
//! segment parameters", 1966): shoulders at 0.818, hips at 0.530, upper arm 0.186, forearm with hand
//! 0.254, half the breadth of shoulders 0.129 and of hips 0.0955, head centred at 0.935. Legs and
//! arms swing as pendulums with the stride, opposite arms with opposite legs; knees do not bend and
//! feet slide a little. Arms that reach, carry or withdraw go to declared angles of shoulder and elbow at
//! a limited rate. That is enough for what sees or touches a person; it is no model of gait.
//!
//! A compliant person has the trunk in two parts and hands (hand 0.108 of the height, forearm without it 0.146), and each part is a
//! body with a mass that is held at its place ([`super::compliant`]).

use super::build::BuiltPerson;
use super::capture::Figure;
use super::compliant::Compliant;
use super::data::{Person, PersonBody};
use super::draws::Draws;
use super::walker::Walker;
use crate::geometry::{
    IDENTITY, Pose, Quaternion, Vector, about, add, compose, cross, dot, from_roll_pitch_yaw, norm,
    rotate, scale, subtract,
};
use crate::physics::{BodyPlan, Form, Layout, Motion, ShapePlan, Surface, Touches};

/// A person's surface: skin and clothes.
const FRICTION: f64 = 0.6;
/// How far below the middle of a forearm the hand ends, for a height of 1.
pub(super) const HAND_BELOW_FOREARM: f64 = 0.127;
/// Lengths of a forearm without the hand, and of a hand, for a height of 1.
const FOREARM: f64 = 0.146;
const HAND: f64 = 0.108;
/// Length of a stride (two steps) for a height of 1.
const STRIDE: f64 = 0.8;
/// Largest angle of the legs at 1.4 m/s, and of the arms.
const LEG_SWING_RAD: f64 = 0.42;
const ARM_SWING_RAD: f64 = 0.35;

/// Where and how a person is, as far as the body shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stance {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
    pub(super) speed_m_s: f64,
    /// Distance walked.
    pub(super) walked_m: f64,
    pub(super) arms: Arms,
    /// Where a hand is that is at something.
    pub(super) hand: Option<HandAt>,
    /// Where the points of the body are, of one who is replayed.
    pub(super) figure: Option<Figure>,
}

/// A hand that goes its own way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HandAt {
    /// 0 is the left one.
    pub(super) side: usize,
    /// Where its end is, in the world, as far as the arm reaches.
    pub(super) at_m: Vector,
}

/// How both arms are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arms {
    /// How much they swing with the stride, 0 to 1.
    pub(super) swing: f64,
    /// Turns of upper arm and forearm about the person's y axis; negative is forwards, 0 hangs.
    pub(super) upper_rad: f64,
    pub(super) fore_rad: f64,
}

impl Arms {
    /// Arms that swing; elbows are never quite straight.
    pub(super) const SWINGING: Self = Self {
        swing: 1.0,
        upper_rad: 0.0,
        fore_rad: -0.2,
    };

    /// Arms that are held at these angles of shoulder and elbow.
    pub(super) fn held(shoulder_rad: f64, elbow_rad: f64) -> Self {
        Self {
            swing: 0.0,
            upper_rad: -shoulder_rad,
            fore_rad: -(shoulder_rad + elbow_rad),
        }
    }

    /// Arms on their way to `goal`, each joint by at most `most_rad`.
    pub(super) fn towards(self, goal: Self, most_rad: f64) -> Self {
        if self == goal {
            return self;
        }
        let step = |now: f64, then: f64| now + (then - now).clamp(-most_rad, most_rad);
        let upper_rad = step(self.upper_rad, goal.upper_rad);
        let elbow_rad = step(
            self.fore_rad - self.upper_rad,
            goal.fore_rad - goal.upper_rad,
        );
        Self {
            swing: step(self.swing, goal.swing),
            upper_rad,
            fore_rad: upper_rad + elbow_rad,
        }
    }
}

/// A limb between two joints in the person's frame (x forwards, y left, z up from the floor).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Limb {
    centre_m: Vector,
    /// Turn about the person's y axis; 0 hangs straight down.
    pitch_rad: f64,
}

/// Adds the bodies and shapes of a person. What is led stands at the origin until it is led; what is held, where it begins.
pub(super) fn body_of(
    layout: &mut Layout,
    person: &Person,
    draws: Draws,
    group: u8,
) -> BuiltPerson {
    let drawn = |field: &str, distribution| draws.of("person", &person.name, field, distribution);
    let height_m = drawn("height_m", &person.height_m);
    let radius_m = drawn("radius_m", &person.radius_m).min(height_m / 2.0 - 1e-3);
    let (first_body, first_shape) = (layout.bodies.len(), layout.shapes.len());
    let at_origin = Pose {
        position_m: [0.0; 3],
        orientation: IDENTITY,
    };
    let parts = parts_of(person.body, height_m, radius_m);
    let compliant = (person.body == PersonBody::Compliant)
        .then(|| Compliant::new(person, &parts, (first_body, first_shape), draws));
    let stance = Walker::new(person, radius_m, draws).stance;
    let poses = poses_of(person.body, height_m, &stance);
    for (place, (part, form)) in parts.into_iter().enumerate() {
        let held = compliant.as_ref().map(|it| it.inertia(place));
        layout.bodies.push(BodyPlan {
            name: format!("{}/{part}", person.name),
            parent: None,
            pose: held.map_or(at_origin, |_| poses[place]),
            motion: held.map_or(Motion::Led, |_| Motion::Free),
            inertia: held,
        });
        layout.shapes.push(ShapePlan {
            name: format!("{}/{part}", person.name),
            body: Some(layout.bodies.len() - 1),
            pose: at_origin,
            form,
            friction: FRICTION,
            touches: Touches::AllButGroup(group),
            surface: Surface::default(),
        });
    }
    BuiltPerson {
        bodies: first_body..layout.bodies.len(),
        shapes: first_shape..layout.shapes.len(),
        height_m,
        radius_m,
        compliant,
    }
}

/// Names and forms of the parts; poses come in the same order.
fn parts_of(body: PersonBody, height_m: f64, radius_m: f64) -> Vec<(&'static str, Form)> {
    let capsule = |radius_m: f64, length_m: f64| Form::Capsule { radius_m, length_m };
    match body {
        PersonBody::Capsule => vec![("body", capsule(radius_m, height_m - 2.0 * radius_m))],
        PersonBody::Articulated => {
            let trunk_m = ((0.818 - 0.53) * height_m - 0.5 * radius_m).max(0.01);
            let leg = capsule(0.045 * height_m, (0.53 - 0.09) * height_m);
            let upper = capsule(0.026 * height_m, 0.186 * height_m);
            let fore = capsule(0.022 * height_m, 0.254 * height_m);
            let trunk = vec![("trunk", capsule(0.75 * radius_m, trunk_m))];
            with_limbs(trunk, height_m, [leg, upper, fore])
        }
        PersonBody::Compliant => compliant_parts(height_m, radius_m),
    }
}

/// The same with a trunk of two parts and with hands. Legs end above the floor, as nothing but the person's balance holds them.
fn compliant_parts(height_m: f64, radius_m: f64) -> Vec<(&'static str, Form)> {
    let capsule = |radius_m: f64, length_m: f64| Form::Capsule {
        radius_m,
        length_m: (length_m - 2.0 * radius_m).max(0.01),
    };
    let trunk = capsule(0.75 * radius_m, 0.144 * height_m + 0.75 * radius_m);
    let leg = capsule(0.045 * height_m, 0.51 * height_m);
    let upper = capsule(0.026 * height_m, 0.238 * height_m);
    let fore = capsule(0.022 * height_m, FOREARM * height_m + 0.022 * height_m);
    let hand = capsule(0.02 * height_m, HAND * height_m);
    let trunk = vec![("chest", trunk.clone()), ("abdomen", trunk)];
    let mut parts = with_limbs(trunk, height_m, [leg, upper, fore]);
    parts.extend([("left_hand", hand.clone()), ("right_hand", hand)]);
    parts
}

/// A trunk with the head, and with legs, upper arms and forearms of these forms.
fn with_limbs(
    trunk: Vec<(&'static str, Form)>,
    height_m: f64,
    [leg, upper, fore]: [Form; 3],
) -> Vec<(&'static str, Form)> {
    let radius_m = 0.065 * height_m;
    let mut parts = trunk;
    parts.extend([
        ("head", Form::Sphere { radius_m }),
        ("left_leg", leg.clone()),
        ("right_leg", leg),
        ("left_upper_arm", upper.clone()),
        ("right_upper_arm", upper),
        ("left_forearm", fore.clone()),
        ("right_forearm", fore),
    ]);
    parts
}

/// The poses of the parts, in the world.
pub(super) fn poses_of(body: PersonBody, height_m: f64, stance: &Stance) -> Vec<Pose> {
    if let Some(figure) = stance.figure.filter(|_| body.has_arms()) {
        return poses_of_figure(body, height_m, &figure);
    }
    let heading = from_roll_pitch_yaw([0.0, 0.0, stance.heading_rad]);
    let foot_m = [stance.x_m, stance.y_m, 0.0];
    let mut poses: Vec<Pose> = limbs_of(body, height_m, stance)
        .into_iter()
        .map(|limb| Pose {
            position_m: add(foot_m, rotate(heading, limb.centre_m)),
            orientation: compose(heading, about([0.0, 1.0, 0.0], limb.pitch_rad)),
        })
        .collect();
    if let Some(hand) = stance.hand.filter(|_| body == PersonBody::Articulated) {
        stretch(&mut poses, height_m, stance, hand);
    }
    poses
}

/// Bends an arm so that its hand is somewhere, or as far that way as it reaches; the elbow hangs down.
fn stretch(poses: &mut [Pose], height_m: f64, stance: &Stance, hand: HandAt) {
    let heading = from_roll_pitch_yaw([0.0, 0.0, stance.heading_rad]);
    let shoulder = shoulder_of(height_m, stance, hand.side);
    let (upper_m, fore_m) = (0.186 * height_m, 0.254 * height_m);
    let way = subtract(hand.at_m, shoulder);
    let along = direction(way).unwrap_or([0.0, 0.0, -1.0]);
    let reach_m = norm(way).clamp(1.01 * (fore_m - upper_m), 0.999 * (fore_m + upper_m));
    let down = subtract([0.0, 0.0, -1.0], scale(-along[2], along));
    let down = direction(down).unwrap_or_else(|| rotate(heading, [-1.0, 0.0, 0.0]));
    let cosine =
        (upper_m * upper_m + reach_m * reach_m - fore_m * fore_m) / (2.0 * upper_m * reach_m);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let bent = add(scale(cosine, along), scale(sine, down));
    let elbow = add(shoulder, scale(upper_m, bent));
    let end = add(shoulder, scale(reach_m, along));
    poses[hand_of(hand.side) - 2] = limb(heading, shoulder, elbow, 0.093 * height_m);
    poses[hand_of(hand.side)] = limb(heading, elbow, end, 0.127 * height_m);
}

/// A limb from one joint towards another, its middle so far along.
fn limb(heading: Quaternion, from: Vector, to: Vector, below_m: f64) -> Pose {
    let along = direction(subtract(to, from)).unwrap_or([0.0, 0.0, -1.0]);
    Pose {
        position_m: add(from, scale(below_m, along)),
        orientation: compose(shortest([0.0, 0.0, -1.0], along), heading),
    }
}

/// Where a shoulder is, in the world; side 0 is the left one.
pub(super) fn shoulder_of(height_m: f64, stance: &Stance, side: usize) -> Vector {
    let heading = from_roll_pitch_yaw([0.0, 0.0, stance.heading_rad]);
    let across = if side == 0 { 0.129 } else { -0.129 };
    let own = [0.0, across * height_m, 0.8 * height_m];
    add([stance.x_m, stance.y_m, 0.0], rotate(heading, own))
}

/// Where the end of a hand is that carries something before the chest.
pub(super) fn resting_hand(height_m: f64, stance: &Stance, side: usize) -> Vector {
    let rests = Stance {
        arms: Arms::held(0.2, 1.4),
        hand: None,
        speed_m_s: 0.0,
        ..*stance
    };
    let pose = &poses_of(PersonBody::Articulated, height_m, &rests)[hand_of(side)];
    let below_m = HAND_BELOW_FOREARM * height_m;
    add(
        pose.position_m,
        rotate(pose.orientation, [0.0, 0.0, -below_m]),
    )
}

/// The part of an articulated person that has a hand: the forearm; side 0 is the left one.
pub(super) fn hand_of(side: usize) -> usize {
    6 + side
}

/// The poses of the parts of one who is replayed: limbs begin at their upper points and lead to their lower ones.
fn poses_of_figure(body: PersonBody, height_m: f64, figure: &Figure) -> Vec<Pose> {
    let heading = from_roll_pitch_yaw([0.0, 0.0, figure.heading_rad()]);
    let [
        head,
        left_shoulder,
        right_shoulder,
        left_elbow,
        right_elbow,
        rest @ ..,
    ] = figure.points_m;
    let [
        left_hand,
        right_hand,
        left_hip,
        right_hip,
        left_foot,
        right_foot,
    ] = rest;
    let (hips, shoulders) = (figure.hips_m(), figure.shoulders_m());
    let limb = |from: Vector, to: Vector, below: f64| limb(heading, from, to, below * height_m);
    let up = direction(subtract(shoulders, hips)).unwrap_or([0.0, 0.0, 1.0]);
    let trunk = |share: f64| Pose {
        position_m: add(hips, scale(share, subtract(shoulders, hips))),
        orientation: compose(shortest([0.0, 0.0, 1.0], up), heading),
    };
    let is_compliant = body == PersonBody::Compliant;
    let mut poses = match is_compliant {
        true => vec![trunk(0.75), trunk(0.25)],
        false => vec![trunk(0.5)],
    };
    poses.push(Pose {
        position_m: head,
        orientation: heading,
    });
    poses.push(limb(left_hip, left_foot, 0.265));
    poses.push(limb(right_hip, right_foot, 0.265));
    poses.push(limb(left_shoulder, left_elbow, 0.093));
    poses.push(limb(right_shoulder, right_elbow, 0.093));
    let fore = match is_compliant {
        true => vec![FOREARM / 2.0, FOREARM + HAND / 2.0],
        false => vec![0.127],
    };
    for below in fore {
        poses.push(limb(left_elbow, left_hand, below));
        poses.push(limb(right_elbow, right_hand, below));
    }
    poses
}

/// A vector of length 1 along another, unless that has no length.
fn direction(vector: Vector) -> Option<Vector> {
    let length = norm(vector);
    (length > 1e-9).then(|| scale(1.0 / length, vector))
}

/// The shortest turn that takes one direction to another.
fn shortest(from: Vector, to: Vector) -> Quaternion {
    let (cosine, [x, y, z]) = (dot(from, to), cross(from, to));
    if cosine < -1.0 + 1e-12 {
        return about([1.0, 0.0, 0.0], std::f64::consts::PI);
    }
    let w = 1.0 + cosine;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    [w / length, x / length, y / length, z / length]
}

/// Where an articulated person's hands are, in the world: the ends of the forearms.
pub(super) fn hands_of(body: PersonBody, height_m: f64, stance: &Stance) -> Option<[Vector; 2]> {
    let poses = poses_of(body, height_m, stance);
    let [.., left, right] = poses.as_slice() else {
        return None;
    };
    let end = |pose: &Pose| {
        let along = rotate(pose.orientation, [0.0, 0.0, -HAND_BELOW_FOREARM * height_m]);
        add(pose.position_m, along)
    };
    (body == PersonBody::Articulated).then(|| [end(left), end(right)])
}

/// The end of a compliant person's hand.
pub(super) fn hand_end(pose: &Pose, height_m: f64) -> Vector {
    let along = rotate(pose.orientation, [0.0, 0.0, -HAND / 2.0 * height_m]);
    add(pose.position_m, along)
}

fn limbs_of(body: PersonBody, height_m: f64, stance: &Stance) -> Vec<Limb> {
    let upright = |x: f64, y: f64, z: f64| Limb {
        centre_m: [x * height_m, y * height_m, z * height_m],
        pitch_rad: 0.0,
    };
    if body == PersonBody::Capsule {
        return vec![upright(0.0, 0.0, 0.5)];
    }
    let phase = std::f64::consts::TAU * stance.walked_m / (STRIDE * height_m);
    let swing = phase.sin() * (stance.speed_m_s / 1.4).min(1.5);
    let hanging = |top: Vector, half: f64, pitch_rad: f64| Limb {
        centre_m: hang(top, half * height_m, pitch_rad),
        pitch_rad,
    };
    let hip = |side: f64| [0.0, side * 0.0955 * height_m, 0.53 * height_m];
    let leg = |side: f64| hanging(hip(side), 0.265, -side * swing * LEG_SWING_RAD);
    let is_compliant = body == PersonBody::Compliant;
    let mut limbs = match is_compliant {
        true => vec![upright(0.0, 0.0, 0.746), upright(0.0, 0.0, 0.602)],
        false => vec![upright(0.0, 0.0, 0.674)],
    };
    limbs.push(upright(0.0, 0.0, 0.935));
    limbs.extend([leg(1.0), leg(-1.0)]);
    let arms = [1.0, -1.0].map(|side| arm_of(side, height_m, swing, stance.arms));
    limbs.extend(arms.map(|[upper, ..]| upper));
    match is_compliant {
        true => {
            limbs.extend(arms.map(|[_, _, fore, _]| fore));
            limbs.extend(arms.map(|[_, _, _, hand]| hand));
        }
        false => limbs.extend(arms.map(|[_, whole, ..]| whole)),
    }
    limbs
}

/// Upper arm, forearm with the hand, forearm and hand of one side (1 left, -1 right).
fn arm_of(side: f64, height_m: f64, swing: f64, arms: Arms) -> [Limb; 4] {
    let shoulder_m = [0.0, side * 0.129 * height_m, 0.8 * height_m];
    let swing_rad = arms.swing * (side * swing * ARM_SWING_RAD);
    let (upper_rad, fore_rad) = (swing_rad + arms.upper_rad, swing_rad + arms.fore_rad);
    let (upper_m, fore_m) = (0.186 * height_m, 0.254 * height_m);
    let elbow_m = hang(shoulder_m, upper_m, upper_rad);
    let of_forearm = |below_m: f64| Limb {
        centre_m: hang(elbow_m, below_m, fore_rad),
        pitch_rad: fore_rad,
    };
    [
        Limb {
            centre_m: hang(shoulder_m, upper_m / 2.0, upper_rad),
            pitch_rad: upper_rad,
        },
        of_forearm(fore_m / 2.0),
        of_forearm(FOREARM * height_m / 2.0),
        of_forearm((FOREARM + HAND / 2.0) * height_m),
    ]
}

/// The point at `length_m` below `top` on a limb that is turned by `pitch_rad`.
fn hang(top: Vector, length_m: f64, pitch_rad: f64) -> Vector {
    add(
        top,
        rotate(about([0.0, 1.0, 0.0], pitch_rad), [0.0, 0.0, -length_m]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stance(arms: Arms) -> Stance {
        Stance {
            x_m: 2.0,
            y_m: 1.0,
            heading_rad: std::f64::consts::FRAC_PI_2,
            speed_m_s: 1.4,
            walked_m: 0.35,
            arms,
            hand: None,
            figure: None,
        }
    }

    #[test]
    fn hands_that_reach_are_ahead_at_shoulder_height() {
        let hands = hands_of(PersonBody::Articulated, 1.75, &stance(Arms::held(1.3, 0.2))).unwrap();
        for (hand, side) in hands.iter().zip([-1.0, 1.0]) {
            // Heading along y, so left is -x; the arm is 0.44 of the height long.
            assert!((hand[0] - (2.0 + side * 0.129 * 1.75)).abs() < 1e-12);
            assert!(hand[1] - 1.0 > 0.4 * 1.75 && hand[1] - 1.0 < 0.44 * 1.75);
            assert!((hand[2] - 0.8 * 1.75).abs() < 0.15);
        }
        assert_eq!(
            hands_of(PersonBody::Capsule, 1.75, &stance(Arms::held(1.3, 0.2))),
            None
        );
    }

    #[test]
    fn legs_swing_opposite_and_stay_on_the_hip() {
        let limbs = limbs_of(PersonBody::Articulated, 1.75, &stance(Arms::SWINGING));
        assert_eq!(
            limbs.len(),
            parts_of(PersonBody::Articulated, 1.75, 0.22).len()
        );
        assert!(limbs[2].pitch_rad * limbs[3].pitch_rad < 0.0);
        let top = hang(limbs[2].centre_m, -0.265 * 1.75, limbs[2].pitch_rad);
        assert!((top[2] - 0.53 * 1.75).abs() < 1e-12 && top[0].abs() < 1e-12);
    }
}
