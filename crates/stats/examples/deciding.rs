//! How often repeating a test until its rate is decided errs, and how many trials it takes: against a fixed number of trials and
//! against repeating it until it passes.
//!
//! `cargo run --release -p corroborate-stats --example deciding [SUITES]`

use stats::{
    Confidence, Decision, IndifferenceTest, Sample, binomial_test_above, binomial_test_below,
    continued_above, continued_below,
};

/// What a requirement asks for in all suites: a rate of at least 0.95, decided at 95 % with a margin of 0.02.
const THRESHOLD: f64 = 0.95;
const MARGIN: f64 = 0.02;
/// The largest number of trials in a suite of continuous integration.
const MOST: u64 = 400;
/// So many times a test that fails is tried again until it passes.
const TRIES: u64 = 5;
/// The true rates of the tests.
const RATES: [f64; 12] = [
    0.4, 0.7, 0.8, 0.9, 0.93, 0.94, 0.95, 0.96, 0.97, 0.98, 0.99, 1.0,
];
/// The tests of a suite.
const TESTS: u64 = 20;

/// SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014): the same draws on every machine.
pub struct Draws(pub u64);

impl Draws {
    /// Whether a trial with this rate succeeds.
    pub fn passes(&mut self, rate: f64) -> bool {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64) < rate
    }
}

/// What one way of running a test with a flaky outcome answered, and after how many trials.
#[derive(Clone, Copy)]
pub struct Answer {
    decision: Decision,
    trials: u64,
    successes: u64,
}

/// Trials one after another until the test has decided, `most` at most.
fn decided(draws: &mut Draws, rate: f64, test: &IndifferenceTest, most: u64) -> Answer {
    let mut sample = Sample {
        successes: 0,
        trials: 0,
    };
    while sample.trials < most {
        sample.trials += 1;
        sample.successes += u64::from(draws.passes(rate));
        let decision = test.decide([sample; 2]);
        if decision != Decision::Open {
            return Answer {
                decision,
                trials: sample.trials,
                successes: sample.successes,
            };
        }
    }
    Answer {
        decision: Decision::Open,
        trials: most,
        successes: sample.successes,
    }
}

/// Until it passes, [`TRIES`] times at most.
fn until_pass(draws: &mut Draws, rate: f64) -> Answer {
    let passed = (1..=TRIES).find(|_| draws.passes(rate));
    Answer {
        decision: match passed {
            Some(_) => Decision::AtLeast,
            None => Decision::Below,
        },
        trials: passed.unwrap_or(TRIES),
        successes: u64::from(passed.is_some()),
    }
}

/// The least fixed number of trials with the same two error rates at the edges of the zone, and how many have to succeed.
pub fn fixed_plan(test: &IndifferenceTest) -> Sample {
    let (alpha, zone) = (test.confidence().alpha(), test.zone());
    let plan = |trials: u64| {
        let mut enough = (0..=trials).map(|successes| Sample { successes, trials });
        let plan = enough.find(|it| binomial_test_above(*it, zone.low) <= alpha)?;
        let missed = Sample {
            successes: plan.successes.checked_sub(1)?,
            trials,
        };
        (binomial_test_below(missed, zone.high) <= alpha).then_some(plan)
    };
    (1..).find_map(plan).expect("some number is enough")
}

fn fixed(draws: &mut Draws, rate: f64, plan: Sample) -> Answer {
    let passed = (0..plan.trials).filter(|_| draws.passes(rate)).count() as u64;
    Answer {
        decision: match passed >= plan.successes {
            true => Decision::AtLeast,
            false => Decision::Below,
        },
        trials: plan.trials,
        successes: passed,
    }
}

/// Shares of the answers, and the mean number of trials.
#[derive(Clone, Copy, Default)]
pub struct Shares {
    /// The share that passed.
    pub passed: f64,
    /// The share that failed.
    pub failed: f64,
    /// Trials on the average.
    pub trials: f64,
}

impl Shares {
    fn of(count: u32, mut answer: impl FnMut() -> Answer) -> Self {
        let mut shares = Self::default();
        for _ in 0..count {
            let Answer {
                decision, trials, ..
            } = answer();
            shares.passed += f64::from(u8::from(decision == Decision::AtLeast));
            shares.failed += f64::from(u8::from(decision == Decision::Below));
            shares.trials += trials as f64;
        }
        let count = f64::from(count);
        Self {
            passed: shares.passed / count,
            failed: shares.failed / count,
            trials: shares.trials / count,
        }
    }
}

/// A true rate, and what each way says of tests with it.
pub struct Row {
    /// The true rate.
    pub rate: f64,
    /// Until decided, without a limit of trials (but ten million).
    pub unlimited: Option<Shares>,
    /// Until decided, 400 trials at most.
    pub decided: Shares,
    /// A fixed number of trials.
    pub fixed: Shares,
    /// Until it passes.
    pub until_pass: Shares,
}

