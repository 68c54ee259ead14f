//! Numbers in models and parameter sets that are a product of two rates of another piece's counts, or 1 minus one.
//!
//! # Definition
//! Each number is held against `x y` and `1 - x y`, `x` and `y` the rates (or the rates of failure) of two different
//! counts of one other piece: a chance of success that is the product of two stages', a chance to fail somewhere that is 1
//! minus it. A number that is the product rounded to its last digit is met. An independent source writes that number
//! with about
//!
//! ```text
//! p = step * density of x y at the number,   x and y with the means and variances of their Jeffreys posteriors
//! ```
//!
//! by the normal distribution of the delta method. All products that could have been met count
//! (`stats::coincidences`), so that the more counts there are, the more digits a number needs to be asked about.
//!
//! # Assumes
//! The two rates are independent of each other and have Jeffreys' posteriors, of independent trials. Their product is taken
//! as normal.
//!
//! # Guarantee
//! None for a single probability, which is an approximation. Measured (`cargo run --release -p corroborate-stats --example groups`),
//! studies of independent evidence are asked in at most 1 % with two and four counts, and in 3.5 % with eight counts and
//! numbers of six digits, which is above the limit. Numbers of two digits are never asked about, of three seldom. Not
//! found: products of three rates or more, and of rates of two pieces.

use super::constants::{Placed, placed};
use super::{Candidate, counted, is_declared, probability, subject_in_words};
use diagnostic::Problem;
use evidence::{CopyKind, Evidence, Subject};
use stats::Sample;
use study::Study;

/// Two counts of one piece.
type Counts<'c> = [&'c (Subject, Sample); 2];

/// All numbers against all products.
pub(super) fn candidates(study: &Study, evidence: &[Evidence]) -> Result<Vec<Candidate>, Problem> {
    let counts: Vec<Vec<(Subject, Sample)>> = evidence.iter().map(counted).collect();
    let mut candidates = Vec::new();
    for placed in placed(study, evidence)? {
        // A quotient is one count's, not a product.
        if placed.number.quotient.is_some() {
            continue;
        }
        for (other, counts) in counts.iter().enumerate() {
            if other == placed.piece {
                continue;
            }
            let free = |(subject, _): &&(Subject, Sample)| {
                !is_declared(&evidence[placed.piece], &evidence[other], subject)
            };
            let free: Vec<&(Subject, Sample)> = counts.iter().filter(free).collect();
            for (place, one) in free.iter().enumerate() {
                for another in &free[place + 1..] {
                    candidates.extend(of_pair(&placed, evidence, other, [one, another]));
                }
            }
        }
    }
    Ok(candidates)
}

/// The products of two counts with a number.
fn of_pair(
    placed: &Placed<'_>,
    evidence: &[Evidence],
    other: usize,
    [one, another]: Counts<'_>,
) -> Vec<Candidate> {
    let turned = |sample: Sample, fails: bool| Sample {
        successes: if fails {
            sample.failures()
        } else {
            sample.successes
        },
        trials: sample.trials,
    };
    let sides = [(false, false), (false, true), (true, false), (true, true)];
    let products = sides.into_iter().flat_map(|(first, second)| {
        let samples = [turned(one.1, first), turned(another.1, second)];
        [(samples, false), (samples, true)]
    });
    let found = products.filter_map(|(samples, of_rest)| {
        let (chance, met) =
            stats::product_by_chance(samples, of_rest, placed.number.value, placed.number.step)?;
        Some(candidate(
            placed,
            evidence,
            other,
            [one, another],
            (samples, of_rest),
            (chance, met),
        ))
    });
    found.collect()
}

fn candidate(
    placed: &Placed<'_>,
    evidence: &[Evidence],
    other: usize,
    [one, another]: Counts<'_>,
    ([first, second], of_rest): ([Sample; 2], bool),
    (chance, met): (f64, bool),
) -> Candidate {
    let (id, with) = (&evidence[placed.piece].id, &evidence[other].id);
    let number = &placed.number;
    let what = number
        .name
        .as_ref()
        .map_or(format!("{id}'s {}", number.text), |name| {
            format!("{id}'s `{name}` = {}", number.text)
        });
    let (first, second) = match (first.successes, first.trials) <= (second.successes, second.trials)
    {
        true => (first, second),
        false => (second, first),
    };
    let product = format!(
        "{}/{} times {}/{}",
        first.successes, first.trials, second.successes, second.trials
    );
    let product = match of_rest {
        true => format!("1 minus {product}"),
        false => product,
    };
    Candidate {
        pieces: [placed.piece, other],
        kind: CopyKind::Product,
        subjects: vec![one.0.clone(), another.0.clone()],
        key: format!("{} {product}", number.text),
        chance,
        met,
        notable: evidence[placed.piece].technique.is_of_model() && chance <= NOTED,
        finding: format!(
            "{what} is {product}, {with}'s counts of {} and {} (an independent source gives it with a probability of {})",
            subject_in_words(&one.0),
            subject_in_words(&another.0),
            probability(chance)
        ),
        places: vec![format!("{}:{}", placed.path, number.line)],
        declare: None,
    }
}

/// Up to which probability of its own a product is noted that is no question: there are many products.
const NOTED: f64 = 0.001;
