//! How often tables of independent trials are asked about their trials, and which dependence is found; and the same for
//! numbers of a model that are products of rates.
//!
//! `cargo run --release -p corroborate-stats --example groups [STUDIES]`
//!
//! Two generators. With the *first* the tests were chosen: people of a beta-binomial rate, sessions with a common rate.
//! The *second* is held out: logistic rates, sessions of unequal size, a drift or a slowly changing state in place of
//! session rates. Each study has one to three counted columns, a label and its order, as `technique/experiment/groups.rs`
//! asks of it; a question is a p-value times the number of tests of at most 1 %.

use stats::{Possible, Sample, alike_by_label, alike_in_order, coincidences, product_by_chance};

const LIMIT: f64 = 0.01;

/// SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014): the same draws on every machine.
struct Draws(u64);

impl Draws {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }

    fn normal(&mut self) -> f64 {
        stats::special::normal_quantile(self.unit().clamp(1e-12, 1.0 - 1e-12))
    }

    fn count(&mut self, trials: u64, rate: f64) -> Sample {
        let successes = (0..trials).filter(|_| self.unit() < rate).count() as u64;
        Sample { successes, trials }
    }

    /// A beta variate of this mean and correlation, by its quantile.
    fn beta(&mut self, mean: f64, correlation: f64) -> f64 {
        if correlation <= 0.0 {
            return mean;
        }
        let size = 1.0 / correlation - 1.0;
        let beta = stats::BetaPosterior::new(mean * size, (1.0 - mean) * size);
        beta.map_or(mean, |it| it.quantile(self.unit()))
    }
}

/// How trials depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dependence {
    /// Not beyond their own row.
    None,
    /// By sessions of this correlation; the rows of a session stand together or not.
    Sessions(f64, bool),
    /// By a drift from the first to the last row, in logits (second generator).
    Drift(f64),
    /// By a state that changes slowly, with this deviation in logits (second generator).
    State(f64),
}

/// The rows of a table by its columns, with a label for each row.
struct Study {
    columns: Vec<Vec<Sample>>,
    labels: Vec<usize>,
}

fn first(draws: &mut Draws, dependence: Dependence) -> Study {
    let (rows, trials) = (draws.of(&[12, 24, 48]), draws.of(&[1, 5, 10]));
    let (sessions, columns) = (draws.of(&[3, 4, 6]), draws.of(&[1, 2, 3]));
    let apart = matches!(dependence, Dependence::Sessions(_, false));
    let label = |row: usize| {
        if apart {
            row % sessions
        } else {
            row * sessions / rows
        }
    };
    let labels: Vec<usize> = (0..rows).map(label).collect();
    let correlation = match dependence {
        Dependence::Sessions(correlation, _) => correlation,
        _ => 0.0,
    };
    let mut column = || {
        let mean = draws.of(&[0.6, 0.8, 0.9]);
        let rates: Vec<f64> = (0..sessions)
            .map(|_| draws.beta(mean, correlation))
            .collect();
        let people = draws.of(&[0.0, 0.1]);
        labels
            .iter()
            .map(|label| {
                let rate = draws.beta(rates[*label].clamp(0.01, 0.99), people);
                draws.count(trials, rate)
            })
            .collect()
    };
    let columns = (0..columns).map(|_| column()).collect();
    Study { columns, labels }
}

fn second(draws: &mut Draws, dependence: Dependence) -> Study {
    let (rows, columns) = (10 + (draws.unit() * 40.0) as usize, draws.of(&[1, 2, 3]));
    // Sessions of unequal size: a new one begins at one row of six.
    let mut session = 0;
    let mut labels: Vec<usize> = (0..rows)
        .map(|_| {
            session += usize::from(draws.unit() < 1.0 / 6.0);
            session
        })
        .collect();
    if matches!(dependence, Dependence::Sessions(_, false)) {
        for last in (1..rows).rev() {
            labels.swap(last, (draws.unit() * (last + 1) as f64) as usize);
        }
    }
    let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
    let mut column = || {
        let (mean, people) = (0.5 + 2.0 * draws.unit(), draws.unit());
        let of_session: Vec<f64> = (0..=rows).map(|_| draws.normal()).collect();
        let mut state = draws.normal();
        (0..rows)
            .map(|row| {
                state = 0.9 * state + 0.19_f64.sqrt() * draws.normal();
                let shift = match dependence {
                    Dependence::None => 0.0,
                    // A correlation in logits: about pi^2 / 3 of variance within.
                    Dependence::Sessions(correlation, _) => {
                        (3.29 * correlation / (1.0 - correlation)).sqrt() * of_session[labels[row]]
                    }
                    Dependence::Drift(size) => size * (row as f64 / rows as f64 - 0.5),
                    Dependence::State(size) => size * state,
                };
                let rate = logistic(mean + shift + people * draws.normal());
                let trials = 1 + (draws.unit() * 8.0) as u64;
                draws.count(trials, rate)
            })
            .collect()
    };
    let columns = (0..columns).map(|_| column()).collect();
    Study { columns, labels }
}

