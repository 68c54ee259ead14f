//! Compares the fast physics with the full one, episode by episode with the same seeds: how the
//! episodes end, and how far hand and object are apart.
//!
//! `cargo run --release -p corroborate-handover --example fast_against_full -- tuned 100 [first seed]`
//!
//! For every way an episode can end it prints how many show it in each physics, in how many only one
//! of them does, and the exact p of McNemar's test ("Note on the sampling error of the difference
//! between correlated proportions or percentages", Psychometrika 12, 1947): with `b` and `c`
//! discordant episodes, twice the lower tail of a binomial of `b + c` and 1/2 at the smaller of
//! them, at most 1. With `FULL_NUDGED=1e-9` the full physics with its object displaced by that many
//! metres takes the place of the fast one, which says what differences mean nothing.

use std::path::Path;

use handover::robot::{Decision, State};
use handover::{Episode, Parameters, Scenario, World, run_episode};
use testbench::{Cancel, Distribution, Engine};
use trace::Trace;

type Test = fn(&Episode) -> bool;

/// The ways an episode can end.
const ENDS: [(&str, Test); 8] = [
    ("success", |it| it.outcome.success),
    ("crashed", |it| it.outcome.crashed),
    ("grip failure", |it| it.outcome.grip_failure),
    ("gaze missed", |it| it.outcome.gaze_ok == Some(false)),
    ("pressure missed", |it| {
        it.outcome.pressure_ok == Some(false)
    }),
    ("location missed", |it| {
        it.outcome.location_ok == Some(false)
    }),
    ("released", |it| it.outcome.decision == Decision::Release),
    ("reset above 0.25 m/s", |it| {
        it.outcome.reset_peak_speed_m_s >= 0.25
    }),
];

/// Distances between two physics: largest, sum of squares, number.
#[derive(Debug, Clone, Copy, Default)]
struct Apart {
    most: f64,
    squares: f64,
    count: f64,
}

impl Apart {
    fn take(&mut self, distance: f64) {
        self.most = self.most.max(distance);
        self.squares += distance * distance;
        self.count += 1.0;
    }

