//! Models of random trees against an interpreter that ticks them: exactly where all sequences of draws can be gone through,
//! else by simulation with an exact binomial test.

use std::collections::BTreeMap;

use behaviour_tree::{Conditions, Options, to_prism};

use crate::random::{Kinds, Random, Trees, text};
use crate::support::{reading, values};
use crate::ticks::{Status, Ticked, World, run};

/// Sequences of draws up to which a tree is gone through exactly.
const MOST_RUNS: usize = 3_000;
const MOST_DRAWS: usize = 300;

/// Chances of success, failure and skipped; of each leaf's having run, and having failed in its first execution.
#[derive(Default)]
struct Chances {
    ends: [f64; 3],
    leaves: BTreeMap<String, (f64, f64)>,
}

impl Chances {
    fn add(&mut self, status: Option<Status>, ran: &[(String, bool)], weight: f64) {
        match status {
            Some(Status::Success) => self.ends[0] += weight,
            Some(Status::Failure) => self.ends[1] += weight,
            Some(_) => self.ends[2] += weight,
            None => {}
        }
        let mut first: BTreeMap<&str, bool> = BTreeMap::new();
        for (name, value) in ran {
            first.entry(name).or_insert(*value);
        }
        for (name, value) in first {
            let of = self.leaves.entry(name.to_owned()).or_default();
            of.0 += weight;
            of.1 += if value { 0.0 } else { weight };
        }
    }
}

fn kept(conditions: Conditions) -> Option<BTreeMap<String, bool>> {
    (conditions == Conditions::Kept).then(BTreeMap::new)
}

/// Goes through all sequences of draws; `None` if they are too many.
fn exactly(
    tree: &Ticked,
    chances: &BTreeMap<String, f64>,
    conditions: Conditions,
) -> Option<Chances> {
    let mut found = Chances::default();
    let mut script: Vec<bool> = Vec::new();
    for _ in 0..MOST_RUNS {
        let mut world = World {
            chances,
            drawn: Vec::new(),
            choose: &mut |at, _| script.get(at).copied().unwrap_or(true),
            delay: &mut || 0,
            most_draws: MOST_DRAWS,
            kept: kept(conditions),
            ran: Vec::new(),
            ticks: 0,
        };
        let status = run(tree, &mut world)?;
        let weight = world.drawn.iter().map(|(_, chance)| chance).product();
        found.add(Some(status), &world.ran, weight);
        script = world.drawn.iter().map(|(value, _)| *value).collect();
        while script.last() == Some(&false) {
            script.pop();
        }
        match script.last_mut() {
            Some(last) => *last = false,
            None => return Some(found),
        }
    }
    None
}

fn simulated(
    tree: &Ticked,
    chances: &BTreeMap<String, f64>,
    conditions: Conditions,
    runs: usize,
    delays: usize,
) -> Chances {
    let mut found = Chances::default();
    let (mut random, mut timing) = (Random(7), Random(11));
    for _ in 0..runs {
        let mut world = World {
            chances,
            drawn: Vec::new(),
            choose: &mut |_, chance| random.is_below(chance),
            delay: &mut || timing.below(delays + 1),
            most_draws: 300,
            kept: kept(conditions),
            ran: Vec::new(),
            ticks: 0,
        };
        let status = run(tree, &mut world);
        found.add(status, &world.ran, 1.0);
    }
    found
}

/// What the model says, in the same form.
fn modelled(
    tree: &Ticked,
    chances: &BTreeMap<String, f64>,
    conditions: Conditions,
) -> Option<Chances> {
    let reading = reading(&text(tree));
    let is_whole = |note: &diagnostic::Problem| note.message().contains("one leaf with all");
    if reading.notes.iter().any(is_whole) {
        return None;
    }
    let options = Options {
        conditions,
        values: chances.clone(),
    };
    let model = to_prism(&reading.tree, &options);
    let leaves: Vec<&str> = reading
        .tree
        .leaves()
        .map(|(_, it)| it.label.as_str())
        .collect();
    let skipped = if model.may_be_skipped {
        "\"skipped\""
    } else {
        "false"
    };
    let mut properties = vec![
        "P=? [ F \"success\" ]".to_owned(),
        "P=? [ F \"failure\" ]".to_owned(),
        format!("P=? [ F {skipped} ]"),
    ];
    for leaf in &leaves {
        properties.push(format!("P=? [ F \"{leaf}_ran\" ]"));
        properties.push(format!("P=? [ !\"{leaf}_ran\" U \"{leaf}_failed\" ]"));
    }
    let (found, _) = values(&model.text, &properties);
    let pairs = found[3..].chunks(2).map(|pair| (pair[0], pair[1]));
    Some(Chances {
        ends: [found[0], found[1], found[2]],
        leaves: leaves
            .iter()
            .map(|it| (*it).to_owned())
            .zip(pairs)
            .collect(),
    })
}

