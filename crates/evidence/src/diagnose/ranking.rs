//! From clues to a ranked list of suspects.
//!
//! # Definition
//! Clues against one asset are one suspect. Ways to fail happen at separate opportunities, so their
//! strengths add up; requirements are sums of what the ways to fail do, so only the strongest counts:
//! `score = max(sum over failure modes, max over requirements)`, where of several clues on one subject
//! the strongest counts. Suspects are ranked by score; of equal ones tools come first, then requirement
//! models, then system models (the cheapest to look at first), then by the order of the ledger.
//!
//! A suspect is fixed if the clues of strong evidence against it all are ([`STRONG`]; without such ones, all), by the
//! evidence that fixes the strongest of them.
//!
//! The suspect's title and first words are those of its strongest clue, the rest of the [`SAID`] strongest.
//!
//! # Assumes
//! What counts say of different ways to fail is independent. Clues against one asset have one cause.
//!
//! # Guarantee
//! The order is that of the scores, which are no probabilities: the shares of the blame add up to 1 for each conflict
//! ([`super::blame`]), the scores of several conflicts do not. Each clue is of one suspect.

use super::matter::{Clue, Matter};
use super::shared::{share_with_edits, share_with_tools};
use super::strength::{CERTAIN, STRONG};
use super::suspect::{Suspect, SuspectAsset};
use crate::{Inaccuracy, Subject};
use std::collections::BTreeMap;

/// Clues whose argument is told, at most; all are among the symptoms.
const SAID: usize = 6;

/// Witnesses that are kept of a suspect, at most.
const WITNESSES: usize = 5;

/// Ranks what the evidence itself shows, with `more` clues from elsewhere.
///
/// ```
/// let matter = evidence::Matter {
///     requirements: &[], failure_modes: &[], evidence: &[], comparisons: &[], cells: &[], tables: &[], study: "my-study",
/// };
/// assert!(evidence::rank(&matter, Vec::new()).is_empty());
/// ```
pub fn rank(matter: &Matter<'_>, more: Vec<Clue>) -> Vec<Suspect> {
    let mut clues = matter.of_conflicts();
    clues.extend(matter.of_missing_modes());
    clues.extend(matter.of_missing_triggers());
    clues.extend(matter.of_other_methods());
    clues.extend(matter.of_forms());
    clues.extend(matter.of_hidden_conflicts());
    clues.extend(more);
    share_with_tools(matter, &mut clues);
    share_with_edits(&mut clues);
    // The strongest first, so that titles and arguments begin with it.
    clues.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut by_asset: Vec<(SuspectAsset, Vec<Clue>)> = Vec::new();
    for clue in clues {
        match by_asset
            .iter_mut()
            .find(|(asset, _)| is_same(asset, &clue.asset))
        {
            Some((asset, of_asset)) => {
                let new = clue.asset.evidence.iter();
                let new: Vec<String> = new
                    .filter(|id| !asset.evidence.contains(id))
                    .cloned()
                    .collect();
                asset.evidence.extend(new);
                let others = clue.asset.together.iter();
                let others: Vec<String> = others
                    .filter(|file| !asset.together.contains(file))
                    .cloned()
                    .collect();
                asset.together.extend(others);
                asset.line = asset.line.or(clue.asset.line);
                of_asset.push(clue);
            }
            None => by_asset.push((clue.asset.clone(), vec![clue])),
        }
    }
    let merged = by_asset
        .into_iter()
        .filter_map(|(asset, clues)| suspect(asset, clues));
    let mut suspects: Vec<Suspect> = merged.collect();
    let place = |suspect: &Suspect| {
        let ids = suspect.asset.evidence.iter();
        let places = ids.filter_map(|id| matter.evidence.iter().position(|e| &e.id == id));
        places.min().unwrap_or(usize::MAX)
    };
    suspects.sort_by(|a, b| {
        let by_score = b.score.total_cmp(&a.score);
        by_score
            .then_with(|| order(a.inaccuracy).cmp(&order(b.inaccuracy)))
            .then_with(|| place(a).cmp(&place(b)))
    });
    for (rank, suspect) in (1..).zip(&mut suspects) {
        suspect.rank = rank;
    }
    suspects
}

