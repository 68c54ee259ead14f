//! Fault trees: one change of a gate that makes the evidence agree.
//!
//! # Definition
//! All single changes of a tree's structure ([`fault_tree::rewrites()`]) are computed and tried on all evidence, where the tree
//! disagrees strongly with counts ([`refinement::Ground::of_texts`]). None of them has a free number.
//!
//! # Cost
//! One analysis of the tree for each of at most some hundred texts.

use super::proposal::{Change, Offered, Proposal, effects, ground};
use super::texts;
use crate::technique::kinds::{Asked, TreeChange, tree_values};
use diagnostic::Problem;
use evidence::{StudyResult, Suspect, SuspectKind};
use fault_tree::{Format, RewriteKind, rewrites};
use host::{Events, Host};
use refinement::{Rewritten, RewrittenOffer, Values, unified};
use study::{Entry, Study, Work};

/// Decades by which an argument that stands in the wrong gate is rarer than a gate of the wrong kind: it is no slip of a word.
const RARER: f64 = 2.0;

/// Answers for other texts of a fault tree.
pub(crate) struct Tree<'a> {
    pub(crate) asked: Asked<'a>,
}

impl refinement::Solver for Tree<'_> {
    fn values(&self, text: &str) -> Result<Values, String> {
        tree_values(self.asked, &TreeChange::Text(text)).map_err(|problem| problem.warning_line())
    }
}

/// A host to which nothing is said: what there is to warn of was said when the study ran.
pub(crate) fn silent(host: &Host) -> Host {
    Host {
        events: Events::none(),
        ..host.clone()
    }
}

/// What could be changed in the structure of an entry's fault tree, with its text; none if the entry has no tree.
pub(crate) fn of_structure(
    study: &Study,
    result: &StudyResult,
    entry: &Entry,
    host: &Host,
) -> Result<Option<(String, Vec<RewrittenOffer>)>, Problem> {
    let Work::FaultTree { tree, .. } = &entry.work else {
        return Ok(None);
    };
    let text = texts::read(study, tree)?.text;
    let format = match tree.extension().is_some_and(|it| it == "xml") {
        true => Format::OpenPsa,
        false => Format::Galileo,
    };
    let host = silent(host);
    let solver = Tree {
        asked: Asked {
            study,
            entry,
            host: &host,
        },
    };
    let all = || -> Vec<Rewritten> {
        let found = rewrites(&text, format).into_iter();
        let found = found.map(|it| Rewritten {
            kind: match it.kind {
                RewriteKind::Gate => 0,
                RewriteKind::Argument => 1,
            },
            rarer: match it.kind {
                RewriteKind::Gate => 0.0,
                RewriteKind::Argument => RARER,
            },
            place: it.place,
            part: format!("gate `{}`", it.gate),
            what: it.what,
            text: it.text,
        });
        found.collect()
    };
    let offers = ground(study, result).of_texts(&entry.id, &text, &all, &solver);
    // An interrupted analysis is no reason to say that there is nothing.
    host.go_on()?;
    Ok(Some((text, offers)))
}

/// Offers the changes of a tree's gates that explain what a suspect is named for.
pub(super) fn of_tree(
    (study, result): (&Study, &StudyResult),
    suspect: &Suspect,
    host: &Host,
    offered: &mut Offered,
) -> Result<(), Problem> {
    if suspect.asset.kind != SuspectKind::FormalModel {
        return Ok(());
    }
    for entry in &study.ledger {
        let Work::FaultTree { tree, .. } = &entry.work else {
            continue;
        };
        let file = tree.to_string_lossy().replace('\\', "/");
        let is_own = suspect.asset.evidence.contains(&entry.id)
            && suspect.asset.file.as_ref() == Some(&file);
        if !is_own {
            continue;
        }
        let Some((text, offers)) = of_structure(study, result, entry, host)? else {
            continue;
        };
        let is_named = |it: &&RewrittenOffer| {
            let mut subjects = it.subjects.iter();
            subjects.any(|subject| suspect.subjects.contains(subject))
        };
        let is_one_of_several = offers.len() > 1;
        for offer in offers.iter().filter(is_named) {
            let new = proposal(
                result,
                (entry, &file, &text),
                (suspect, is_one_of_several),
                offer,
            );
            offered.add(new);
        }
    }
    Ok(())
}

fn proposal(
    result: &StudyResult,
    (entry, file, text): (&Entry, &str, &str),
    (suspect, is_one_of_several): (&Suspect, bool),
    offer: &RewrittenOffer,
) -> Proposal {
    let changed = &offer.rewritten;
    let mut notes = vec![format!(
        "No number was fitted for it; {} other changes of the tree's gates were tried that change what is answered.",
        offer.tried.saturating_sub(1)
    )];
    if is_one_of_several {
        notes.push("The evidence does not tell it apart from another change of a gate.".to_owned());
    }
    let subject = offer.subjects.first();
    Proposal {
        title: format!("{}: {}", entry.id, changed.what),
        file: file.to_owned(),
        diff: unified(file, file, text, &changed.text),
        effects: subject.map_or_else(Vec::new, |subject| {
            effects(result, &offer.before, &offer.values, subject, &offer.counts)
        }),
        tried: offer.trial.clone(),
        notes,
        // What a tree is made of is decided by who knows the system.
        needs_decision: true,
        ..super::suspects::of(
            suspect,
            Change::Whole {
                file: file.to_owned(),
                old: text.to_owned(),
                new: changed.text.clone(),
            },
        )
    }
}
