//! What the ledger is told of changes that were accepted: whose counts a number was set to, and with what a changed text was chosen
//! to agree.
//!
//! # Definition
//! A change of a text is *chosen for* evidence E on a subject when it is offered for a suspect that touches the subject, and before it
//! E differed, at the 5 % level and without a correction, from evidence that rests on the text. Where both sides rest on it, the one whose
//! technique reads the changed key is said to be chosen, or else the later one. A change of a model's branches is chosen for the counts that it is offered for, too.
//!
//! # Source
//! A. Gelman and E. Loken, "The statistical crisis in science", American Scientist 102 (2014): what was chosen after a look at data is
//! not tested by them. The level from which on a difference counts as a reason is this project's.
//!
//! # Assumes
//! Whoever accepts a change has no other reason for it. Who has one takes the line out of the ledger and gives the reason in `changed`.
//!
//! # Guarantee
//! Evidence that differed before a change, and agrees with it afterwards, is not called independent of it.

use super::ledger_text::{SetTo, calibrated, chosen as chosen_text};
use super::proposal::{Change, Fitted, Proposal, is_of_structure};
use diagnostic::{Problem, Source};
use evidence::{
    AskedBy, Calibration, Comparison, Outcome, StudyResult, Subject, Suspect, Technique,
};
use host::files::{read_source, write_text};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use study::{Entry, Study};

/// From this p-value down a difference counts as a reason for a change.
const REASON: f64 = 0.05;

/// Evidence with which agreement is a fit once a change is made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ChosenFor {
    /// The evidence that rests on the changed text.
    pub entry: String,
    /// The evidence that it agrees with by the change.
    pub from: String,
    /// On what.
    pub subject: Subject,
}

impl ChosenFor {
    fn lineage(&self, what: &str) -> Calibration {
        Calibration {
            parameter: what.to_owned(),
            from: self.from.clone(),
            subject: self.subject.clone(),
            chosen: true,
        }
    }
}

/// Whether a change leaves no line of its own about counts that it was set to.
fn is_choice(change: &Change) -> bool {
    match change {
        Change::Model { change, .. } => is_of_structure(change),
        Change::Value { fitted, .. } => fitted.is_none(),
        Change::Form(_) | Change::Text { .. } | Change::Whole { .. } | Change::Exchange { .. } => {
            true
        }
        Change::Recalibrate(_) | Change::FitCommand(_) => false,
    }
}

/// For what evidence a proposal's change is chosen.
pub(super) fn chosen_for(result: &StudyResult, proposal: &Proposal) -> Vec<ChosenFor> {
    if !is_choice(&proposal.change) {
        return Vec::new();
    }
    let mut all = result.suspected().iter();
    let suspect = all.find(|it| Some(it.rank) == proposal.suspect);
    let mut found = Vec::new();
    let own = match &proposal.change {
        Change::Model { entry, change } => {
            found.push(ChosenFor {
                entry: entry.clone(),
                from: change.counts().evidence.clone(),
                subject: change.subject(),
            });
            vec![entry.clone()]
        }
        _ => suspect.map_or_else(Vec::new, |it| it.asset.evidence.clone()),
    };
    let subjects = suspect.map_or(&[][..], |it: &Suspect| &it.subjects);
    let differ = result.comparisons.iter().filter(|it| {
        subjects.contains(&it.subject)
            && it.outcome != Outcome::NotComparable
            && it.p_difference.is_some_and(|p| p <= REASON)
    });
    let reads = |id: &str| {
        let mut pieces = result.evidence.iter();
        let piece = pieces.find(|piece| piece.id == id);
        let part = suspect.and_then(|it| it.asset.part.as_deref());
        piece
            .zip(part)
            .is_some_and(|(piece, part)| is_read(part, piece.technique))
    };
    for it in differ {
        let chosen = of_pair(it, &own, &reads);
        found.extend(chosen.filter(|it| !found.contains(it)));
    }
    found
}

/// Whether a technique reads this part of the study's words: the key stands last in its name (`w0, model`).
fn is_read(part: &str, technique: Technique) -> bool {
    let key = part.rsplit(", ").next().unwrap_or(part);
    let traits = technique.traits();
    let is_monitored = matches!(traits.asked_by, AskedBy::Monitor);
    match key.trim_matches('`') {
        "model" | "property" | "occurs" | "opportunity" => technique.is_of_model(),
        "column" | "experiment" => traits.is_counted_by_people,
        "trace" | "graded" | "monitor" => is_monitored && !traits.is_counted_by_people,
        _ => false,
    }
}

/// What of a pair is chosen for what, where one of it rests on the text; where both do, the one that reads the part.
fn of_pair(pair: &Comparison, own: &[String], reads: &dyn Fn(&str) -> bool) -> Option<ChosenFor> {
    let (left, right) = (own.contains(&pair.left), own.contains(&pair.right));
    let (entry, from) = match (left, right) {
        (true, true) if reads(&pair.left) && !reads(&pair.right) => (&pair.left, &pair.right),
        (_, true) => (&pair.right, &pair.left),
        (true, false) => (&pair.left, &pair.right),
        (false, false) => return None,
    };
    Some(ChosenFor {
        entry: entry.clone(),
        from: from.clone(),
        subject: pair.subject.clone(),
    })
}