fn is_same(one: &SuspectAsset, other: &SuspectAsset) -> bool {
    let is_named = one.file.is_some() || one.evidence == other.evidence;
    is_named && (one.kind, &one.file, &one.part) == (other.kind, &other.file, &other.part)
}

fn order(inaccuracy: Inaccuracy) -> u8 {
    match inaccuracy {
        Inaccuracy::Tool => 0,
        Inaccuracy::RequirementModel => 1,
        Inaccuracy::SystemModel => 2,
        Inaccuracy::Undetermined => 3,
    }
}

/// All clues against one asset, the strongest first, as one suspect.
fn suspect(asset: SuspectAsset, clues: Vec<Clue>) -> Option<Suspect> {
    let score = score(&clues);
    let mended = mended(&clues);
    let mut clues = clues.into_iter();
    let mut suspect = Suspect::of(clues.next()?);
    let mut said = 1;
    for clue in clues {
        if !suspect.subjects.contains(&clue.subject) {
            suspect.subjects.push(clue.subject);
        }
        let new = unsaid(&suspect.explanation, &clue.explanation);
        if said < SAID && !new.is_empty() {
            said += 1;
            suspect.explanation.push(' ');
            suspect.explanation.push_str(&new);
        }
        suspect.symptoms.push(clue.symptom);
        suspect.figures.extend(clue.figures);
        suspect.witnesses.extend(clue.witnesses);
        for reason in clue.ruled_out {
            if !suspect.ruled_out.contains(&reason) {
                suspect.ruled_out.push(reason);
            }
        }
    }
    let mut kept: Vec<crate::Witness> = Vec::new();
    for witness in std::mem::take(&mut suspect.witnesses) {
        if kept.len() < WITNESSES && kept.iter().all(|w| w.replay != witness.replay) {
            kept.push(witness);
        }
    }
    suspect.witnesses = kept;
    suspect.asset = asset;
    suspect.score = score;
    suspect.resolved_by = mended;
    Some(suspect)
}

/// The sentences of an argument that were not said before: what holds of the asset holds for each subject.
fn unsaid(said: &str, argument: &str) -> String {
    let sentences = argument.split_inclusive(". ");
    let new = sentences.filter(|sentence| !said.contains(sentence.trim_end()));
    new.collect::<String>().trim_end().to_owned()
}

/// The evidence that fixes all that counts against an asset; `clues` are sorted, the strongest first.
fn mended(clues: &[Clue]) -> Option<String> {
    let strong = clues.iter().filter(|clue| clue.score >= STRONG).count();
    let counting = match strong {
        0 => clues,
        _ => &clues[..strong],
    };
    let is_mended = counting.iter().all(|clue| clue.resolved_by.is_some());
    let first = counting.first().filter(|_| is_mended);
    first.and_then(|clue| clue.resolved_by.clone())
}

fn score(clues: &[Clue]) -> f64 {
    let mut of_modes: BTreeMap<&Subject, f64> = BTreeMap::new();
    let mut of_requirements = 0.0_f64;
    for clue in clues {
        match clue.subject {
            Subject::Requirement(_) => of_requirements = of_requirements.max(clue.score),
            Subject::FailureMode(_) => {
                let most = of_modes.entry(&clue.subject).or_default();
                *most = most.max(clue.score);
            }
        }
    }
    let modes: f64 = of_modes.values().sum();
    modes.max(of_requirements).clamp(0.0, CERTAIN) + 0.0
}

#[cfg(test)]
mod tests {
    use super::unsaid;

    #[test]
    fn a_sentence_is_said_once() {
        let said = "With 2 A and B agree (10^3.5 goes away). And the text says 2.";
        let more = "With 2 A and C agree (10^4.5 goes away). And the text says 2.";
        assert_eq!(
            unsaid(said, more),
            "With 2 A and C agree (10^4.5 goes away)."
        );
        assert_eq!(unsaid(said, said), "");
    }
}
