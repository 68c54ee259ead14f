//! Properties that say nothing of a model, where others saw that what they ask for comes both ways.
//!
//! # Definition
//! A property that has one truth value on all runs of a model, whatever its commands do, makes the model no evidence
//! ([`Measure::NotCovered`] with its `constant`). Where another piece under the same conditions differs strongly from that value
//! ([`Rate::asked`]), what is wrong is the property, a word that it asks with, or the state in which the model begins: the commands
//! cannot be. If a single edit or a change of the model explains it, that is named, by [`super::edits`] or with its line; else
//! the word that no other property which agrees is asked with, the last of several, and the others with it. It counts at most
//! [`UNHARMFUL`], since no conflict hangs on it.
//!
//! # Assumes
//! That the model was meant to speak of it: a model of another part ([`evidence::is_of_another_part`]) was not.
//!
//! # Guarantee
//! One of what is named is not as it was meant, if the model was meant to say something of the system's runs: that the property is
//! constant is a theorem.

use super::candidates::clauses::of_property;
use super::lines::OfModels;
use super::{Diagnosing, Gathered};
use evidence::{
    Clue, Evidence, Figure, Inaccuracy, Measure, Rate, STRONG, Subject, SuspectAsset, SuspectKind,
    Symptom, is_of_another_part, strength, system_model,
};

/// The most that counts on which no conflict hangs.
const UNHARMFUL: f64 = 2.0;

