//! How often studies of independent evidence are asked whether something was copied, and which copies are found.
//!
//! `cargo run --release -p corroborate-stats --example copies [STUDIES]`

use stats::{Possible, Sample, Unnamed, coincidences, renamed_rows};

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

    fn count(&mut self, trials: u64, rate: f64) -> Sample {
        let successes = (0..trials).filter(|_| self.unit() < rate).count() as u64;
        Sample { successes, trials }
    }

    /// A rate of a person whose trials have this correlation, by a beta distribution (of two gamma variates).
    fn person(&mut self, mean: f64, correlation: f64) -> f64 {
        if correlation <= 0.0 {
            return mean;
        }
        let size = 1.0 / correlation - 1.0;
        let (a, b) = (self.gamma(mean * size), self.gamma((1.0 - mean) * size));
        a / (a + b)
    }

    /// Marsaglia and Tsang (2000); a shape below 1 by a power of a uniform variate.
    fn gamma(&mut self, shape: f64) -> f64 {
        if shape < 1.0 {
            return self.gamma(shape + 1.0) * self.unit().powf(1.0 / shape);
        }
        let d = shape - 1.0 / 3.0;
        loop {
            let z = stats::special::normal_quantile(self.unit().clamp(1e-12, 1.0 - 1e-12));
            let v = (1.0 + z / (9.0 * d).sqrt()).powi(3);
            if v > 0.0 && self.unit().ln() < 0.5 * z * z + d - d * v + d * v.ln() {
                return d * v;
            }
        }
    }
}

/// Numbers of a model against the counts of an experiment: whether any is asked about, and whether any is noted.
fn constants(draws: &mut Draws, modes: usize, decimals: i32, source: Source) -> [bool; 2] {
    let trials = draws.of(&[20, 50, 100, 200, 500]);
    let mut possible = Vec::new();
    for _ in 0..modes {
        let rate = 0.02 + 0.96 * draws.unit().powi(2);
        let counts = draws.count(trials, rate);
        let step = 10_f64.powi(-decimals);
        let written = |value: f64| (value / step).round() * step;
        let value = match source {
            Source::Truth => written(rate),
            Source::Guess => written((rate + 0.1 * (draws.unit() - 0.5)).clamp(0.01, 0.99)),
            Source::Pilot => {
                let trials = draws.of(&[30, 60, 100, 240]);
                written(draws.count(trials, rate).rate().unwrap_or(0.0))
            }
            Source::Quotient | Source::SameTrials => {
                let of = match source {
                    Source::SameTrials => trials,
                    _ => draws.of(&[20, 50, 100, 200, 500, 37, 64, 120, 150, 250, 300, 400]),
                };
                let pilot = draws.count(of, rate);
                let chance = stats::quotient_by_chance(pilot);
                if of == trials && pilot.is_informative() {
                    push(&mut possible, chance, pilot == counts);
                }
                continue;
            }
            Source::Copy => written(counts.rate().unwrap_or(0.0)),
        };
        if value > 0.0 && value < 1.0 && counts.is_informative() {
            let exact = counts.rate().unwrap_or(0.0);
            let met = (value - exact).abs() <= 0.5 * step * (1.0 + 1e-9);
            push(
                &mut possible,
                stats::constant_by_chance(counts, value, step),
                met,
            );
        }
    }
    let found = coincidences(&possible);
    let asked = found.iter().flatten().any(|chance| *chance <= LIMIT);
    let noted = possible.iter().any(|it| it.met && it.chance <= 0.2);
    [asked, noted]
}

#[derive(Clone, Copy)]
enum Source {
    Truth,
    Guess,
    Pilot,
    Quotient,
    SameTrials,
    Copy,
}

fn push(possible: &mut Vec<Possible>, chance: f64, met: bool) {
    possible.push(Possible {
        pair: 0,
        chance,
        met,
    });
}

/// Totals of failure modes in two tables.
fn totals(draws: &mut Draws, modes: usize, trials: u64, copied: bool) -> [bool; 2] {
    let possible: Vec<Possible> = (0..modes)
        .filter_map(|_| {
            let rate = 0.3 * draws.unit();
            let first = draws.count(trials, rate);
            let second = if copied {
                first
            } else {
                draws.count(trials, rate)
            };
            first.is_informative().then(|| Possible {
                pair: 0,
                chance: stats::count_by_chance(first),
                met: first == second,
            })
        })
        .collect();
    let found = coincidences(&possible);
    [found.iter().flatten().any(|chance| *chance <= LIMIT), false]
}

/// Two cohorts of people, or the same conditions in two tables.
fn cohorts(draws: &mut Draws, rows: usize, trials: u64, kind: Rows) -> [bool; 2] {
    let mean = draws.of(&[0.5, 0.7, 0.88, 0.95]);
    let conditions: Vec<f64> = (0..rows).map(|_| draws.unit()).collect();
    let cohort = |draws: &mut Draws| -> Vec<u64> {
        (0..rows)
            .map(|row| {
                let rate = match kind {
                    Rows::People(correlation) => draws.person(mean, correlation),
                    Rows::Conditions => conditions[row],
                    Rows::Trend => row as f64 / (rows - 1) as f64,
                    Rows::InOrder | Rows::Mixed => draws.person(mean, 0.1),
                };
                draws.count(trials, rate).successes
            })
            .collect()
    };
    let first = cohort(draws);
    let mut second = cohort(draws);
    if matches!(kind, Rows::InOrder | Rows::Mixed) {
        second.clone_from(&first);
    }
    if matches!(kind, Rows::Mixed) {
        for i in (1..rows).rev() {
            second.swap(i, (draws.unit() * (i + 1) as f64) as usize);
        }
    }
    let [first, second] = [first, second].map(|counts| Unnamed {
        columns: vec![
            counts
                .iter()
                .map(|&successes| Sample { successes, trials })
                .collect(),
        ],
        contents: counts,
    });
    [renamed_rows(&first, &second).chance <= LIMIT, false]
}

