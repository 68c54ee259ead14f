//! Two pieces whose sources changed places: what is entered under the conditions of the one is the other's.
//!
//! # Definition
//! Two pieces `P`, `Q` of one technique under different conditions changed places if
//!
//! * under the conditions of each there is other evidence from which it differs strongly (at least [`STRONG`], see
//!   [`mod@super::strength`]) on some subject, and
//! * with the findings of the other in its place each differs strongly from nobody, on all subjects that both have.
//!
//! Of several such pieces the one with which most goes away. The exchange takes `T - T'` of a conflict, `T'` being what is left with
//! the other's rate; where the piece on the other side of the conflict changed places, too, as far as the evidence can tell,
//! each takes half.
//!
//! # Assumes
//! One exchange at most was made, and all other evidence is right. That many pairs of pieces are tried is not allowed for.
//! Trials are independent, or count at their effective size.
//!
//! # Source and guarantee
//! One exchange in place of two wrong pieces, as in [`super::names`]: both have to be wrong where they stand and to fit where the
//! other stood, which a wrong rate does not do beyond chance.

use super::matter::{Clue, Matter, name_of, rate_in_words};
use super::rates::figure;
use super::strength::{Rate, STRONG, strength};
use super::suspect::{SuspectAsset, SuspectKind, Symptom};
use crate::{Evidence, Inaccuracy, Subject};

/// The piece that has what belongs here, and here is what belongs there, if the other evidence says so.
#[must_use]
pub fn changed_places<'e>(
    evidence: &'e [Evidence],
    piece: &Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<&'e Evidence> {
    let speaks = |it: &Evidence| !it.intermediate && !it.published;
    let others = evidence.iter().filter(|other| {
        speaks(other) && other.technique == piece.technique && other.conditions != piece.conditions
    });
    let gain = |other: &Evidence| {
        let two = [piece, other];
        let apart = |place: &Evidence, data: &Evidence| apart(evidence, two, place, data, margin);
        let now = [apart(piece, piece)?, apart(other, other)?];
        let then = [apart(piece, other)?, apart(other, piece)?];
        let are_wrong = now.iter().all(|[_, most]| *most >= STRONG);
        let fit = then.iter().all(|[_, most]| *most < STRONG);
        let sum = |of: [[f64; 2]; 2]| of.iter().map(|[sum, _]| sum).sum::<f64>();
        (are_wrong && fit).then(|| sum(now) - sum(then))
    };
    let found = others.filter_map(|other| Some((gain(other)?, other)));
    let best = found.max_by(|(one, _), (other, _)| one.total_cmp(other));
    best.filter(|_| speaks(piece)).map(|(_, other)| other)
}

/// How strongly the findings of `data` differ from the other evidence under the conditions of `place`, on the subjects that both of
/// `two` have: the sum, and the strongest; nothing if there is nobody to differ from.
fn apart(
    evidence: &[Evidence],
    two: [&Evidence; 2],
    place: &Evidence,
    data: &Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<[f64; 2]> {
    let others = evidence.iter().filter(|it| {
        it.conditions == place.conditions
            && !it.intermediate
            && two.iter().all(|own| own.id != it.id)
    });
    let mut all = Vec::new();
    for other in others {
        for finding in &place.findings {
            let subject = &finding.subject;
            let [Some(_), Some(_)] = two.map(|own| Rate::on(own, subject)) else {
                continue;
            };
            if let (Some(own), Some(theirs)) = (Rate::on(data, subject), Rate::on(other, subject)) {
                all.push(strength(theirs, own, margin(subject)));
            }
        }
    }
    let most = all.iter().copied().fold(0.0, f64::max);
    (!all.is_empty()).then(|| [all.iter().sum(), most])
}

impl Matter<'_> {
    /// What of a conflict goes away if pieces changed places with others under other conditions: a clue for each of the two that
    /// did, and what is left.
    pub(super) fn of_places(
        &self,
        two: [&Evidence; 2],
        subject: &Subject,
        whole: f64,
    ) -> (Vec<Clue>, f64) {
        let margin = |subject: &Subject| self.margin(subject);
        let [one, against] = two;
        let both = [(one, against), (against, one)];
        let found = both.into_iter().filter_map(|(piece, against)| {
            let other = changed_places(self.evidence, piece, &margin)?;
            let rates = (Rate::on(other, subject)?, Rate::on(against, subject)?);
            let rest = strength(rates.0, rates.1, self.margin(subject)).min(whole);
            Some((piece, other, against, rest))
        });
        let found: Vec<_> = found.collect();
        let share = 1.0 / found.len().max(1) as f64;
        let taken: f64 = found.iter().map(|(.., rest)| (whole - rest) * share).sum();
        let file = |piece: &Evidence| self.asset_of(piece, subject).file;
        let alike: Vec<String> = found.iter().filter_map(|(piece, ..)| file(piece)).collect();
        let clues = found.into_iter().map(|(piece, other, against, rest)| {
            let mut ids = [piece.id.clone(), other.id.clone()];
            ids.sort_by_key(|id| self.evidence.iter().position(|it| &it.id == id));
            let mut together: Vec<String> = [file(piece), file(other)].into_iter().flatten().collect();
            for file in &alike {
                if !together.contains(file) {
                    together.push(file.clone());
                }
            }
            // Which of the two files is called wrongly, or entered wrongly, nothing tells: the ledger says which is whose.
            let asset = SuspectAsset {
                kind: SuspectKind::Data,
                file: Some("ledger.toml".to_owned()),
                part: Some(format!("the files of {} and {}", ids[0], ids[1])),
                evidence: ids.to_vec(),
                together,
                line: None,
            };
            Clue {
                inaccuracy: Inaccuracy::SystemModel,
                subject: subject.clone(),
                score: (whole - rest) * share,
                title: format!("{} and {} may have changed places", piece.id, other.id),
                explanation: format!(
                    "{} against {}: a conflict on {} with a Bayes factor of 10^{whole:.1}; with what is entered as {}, under other \
                     conditions, 10^{rest:.1} is left of it. Each of the two differs from the other evidence where it stands, and \
                     neither does where the other stands.",
                    rate_in_words(piece, subject),
                    rate_in_words(against, subject),
                    name_of(subject),
                    other.id
                ),
                symptom: Symptom::RateDiffers {
                    subject: subject.clone(),
                    evidence: piece.id.clone(),
                    value: piece
                        .finding(subject)
                        .and_then(|it| it.measure.estimate())
                        .unwrap_or(f64::NAN),
                    others: vec![super::rates::counts_of(against, subject)],
                },
                figures: vec![
                    figure("conflict, log10 Bayes factor", whole),
                    figure("left of it with the two exchanged, log10 Bayes factor", rest),
                ],
                witnesses: Vec::new(),
                ruled_out: Vec::new(),
                resolved_by: None,
                asset,
            }
        });
        (clues.collect(), whole - taken)
    }
}
