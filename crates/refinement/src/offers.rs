//! What is offered against a suspect.
//!
//! # Definition
//! By the kind of the suspected asset:
//!
//! | suspect | offer |
//! |---|---|
//! | formal model | [`Ground::of_model`] of the latest that rests on it, as far as it is about a failure mode that the suspect is named for, or repairs what the suspect is named for |
//! | property, monitor | the form goes, and that of the sentence takes its place |
//! | solver whose answer counts | the method whose bounds hold comes first |
//! | time step | divided until the error that is left is a tenth of the margin ([`crate::steps`]) |
//! | simulation | its parameters fitted to the counts of the failure modes that it is named for, if it is likelier than not the odd one out |
//! | data | two failure modes change places, in all texts that count them, if that explains what the table differs in |
//!
//! Pieces that changed places with each other ([`evidence::changed_places`]) are offered to do so in the ledger, before all else.
//!
//! What of a table was exchanged is what [`evidence::exchanged`] finds.
//!
//! A simulation that nothing is held against is offered the same fit if a failure mode's counts differ from those it may be
//! set to with a p-value below the study's level, as a model's rate is ([`Ground::of_model`]).
//!
//! Each change of a model is tried on all evidence first ([`crate::trial`]): what it repairs and what it breaks is part of
//! the offer.
//!
//! Other engines and vocabularies have no offer: which of two is right is nothing that the evidence says.
//!
//! # Assumes
//! The suspect is what is wrong. The p-value takes all trials as independent (`Counts::p_value`).
//!
//! # Guarantee
//! Nothing is applied here. A change of a model that makes other evidence conflict comes behind all that does not, and is marked.

use crate::counts::{Counts, anchors};
use crate::form_change::FormChange;
use crate::model_change::{Changed, ModelChange};
use crate::model_offers::{Ground, Model};
use crate::text_change::{TextChange, steps};
use crate::trial::Trial;
use evidence::{
    Evidence, Exchanged, Measure, Subject, Suspect, SuspectKind, Symptom, changed_places, exchanged,
};

/// The part of the margin that may be left of a step's error.
const LEFT_OF_MARGIN: f64 = 0.1;

/// From which probability on of being the odd one out a simulation is fitted again.
const LIKELY: f64 = 0.5;

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
        changed: Box<Changed>,
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
    /// The columns "passed" and "failed" of a table of requirements change places.
    Columns {
        /// The evidence that rests on the table.
        evidence: String,
        /// The requirements in whose rows they do; none for all.
        rows: Vec<String>,
    },
    /// Two failure modes, or two requirements, of a table change places, in all texts that count them.
    Exchange {
        /// The evidence that rests on the table.
        evidence: String,
        /// The failure modes, or the requirements.
        modes: [Subject; 2],
        /// Whether their opportunities change places, too.
        is_whole: bool,
    },
    /// What two entries of the ledger are made of changes places.
    Entries {
        /// The evidence of the two, in the order of the ledger.
        evidence: [String; 2],
    },
    /// A simulation's parameters are fitted.
    Parameters {
        /// The evidence that it gives.
        evidence: String,
        /// To these counts, by failure mode; none where the suspect is named for requirements, and the study counts none.
        counts: Vec<(String, Counts)>,
    },
}

/// An offer with the suspect that it is for.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// The suspect's rank; none if the model's failures ask for it and nothing is suspected.
    pub suspect: Option<u32>,
    /// What is offered.
    pub offer: Offer,
    /// What it does to the agreement with all evidence, where that was computed.
    pub tried: Option<Trial>,
}

impl Ranked {
    /// Whether it makes other evidence conflict, or moves away from the majority of it.
    #[must_use]
    pub fn is_harmful(&self) -> bool {
        self.tried.as_ref().is_some_and(Trial::is_harmful)
    }
}

/// All that is offered, in the order of the suspects.
#[derive(Clone, Debug, Default)]
pub struct Offers {
    /// The offers.
    pub ranked: Vec<Ranked>,
    /// Failures of models for which there is none, with the reason.
    pub refused: Vec<String>,
}

impl Offers {
    /// Adds what is not offered already.
    fn extend(&mut self, suspect: Option<u32>, offers: Vec<(Offer, Option<Trial>)>) {
        for (offer, tried) in offers {
            if self.ranked.iter().all(|known| known.offer != offer) {
                self.ranked.push(Ranked {
                    suspect,
                    offer,
                    tried,
                });
            }
        }
    }