/// What is said of it before the change is accepted; none if it is chosen for nothing, or already said.
pub(super) fn note(proposal: &Proposal) -> Option<String> {
    let all = |of: &dyn Fn(&ChosenFor) -> String| {
        let names: BTreeSet<String> = proposal.chosen.iter().map(of).collect();
        names.into_iter().collect::<Vec<_>>().join(", ")
    };
    // Of a model's change what it is offered for is said already.
    let said = match &proposal.change {
        Change::Model { change, .. } => Some((&change.counts().evidence, change.subject())),
        _ => None,
    };
    let is_said = |it: &ChosenFor| {
        said.as_ref()
            .is_some_and(|(from, subject)| **from == it.from && *subject == it.subject)
    };
    let has_more = proposal.chosen.iter().any(|it| !is_said(it));
    has_more.then(|| {
        format!(
            "From then on, agreement with {} on {} is a fit, not corroboration: the ledger says so under `chosen`. Where something else \
             shows the change to be right, give that reason in `changed` and take the line out.",
            all(&|it| it.from.clone()),
            all(&|it| it.subject.in_words())
        )
    })
}

/// What an entry's texts were chosen for, with what an accepted change adds.
pub(super) fn with_choices(entry: &Entry, accepted: &[&Proposal]) -> Vec<Calibration> {
    let mut all = entry.chosen.clone();
    for proposal in accepted {
        let own = proposal.chosen.iter().filter(|it| it.entry == entry.id);
        for new in own.map(|it| it.lineage(&proposal.title)) {
            if !all.contains(&new) {
                all.push(new);
            }
        }
    }
    all
}

/// Writes into the entries of the ledger what the accepted changes of their texts and values rest on. Models that are refined have new
/// entries, which say it themselves.
pub(super) fn declare(study: &Study, accepted: &[&Proposal]) -> Result<(), Problem> {
    let in_place: Vec<&Proposal> = accepted
        .iter()
        .copied()
        .filter(|it| !matches!(it.change, Change::Model { .. }))
        .collect();
    let fitted: Vec<&Fitted> = in_place.iter().filter_map(|it| fitted_by(it)).collect();
    let path = study.folder.join("ledger.toml");
    let source = read_source(&path)?;
    let mut text = source.text.clone();
    // From the last entry on, so that what stands before keeps its place.
    for (place, entry) in study.ledger.iter().enumerate().rev() {
        let chosen = with_choices(entry, &in_place);
        if chosen != entry.chosen {
            let key = ("chosen", !entry.chosen.is_empty());
            write_list(&mut text, &source, place, key, &chosen_text(&chosen));
        }
        let mut set_to = SetTo::of(entry);
        for it in fitted.iter().filter(|it| it.entry == entry.id) {
            set_to.retain(|old| old.name != it.name);
            set_to.push(SetTo {
                key: "parameter",
                name: it.name.clone(),
                from: it.from.clone(),
                subject: it.subject.clone(),
                held: false,
                is_complement: false,
            });
        }
        if set_to != SetTo::of(entry) {
            let key = ("calibrated", !entry.calibrated.is_empty());
            write_list(&mut text, &source, place, key, &calibrated(&set_to));
        }
    }
    // What a number was set to has to stand before it.
    let mut order: Vec<&str> = study.ledger.iter().map(|it| it.id.as_str()).collect();
    let of = |order: &[&str], id: &str| order.iter().position(|it| *it == id);
    for it in fitted {
        let (own, from) = (of(&order, &it.entry), of(&order, &it.from));
        if let (Some(own), Some(from)) = (own, from)
            && from > own
        {
            text = moved_to_the_end(&text, own);
            let moved = order.remove(own);
            order.push(moved);
        }
    }
    match text == source.text {
        true => Ok(()),
        false => write_text(&path, &text, &path),
    }
}

fn fitted_by(proposal: &Proposal) -> Option<&Fitted> {
    match &proposal.change {
        Change::Value { fitted, .. } => fitted.as_ref(),
        _ => None,
    }
}

/// Writes a list of an entry: in the place of the one that is there, or behind its identifier. `text` equals `source` up to the entry's end.
fn write_list(
    text: &mut String,
    source: &Source,
    place: usize,
    (key, is_there): (&str, bool),
    written: &str,
) {
    let entry = place.to_string();
    let at = |key: &str| study::placed::value_place(source, &["evidence", &entry, key]);
    match is_there {
        true => {
            let value = written.trim_start_matches(&format!("{key} = "));
            text.replace_range(at(key), value);
        }
        false => {
            let id = at("id");
            let end = text[id.end..]
                .find('\n')
                .map_or(text.len(), |at| id.end + at);
            text.insert_str(end, &format!("\n{written}"));
        }
    }
}

/// A ledger with one of its entries behind all others.
fn moved_to_the_end(text: &str, place: usize) -> String {
    let heads = || text.match_indices("[[evidence]]").map(|(at, _)| at);
    // A head stands at the beginning of a line.
    let heads: Vec<usize> = heads()
        .filter(|at| *at == 0 || text[..*at].ends_with('\n'))
        .collect();
    // The last one stands there already.
    let (Some(start), Some(end)) = (heads.get(place), heads.get(place + 1).copied()) else {
        return text.to_owned();
    };
    let (before, entry, behind) = (&text[..*start], &text[*start..end], &text[end..]);
    format!("{before}{}\n\n{}\n", behind.trim_end(), entry.trim_end())
}

#[cfg(test)]
mod tests {
    use super::moved_to_the_end;

    #[test]
    fn an_entry_goes_behind_the_others_with_all_its_lines() {
        let text = "# [[evidence]]\n[[evidence]]\nid = \"A\"\n\n[[evidence]]\nid = \"B\"\n";
        assert_eq!(
            moved_to_the_end(text, 0),
            "# [[evidence]]\n[[evidence]]\nid = \"B\"\n\n[[evidence]]\nid = \"A\"\n"
        );
        assert_eq!(moved_to_the_end(text, 1), text);
    }
}