    fn print(&self, what: &str, unit: f64, name: &str) {
        let rms = (self.squares / self.count.max(1.0)).sqrt();
        println!(
            "{what:<34} at most {:.4} {name}, root mean square {:.4} {name}",
            self.most * unit,
            rms * unit
        );
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = arguments.first().map_or("tuned", String::as_str);
    let count: u64 = arguments.get(1).map_or(Ok(20), |text| text.parse())?;
    let first: u64 = arguments.get(2).map_or(Ok(1), |text| text.parse())?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = root.join("case-studies/handover/simulation");
    let scenario = std::fs::read_to_string(folder.join("scenario.toml"))?;
    let parameters = std::fs::read_to_string(folder.join(format!("{set}.toml")))?;
    let engine = Engine::load(&root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0"))?;
    let world = |fast: bool, displaced_m: f64| -> Result<World, Box<dyn std::error::Error>> {
        let mut scenario = Scenario::parse(&scenario)?;
        scenario.simulation.fast = fast;
        let mut parameters = Parameters::parse(&parameters)?;
        match &mut parameters.object.x_error_m {
            Distribution::Constant(value) => *value += displaced_m,
            Distribution::Uniform { uniform } => {
                uniform.iter_mut().for_each(|it| *it += displaced_m)
            }
            Distribution::Normal { normal } => normal[0] += displaced_m,
        }
        Ok(World::new(&engine, &scenario, &parameters)?)
    };
    let nudge_m = std::env::var("FULL_NUDGED");
    let nudge_m = nudge_m.ok().map(|text| text.parse()).transpose()?;
    let full = world(false, 0.0)?;
    let other = world(nudge_m.is_none(), nudge_m.unwrap_or(0.0))?;
    let mut episodes = Vec::new();
    let (mut hand, mut speed) = (Apart::default(), Apart::default());
    let (mut held, mut placed) = (Apart::default(), Apart::default());
    for seed in first..first + count {
        let pair = [&full, &other].map(|world| run_episode(world, seed, &Cancel::default()));
        let [a, b] = pair;
        let (a, b) = (a?, b?);
        compare(&a, &b, [&mut hand, &mut speed, &mut held, &mut placed]);
        episodes.push((a, b));
    }
    print_ends(&episodes);
    hand.print("hand, until it grasps", 1e3, "mm");
    speed.print("hand's speed, until it grasps", 1e3, "mm/s");
    placed.print("object, until it is grasped", 1e3, "mm");
    held.print("object in the hand, until released", 1e3, "mm");
    Ok(())
}

/// Takes in the distances of one pair; once the robots' states differ, moments are not comparable.
fn compare(a: &Episode, b: &Episode, [hand, speed, held, placed]: [&mut Apart; 4]) {
    let grasp = State::NAMES
        .iter()
        .position(|(state, _)| *state == State::Grasp);
    let release = State::NAMES
        .iter()
        .position(|(state, _)| *state == State::Release);
    let (Some(grasp), Some(release)) = (grasp, release) else {
        return;
    };
    let [states_a, states_b] = [a, b].map(|it| rows(&it.trace, "/robot", &["state"]));
    let fields = ["hand.x", "hand.y", "hand.z", "hand_speed"];
    let [hands_a, hands_b] = [a, b].map(|it| rows(&it.trace, "/robot", &fields));
    let fields = ["object.x", "object.y", "object.z", "in_hand"];
    let [objects_a, objects_b] = [a, b].map(|it| rows(&it.trace, "/truth", &fields));
    for (index, (state_a, state_b)) in states_a.iter().zip(&states_b).enumerate() {
        let (hand_a, hand_b) = (&hands_a[index], &hands_b[index]);
        let (object_a, object_b) = (&objects_a[index], &objects_b[index]);
        if state_a != state_b || state_a[0] >= release as f64 {
            continue;
        }
        if state_a[0] < grasp as f64 {
            hand.take(apart(hand_a, hand_b));
            speed.take((hand_a[3] - hand_b[3]).abs());
            placed.take(apart(object_a, object_b));
        } else if object_a[3] == 1.0 && object_b[3] == 1.0 {
            // As it lies in the hand: the hands' own difference left out.
            let own = |object: &[f64], hand: &[f64]| [0, 1, 2].map(|i| object[i] - hand[i]);
            held.take(apart(&own(object_a, hand_a), &own(object_b, hand_b)));
        }
    }
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Some fields of a topic, row by row; empty if it lacks one.
fn rows(trace: &Trace, topic: &str, fields: &[&str]) -> Vec<Vec<f64>> {
    let Some(channel) = trace.channel(topic) else {
        return Vec::new();
    };
    let places: Vec<usize> = (fields.iter())
        .filter_map(|field| channel.field_index(field))
        .collect();
    let rows = channel.values.chunks(channel.fields.len());
    rows.map(|row| places.iter().map(|place| row[*place]).collect())
        .collect()
}

fn print_ends(episodes: &[(Episode, Episode)]) {
    println!(
        "{} pairs               full other  only full  only other      p",
        episodes.len()
    );
    for (name, test) in ENDS {
        let count = |wanted: fn(bool, bool) -> bool| {
            let hits = episodes.iter().filter(|(a, b)| wanted(test(a), test(b)));
            hits.count() as u32
        };
        let (only_full, only_other) = (count(|a, b| a && !b), count(|a, b| b && !a));
        println!(
            "{name:<24} {:>5} {:>5} {only_full:>10} {only_other:>11} {:>6.3}",
            count(|a, _| a),
            count(|_, b| b),
            mcnemar(only_full, only_other)
        );
    }
    let seconds = |part: fn(&(Episode, Episode)) -> f64| episodes.iter().map(part).sum::<f64>();
    println!(
        "{:.0} and {:.0} s simulated",
        seconds(|it| it.0.sim_secs),
        seconds(|it| it.1.sim_secs)
    );
}

/// The exact p of McNemar's test.
fn mcnemar(b: u32, c: u32) -> f64 {
    let (number, fewer) = (b + c, b.min(c));
    let mut term = 0.5_f64.powi(number as i32);
    let mut tail = term;
    for k in 0..fewer {
        term *= f64::from(number - k) / f64::from(k + 1);
        tail += term;
    }
    (2.0 * tail).min(1.0)
}