/// Whether the study is asked about.
fn is_asked(study: &Study) -> bool {
    let tests = study
        .columns
        .iter()
        .flat_map(|rows| [alike_by_label(rows, &study.labels), alike_in_order(rows)]);
    let found: Vec<f64> = tests.flatten().collect();
    let least = found.iter().copied().fold(1.0, f64::min);
    least * found.len() as f64 <= LIMIT
}

/// Whether a model's numbers are asked about as products of an experiment's rates: `copied` of them are.
fn products(draws: &mut Draws, modes: usize, decimals: i32, copied: bool) -> bool {
    let trials = draws.of(&[50, 100, 200, 500]);
    let rates: Vec<f64> = (0..modes).map(|_| 0.5 + 0.5 * draws.unit()).collect();
    let counts: Vec<Sample> = rates
        .iter()
        .map(|rate| draws.count(trials, *rate))
        .collect();
    let step = 10_f64.powi(-decimals);
    let rounded = |value: f64| (value / step).round() * step;
    let (a, b) = (0, 1);
    let mut possible = Vec::new();
    // The same product of two counts is one coincidence, and each is one of its own, as in `copies/products.rs`.
    let mut known = std::collections::BTreeSet::new();
    for number in 0..modes {
        // An independent source knows the same system, by trials of its own.
        let own: Vec<f64> = rates
            .iter()
            .map(|rate| draws.count(trials + 37, *rate).rate().unwrap_or(0.0))
            .collect();
        let product = match (copied && number == 0, number % 2) {
            (true, _) => counts[a].rate().unwrap_or(0.0) * counts[b].rate().unwrap_or(0.0),
            (false, 0) => own[a] * own[b],
            _ => own[number],
        };
        let value = rounded(product);
        for (i, one) in counts.iter().enumerate() {
            for other in &counts[i + 1..] {
                let turned = |sample: &Sample, fails: usize| Sample {
                    successes: if fails == 1 {
                        sample.failures()
                    } else {
                        sample.successes
                    },
                    trials: sample.trials,
                };
                for way in 0..8 {
                    let sides = [turned(one, way & 1), turned(other, way >> 1 & 1)];
                    if !sides.iter().all(Sample::is_informative) {
                        continue;
                    }
                    let mut key = sides.map(|side| (side.successes, side.trials));
                    key.sort_unstable();
                    if !known.insert((format!("{value:.9}"), key, way >> 2)) {
                        continue;
                    }
                    if let Some((chance, met)) =
                        product_by_chance(sides, way >> 2 == 1, value, step)
                    {
                        possible.push(Possible {
                            pair: possible.len(),
                            chance,
                            met,
                        });
                    }
                }
            }
        }
    }
    coincidences(&possible)
        .into_iter()
        .flatten()
        .any(|chance| chance <= LIMIT)
}

fn share(studies: usize, seed: u64, mut asked: impl FnMut(&mut Draws) -> bool) -> String {
    let mut draws = Draws(seed);
    let count = (0..studies).filter(|_| asked(&mut draws)).count() as u64;
    let sample = Sample {
        successes: count,
        trials: studies as u64,
    };
    let interval = stats::wilson(sample, stats::Confidence::P95);
    format!(
        "{:5.1} % [{:.1}, {:.1}]",
        100.0 * count as f64 / studies as f64,
        100.0 * interval.low,
        100.0 * interval.high
    )
}

fn main() {
    let studies = std::env::args()
        .nth(1)
        .and_then(|it| it.parse().ok())
        .unwrap_or(400);
    println!("Studies with a question of {studies} each (95 % interval)\n");
    println!("| trials | first generator (tuned) | second generator (held out) |\n|---|---|---|");
    for dependence in [
        Dependence::None,
        Dependence::Sessions(0.05, true),
        Dependence::Sessions(0.1, true),
        Dependence::Sessions(0.3, true),
        Dependence::Sessions(0.1, false),
        Dependence::Sessions(0.3, false),
    ] {
        let tuned = share(studies, 1, |draws| is_asked(&first(draws, dependence)));
        let held_out = share(studies, 2, |draws| is_asked(&second(draws, dependence)));
        println!("| {dependence:?} | {tuned} | {held_out} |");
    }
    for dependence in [
        Dependence::Drift(2.0),
        Dependence::Drift(4.0),
        Dependence::State(1.5),
    ] {
        let held_out = share(studies, 3, |draws| is_asked(&second(draws, dependence)));
        println!("| {dependence:?} | - | {held_out} |");
    }
    println!("\n| products of rates | independent | one copied |\n|---|---|---|");
    for modes in [2, 4, 8] {
        for decimals in [2, 3, 4, 6] {
            let independent = share(studies, 4, |draws| products(draws, modes, decimals, false));
            let copied = share(studies, 5, |draws| products(draws, modes, decimals, true));
            println!("| {modes} counts, {decimals} digits | {independent} | {copied} |");
        }
    }
}