    /// How many of them do no harm.
    fn harmless(&self) -> usize {
        self.ranked
            .iter()
            .filter(|known| !known.is_harmful())
            .count()
    }

    /// Whether parameters of this simulation are offered already.
    fn fits(&self, simulation: &str) -> bool {
        self.ranked.iter().any(|known| {
            matches!(&known.offer, Offer::Parameters { evidence, .. } if evidence == simulation)
        })
    }
}

/// What a model's failures ask for, as far as it is not offered yet.
struct OfModel<'a> {
    evidence: &'a str,
    changes: Vec<(ModelChange, Changed, Trial)>,
}

impl OfModel<'_> {
    /// Offers what is left for these subjects, in their order: changes of their own rates, then those that by their trial
    /// repair one of them. Without subjects all that is left.
    fn take(&mut self, subjects: Option<&[Subject]>) -> Vec<(Offer, Option<Trial>)> {
        let all = std::mem::take(&mut self.changes);
        let mut changes = match subjects {
            None => all,
            Some(subjects) => {
                let place = |(change, _, trial): &(ModelChange, Changed, Trial)| {
                    let own = |subject: &Subject| *subject == change.subject();
                    // They are offered only where no change weighs more.
                    if change.is_of_lacking_branch() && subjects.iter().any(own) {
                        return Some(0);
                    }
                    let repairs = |subject: &Subject| {
                        let mut touched = trial.repairs.iter();
                        touched.any(|touch| &touch.subject == subject)
                    };
                    let by_repair = || subjects.iter().position(repairs);
                    let by_repair = || Some(1 + subjects.len() + by_repair()?);
                    let own = subjects.iter().position(own).map(|at| at + 1);
                    own.or_else(by_repair)
                };
                let (mut own, rest): (Vec<_>, Vec<_>) =
                    all.into_iter().partition(|it| place(it).is_some());
                self.changes = rest;
                own.sort_by_key(place);
                own
            }
        };
        let offer = |(change, changed, trial)| {
            let offer = Offer::Model {
                evidence: self.evidence.to_owned(),
                change,
                changed: Box::new(changed),
            };
            (offer, Some(trial))
        };
        changes.drain(..).map(offer).collect()
    }
}

/// Models, asked when a suspect rests on them: solving them takes most of the time.
struct Asking<'m> {
    ground: Ground<'m>,
    models: &'m [Model<'m>],
    asked: Vec<Option<OfModel<'m>>>,
    refused: Vec<String>,
}

