//! Speed and separation monitoring: the robot keeps a protective distance from people.
//!
//! ISO/TS 15066:2016, 5.5.4, gives the protective separation distance as
//!
//! ```text
//! S_p = S_h + S_r + S_s + C + Z_d + Z_r
//! ```
//!
//! with `S_h = v_h (T_r + T_s)` what the person covers until the robot is at rest, `S_r = v_r T_r`
//! what the robot covers until it begins to brake, `S_s` what it covers while it brakes, `C` the
//! intrusion before a person is detected, and `Z_d`, `Z_r` the uncertainties of the positions of
//! person and robot. A person whose speed is not measured is taken to walk at 1.6 m/s.

use super::{Declaration, PERSON_DISTANCE, Template, parameter, proposition, quantity_in};

/// The terms of the protective separation distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationTerms {
    /// `v_h`: speed of the person towards the robot in m/s.
    pub person_speed_m_s: f64,
    /// `v_r`: speed of the robot towards the person in m/s.
    pub robot_speed_m_s: f64,
    /// `T_r`: time from detection to the beginning of braking in seconds.
    pub reaction_time_secs: f64,
    /// `T_s`: time from the beginning of braking to standstill in seconds.
    pub braking_time_secs: f64,
    /// `S_s`: distance covered while braking in metres.
    pub braking_distance_m: f64,
    /// `C`: intrusion before detection in metres.
    pub intrusion_m: f64,
    /// `Z_d`: uncertainty of the person's position in metres.
    pub person_uncertainty_m: f64,
    /// `Z_r`: uncertainty of the robot's position in metres.
    pub robot_uncertainty_m: f64,
}

/// The protective separation distance `S_p` in metres.
///
/// ```
/// use requirement_lang::library::{SeparationTerms, protective_separation_distance_m};
/// let terms = SeparationTerms {
///     person_speed_m_s: 1.6,
///     robot_speed_m_s: 1.0,
///     reaction_time_secs: 0.1,
///     braking_time_secs: 0.3,
///     braking_distance_m: 0.15,
///     intrusion_m: 0.2,
///     person_uncertainty_m: 0.05,
///     robot_uncertainty_m: 0.01,
/// };
/// // 0.64 m + 0.1 m + 0.15 m + 0.2 m + 0.05 m + 0.01 m
/// assert!((protective_separation_distance_m(&terms) - 1.15).abs() < 1e-12);
/// ```
#[must_use]
pub fn protective_separation_distance_m(terms: &SeparationTerms) -> f64 {
    let person = terms.person_speed_m_s * (terms.reaction_time_secs + terms.braking_time_secs);
    let robot = terms.robot_speed_m_s * terms.reaction_time_secs + terms.braking_distance_m;
    person + robot + terms.intrusion_m + terms.person_uncertainty_m + terms.robot_uncertainty_m
}

const REACTION_TIME: Declaration = parameter(
    "reaction_time",
    "0.1 s",
    ["0 s", "2 s"],
    "T_r: time from the detection of the person to the beginning of braking; of the sensors and the control",
);
const BRAKING_TIME: Declaration = parameter(
    "braking_time",
    "0.3 s",
    ["0 s", "5 s"],
    "T_s: time from the beginning of braking to standstill; from the robot's stopping data",
);
const BRAKING_DISTANCE: Declaration = parameter(
    "braking_distance",
    "0.15 m",
    ["0 m", "5 m"],
    "S_s: what the robot covers while it brakes from its greatest speed; from its stopping data",
);
const INTRUSION: Declaration = parameter(
    "intrusion_distance",
    "0.2 m",
    ["0 m", "2 m"],
    "C: how far a body part can intrude before it is detected; of the sensors and where they are",
);
const PERSON_UNCERTAINTY: Declaration = parameter(
    "person_uncertainty",
    "0.05 m",
    ["0 m", "1 m"],
    "Z_d: uncertainty of the person's measured position",
);
const ROBOT_UNCERTAINTY: Declaration = parameter(
    "robot_uncertainty",
    "0.01 m",
    ["0 m", "1 m"],
    "Z_r: uncertainty of the robot's position",
);

pub(super) const TEMPLATES: &[Template] = &[
    Template {
        id: "separation-constant",
        title: "Constant protective separation distance",
        standard: "ISO/TS 15066:2016, 5.5.4 (speed and separation monitoring)",
        notes: "Use the greatest distance that any speed of robot and person demands; the function \
                protective_separation_distance_m computes it.",
        sentence: "Whenever robot_moving, the robot shall immediately satisfy \
                   person_distance >= protective_distance",
        parameters: &[Declaration {
            name: "protective_distance",
            default: None,
            least: "0 m",
            most: "20 m",
            meaning: "S_p: the protective separation distance, computed for this robot and its sensors",
        }],
        needs: &[
            proposition(
                "robot_moving",
                "the robot carries out a motion that can hurt a person",
            ),
            PERSON_DISTANCE,
        ],
    },
    Template {
        id: "separation-walking-person",
        title: "Speed-dependent separation distance, person's speed not measured",
        standard: "ISO/TS 15066:2016, 5.5.4 (speed and separation monitoring)",
        notes: "The distance follows the robot's present speed; the person is taken to walk towards it.",
        sentence: "Whenever robot_moving, the robot shall immediately satisfy \
                   person_distance >= walking_speed * (reaction_time + braking_time) \
                   + robot_speed_to_person * reaction_time + braking_distance \
                   + intrusion_distance + person_uncertainty + robot_uncertainty",
        parameters: &[
            parameter(
                "walking_speed",
                "1.6 m/s",
                ["0 m/s", "3 m/s"],
                "v_h: speed of a person who is not measured; 1.6 m/s in the standard",
            ),
            REACTION_TIME,
            BRAKING_TIME,
            BRAKING_DISTANCE,
            INTRUSION,
            PERSON_UNCERTAINTY,
            ROBOT_UNCERTAINTY,
        ],
        needs: &[
            proposition(
                "robot_moving",
                "the robot carries out a motion that can hurt a person",
            ),
            PERSON_DISTANCE,
            quantity_in(
                "robot_speed_to_person",
                "m/s",
                "world",
                "speed of the robot's part nearest to the person, towards the person; 0 if it recedes",
            ),
        ],
    },
    Template {
        id: "separation-measured-person",
        title: "Speed-dependent separation distance, person's speed measured",
        standard: "ISO/TS 15066:2016, 5.5.4 (speed and separation monitoring)",
        notes: "As separation-walking-person, with the speed of the person as it is measured.",
        sentence: "Whenever robot_moving, the robot shall immediately satisfy \
                   person_distance >= person_speed_to_robot * (reaction_time + braking_time) \
                   + robot_speed_to_person * reaction_time + braking_distance \
                   + intrusion_distance + person_uncertainty + robot_uncertainty",
        parameters: &[
            REACTION_TIME,
            BRAKING_TIME,
            BRAKING_DISTANCE,
            INTRUSION,
            PERSON_UNCERTAINTY,
            ROBOT_UNCERTAINTY,
        ],
        needs: &[
            proposition(
                "robot_moving",
                "the robot carries out a motion that can hurt a person",
            ),
            PERSON_DISTANCE,
            quantity_in(
                "person_speed_to_robot",
                "m/s",
                "world",
                "speed of the person towards the robot; 0 if the person recedes",
            ),
            quantity_in(
                "robot_speed_to_person",
                "m/s",
                "world",
                "speed of the robot's part nearest to the person, towards the person; 0 if it recedes",
            ),
        ],
    },
];