/// The test of all rows.
pub fn test(confidence: Confidence) -> IndifferenceTest {
    IndifferenceTest::new(THRESHOLD, MARGIN, confidence).expect("a zone between 0 and 1")
}

/// One row for each rate, of so many tests.
pub fn table(tests: u32) -> Vec<Row> {
    let test = test(Confidence::P95);
    let plan = fixed_plan(&test);
    let rows = (1_u64..).zip(RATES).map(|(seed, rate)| {
        let draws = &mut Draws(seed << 40);
        // In the middle of the zone a decision may take for ever.
        let is_edge = [0.93, 0.97].contains(&rate);
        Row {
            rate,
            unlimited: is_edge
                .then(|| Shares::of(tests, || decided(draws, rate, &test, 10_000_000))),
            decided: Shares::of(tests, || decided(draws, rate, &test, MOST)),
            fixed: Shares::of(tests, || fixed(draws, rate, plan)),
            until_pass: Shares::of(tests, || until_pass(draws, rate)),
        }
    });
    rows.collect()
}

/// A suite whose tests have one rate: the share of suites of [`TESTS`] tests in which some answer is wrong, at 95 % for each
/// test and at 95 % for the suite.
pub fn wrong_suites(rate: f64, wrong: Decision, suites: u32) -> [f64; 2] {
    let each = [
        Confidence::P95,
        Confidence::P95.simultaneous(TESTS as usize),
    ];
    each.map(|confidence| {
        let test = test(confidence);
        let draws = &mut Draws(7 << 50);
        let any_wrong = |draws: &mut Draws| {
            let answers = (0..TESTS).map(|_| decided(draws, rate, &test, MOST));
            // All are run, as a suite does.
            answers.filter(|it| it.decision == wrong).count() > 0
        };
        let count = (0..suites).filter(|_| any_wrong(draws)).count();
        count as f64 / f64::from(suites)
    })
}

/// How often a study is wrong that takes the number of trials for fixed at which this test stopped them, where the true rate is the one
/// that it judges them against: "satisfied" (the rate is shown to be above), and "violated" (below), each at 5 % with one look.
pub fn taken_for_fixed(tests: u32) -> [f64; 2] {
    let test = test(Confidence::P95);
    let draws = &mut Draws(9 << 50);
    let mut wrong = [0_u32; 2];
    for _ in 0..tests {
        let stopped = decided(draws, THRESHOLD, &test, MOST);
        let look = [Sample {
            successes: stopped.successes,
            trials: stopped.trials,
        }];
        wrong[0] += u32::from(continued_above(&look, THRESHOLD) <= 0.05);
        wrong[1] += u32::from(continued_below(&look, THRESHOLD) <= 0.05);
    }
    wrong.map(|wrong| f64::from(wrong) / f64::from(tests))
}

fn main() {
    let suites = std::env::args().nth(1).and_then(|it| it.parse().ok());
    let suites = suites.unwrap_or(4000);
    let plan = fixed_plan(&test(Confidence::P95));
    println!(
        "fixed: {} of {} have to succeed\n",
        plan.successes, plan.trials
    );
    println!(
        "| rate | decided: pass, % | fail, % | undecided, % | trials | fixed: pass, % | trials | until pass: pass, % | trials |\n\
         |---|---|---|---|---|---|---|---|---|"
    );
    for row in table(suites) {
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let Row {
            decided,
            fixed,
            until_pass,
            ..
        } = &row;
        let open = 1.0 - decided.passed - decided.failed;
        println!(
            "| {} | {} | {} | {} | {:.0} | {} | {:.0} | {} | {:.2} |",
            row.rate,
            percent(decided.passed),
            percent(decided.failed),
            percent(open.max(0.0)),
            decided.trials,
            percent(fixed.passed),
            fixed.trials,
            percent(until_pass.passed),
            until_pass.trials
        );
    }
    println!("\n| rate | without a limit: pass, % | fail, % | trials |\n|---|---|---|---|");
    for row in table(suites) {
        if let Some(shares) = row.unlimited {
            let [passed, failed] = [shares.passed, shares.failed].map(|it| 100.0 * it);
            println!(
                "| {} | {passed:.1} | {failed:.1} | {:.0} |",
                row.rate, shares.trials
            );
        }
    }
    println!(
        "\n| suite of {TESTS} tests | wrong at 95 % each, % | at 95 % for all, % |\n|---|---|---|"
    );
    for (rate, wrong, name) in [
        (0.93, Decision::AtLeast, "all rates 0.93: any passes"),
        (0.97, Decision::Below, "all rates 0.97: any fails"),
    ] {
        let [each, all] = wrong_suites(rate, wrong, suites).map(|it| 100.0 * it);
        println!("| {name} | {each:.1} | {all:.1} |");
    }
    let [satisfied, violated] = taken_for_fixed(suites).map(|it| 100.0 * it);
    println!(
        "\nstopped counts taken for fixed, true rate {THRESHOLD}: \"satisfied\" in {satisfied:.1} %, \"violated\" in {violated:.1} %"
    );
}
