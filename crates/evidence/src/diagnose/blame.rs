//! Which of two pieces that conflict is the odd one out, by all the evidence.
//!
//! # Definition
//! Some of the pieces under the same conditions are wrong, and each other one has the rate of the system. For a set `W` of
//! wrong ones
//!
//! ```text
//! P(W) P(data | W) = product over groups of W of  WRONG * P(group)  *  P(all others together)
//! ```
//!
//! Pieces of `W` that share an assumption ([`mod@super::voices`]) may be wrong together: they are one group with one rate, or
//! each one of its own, whichever is likelier. All others are groups of one. A group with data of the real system counts a
//! tenth: tables and recordings are less likely to be wrong than models of it. The blame is shared out between two pieces in
//! the proportion of the sets with the one and without the other.
//!
//! The runs of simulators and recordings are all read through the same words and the same monitor. Where several pieces are
//! read so, or one that comes out alike in all its runs, and all of them are in `W`, what they are read through may be wrong in
//! their place: one error with one rate, which has the prior [`READING`]. What such sets weigh is the part of the blame that the reading has.
//!
//! Where a model computes that a requirement always holds, the sets are weighed by the rates of its violations, which the model
//! excludes ([`Rate::Never`]): what was seen a few times cannot be impossible, although it lies within the margin of a certainty.
//!
//! # Assumes
//! Pieces that share no assumption ([`mod@super::voices`]) are wrong independently of each other. A wrong count has any
//! rate, by Jeffreys' prior; the right pieces have one rate, to within the margin where it is computed. How often models,
//! data and what runs are read through are wrong is a guess, which no count tells. Trials are independent, or count at
//! their effective size.
//!
//! # Source and guarantee
//! Bayes' theorem over all sets (H. Jeffreys, "Theory of Probability", 1961, section 5.04, for the prior of each further
//! hypothesis). Two against two of one kind and size that agree with each other have one half each (of models against data
//! of the real system the models have more); one against two that agree beyond what chance brings about is the odd one out.
//! The blame of two pieces adds up to 1, and of one piece against several it never contradicts itself: all are of one
//! distribution over sets.
//!
//! # Cost
//! `2^n` sets of at most [`MOST`] pieces; of more, the two and those that differ most from them.

use super::matter::Matter;
use super::rates::rate_or_never;
use super::strength::{Rate, ln_together, strength};
use super::voices::share_assumption;
use crate::{AskedBy, Evidence, Measure, Subject};

/// How likely a group is to be wrong against that it is right, as a natural logarithm.
const WRONG: f64 = -std::f64::consts::LN_10;

/// How much likelier a model is wrong than the real system's data, as a natural logarithm.
const DATA: f64 = std::f64::consts::LN_10;

/// How likely what runs are read through is wrong: a third of a model's, which has more numbers to go wrong.
const READING: f64 = WRONG - 1.098_612_288_668_109_8;

/// Pieces whose sets are gone through.
const MOST: usize = 10;

/// A piece with its rate.
struct Piece<'e> {
    evidence: &'e Evidence,
    rate: Rate,
}

/// The blame of two pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blame {
    /// The share of each piece by itself.
    pub pieces: [f64; 2],
    /// The share of what each is read through, and others with it.
    pub reading: [f64; 2],
}

/// Whether the runs of a piece are read through words on signals, as those of others are: what is counted in tables is not,
/// and has no run that is a witness.
pub(super) fn is_read_from_runs(piece: &Evidence) -> bool {
    let has_runs = piece.findings.iter().any(|it| !it.witnesses.is_empty());
    piece.technique.traits().asked_by == AskedBy::Monitor && has_runs && !piece.published
}

