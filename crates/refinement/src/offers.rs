//! What is offered against a suspect.
//!
//! # Definition
//! By the kind of the suspected asset:
//!
//! | suspect | offer |
//! |---|---|
//! | formal model | [`Ground::of_model`], the failure modes that the suspect is named for first |
//! | property, monitor | the form goes, and that of the sentence takes its place |
//! | solver whose answer counts | the method whose bounds hold comes first |
//! | time step | divided until the error that is left is a tenth of the margin ([`crate::steps`]) |
//! | simulation | its parameters fitted to the counts of the failure modes that it is named for |
//! | data | two names change places, if that explains what the table differs in |
//!
//! *Two names* `a`, `b` of a table were mixed up if the strengths (see [`evidence::strength`]) with which its two rates
//! differ from those of all other evidence sum to at least [`MIXED_UP`] as they are, and to less than [`STRONG`] for
//! every other piece once they are exchanged; of several pairs the one that explains most.
//!
//! Other engines and vocabularies have no offer: which of two is right is nothing that the evidence says.

use crate::counts::{Counts, anchors};
use crate::form_change::FormChange;
use crate::model_change::{Changed, ModelChange};
use crate::model_offers::{Ground, Model};
use crate::text_change::{TextChange, steps};
use evidence::{Evidence, Measure, Rate, Subject, Suspect, SuspectKind, Symptom, strength};

/// What is strong evidence, in decades.
const STRONG: f64 = 1.0;

/// From how many decades on an exchange of names is offered.
const MIXED_UP: f64 = 2.0;

/// The part of the margin that may be left of a step's error.
const LEFT_OF_MARGIN: f64 = 0.1;

/// A change that is offered.
#[derive(Clone, Debug, PartialEq)]
pub enum Offer {
    /// Of a formal model.
    Model {
        /// The evidence that it gives.
        evidence: String,
        /// How.
        change: ModelChange,
        /// The model after it.
        changed: Changed,
    },
    /// Of a requirement's form.
    Form(FormChange),
    /// Of another text.
    Text {
        /// The evidence that rests on it.
        evidence: String,
        /// How.
        change: TextChange,
    },
    /// A simulation's parameters are fitted.
    Parameters {
        /// The evidence that it gives.
        evidence: String,
        /// To these counts, by failure mode.
        counts: Vec<(String, Counts)>,
    },
}