impl<'m> Asking<'m> {
    fn new(ground: Ground<'m>, models: &'m [Model<'m>]) -> Self {
        Self {
            ground,
            models,
            asked: models.iter().map(|_| None).collect(),
            refused: Vec::new(),
        }
    }

    /// Offers what is left of what a model asks for, for these subjects or all ([`OfModel::take`]).
    fn take(
        &mut self,
        place: usize,
        subjects: Option<&[Subject]>,
    ) -> Result<Vec<(Offer, Option<Trial>)>, String> {
        if let Some(known) = &mut self.asked[place] {
            return Ok(known.take(subjects));
        }
        let model = &self.models[place];
        let before = model.solver.values(model.text)?;
        let found = self.ground.of_model(model, &before);
        self.refused.extend(found.refused);
        let changes = found.changes.into_iter().map(|(change, changed)| {
            let trial = self
                .ground
                .tried(model.evidence, &before, changed.at_last());
            (change, changed, trial)
        });
        let known = self.asked[place].insert(OfModel {
            evidence: model.evidence,
            changes: changes.collect(),
        });
        Ok(known.take(subjects))
    }
}

impl<'g> Ground<'g> {
    /// What is offered against the suspects that nothing has fixed, the first suspect's first; then what else the
    /// failures of the models and of the simulations ask for. What does harm ([`Ranked::is_harmful`]) comes behind all
    /// that does none. `models` and `simulations` are those that may be changed.
    ///
    /// # Errors
    /// Why a model cannot be solved as it is.
    pub fn against<'m>(
        &self,
        suspects: &[Suspect],
        models: &'m [Model<'m>],
        simulations: &[&str],
    ) -> Result<Offers, String>
    where
        'g: 'm,
    {
        self.at_most(usize::MAX, suspects, models, simulations)
    }

    /// The first of them; models are only solved as far as that needs.
    ///
    /// # Errors
    /// Why a model cannot be solved as it is.
    pub fn first_against<'m>(
        &self,
        suspects: &[Suspect],
        models: &'m [Model<'m>],
        simulations: &[&str],
    ) -> Result<Option<Offer>, String>
    where
        'g: 'm,
    {
        let found = self.at_most(1, suspects, models, simulations)?;
        Ok(found.ranked.into_iter().next().map(|first| first.offer))
    }

    fn at_most<'m>(
        &self,
        most: usize,
        suspects: &[Suspect],
        models: &'m [Model<'m>],
        simulations: &[&str],
    ) -> Result<Offers, String>
    where
        'g: 'm,
    {
        let mut asking = Asking::new(*self, models);
        let mut found = Offers::default();
        for suspect in suspects.iter().filter(|suspect| suspect.is_open()) {
            if found.harmless() < most {
                let offers = self.of_suspect(suspect, &mut asking, simulations)?;
                found.extend(Some(suspect.rank), offers);
            }
        }
        for place in 0..models.len() {
            if found.harmless() < most {
                found.extend(None, asking.take(place, None)?);
            }
        }
        let rest = simulations.iter().filter(|id| !found.fits(id));
        let rest = rest.filter_map(|id| Some((self.of_counts(id)?, None)));
        let rest: Vec<(Offer, Option<Trial>)> = rest.collect();
        found.extend(None, rest);
        found.ranked.sort_by_key(Ranked::is_harmful);
        found.refused = asking.refused;
        Ok(found)
    }

    fn of_suspect(
        &self,
        suspect: &Suspect,
        asking: &mut Asking<'_>,
        simulations: &[&str],
    ) -> Result<Vec<(Offer, Option<Trial>)>, String> {
        let mut first = self.of_places(suspect);
        let offers = match suspect.asset.kind {
            SuspectKind::FormalModel => {
                first.extend(self.of_formal(suspect, asking)?);
                return Ok(first);
            }
            SuspectKind::Property | SuspectKind::Monitor => self.of_form(suspect),
            SuspectKind::Solver => self.of_solver(suspect),
            SuspectKind::TimeStep => self.of_step(suspect),
            SuspectKind::Simulation => self.of_simulation(suspect, simulations),
            SuspectKind::Data => self.of_data(suspect),
            SuspectKind::Vocabulary | SuspectKind::Engine | SuspectKind::TimeScale => Vec::new(),
        };
        first.extend(offers.into_iter().map(|offer| (offer, None)));
        Ok(first)
    }

    /// The entries with which those of a suspect changed places.
    fn of_places(&self, suspect: &Suspect) -> Vec<(Offer, Option<Trial>)> {
        if suspect.asset.kind != SuspectKind::Data {
            return Vec::new();
        }
        let margin = |subject: &Subject| self.margin(subject);
        let place = |id: &String| self.evidence.iter().position(|it| &it.id == id);
        let offer = |piece: &Evidence| {
            let other = changed_places(self.evidence, piece, &margin)?;
            let mut evidence = [piece.id.clone(), other.id.clone()];
            evidence.sort_by_key(place);
            let is_accused = suspect.asset.evidence.contains(&other.id);
            is_accused.then_some((Offer::Entries { evidence }, None))
        };
        let mut found: Vec<(Offer, Option<Trial>)> =
            self.pieces(suspect).filter_map(offer).collect();
        found.dedup();
        found
    }

    /// The pieces that rest on a suspect, the latest first.
    fn pieces(&self, suspect: &Suspect) -> impl Iterator<Item = &Evidence> {
        let ids = &suspect.asset.evidence;
        let all = self.evidence.iter().rev();
        all.filter(|piece| ids.contains(&piece.id))
    }

    /// The declared margin of a subject.
    #[must_use]
    pub fn margin(&self, subject: &Subject) -> f64 {
        evidence::margin_of(self.requirements, self.failure_modes, subject)
    }

    /// What the latest model that the suspect rests on asks for on what the suspect is named for.
    fn of_formal(
        &self,
        suspect: &Suspect,
        asking: &mut Asking<'_>,
    ) -> Result<Vec<(Offer, Option<Trial>)>, String> {
        let latest = self.pieces(suspect).find_map(|piece| {
            let mut all = asking.models.iter();
            all.position(|model| model.evidence == piece.id)
        });
        match latest {
            Some(place) => asking.take(place, Some(&suspect.subjects)),
            None => Ok(Vec::new()),
        }
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
            // Which reading is meant is not the sentence's to say.
            if !["property", "monitor"].contains(&form.as_str()) {
                continue;
            }
            let offer = Offer::Form(FormChange::Derived {
                requirement: id.clone(),
                form: form.clone(),
            });
            // The sentence of a form that says the same would change nothing.
            let is_other = !self.says_the_same(subject, form);
            if has_sentence(id) && is_other && !offers.contains(&offer) {
                offers.push(offer);
            }
        }
        offers
    }

    /// Whether other forms of a subject differ from its sentence on some runs, and this one on none.
    fn says_the_same(&self, subject: &Subject, form: &str) -> bool {
        let all = self.evidence.iter().flat_map(|it| &it.form_differences);
        let mut all = all
            .filter(|d| &d.subject == subject && d.reference == "sentence")
            .peekable();
        all.peek().is_some() && all.all(|d| d.form != form)
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
                differing,
                ..
            } => {
                let allowed = LEFT_OF_MARGIN * self.margin(subject);
                Some(steps(*violated, *differing, *episodes, allowed))
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
        // The part may be the fast physics, of which there is no half.
        let is_step = key.ends_with("time_step_secs");
        let worst = divisor.max().filter(|_| is_step);
        worst
            .zip(self.pieces(suspect).next())
            .map(offer)
            .into_iter()
            .collect()
    }

    /// All failure modes that the suspect is named for, or all that it counts if it is named for none; nothing unless it
    /// is more likely than not the odd one out somewhere: data are not to be fitted to a simulator's errors, nor a
    /// simulator to those of a model.
    fn of_simulation(&self, suspect: &Suspect, simulations: &[&str]) -> Vec<Offer> {
        let is_odd = suspect.odd_one_out().is_none_or(|odd| odd >= LIKELY);
        let mut pieces = self.pieces(suspect);
        let current = pieces.find(|piece| simulations.contains(&piece.id.as_str()));
        let Some(piece) = current.filter(|_| is_odd) else {
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
        let offer = self.fitted(piece, modes.into_iter());
        // Without a failure mode to count, what the suspect is named for has to come as often as it was counted.
        let of_named = || Offer::Parameters {
            evidence: piece.id.clone(),
            counts: Vec::new(),
        };
        let offer = offer.or_else(|| (!suspect.subjects.is_empty()).then(of_named));
        offer.into_iter().collect()
    }

    /// A simulation's parameters fitted to the counts of these failure modes that come nearest to the real system.
    fn fitted<'s>(
        &self,
        piece: &Evidence,
        modes: impl Iterator<Item = &'s Subject>,
    ) -> Option<Offer> {
        let counts = modes.filter_map(|mode| {
            let best = anchors(self.evidence, piece, mode).into_iter().next()?;
            Some((mode.id().to_owned(), best))
        });
        let counts: Vec<(String, Counts)> = counts.collect();
        let evidence = piece.id.clone();
        (!counts.is_empty()).then_some(Offer::Parameters { evidence, counts })
    }

    /// A simulation's parameters fitted to the counts from which its own differ beyond chance, each by itself: what a
    /// study's many comparisons leave undecided may still be worth a fit.
    fn of_counts(&self, id: &str) -> Option<Offer> {
        let piece = self.evidence.iter().find(|piece| piece.id == id)?;
        let differs = |mode: &&Subject| {
            let best = anchors(self.evidence, piece, mode).into_iter().next();
            let mut all = self.comparisons.iter().filter(|c| &c.subject == *mode);
            best.is_some_and(|best| {
                let pair = [&best.evidence, &piece.id];
                let found = all.find(|c| pair.contains(&&c.left) && pair.contains(&&c.right));
                let p = found.and_then(|c| c.p_difference);
                p.is_some_and(|p| p < 1.0 - self.confidence)
            })
        };
        let modes = piece.findings.iter().map(|finding| &finding.subject);
        let modes = modes.filter(|s| matches!(s, Subject::FailureMode(_)));
        self.fitted(piece, modes.filter(differs))
    }

    fn of_data(&self, suspect: &Suspect) -> Vec<Offer> {
        let pieces = self.pieces(suspect);
        let margin = |subject: &Subject| self.margin(subject);
        let offers = pieces.filter_map(|piece| {
            let evidence = piece.id.clone();
            match exchanged(self.evidence, piece, &margin)? {
                Exchanged::Columns(found) => {
                    let rows = found.rows.iter().filter(|_| !found.are_all);
                    let rows = rows.map(|subject| subject.id().to_owned()).collect();
                    Some(Offer::Columns { evidence, rows })
                }
                Exchanged::Names(found) => Some(Offer::Exchange {
                    evidence,
                    modes: found.modes.map(Subject::clone),
                    is_whole: found.is_whole,
                }),
            }
        });
        offers.collect()
    }
}