impl Matter<'_> {
    /// The shares of the blame of two pieces that conflict on a subject, judged by `form` where they are; their sum is 1.
    pub(super) fn blame(
        &self,
        [one, other]: [&Evidence; 2],
        subject: &Subject,
        form: Option<&str>,
    ) -> Blame {
        let margin = self.margin(subject);
        let pieces = self.pieces_of([one, other], subject, form);
        let place = |id: &str| pieces.iter().position(|it| it.evidence.id == id);
        let (Some(first), Some(second)) = (place(&one.id), place(&other.id)) else {
            return Blame {
                pieces: [0.5; 2],
                reading: [0.0; 2],
            };
        };
        let read: usize = pieces
            .iter()
            .enumerate()
            .filter(|(_, it)| is_read_from_runs(it.evidence))
            .map(|(place, _)| 1_usize << place)
            .sum();
        let is_read = |place: usize| read >> place & 1 == 1;
        let are_alike =
            (0..pieces.len()).all(|place| !is_read(place) || pieces[place].rate.has_one_outcome());
        let may_be_misread = read.count_ones() > 1 || read != 0 && are_alike;
        // Of each of the two as it is, and of what each is read through.
        let mut weights: [Vec<f64>; 4] = [const { Vec::new() }; 4];
        for set in 1_usize..1 << pieces.len() {
            let is_wrong = |place: usize| set >> place & 1 == 1;
            let of = match (is_wrong(first), is_wrong(second)) {
                (true, false) => 0,
                (false, true) => 1,
                _ => continue,
            };
            let (mut wrong, mut right) = (Vec::new(), Vec::new());
            for (place, piece) in pieces.iter().enumerate() {
                match is_wrong(place) {
                    true => wrong.push(piece),
                    false => right.push(piece.rate),
                }
            }
            let together = ln_together(&right, margin);
            weights[of].push(ln_wrong(&wrong, subject, margin) + together);
            if may_be_misread && set & read == read {
                let (through, rest): (Vec<&Piece<'_>>, Vec<&Piece<'_>>) =
                    wrong.iter().partition(|it| is_read_from_runs(it.evidence));
                let rates: Vec<Rate> = through.iter().map(|it| it.rate).collect();
                let reading = READING + ln_together(&rates, margin);
                let accused = if is_read([first, second][of]) {
                    of + 2
                } else {
                    of
                };
                weights[accused].push(reading + ln_wrong(&rest, subject, margin) + together);
            }
        }
        let greatest = weights
            .iter()
            .flatten()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let sums = weights.map(|all| all.iter().map(|it| (it - greatest).exp()).sum::<f64>());
        let total: f64 = sums.iter().sum();
        let [one, other, by_one, by_other] = sums.map(|sum| sum / total);
        Blame {
            pieces: [one, other],
            reading: [by_one, by_other],
        }
    }

    /// The pieces under the same conditions that say something of a subject, the two always among them.
    fn pieces_of(
        &self,
        two: [&Evidence; 2],
        subject: &Subject,
        form: Option<&str>,
    ) -> Vec<Piece<'_>> {
        let margin = self.margin(subject);
        let of = |evidence| {
            let mut judged = self.judged(evidence, subject).into_iter();
            let by_form = judged.find(|judged| form == Some(judged.form.as_str()));
            let rate = by_form
                .map(|judged| judged.rate)
                .or_else(|| rate_or_never(evidence, subject))?;
            Some(Piece { evidence, rate })
        };
        let all = self
            .speaking()
            .filter(|e| e.conditions == two[0].conditions);
        let mut pieces: Vec<Piece<'_>> = all.filter_map(of).collect();
        // A model for which a violation is impossible is wrong if one was seen, however few there are.
        let is_certain = |it: &Piece<'_>| {
            it.rate == Rate::Computed(1.0)
                && it.evidence.finding(subject).is_some_and(|finding| {
                    matches!(&finding.measure, Measure::Probability { answer, .. } if !answer.guarantee.is_estimated())
                })
        };
        if matches!(subject, Subject::Requirement(_)) && pieces.iter().any(is_certain) {
            for piece in &mut pieces {
                piece.rate = piece.rate.of_contrary();
            }
        }
        let is_of_two = |it: &Piece<'_>| two.iter().any(|own| own.id == it.evidence.id);
        if pieces.len() > MOST {
            let own: Vec<Rate> = pieces
                .iter()
                .filter(|it| is_of_two(it))
                .map(|it| it.rate)
                .collect();
            let apart = |it: &Piece<'_>| {
                let from = own.iter().map(|rate| strength(*rate, it.rate, margin));
                from.fold(0.0, f64::max)
            };
            pieces.sort_by(|a, b| {
                is_of_two(b)
                    .cmp(&is_of_two(a))
                    .then(apart(b).total_cmp(&apart(a)))
            });
            pieces.truncate(MOST);
        }
        pieces
    }
}

/// `ln` of the product over the groups of what is wrong.
fn ln_wrong(wrong: &[&Piece<'_>], subject: &Subject, margin: f64) -> f64 {
    let mut rest: Vec<&Piece<'_>> = wrong.to_vec();
    let mut sum = 0.0;
    while let Some(first) = rest.pop() {
        let mut group = vec![first];
        // All that is reached from the first by shared assumptions.
        let mut at = 0;
        while at < group.len() {
            let shares =
                |it: &&Piece<'_>| share_assumption(group[at].evidence, it.evidence, subject);
            let (more, others): (Vec<_>, Vec<_>) = rest.into_iter().partition(shares);
            group.extend(more);
            rest = others;
            at += 1;
        }
        let apart = group
            .iter()
            .map(|it| prior(&[it]) + ln_together(&[it.rate], margin));
        let rates: Vec<Rate> = group.iter().map(|it| it.rate).collect();
        let together = prior(&group) + ln_together(&rates, margin);
        sum += together.max(apart.sum());
    }
    sum
}

fn prior(group: &[&Piece<'_>]) -> f64 {
    match group.iter().any(|it| it.evidence.technique.is_of_system()) {
        true => WRONG - DATA,
        false => WRONG,
    }
}