#[derive(Clone, Copy)]
enum Rows {
    People(f64),
    Conditions,
    Trend,
    InOrder,
    Mixed,
}

/// Draws a study: whether anything is asked, and whether anything is noted.
type Drawn = Box<dyn Fn(&mut Draws) -> [bool; 2]>;

type Kind = (String, bool, Drawn);

fn kinds() -> Vec<Kind> {
    let mut kinds: Vec<Kind> = Vec::new();
    let mut add = |name: String, copied, study: Drawn| {
        kinds.push((name, copied, study));
    };
    for (source, name) in [
        (Source::Guess, "guesses"),
        (Source::Truth, "the true rates"),
        (Source::Pilot, "rates of a pilot"),
    ] {
        for decimals in [2, 3, 4] {
            let study = move |draws: &mut Draws| constants(draws, 3, decimals, source);
            add(
                format!("3 constants, {name}, {decimals} decimals"),
                false,
                Box::new(study),
            );
        }
    }
    let study = |draws: &mut Draws| constants(draws, 3, 2, Source::Quotient);
    add(
        "3 constants, quotients of a pilot".into(),
        false,
        Box::new(study),
    );
    let study = |draws: &mut Draws| constants(draws, 3, 2, Source::SameTrials);
    add(
        "the same, always of as many trials".into(),
        false,
        Box::new(study),
    );
    for (modes, trials) in [(1, 50), (3, 100), (6, 200)] {
        let study = move |draws: &mut Draws| totals(draws, modes, trials, false);
        add(
            format!("totals of {modes} modes in {trials} trials"),
            false,
            Box::new(study),
        );
    }
    for correlation in [0.0, 0.1, 0.5] {
        let study = move |draws: &mut Draws| cohorts(draws, 10, 10, Rows::People(correlation));
        add(
            format!("10 people x 10, correlation {correlation}"),
            false,
            Box::new(study),
        );
    }
    let study = |draws: &mut Draws| cohorts(draws, 40, 5, Rows::People(0.1));
    add(
        "40 people x 5, correlation 0.1".into(),
        false,
        Box::new(study),
    );
    let study = |draws: &mut Draws| cohorts(draws, 60, 1, Rows::People(0.0));
    add("60 rows of one trial".into(), false, Box::new(study));
    let study = |draws: &mut Draws| cohorts(draws, 12, 20, Rows::Conditions);
    add("the same 12 conditions x 20".into(), false, Box::new(study));
    let study = |draws: &mut Draws| cohorts(draws, 24, 5, Rows::Trend);
    add("a trend over 24 rows x 5".into(), false, Box::new(study));
    for decimals in [2, 3, 4] {
        for modes in [1, 3] {
            let study = move |draws: &mut Draws| constants(draws, modes, decimals, Source::Copy);
            add(
                format!("{modes} copied rates, {decimals} decimals"),
                true,
                Box::new(study),
            );
        }
    }
    for (modes, trials) in [(1, 200), (3, 100), (6, 200)] {
        let study = move |draws: &mut Draws| totals(draws, modes, trials, true);
        add(
            format!("copied totals of {modes} modes in {trials} trials"),
            true,
            Box::new(study),
        );
    }
    for (rows, trials) in [(5, 10), (10, 10), (20, 10), (40, 5)] {
        let study = move |draws: &mut Draws| cohorts(draws, rows, trials, Rows::InOrder);
        add(
            format!("renamed rows, {rows} x {trials}"),
            true,
            Box::new(study),
        );
        let study = move |draws: &mut Draws| cohorts(draws, rows, trials, Rows::Mixed);
        add(
            format!("renamed and mixed rows, {rows} x {trials}"),
            true,
            Box::new(study),
        );
    }
    kinds
}

/// A kind of study, and in which share of them anything is asked and noted.
pub struct Row {
    /// What the studies have.
    pub name: String,
    /// Whether something is copied in them.
    pub copied: bool,
    /// The share that is asked about.
    pub asked: f64,
    /// The share with a coincidence of numbers that is only noted, or asked about.
    pub noted: f64,
}

/// All kinds, so many studies each.
pub fn table(studies: u32) -> Vec<Row> {
    let mut rows = Vec::new();
    for (seed, (name, copied, study)) in (1_u64..).zip(kinds()) {
        let mut draws = Draws(seed << 40);
        let mut many = [0_u32; 2];
        for _ in 0..studies {
            for (many, is) in many.iter_mut().zip(study(&mut draws)) {
                *many += u32::from(is);
            }
        }
        let [asked, noted] = many.map(|many| f64::from(many) / f64::from(studies));
        rows.push(Row {
            name,
            copied,
            asked,
            noted,
        });
    }
    rows
}

fn main() {
    let studies = std::env::args().nth(1).and_then(|it| it.parse().ok());
    println!("| evidence | copied | asked, % | noted, % |\n|---|---|---|---|");
    for row in table(studies.unwrap_or(2000)) {
        let copied = if row.copied { "yes" } else { "no" };
        let [asked, noted] = [row.asked, row.noted].map(|share| 100.0 * share);
        println!("| {} | {copied} | {asked:.2} | {noted:.1} |", row.name);
    }
}
