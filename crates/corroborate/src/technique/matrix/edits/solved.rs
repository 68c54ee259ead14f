//! Numbers that runs are read through, solved for where nothing says a value that explains what disagrees.
//!
//! # Definition
//! Looked at is each number in a text that the runs of several techniques are judged by (a parameter, a limit in a predicate or
//! a formula, a scale) for which a slip was tried. From its present value it is moved by factors of 2, 4, 8 and 32 either way until
//! the pieces that are read from runs pass the rate of the other pieces, less and plus [`DEVIATIONS`] of a few runs; both crossings
//! are enclosed by halving on a logarithmic
//! scale. People write round numbers: powers of ten, twice and five times these, then numbers of one, two and three digits that
//! count. Of those between the crossings, widened by [`AROUND`], of which of more digits the middle alone, the one is taken with
//! which the pieces agree best for what its choice costs.
//!
//! # Assumes
//! One number is wrong, and a round one was meant; round numbers of as many digits are equally likely before.
//!
//! # Guarantee
//! None: it has a free value. It pays for the choice among all round values with as many digits within [`DECADES`] decades: the
//! logarithm of their number. What is named was judged anew on all evidence.
//!
//! # Cost
//! Some thirty times what an edit costs for each of at most [`MOST_PLACES`] numbers.

use super::{Context, Diagnosing, FEW_RUNS, TextEdit};
use crate::technique::matrix::candidates::Reach;
use crate::technique::matrix::candidates::scales::is_of_nature;
use diagnostic::Problem;
use evidence::{Evidence, Rate, Subject};
use std::collections::BTreeMap;

/// Numbers that are solved for, at most.
const MOST_PLACES: usize = 6;

/// How far a number is moved, by turns.
const FACTORS: [f64; 4] = [2.0, 4.0, 8.0, 32.0];

/// How often the bracket is halved.
const HALVINGS: u32 = 8;

/// Decades over which a round value may lie.
const DECADES: f64 = 2.0;

/// Digits that a round number has at most.
const MOST_DIGITS: i32 = 3;

/// By how many deviations the rate of a few runs may lie off that of all.
const DEVIATIONS: f64 = 2.0;

/// By which factor a round number may lie beyond the crossings.
const AROUND: f64 = 1.25;

/// A number in a text, with what stands around it: of `<=8 N` it is `<=`, 8 and ` N`.
pub(super) struct Written<'t> {
    before: &'t str,
    pub(super) value: f64,
    behind: &'t str,
}

impl<'t> Written<'t> {
    pub(super) fn read(text: &'t str) -> Option<Self> {
        let start = text.find(|c: char| c.is_ascii_digit() || c == '-' || c == '.')?;
        let rest = &text[start..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || "-._".contains(c)));
        let (number, behind) = rest.split_at(end.unwrap_or(rest.len()));
        let value = number.replace('_', "").parse().ok()?;
        Some(Self {
            before: &text[..start],
            value,
            behind,
        })
    }

    fn with(&self, value: f64, digits: i32) -> String {
        let places = digits - 1 - value.abs().log10().floor() as i32;
        let scale = 10.0_f64.powi(places);
        let rounded = (value * scale).round() / scale;
        format!("{}{}{}", self.before, rounded, self.behind)
    }
}

impl Diagnosing<'_> {
    /// Edits of numbers that runs are read through, each with round values about that with which these have the rate of all
    /// other evidence, and the decades that their choice costs.
    pub(super) fn solved(
        &self,
        context: &Context<'_>,
        tried: &[TextEdit],
    ) -> Result<Vec<Vec<(TextEdit, f64)>>, Problem> {
        let mut places: Vec<&TextEdit> = Vec::new();
        for edit in tried {
            let is_read = matches!(edit.reach, Reach::Runs | Reach::All);
            let is_number = edit.is_number() && !edit.new.contains('\n') && !edit.is_said;
            let is_number = is_number && !is_of_nature(edit);
            let is_new = places.iter().all(|it| !it.is_of_place(edit));
            if is_read && is_number && is_new && places.len() < MOST_PLACES {
                places.push(edit);
            }
        }
        let mut found = Vec::new();
        for place in places {
            for subject in context.strong {
                self.setting.go_on()?;
                let written = Written::read(&place.old);
                let values = self.values_between(context, (place, subject));
                if let (Some(written), [first, .., last] | [first @ last]) =
                    (written, values.as_slice())
                {
                    let edits =
                        round_values([*first, *last])
                            .into_iter()
                            .map(|(value, choices)| {
                                let edit = TextEdit {
                                    new: written.with(value, MOST_DIGITS),
                                    hint: None,
                                    ..place.clone()
                                };
                                (edit, choices.log10())
                            });
                    found.push(edits.filter(|(it, _)| it.new != it.old).collect());
                    break;
                }
            }
        }
        Ok(found)
    }

    /// The values with which the pieces that are read from runs have the rate of the others on a subject, and that rate less and
    /// plus the deviation of a few runs, in this order; a rate that is never passed has none.
    fn values_between(
        &self,
        context: &Context<'_>,
        (place, subject): (&TextEdit, &Subject),
    ) -> Vec<f64> {
        let is_run = |piece: &&Evidence| {
            let entry = self.study.entry(&piece.id);
            entry.is_ok_and(|entry| self.runs_of(entry).is_some())
        };
        let mean = |evidence: &[Evidence], of_runs: bool| {
            let pieces = evidence
                .iter()
                .filter(|it| is_run(it) == of_runs && !it.intermediate);
            let rates: Vec<f64> = pieces
                .filter_map(|it| Rate::on(it, subject)?.share())
                .collect();
            (!rates.is_empty()).then(|| rates.iter().sum::<f64>() / rates.len() as f64)
        };
        let written = Written::read(&place.old);
        let target = mean(&self.result.evidence, false);
        let start = mean(&self.result.evidence, true);
        let (Some(written), Some(target), Some(start)) = (written, target, start) else {
            return Vec::new();
        };
        // With one factor the runs are judged once, whatever is asked of their rate.
        let mut known: BTreeMap<u64, Option<f64>> = BTreeMap::new();
        let mut rate = |factor: f64| {
            *known.entry(factor.to_bits()).or_insert_with(|| {
                let edit = TextEdit {
                    new: written.with(written.value * factor, MOST_DIGITS + 3),
                    // Of models nothing is asked here.
                    reach: Reach::Runs,
                    ..place.clone()
                };
                // A number with which the study cannot be read is none.
                let study = context.scratch.with(&edit).ok()?;
                let edit = (&edit, context.now);
                let evidence = self.produced_with(&study, context.scratch, edit, FEW_RUNS);
                mean(&evidence.ok()?, true)
            })
        };
        let deviation = (target * (1.0 - target) / FEW_RUNS as f64).sqrt();
        let factors = [-DEVIATIONS, 0.0, DEVIATIONS]
            .map(|side| crossing(start, target + side * deviation, &mut rate));
        factors
            .into_iter()
            .flatten()
            .map(|factor| written.value * factor)
            .collect()
    }
}