impl Ground<'_> {
    /// What is offered against a suspect, best first; `model` gives the formal model of a piece of evidence.
    ///
    /// # Errors
    /// Why a model cannot be solved as it is.
    pub fn of_suspect<'m>(
        &self,
        suspect: &Suspect,
        model: &dyn Fn(&str) -> Option<Model<'m>>,
    ) -> Result<Vec<Offer>, String> {
        if suspect.resolved_by.is_some() {
            return Ok(Vec::new());
        }
        Ok(match suspect.asset.kind {
            SuspectKind::FormalModel => return self.of_formal(suspect, model),
            SuspectKind::Property | SuspectKind::Monitor => self.of_form(suspect),
            SuspectKind::Solver => self.of_solver(suspect),
            SuspectKind::TimeStep => self.of_step(suspect),
            SuspectKind::Simulation => self.of_simulation(suspect),
            SuspectKind::Data => self.of_data(suspect),
            SuspectKind::Vocabulary | SuspectKind::Engine => Vec::new(),
        })
    }

    /// The pieces that rest on a suspect, the latest first.
    fn pieces(&self, suspect: &Suspect) -> impl Iterator<Item = &Evidence> {
        let ids = &suspect.asset.evidence;
        let all = self.evidence.iter().rev();
        all.filter(|piece| ids.contains(&piece.id))
    }

    fn margin(&self, subject: &Subject) -> f64 {
        let modes = self.failure_modes.iter().map(|m| (&m.id, m.margin));
        let requirements = self.requirements.iter().map(|r| (&r.id, r.margin));
        let margin = match subject {
            Subject::FailureMode(id) => modes.into_iter().find(|(own, _)| *own == id),
            Subject::Requirement(id) => requirements.into_iter().find(|(own, _)| *own == id),
        };
        margin.map_or(0.0, |(_, margin)| margin)
    }

    fn of_formal<'m>(
        &self,
        suspect: &Suspect,
        model: &dyn Fn(&str) -> Option<Model<'m>>,
    ) -> Result<Vec<Offer>, String> {
        let Some(model) = self.pieces(suspect).find_map(|piece| model(&piece.id)) else {
            return Ok(Vec::new());
        };
        let before = model.solver.values(model.text)?;
        let mut changes = self.of_model(&model, &before).changes;
        let place = |change: &ModelChange| {
            let mut all = suspect.subjects.iter();
            let place = all.position(|subject| subject.id() == change.mode());
            place.unwrap_or(usize::MAX)
        };
        changes.sort_by_key(|(change, _)| place(change));
        let offer = |(change, changed)| Offer::Model {
            evidence: model.evidence.to_owned(),
            change,
            changed,
        };
        Ok(changes.into_iter().map(offer).collect())
    }

    fn of_form(&self, suspect: &Suspect) -> Vec<Offer> {
        let mut offers = Vec::new();
        for symptom in &suspect.symptoms {
            let (subject, form) = match symptom {
                Symptom::FormsDiffer { subject, form, .. } => (subject, form),
                Symptom::Drifted { subject, form, .. } => (subject, form),
                _ => continue,
            };
            let has_sentence = |id: &str| {
                let mut all = self.requirements.iter();
                all.any(|r| r.id == id && r.sentence.is_some())
            };
            let Subject::Requirement(id) = subject else {
                continue;
            };
            let offer = Offer::Form(FormChange::Derived {
                requirement: id.clone(),
                form: form.clone(),
            });
            if has_sentence(id) && !offers.contains(&offer) {
                offers.push(offer);
            }
        }
        offers
    }

    fn of_solver(&self, suspect: &Suspect) -> Vec<Offer> {
        let offer = |piece: &Evidence| {
            let counting = piece.findings.iter().find_map(|f| match &f.measure {
                Measure::Probability { answer, .. } => Some(&answer.method),
                _ => None,
            });
            suspect.symptoms.iter().find_map(|symptom| match symptom {
                Symptom::SolverStopped { method, sound, .. } if Some(method) == counting => {
                    Some(Offer::Text {
                        evidence: piece.id.clone(),
                        change: TextChange::Methods {
                            evidence: piece.id.clone(),
                            first: sound.clone(),
                        },
                    })
                }
                _ => None,
            })
        };
        self.pieces(suspect).filter_map(offer).collect()
    }

    fn of_step(&self, suspect: &Suspect) -> Vec<Offer> {
        let divisor = suspect.symptoms.iter().filter_map(|symptom| match symptom {
            Symptom::RunsOtherwise {
                subject,
                violated,
                episodes,
                ..
            } => {
                let rate = |count: u64| count as f64 / (*episodes).max(1) as f64;
                let allowed = LEFT_OF_MARGIN * self.margin(subject);
                Some(steps(rate(violated[0]), rate(violated[1]), allowed))
            }
            _ => None,
        });
        let part = suspect.asset.part.as_deref().unwrap_or_default();
        let key = part.split('=').next().unwrap_or_default().trim();
        let offer = |(divisor, piece): (u32, &Evidence)| Offer::Text {
            evidence: piece.id.clone(),
            change: TextChange::Step {
                key: key.to_owned(),
                divisor,
            },
        };
        let worst = divisor.max().filter(|_| !key.is_empty());
        worst
            .zip(self.pieces(suspect).next())
            .map(offer)
            .into_iter()
            .collect()
    }

    /// All failure modes that the suspect is named for, or all that it counts if it is named for none.
    fn of_simulation(&self, suspect: &Suspect) -> Vec<Offer> {
        let Some(piece) = self.pieces(suspect).next() else {
            return Vec::new();
        };
        let named = suspect.subjects.iter();
        let mut modes: Vec<&Subject> = named
            .filter(|subject| matches!(subject, Subject::FailureMode(_)))
            .collect();
        if modes.is_empty() {
            let all = piece.findings.iter().map(|finding| &finding.subject);
            modes = all
                .filter(|s| matches!(s, Subject::FailureMode(_)))
                .collect();
        }
        let counts = modes.into_iter().filter_map(|mode| {
            let best = anchors(self.evidence, piece, mode).into_iter().next()?;
            Some((mode.id().to_owned(), best))
        });
        let counts: Vec<(String, Counts)> = counts.collect();
        let evidence = piece.id.clone();
        match counts.is_empty() {
            true => Vec::new(),
            false => vec![Offer::Parameters { evidence, counts }],
        }
    }

    fn of_data(&self, suspect: &Suspect) -> Vec<Offer> {
        let pieces = self.pieces(suspect);
        let offers = pieces.filter_map(|piece| {
            let modes = self.mixed_up(piece)?;
            Some(Offer::Text {
                evidence: piece.id.clone(),
                change: TextChange::Names { modes },
            })
        });
        offers.collect()
    }

    /// The two failure modes of a table whose names were mixed up, if the others say so.
    fn mixed_up(&self, piece: &Evidence) -> Option<[String; 2]> {
        let modes: Vec<(&Subject, Rate)> = piece
            .findings
            .iter()
            .filter(|finding| matches!(finding.subject, Subject::FailureMode(_)))
            .filter_map(|finding| Some((&finding.subject, Rate::of(&finding.measure)?)))
            .collect();
        let mut best: Option<(f64, [String; 2])> = None;
        for (place, (a, of_a)) in modes.iter().enumerate() {
            for (b, of_b) in &modes[place + 1..] {
                let (now, _) = self.against_others(piece, [(a, *of_a), (b, *of_b)]);
                let (then, worst) = self.against_others(piece, [(a, *of_b), (b, *of_a)]);
                let explains = now - then;
                let is_best = best.as_ref().is_none_or(|(most, _)| explains > *most);
                if explains >= MIXED_UP && worst < STRONG && is_best {
                    best = Some((explains, [a.id().to_owned(), b.id().to_owned()]));
                }
            }
        }
        best.map(|(_, modes)| modes)
    }

    /// How strongly rates differ from those of all other evidence: the sum, and the strongest.
    fn against_others(&self, piece: &Evidence, rates: [(&Subject, Rate); 2]) -> (f64, f64) {
        let (mut sum, mut most) = (0.0, 0.0_f64);
        let others = self.evidence.iter().filter(|other| {
            other.id != piece.id && !other.intermediate && other.conditions == piece.conditions
        });
        for other in others {
            for (subject, rate) in rates {
                let theirs = other.finding(subject).and_then(|f| Rate::of(&f.measure));
                let apart = theirs.map_or(0.0, |r| strength(r, rate, self.margin(subject)));
                sum += apart;
                most = most.max(apart);
            }
        }
        (sum, most)
    }
}
