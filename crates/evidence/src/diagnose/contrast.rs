//! Pairs of cells that differ in one asset, tested.
//!
//! On the same traces only those with two verdicts speak: McNemar's exact test, a sign test of which way
//! they go (Q. McNemar, 1947). On different traces: Fisher's exact test. Traces without a verdict may each be kept or not: the
//! test and the strength are those of the completions that come nearest to each other, so that nothing is shown that these
//! traces alone could explain (as [`mod@super::strength`] has it).
//!
//! # Assumes
//! Traces are independent of each other; on different traces both cells are, too. The strength takes them so on the same
//! traces as well, where McNemar's test alone knows of pairs.

use super::strength::{Rate, strength};
use super::suspect::{Cell, Contrast, JudgedBy};
use crate::{Inaccuracy, Subject};

/// Traces with two verdicts, by which of the cells keeps the requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct SameTraces {
    /// The evidence whose assets gave the traces.
    pub evidence: String,
    /// The requirement or failure mode.
    pub subject: Subject,
    /// Property violated, monitor not; and the other way round.
    pub differing: [u64; 2],
}

/// All contrasts of the cells, in their order: requirement models on the same traces, then system models
/// under the same requirement model.
pub fn contrasts(
    cells: &[Cell],
    same: &[SameTraces],
    margin: impl Fn(&Subject) -> f64,
) -> Vec<Contrast> {
    let filled: Vec<&Cell> = cells.iter().filter(|c| c.trials > 0).collect();
    let mut found = Vec::new();
    for (place, one) in filled.iter().enumerate() {
        for other in filled.iter().skip(place + 1) {
            let on_same = one.evidence == other.evidence && one.judged_by != other.judged_by;
            let by_same = one.evidence != other.evidence
                && one.judged_by == other.judged_by
                && one.traces != other.traces;
            // The property of a failure mode counts runs here and opportunities there.
            let is_rate = one.judged_by == JudgedBy::Monitor
                || matches!(one.subject, Subject::Requirement(_));
            if one.subject != other.subject {
                continue;
            }
            if on_same {
                let pair = same
                    .iter()
                    .find(|s| s.evidence == one.evidence && s.subject == one.subject);
                found.extend(pair.map(|pair| on_same_traces(one, other, pair)));
            } else if by_same && is_rate {
                found.push(on_others(one, other, margin(&one.subject)));
            }
        }
    }
    found
}

fn on_same_traces(one: &Cell, other: &Cell, same: &SameTraces) -> Contrast {
    let [first, second] = same.differing;
    let p_value = stats::Sample::new(first, first + second)
        .map_or(1.0, |sample| stats::binomial_test_two_sided(sample, 0.5));
    contrast(
        one,
        other,
        Inaccuracy::RequirementModel,
        (p_value, Some(first + second), 0.0),
    )
}

fn on_others(one: &Cell, other: &Cell, margin: f64) -> Contrast {
    let p_value = match nearest(one, other) {
        Some([a, b]) => stats::fisher_exact(a, b),
        None => 1.0,
    };
    contrast(one, other, Inaccuracy::SystemModel, (p_value, None, margin))
}

/// The completions of two cells whose shares come nearest to each other; nothing if they can be the same.
fn nearest(one: &Cell, other: &Cell) -> Option<[stats::Sample; 2]> {
    let ([_, one_high], [_, other_high]) = (one.shares(), other.shares());
    let (lower, higher) = match one_high < other_high {
        true => (one, other),
        false => (other, one),
    };
    let ([_, low], [high, _]) = (lower.shares(), higher.shares());
    let all = |cell: &Cell, count| stats::Sample::new(count, cell.trials + cell.undecided).ok();
    let apart = [
        all(lower, lower.count + lower.undecided)?,
        all(higher, higher.count)?,
    ];
    (low < high).then_some(apart)
}

fn contrast(
    one: &Cell,
    other: &Cell,
    changed: Inaccuracy,
    (p_value, differing, margin): (f64, Option<u64>, f64),
) -> Contrast {
    let rate = |cell: &Cell| Rate::Counted {
        count: cell.count as f64,
        open: cell.undecided as f64,
        trials: (cell.trials + cell.undecided) as f64,
    };
    Contrast {
        cells: format!("{}-{}", one.cell, other.cell),
        changed,
        evidence: [one.evidence.clone(), other.evidence.clone()],
        subject: one.subject.clone(),
        p_value,
        strength: strength(rate(one), rate(other), margin),
        differing,
    }
}