/// The factor with which a rate, `start` with the factor 1, passes a target.
fn crossing(start: f64, target: f64, rate: &mut dyn FnMut(f64) -> Option<f64>) -> Option<f64> {
    let start = start > target;
    let mut ends = [(1.0_f64, true), (1.0, true)];
    for factor in FACTORS {
        for (end, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
            let (near, goes_on) = *end;
            if !goes_on {
                continue;
            }
            let far = factor.powf(sign);
            match rate(far).map(|it| it > target) {
                None => end.1 = false,
                Some(is_above) if is_above == start => end.0 = far,
                Some(_) => {
                    let (mut near, mut far) = (near.ln(), far.ln());
                    for _ in 0..HALVINGS {
                        let middle = (near + far) / 2.0;
                        match (rate(middle.exp())? > target) == start {
                            true => near = middle,
                            false => far = middle,
                        }
                    }
                    return Some(((near + far) / 2.0).exp());
                }
            }
        }
    }
    None
}

/// Round values between two of one sign, each with how many as round there are within [`DECADES`] decades.
fn round_values(ends: [f64; 2]) -> Vec<(f64, f64)> {
    let sizes = ends.map(f64::abs);
    let (low, high) = (sizes[0].min(sizes[1]), sizes[0].max(sizes[1]));
    let middle = (low * high).sqrt();
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut add = |round: f64, per_decade: f64| {
        let is_near = round * AROUND >= low && round <= high * AROUND;
        let is_new = found
            .iter()
            .all(|(it, _)| (it - round).abs() > 1e-9 * round);
        if is_near && is_new {
            found.push((round.copysign(ends[0]), per_decade * DECADES));
        }
    };
    let power = middle.log10().floor() as i32;
    const DIGITS: [(&[f64], f64); 3] = [
        (&[1.0], 1.0),
        (&[2.0, 5.0], 2.0),
        (&[1.5, 2.5, 3.0, 4.0, 6.0, 7.0, 8.0, 9.0], 9.0),
    ];
    for (digits, per_decade) in DIGITS {
        for power in [power, power + 1] {
            for digit in digits {
                add(digit * 10.0_f64.powi(power), per_decade);
            }
        }
    }
    for digits in 2..=MOST_DIGITS {
        let scale = 10.0_f64.powi(digits - 1 - power);
        add(
            (middle * scale).round() / scale,
            9.0 * 10.0_f64.powi(digits - 1),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{Written, crossing, round_values};

    #[test]
    fn the_roundest_values_about_one_are_cheapest() {
        let found = round_values([0.113, 0.123]);
        let of = |value: f64| {
            let mut all = found.iter();
            all.find(|(it, _)| (it - value).abs() < 1e-12)
                .map(|it| it.1)
        };
        assert_eq!(
            (of(0.1), of(0.12), of(0.118), of(0.2)),
            (Some(2.0), Some(180.0), Some(1800.0), None)
        );
        assert!(round_values([-8.3, -8.1]).iter().any(|(it, _)| *it == -8.0));
    }

    /// A rate that falls as the number grows, and one with values at which nothing can be judged.
    #[test]
    fn the_factor_is_enclosed_in_either_direction() {
        let mut falls = |factor: f64| Some((0.5 / factor).min(1.0));
        for (target, expected) in [(0.25, 2.0), (0.8, 0.625), (0.05, 10.0)] {
            let found = crossing(0.5, target, &mut falls).expect("it is passed");
            assert!((found / expected - 1.0).abs() < 0.02, "{target}: {found}");
        }
        let mut never = |_: f64| Some(0.5);
        assert_eq!(crossing(0.5, 0.9, &mut never), None);
        let mut refused = |factor: f64| (factor > 1.0).then_some(0.5 / factor);
        assert_eq!(crossing(0.5, 0.8, &mut refused), None);
    }

    #[test]
    fn a_number_is_replaced_with_what_stands_around_it() {
        let of =
            |text, value, digits| Written::read(text).map(|it: Written<'_>| it.with(value, digits));
        assert_eq!(of("8 N", 7.96, 1).as_deref(), Some("8 N"));
        assert_eq!(of("0.13", 0.1043, 1).as_deref(), Some("0.1"));
        assert_eq!(of("0.13", 0.1043, 3).as_deref(), Some("0.104"));
        assert_eq!(of("<=120", 148.7, 2).as_deref(), Some("<=150"));
        assert_eq!(of("N", 1.0, 1), None);
    }
}