impl Diagnosing<'_> {
    /// A clue for each property that says nothing and that no edit explains.
    pub(super) fn constants(&self, offered: &OfModels, gathered: &mut Gathered) {
        for piece in &self.result.evidence {
            for finding in &piece.findings {
                if let Measure::NotCovered {
                    constant: Some(truth),
                    ..
                } = finding.measure
                {
                    gathered
                        .clues
                        .extend(self.constant((piece, &finding.subject), truth, offered));
                }
            }
        }
        // What an edit explains it is the reason of, but for the share of a change of the model that explains it, too.
        let mut explained: Vec<(Subject, String, f64)> = Vec::new();
        for clue in &gathered.clues {
            if let Symptom::EditExplains {
                subject,
                pairs,
                share,
                ..
            } = &clue.symptom
            {
                let ids = pairs.iter().flatten();
                explained.extend(ids.map(|id| (subject.clone(), id.clone(), *share)));
            }
        }
        gathered.clues.retain_mut(|clue| {
            let Symptom::SaysNothing {
                subject, evidence, ..
            } = &clue.symptom
            else {
                return true;
            };
            let own = explained
                .iter()
                .filter(|(of, id, _)| of == subject && id == evidence)
                .map(|(.., share)| *share);
            let Some(share) = own.max_by(f64::total_cmp) else {
                return true;
            };
            let whole = clue.figures.first().map_or(0.0, |it| it.value);
            clue.score = whole * (1.0 - share);
            clue.asset.kind == SuspectKind::FormalModel
        });
    }

    fn constant(
        &self,
        (piece, subject): (&Evidence, &Subject),
        truth: bool,
        offered: &OfModels,
    ) -> Option<Clue> {
        let all = &self.result.evidence;
        let own = Rate::asked(piece, subject)?;
        let speaks = |it: &&Evidence| {
            it.id != piece.id
                && it.conditions == piece.conditions
                && !it.intermediate
                && !it.technique.is_of_model()
        };
        let others = all.iter().filter(speaks).filter_map(|other| {
            let rate = Rate::on(other, subject)?;
            Some((strength(own, rate, self.margin(subject)), other))
        });
        let (apart, other) = others.max_by(|a, b| a.0.total_cmp(&b.0))?;
        if apart <= STRONG || is_of_another_part(all, piece, subject) || !self.is_own(subject) {
            return None;
        }
        // As they were counted, not at their effective size.
        let counts = match other.finding(subject).map(|it| &it.measure) {
            Some(Measure::Counts { count, trials, .. }) => [*count, *trials],
            _ => return None,
        };
        let says = if truth { "true" } else { "false" };
        Some(Clue {
            inaccuracy: Inaccuracy::RequirementModel,
            asset: self.says_nothing(piece, subject, offered),
            subject: subject.clone(),
            score: apart.min(UNHARMFUL),
            title: format!(
                "the property of {} is not evidence about {}",
                subject.in_words(),
                piece.id
            ),
            explanation: format!(
                "It is {says} of each run of {} that counts, whatever the model's commands do; {} counted {} of {}. So the property, a word \
                 that it asks with, or the state in which the model begins is not what was meant.",
                piece.id, other.id, counts[0], counts[1]
            ),
            symptom: Symptom::SaysNothing {
                subject: subject.clone(),
                evidence: piece.id.clone(),
                truth,
                other: (other.id.clone(), counts[0], counts[1]),
            },
            figures: vec![Figure {
                name: "against the constant, log10 Bayes factor".into(),
                value: apart,
                interval: None,
            }],
            witnesses: Vec::new(),
            ruled_out: vec![
                "the model's commands: they cannot change what the property says".into(),
            ],
            resolved_by: None,
        })
    }

    /// What is to be looked at: the model, if a change of it explains what disagrees, else the last word of the property that
    /// nothing confirms, else the property.
    fn says_nothing(
        &self,
        piece: &Evidence,
        subject: &Subject,
        offered: &OfModels,
    ) -> SuspectAsset {
        let model = system_model(piece);
        let form = self.study.forms.of(subject);
        let words = form.map(of_property).unwrap_or_default();
        let mut places: Vec<(String, u32)> = Vec::new();
        for name in &words {
            let word = self.study.vocabulary.propositions.get(name);
            if let Some(binding) = word.and_then(|it| it.model.as_ref())
                && !self.is_word_confirmed(piece, name)
            {
                let text = &self.study.vocabulary.source.text;
                let (line, _) = prism_lang::line_and_column(text, binding.span.start);
                places.push((name.clone(), u32::try_from(line).unwrap_or(u32::MAX)));
            }
        }
        places.sort_by_key(|(_, line)| *line);
        let by_hand = form.and_then(|form| form.property.as_ref());
        let property = by_hand.map(|_| "requirements.toml".to_owned());
        let named = places.pop();
        if offered.explain(&piece.id, subject) {
            let words = named.is_some().then(|| "vocabulary.toml".to_owned());
            return SuspectAsset {
                together: words.into_iter().chain(property).collect(),
                ..model
            };
        }
        let mut together: Vec<String> = places
            .iter()
            .map(|(name, line)| format!("vocabulary.toml:{line} ({name}, model)"))
            .collect();
        let (kind, file, part, line) = match named {
            Some((name, line)) => {
                together.extend(property);
                let part = format!("{name}, model");
                (SuspectKind::Vocabulary, "vocabulary.toml", part, Some(line))
            }
            None => {
                let part = format!("{}, property", subject.in_words());
                let line = self.property_line(subject);
                (SuspectKind::Property, "requirements.toml", part, line)
            }
        };
        together.extend(model.file);
        SuspectAsset {
            kind,
            file: Some(file.to_owned()),
            part: Some(part),
            evidence: vec![piece.id.clone()],
            together,
            line,
        }
    }

    /// Whether another subject of the same model is asked with a word and agrees with all that others counted of it.
    fn is_word_confirmed(&self, piece: &Evidence, name: &str) -> bool {
        let mut others = piece.findings.iter().filter(|finding| {
            let form = self.study.forms.of(&finding.subject);
            matches!(finding.measure, Measure::Probability { .. })
                && form.is_some_and(|form| of_property(form).contains(name))
        });
        others.any(|finding| {
            let own = Rate::on(piece, &finding.subject);
            let mut counted = self.result.evidence.iter().filter(|other| {
                other.conditions == piece.conditions && !other.technique.is_of_model()
            });
            let mut has_any = false;
            let agree = counted.all(|other| match (own, Rate::on(other, &finding.subject)) {
                (Some(own), Some(rate)) => {
                    has_any = true;
                    strength(own, rate, self.margin(&finding.subject)) <= STRONG
                }
                _ => true,
            });
            has_any && agree
        })
    }

    fn property_line(&self, subject: &Subject) -> Option<u32> {
        let form = self.study.forms.of(subject)?;
        let property = form.property.as_ref()?;
        let text = &self.study.forms.source.text;
        let (line, _) = prism_lang::line_and_column(text, property.span.start);
        u32::try_from(line).ok()
    }
}
