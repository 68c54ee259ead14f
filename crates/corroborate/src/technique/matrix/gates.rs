//! Lines of fault trees that are suspected as a whole: a gate that should be another, or a number.
//!
//! # Definition
//! Of a tree that disagrees strongly with something each single change of its structure is tried on all evidence
//! ([`crate::refine::trees`]). For a suspect that is such a tree the best of them that explains what it is named for says the
//! line; others that explain as much are named with theirs. Where a number that is solved for
//! ([`refinement::Ground::of_named_numbers`]) weighs more, although it is free ([`refinement::FREE_VALUE`]), it says the line
//! instead.
//!
//! # Assumes
//! That of [`super::lines`].
//!
//! # Guarantee
//! That of [`super::lines`].

use super::Diagnosing;
use super::lines::is_whole_model;
use crate::refine::proposal::ground;
use crate::refine::trees::{Tree, of_structure, silent};
use crate::technique::kinds::Asked;
use diagnostic::Problem;
use evidence::{STRONG, Suspect, Symptom};
use refinement::{NamedOffer, RewrittenOffer, Solver};
use study::{Entry, Work};

/// What could be changed in a fault tree.
pub(super) struct OfTree {
    evidence: String,
    text: String,
    offers: Vec<RewrittenOffer>,
}

impl OfTree {
    /// The most that one of its changes explains, with what counts against it.
    pub(super) fn weight(&self) -> Option<f64> {
        let weights = self.offers.iter().map(|it| it.weight);
        weights.max_by(f64::total_cmp)
    }
}

impl Diagnosing<'_> {
    /// What could be changed in the fault trees that disagree strongly with something.
    pub(super) fn offered_trees(&self) -> Result<Vec<OfTree>, Problem> {
        let apart = self.disagreements(&self.result.evidence);
        let mut found = Vec::new();
        for entry in &self.study.ledger {
            let disagrees = apart.iter().any(|((one, other, _), apart)| {
                *apart > STRONG && [one, other].contains(&&entry.id)
            });
            if !disagrees {
                continue;
            }
            let offered = of_structure(self.study, self.result, entry, self.setting)?;
            found.extend(offered.map(|(text, offers)| OfTree {
                evidence: entry.id.clone(),
                text,
                offers,
            }));
        }
        Ok(found)
    }

    /// Gives the trees among the suspects the lines that a change fixes.
    pub(super) fn tree_lines(
        &self,
        suspects: &mut [Suspect],
        trees: &[OfTree],
    ) -> Result<(), Problem> {
        for entry in &self.study.ledger {
            let Work::FaultTree { tree, .. } = &entry.work else {
                continue;
            };
            if !suspects.iter().any(|it| is_whole_model(it, &entry.id)) {
                continue;
            }
            let text = host::files::read_source(&self.study.folder.join(tree))?.text;
            let numbers = self.numbers_of_tree(entry, &text)?;
            let structure = trees.iter().find(|it| it.evidence == entry.id);
            for suspect in suspects
                .iter_mut()
                .filter(|it| is_whole_model(it, &entry.id))
            {
                let own = numbers
                    .iter()
                    .filter(|(_, it)| suspect.subjects.contains(&it.subject));
                let own: Vec<&(f64, NamedOffer)> = own.collect();
                let weight = own.iter().map(|it| it.0).fold(f64::NEG_INFINITY, f64::max);
                let is_pointed = structure.is_some_and(|it| point_at_gate(suspect, it, weight));
                if !is_pointed {
                    point_at_number(suspect, &text, &own);
                }
            }
        }
        Ok(())
    }

    /// The numbers of a tree that were solved for, with their weights.
    fn numbers_of_tree(
        &self,
        entry: &Entry,
        text: &str,
    ) -> Result<Vec<(f64, NamedOffer)>, Problem> {
        let host = silent(self.setting);
        let solver = Tree {
            asked: Asked {
                study: self.study,
                entry,
                host: &host,
            },
        };
        let ground = ground(self.study, self.result);
        let offers = ground.of_named_numbers(&entry.id, text, &solver);
        let before = solver.values(text).unwrap_or_default();
        self.setting.go_on()?;
        let weighed = offers.into_iter().map(|it| {
            let weight = ground.weight_of_value(&entry.id, &before, &it.values);
            (weight.unwrap_or(f64::NEG_INFINITY), it)
        });
        Ok(weighed.collect())
    }
}

/// Says the line of the gate that explains what a suspect is named for, if it weighs at least as much as this; whether it does.
fn point_at_gate(suspect: &mut Suspect, tree: &OfTree, weight: f64) -> bool {
    let is_named = |it: &&RewrittenOffer| {
        let mut subjects = it.subjects.iter();
        it.weight >= weight && subjects.any(|subject| suspect.subjects.contains(subject))
    };
    let own: Vec<&RewrittenOffer> = tree.offers.iter().filter(is_named).collect();
    let Some((first, others)) = own.split_first() else {
        return false;
    };
    let line = |it: &RewrittenOffer| {
        let (line, _) = prism_lang::line_and_column(&tree.text, it.rewritten.place);
        u32::try_from(line).ok()
    };
    let subjects: Vec<String> = first.subjects.iter().map(|it| it.in_words()).collect();
    suspect.asset.line = line(first);
    suspect.asset.part = Some(first.rewritten.part.clone());
    suspect.explanation.push_str(&format!(
        " If {}, it agrees with all others on {}; {} changes of the tree's gates were tried that change what is answered.",
        first.rewritten.what,
        subjects.join(" and "),
        first.tried
    ));
    let file = suspect.asset.file.clone().unwrap_or_default();
    let others = others
        .iter()
        .filter_map(|it| Some(format!("{file}:{} ({})", line(it)?, it.rewritten.what)));
    suspect.asset.together.extend(others);
    true
}

/// Says the line of the number that gives a tree the counted rate.
fn point_at_number(suspect: &mut Suspect, text: &str, own: &[&(f64, NamedOffer)]) {
    let Some(((_, first), others)) = own.split_first() else {
        return;
    };
    let line = |offer: &NamedOffer| {
        let (line, _) = prism_lang::line_and_column(text, offer.number.span.start);
        u32::try_from(line).ok()
    };
    suspect.asset.line = line(first);
    suspect.asset.part = Some(format!("`{}`", first.number.name));
    suspect.explanation.push_str(&format!(
        " With {:.3} in place of {} its rate is that of {}.",
        first.value,
        first.number.value,
        first.counts.words()
    ));
    // What it is to be instead can be offered, as it is written for a text.
    let changed = first.number.set(text, first.value);
    let (start, end) = (first.number.span.start, first.number.span.end);
    let behind = text.len() - end;
    suspect.symptoms.push(Symptom::EditExplains {
        subject: first.subject.clone(),
        found: text[start..end].to_owned(),
        instead: changed[start..changed.len() - behind].to_owned(),
        pairs: suspect
            .asset
            .evidence
            .iter()
            .map(|id| [id.clone(), first.counts.evidence.clone()])
            .collect(),
        share: 1.0,
    });
    let file = suspect.asset.file.clone().unwrap_or_default();
    let others = others
        .iter()
        .filter_map(|(_, it)| Some(format!("{file}:{}", line(it)?)));
    suspect.asset.together.extend(others);
}