fn compare(expected: &Chances, found: &Chances, are_same: &dyn Fn(f64, f64) -> bool, about: &str) {
    for (at, end) in ["success", "failure", "skipped"].iter().enumerate() {
        let (expected, found) = (expected.ends[at], found.ends[at]);
        assert!(
            are_same(expected, found),
            "{end}: {expected} ticked, {found} in the model\n{about}"
        );
    }
    for (leaf, found) in &found.leaves {
        let expected = expected.leaves.get(leaf).copied().unwrap_or_default();
        let both = are_same(expected.0, found.0) && are_same(expected.1, found.1);
        assert!(
            both,
            "{leaf}: {expected:?} ticked, {found:?} in the model\n{about}"
        );
    }
}

/// How many trees were compared exactly, and how many were left out.
fn all_exactly(
    seeds: std::ops::Range<u64>,
    kinds: Kinds,
    conditions: Conditions,
) -> (usize, usize) {
    let (mut compared, mut left_out) = (0, 0);
    for seed in seeds {
        let mut trees = Trees::new(seed, kinds);
        let tree = trees.tree(3);
        let found = modelled(&tree, &trees.chances, conditions);
        let expected = exactly(&tree, &trees.chances, conditions);
        let (Some(found), Some(expected)) = (found, expected) else {
            left_out += 1;
            continue;
        };
        let about = format!(
            "seed {seed}, {kinds:?}, {conditions:?}\n{}\n{:?}",
            text(&tree),
            trees.chances
        );
        compare(&expected, &found, &|a, b| (a - b).abs() < 1e-9, &about);
        compared += 1;
    }
    (compared, left_out)
}

const ALL: Kinds = Kinds {
    endless: false,
    reactive: true,
    preconditions: true,
};

#[test]
fn bounded_trees_have_the_chances_that_their_ticks_have() {
    let (compared, left_out) = all_exactly(0..600, ALL, Conditions::DrawnAgain);
    assert!(compared > 350, "{compared} compared, {left_out} left out");
    let plain = Kinds {
        preconditions: false,
        ..ALL
    };
    let (compared, left_out) = all_exactly(1_000..1_400, plain, Conditions::DrawnAgain);
    assert!(compared > 200, "{compared} compared, {left_out} left out");
}

#[test]
fn conditions_that_keep_their_value_do_so_in_all_rounds() {
    let (compared, left_out) = all_exactly(2_000..2_300, ALL, Conditions::Kept);
    assert!(compared > 170, "{compared} compared, {left_out} left out");
}

/// Without reactive nodes it makes no difference for how long a leaf is under way.
#[test]
fn trees_with_endless_loops_agree_with_simulated_ticks() {
    let kinds = Kinds {
        endless: true,
        reactive: false,
        preconditions: true,
    };
    let (mut compared, runs) = (0, 500);
    for seed in 3_000..3_150 {
        let mut trees = Trees::new(seed, kinds);
        let tree = trees.tree(4);
        let Some(found) = modelled(&tree, &trees.chances, Conditions::DrawnAgain) else {
            continue;
        };
        let expected = simulated(&tree, &trees.chances, Conditions::DrawnAgain, runs, 2);
        // Where all runs end, but some were cut, the shares of those that were not are not the model's.
        let ended: f64 = expected.ends.iter().sum();
        if found.ends.iter().sum::<f64>() > 1.0 - 1e-9 && ended < runs as f64 {
            continue;
        }
        // About 3,000 tests in all; the same seeds give the same draws each time.
        let are_same = |ticked: f64, model: f64| match model.clamp(0.0, 1.0) {
            0.0 => ticked == 0.0,
            1.0 => ticked == runs as f64,
            model if !(1e-6..=1.0 - 1e-6).contains(&model) => {
                (ticked / runs as f64 - model).abs() < 0.01
            }
            model => {
                let sample = stats::Sample::new(ticked as u64, runs as u64).expect("a sample");
                stats::binomial_test_two_sided(sample, model) > 1e-6
            }
        };
        let about = format!("seed {seed}\n{}\n{:?}", text(&tree), trees.chances);
        compare(&expected, &found, &are_same, &about);
        compared += 1;
    }
    assert!(compared > 100, "{compared} compared");
}
