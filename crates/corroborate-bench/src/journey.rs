//! The corridor's journey, as its formal model describes it: a robot and a person on one line.
//!
//! With the probability of the first stage ("stray") somebody comes in the robot's way; with that of the second
//! ("distracted"), if so, somebody who does not make room. All else is decided, but for how soon an attentive person
//! makes room: after each step with probability 0.6. The rules are those of
//! `case-studies/corridor/models/corridor.prism`, whose steps count as the task's; the two are one by a test.

use crate::random::Random;
use crate::task::{Passed, Run, Task};
use prism_lang::edit;

/// The model.
const MODEL: &str = include_str!("../../../case-studies/corridor/models/corridor.prism");

/// The model's constants of the two stages.
pub const CONSTANTS: [&str; 2] = ["pStray", "pDistracted"];

/// The failure modes: what each means over the model's variables, and its opportunity.
pub const MODES: [(&str, &str, &str); 2] = [
    ("stray", "begun & stray", "begun"),
    ("distracted", "begun & !attentive", "begun & stray"),
];

/// In which states of the model the journey is done.
pub const DONE: &str = "robot>=goal";

/// The probability that an attentive person makes room in a step.
const LEAVES: f64 = 0.6;

/// More steps than any journey takes.
const MOST_STEPS: u32 = 200;

const GOAL: i32 = 67;

/// The model with the rates of `task`.
///
/// # Errors
/// What is wrong with the model's text.
pub fn model(task: &Task) -> Result<String, String> {
    let mut text = MODEL.to_owned();
    for (constant, stage) in CONSTANTS.iter().zip(&task.stages) {
        let tree = prism_lang::parse_model(&text).tree;
        let edits = edit::set_constant(&tree, constant, &stage.fails.to_string());
        let edits = edits.map_err(|error| error.to_string())?;
        text = edit::apply(&text, &edits).map_err(|error| error.to_string())?;
    }
    Ok(text)
}

/// One journey.
pub fn run(task: &Task, random: &mut Random) -> Run {
    let stray = random.chance(task.stages[0].fails);
    let distracted = stray && random.chance(task.stages[1].fails);
    let steps = steps(stray, distracted, &mut || random.chance(LEAVES));
    let mut passed = vec![Passed {
        place: 0,
        at: 1,
        failed: stray,
    }];
    if stray {
        passed.push(Passed {
            place: 1,
            at: 2,
            failed: distracted,
        });
    }
    Run {
        passed,
        done_at: Some(steps),
        speed: 0.0,
    }
}

/// The steps of a journey; `leaves` says whether an attentive person makes room now.
fn steps(mut stray: bool, distracted: bool, leaves: &mut dyn FnMut() -> bool) -> u32 {
    let (mut robot, mut speed, mut clear, mut person) = (0_i32, 0_i32, 0_i32, 77_i32);
    // The first step is who comes.
    let mut steps = 1;
    while robot < GOAL && steps < MOST_STEPS {
        let gap = person - robot;
        let ahead = stray && gap > 0;
        let wanted = match ahead {
            true if gap <= 8 => 0,
            true if gap <= 15 => 1,
            _ if clear > 0 => 1,
            _ => 3,
        };
        let next = match speed < wanted {
            true => speed + 1,
            false => wanted.max(speed - 2),
        };
        if ahead && !distracted && gap <= 17 {
            clear = if gap <= 15 { 2 } else { (clear - 1).max(0) };
            stray = !leaves();
        } else {
            clear = if ahead && gap <= 15 {
                2
            } else {
                (clear - 1).max(0)
            };
            person = (person - 4).max(-30);
        }
        robot = (robot + speed).min(70);
        speed = next;
        steps += 1;
    }
    steps
}

/// The probability that a journey takes more than `from` and at most `to` steps.
#[must_use]
pub fn done_between(task: &Task, from: u32, to: u32) -> f64 {
    let is_within = |steps: u32| from < steps && steps <= to;
    let weight = |steps: u32, weight: f64| if is_within(steps) { weight } else { 0.0 };
    let (stray, distracted) = (task.stages[0].fails, task.stages[1].fails);
    let mut sum = weight(steps(false, false, &mut || false), 1.0 - stray)
        + weight(steps(true, true, &mut || false), stray * distracted);
    let mut left = stray * (1.0 - distracted);
    // The person makes room when asked the n-th time.
    for n in 1..MOST_STEPS {
        let mut asked = 0;
        let taken = steps(true, false, &mut || {
            asked += 1;
            asked >= n
        });
        sum += weight(taken, LEAVES * left);
        left *= 1.0 - LEAVES;
    }
    sum
}
