//! Proposals: what may be changed, why, and what it is predicted to do.

use super::command::{CommandFit, search};
use super::ledger_text::Names;
use super::one_value::OneValue;
use super::simulator::Recalibration;
use super::solver::Solver;
use diagnostic::Problem;
use evidence::{StudyResult, Subject, Suspect, Symptom};
use host::Host;
use refinement::{
    Asked, Changed, Counts, Exchange, FormChange, Ground, Model, ModelChange, ModelOffers, SAME,
    TextChange, Trial, Values, Word, rate_of, unified,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use study::{Entry, Simulated, Study, quoted_names};

/// The share of a conflict that an edit explains at the least for a model's number to wait for it.
const LEAST_SHARE: f64 = 0.05;

/// One change that is offered.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Proposal {
    /// By which it is accepted, from 1.
    pub number: usize,
    /// The suspect that it is for, by its rank as `diagnose` and the report show
    /// it; none if nothing is suspected for it.
    pub suspect: Option<u32>,
    /// What is changed, as a headline.
    pub title: String,
    /// Why.
    pub reason: String,
    /// The file that is changed, or from which the new one is made.
    pub file: String,
    /// Other files that change together with it, since each alone would contradict the others.
    pub also: Vec<String>,
    /// The change as a unified diff of all these files; empty if it is only known once it is made.
    pub diff: String,
    /// What it changes, by solving the changed asset.
    pub effects: Vec<Effect>,
    /// What it does to the agreement with all other evidence, as far as that can be computed before it is made.
    pub tried: Trial,
    /// What has to be known before it is accepted.
    pub notes: Vec<String>,
    /// Whether `--all` leaves it open: it decides what a text means, makes other evidence conflict, or fixes nothing.
    pub needs_decision: bool,
    /// What is done.
    #[serde(skip)]
    pub change: Change,
}

/// A value before and after a change.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Effect {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The model's value now.
    pub before: Option<f64>,
    /// Its value after the change.
    pub after: Option<f64>,
    /// What was counted.
    pub counted: Option<Counts>,
    /// Of the value after the change, by the exact binomial test.
    pub p_value: Option<f64>,
}

/// Whether a change solves for a number with which a requirement has its counted rate.
fn is_fitted(change: &ModelChange) -> bool {
    matches!(
        change,
        ModelChange::Solve {
            subject: Subject::Requirement(_),
            ..
        }
    )
}

impl Proposal {
    /// Whether it solves for a model's number with which a requirement has its counted rate.
    pub(super) fn is_fitted(&self) -> bool {
        matches!(&self.change, Change::Model { change, .. } if is_fitted(change))
    }

    /// Whether it says which branches a model has.
    pub(super) fn is_structural(&self) -> bool {
        matches!(&self.change, Change::Model { change, .. } if is_of_structure(change))
    }

    fn is_exchange(&self) -> bool {
        matches!(self.change, Change::Exchange { .. })
    }

    /// Whether nothing is suspected for it, and it fixes no strong disagreement.
    pub(super) fn is_idle(&self) -> bool {
        self.suspect.is_none() && self.tried.repairs.is_empty()
    }

    /// Whether it moves the value of one of these, or fits a simulation.
    fn touches(&self, subjects: &[Subject]) -> bool {
        let mut moved = self.effects.iter().filter(|it| it.before != it.after);
        matches!(self.change, Change::Recalibrate(_) | Change::FitCommand(_))
            || moved.any(|it| subjects.contains(&it.subject))
    }
}

/// What is done if a proposal is accepted.
#[derive(Clone, Debug)]
pub enum Change {
    /// A formal model is changed.
    Model {
        /// The entry of the ledger.
        entry: String,
        /// How.
        change: ModelChange,
    },
    /// A requirement's form is changed.
    Form(FormChange),
    /// Another text of the study is changed in its place.
    Text {
        /// The file, relative to the study.
        file: PathBuf,
        /// How.
        change: TextChange,
    },
    /// One value of a text is replaced in its place.
    Value {
        /// The file, relative to the study.
        file: String,
        /// Which value.
        value: OneValue,
        /// The lineage that the ledger gets, where the value was set to counts.
        fitted: Option<Fitted>,
    },
    /// A text of the study gets another one in its place.
    Whole {
        /// The file, relative to the study.
        file: String,
        /// What it was.
        old: String,
        /// What it becomes.
        new: String,
    },
    /// Two things change places, in all texts of the study that hold them.
    Exchange {
        /// The files, relative to the study, and what changes places in each.
        texts: Vec<(String, Exchange)>,
    },
    /// A simulation's parameters are fitted again.
    Recalibrate(Recalibration),
    /// A number in the files of a simulator that is a command is found and fitted.
    FitCommand(CommandFit),
}

/// What is offered, and what could not be.
#[derive(Clone, Debug, Default)]
pub struct Offered {
    /// Proposals.
    pub proposals: Vec<Proposal>,
    /// Disagreements for which there is none, with the reason.
    pub refused: Vec<String>,
}

impl Offered {
    pub(super) fn add(&mut self, mut proposal: Proposal) {
        proposal.number = self.proposals.len() + 1;
        self.proposals.push(proposal);
    }

    /// Searches for the numbers of commands' files that are offered; what has none is not offered.
    pub(super) fn fit(
        &mut self,
        study: &Study,
        result: &StudyResult,
        setting: &Host,
    ) -> Result<(), Problem> {
        let mut kept = Vec::new();
        for mut proposal in std::mem::take(&mut self.proposals) {
            match search(study, result, &mut proposal, setting)? {
                Some(why) => self.refused.push(format!("{why}.")),
                None => kept.push(proposal),
            }
        }
        self.proposals = kept;
        self.in_order(result.suspected());
        Ok(())
    }

    /// Leaves open what is set to counts that may be those of something else: an exchange that explains a disagreement better than
    /// what a proposal is for has to be decided on first. `touched` are the ranks of suspects with what they touch.
    pub(super) fn await_exchanges(&mut self, touched: &[(u32, &[Subject])]) {
        let exchanges = self.proposals.iter().filter(|it| it.is_exchange());
        let exchanges: Vec<(usize, u32, Vec<Subject>)> = exchanges
            .filter_map(|it| {
                let (_, subjects) = touched.iter().find(|of| Some(of.0) == it.suspect)?;
                Some((it.number, it.suspect?, subjects.to_vec()))
            })
            .collect();
        for proposal in self.proposals.iter_mut().filter(|it| !it.is_exchange()) {
            for (number, rank, subjects) in &exchanges {
                let is_better = proposal.suspect.is_none_or(|of| *rank < of);
                if is_better && proposal.touches(subjects) {
                    proposal.needs_decision = true;
                    proposal.notes.push(format!(
                        "Decide on {number} first: if two things have each other's counts, this sets a value to the wrong ones."
                    ));
                }
            }
        }
    }

    /// Leaves open what sets a model's number on a subject that an edit of another text explains, too: which of both is wrong
    /// the evidence does not say, and a right model must not be made to fit a wrong word.
    pub(super) fn await_edits(&mut self, suspects: &[Suspect]) {
        for proposal in &mut self.proposals {
            let Change::Model { entry, change } = &proposal.change else {
                continue;
            };
            let subject = change.subject();
            let explains = |suspect: &&Suspect| {
                suspect.is_open()
                    && suspect.symptoms.iter().any(|symptom| match symptom {
                        Symptom::EditExplains {
                            subject: of,
                            pairs,
                            share,
                            ..
                        } => {
                            *of == subject
                                && *share >= LEAST_SHARE
                                && pairs.iter().any(|pair| pair.contains(entry))
                        }
                        _ => false,
                    })
            };
            if let Some(other) = suspects.iter().find(explains) {
                proposal.needs_decision = true;
                proposal.notes.push(format!(
                    "Decide on suspect {} first: {}, too, and then this number is right as it is.",
                    other.rank, other.title
                ));
            }
        }
    }

    /// Leaves open what sets a model's number on a subject that a branch put into or taken out of the same model moves, too: a number
    /// can be made to fit what a wrong or a lacking branch does.
    pub(super) fn await_branches(&mut self) {
        let branches = self.proposals.iter().filter(|it| !it.tried.is_harmful());
        let branches: Vec<(usize, String, Vec<Subject>)> = branches
            .filter_map(|it| match &it.change {
                Change::Model { entry, change } if is_of_structure(change) => {
                    let moved = it.effects.iter().filter(|of| of.before != of.after);
                    let moved = moved.map(|of| of.subject.clone()).collect();
                    Some((it.number, entry.clone(), moved))
                }
                _ => None,
            })
            .collect();
        for proposal in &mut self.proposals {
            let Change::Model { entry, change } = &proposal.change else {
                continue;
            };
            let is_number = !is_of_structure(change);
            let rival = branches
                .iter()
                .find(|(_, of, subjects)| of == entry && subjects.contains(&change.subject()));
            if let (true, Some((number, ..))) = (is_number, rival) {
                proposal.needs_decision = true;
                proposal.notes.push(format!(
                    "Decide on {number} as well: another branch explains it, too, and then this number is right as it is."
                ));
            }
        }
    }

    /// Puts what does no harm before what does, and of these what is for the first suspects first; but a search for a number behind
    /// what explains all that it is for with a value that is known, and what mends nothing behind what does.
    pub(super) fn in_order(&mut self, suspects: &[Suspect]) {
        let offered: Vec<u32> = self.proposals.iter().filter_map(|it| it.suspect).collect();
        let edits = suspects
            .iter()
            .filter(|it| it.is_open() && offered.contains(&it.rank));
        let explained: Vec<&Subject> = edits
            .flat_map(|it| &it.symptoms)
            .filter_map(|symptom| match symptom {
                Symptom::EditExplains { subject, share, .. } if *share >= LEAST_SHARE => {
                    Some(subject)
                }
                _ => None,
            })
            .collect();
        let is_late = |it: &Proposal| {
            let mut subjects = it
                .tried
                .repairs
                .iter()
                .map(|touch| &touch.subject)
                .peekable();
            let is_search = matches!(it.change, Change::FitCommand(_) | Change::Recalibrate(_));
            is_search && subjects.peek().is_some() && subjects.all(|it| explained.contains(&it))
        };
        let is_vain = |it: &Proposal| {
            matches!(it.change, Change::Model { .. }) && it.tried.repairs.is_empty()
        };
        self.proposals.sort_by_cached_key(|it| {
            let suspect = it.suspect.unwrap_or(u32::MAX);
            (it.tried.is_harmful(), is_late(it) || is_vain(it), suspect)
        });
        for (number, proposal) in (1..).zip(&mut self.proposals) {
            proposal.number = number;
        }
    }
}

/// Whether a change says which branches a model has.
pub fn is_of_structure(change: &ModelChange) -> bool {
    matches!(change, ModelChange::Branchless { .. }) || change.is_of_lacking_branch()
}

/// Whose counts a number of an entry was solved for.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The entry.
    pub entry: String,
    /// The number.
    pub name: String,
    /// Whose counts.
    pub from: String,
    /// Of what.
    pub subject: Subject,
}

/// The current evidence of each technique: the last in the ledger under each
/// condition.
pub fn current(study: &Study) -> Vec<&Entry> {
    let mut found: Vec<&Entry> = Vec::new();
    for entry in study.ledger.iter().filter(|entry| !entry.intermediate) {
        let technique = entry.work.technique();
        if entry.work.model().is_none() && !is_simulated(entry) {
            continue;
        }
        found.retain(|o| o.work.technique() != technique || o.conditions != entry.conditions);
        found.push(entry);
    }
    found
}

/// Whether parameters of a simulation may be fitted.
pub fn is_simulated(entry: &Entry) -> bool {
    match entry.work.simulated() {
        Some(Simulated::Handover { .. }) => true,
        // A rig moves: its trials are of the system.
        Some(Simulated::Command(_)) => entry.work.technique().is_of_simulator(),
        Some(Simulated::Scene { .. }) | None => false,
    }
}

/// A formal model as it is, or as it has become.
pub struct Asset<'a> {
    /// The entry of the ledger that it belongs to.
    pub entry: &'a Entry,
    /// Its file.
    pub path: &'a Path,
    /// Its text.
    pub text: &'a str,
}

/// What is refined: a study's evidence, and what it declares.
pub fn ground<'a>(study: &'a Study, result: &'a StudyResult) -> Ground<'a> {
    Ground {
        evidence: &result.evidence,
        requirements: &study.requirements,
        failure_modes: &study.failure_modes,
        comparisons: &result.comparisons,
        confidence: result.confidence,
    }
}

/// How formal models are asked about failure modes.
pub fn asked(study: &Study) -> Vec<Asked> {
    let modes = study.forms.subjects.iter();
    let modes = modes.filter(|form| matches!(form.subject, Subject::FailureMode(_)));
    modes
        .map(|form| Asked {
            mode: form.subject.id().to_owned(),
            occurs: binding(study, form.property.as_ref().map(|p| p.text.as_str())),
            after: binding(study, form.opportunity.as_ref().map(|p| p.text.as_str())),
        })
        .collect()
}

/// The propositions that properties ask for, with what they mean to a formal model.
pub fn words(study: &Study) -> Vec<Word> {
    let of_form = |form: &study::SubjectForm| {
        let text = form.property.as_ref().map_or("", |it| it.text.as_str());
        let names = quoted_names(text).into_iter();
        let all = names.filter_map(|(name, _)| {
            let bound = study.vocabulary.propositions.get(&name)?;
            Some(Word {
                subject: form.subject.clone(),
                meaning: bound.model.as_ref()?.text.clone(),
                name,
            })
        });
        all.collect::<Vec<_>>()
    };
    study.forms.subjects.iter().flat_map(of_form).collect()
}

/// What could be changed in a formal model so that its failures come as often
/// as they were counted.
pub fn of_model(
    study: &Study,
    result: &StudyResult,
    asset: &Asset,
    solver: &Solver,
) -> Result<ModelOffers, Problem> {
    let before = solver.values(asset.path, asset.text)?;
    let model = Model {
        evidence: &asset.entry.id,
        text: asset.text,
        asked: &asked(study),
        words: &words(study),
        solver: &solver.at(asset.path),
        states: states_of(result, &asset.entry.id),
    };
    Ok(ground(study, result).of_model(&model, &before))
}

/// How many states the model of a piece has, as the run counted them.
pub(super) fn states_of(result: &StudyResult, id: &str) -> Option<u64> {
    let mut costs = result.costs.iter();
    costs.find(|cost| cost.evidence == id)?.states
}

/// What the only proposition of a question means to the model.
fn binding(study: &Study, question: Option<&str>) -> Option<String> {
    let names = quoted_names(question?);
    let [(name, _)] = names.as_slice() else {
        return None;
    };
    let proposition = study.vocabulary.propositions.get(name)?;
    Some(proposition.model.as_ref()?.text.clone())
}

/// A change of a formal model as a proposal.
pub fn model_proposal(
    result: &StudyResult,
    asset: &Asset,
    before: &Values,
    (suspect, tried): (Option<u32>, Trial),
    (change, changed): (ModelChange, Changed),
) -> Proposal {
    let entry = &asset.entry.id;
    let counts = change.counts();
    let mode = change.subject();
    let old = asset.path.display().to_string();
    let new = Names::next_model(asset.path);
    let mut notes = vec![format!(
        "From then on, agreement with {} on {} is a fit, not corroboration.",
        counts.evidence,
        mode.id().replace('_', " ")
    )];
    notes.extend(remains(&change, &changed));
    notes.extend(changed.notes.iter().cloned());
    notes.extend(alone(&change, &tried));
    notes.extend(hides(result, &change, before, changed.at_last()));
    let is_harmful = tried.is_harmful();
    // A number that makes a requirement agree is the model's error only if the model is the likeliest to be wrong, and the
    // number the only one that does; so is a branch.
    let is_fitted = matches!(
        change,
        ModelChange::Solve {
            subject: Subject::Requirement(_),
            ..
        } | ModelChange::Branchless { .. }
            | ModelChange::Split { .. }
            | ModelChange::Idle { .. }
            | ModelChange::Slip { .. }
    );
    let is_a_guess = !changed.alternatives.is_empty() || (is_fitted && suspect != Some(1));
    // Which branches there are is decided by who knows the system.
    let is_structure = is_of_structure(&change);
    // A number can be made to fit what a lacking branch does.
    let never_taken = refinement::never_taken(asset.text).filter(|_| !is_structure);
    if let Some((asked, line)) = &never_taken {
        notes.push(format!(
            "Look at line {line} first: it asks for `{asked}`, and no command leads there. If one should, this number makes up for it \
             and is right as it is."
        ));
    }
    // What is right within the margin, or as far as chance tells, is not to be changed without being looked at.
    let repairs_nothing = tried.repairs.is_empty();
    if repairs_nothing {
        notes.push(
            "It mends no disagreement that is strong: the counts may differ from the model by chance, or for a reason that \
             lies elsewhere."
                .to_owned(),
        );
    }
    Proposal {
        number: 0,
        suspect,
        title: format!("{}: {}", entry, changed.what),
        reason: reason(
            &change,
            [before, &changed.values].map(|values| values.get(&mode).copied().flatten()),
            counts,
        ),
        diff: unified(&old, &new, asset.text, &changed.text),
        file: old,
        also: Vec::new(),
        effects: effects(result, before, &changed.values, &mode, counts),
        tried,
        notes,
        needs_decision: is_harmful
            || repairs_nothing
            || is_a_guess
            || is_structure
            || never_taken.is_some(),
        change: Change::Model {
            entry: entry.clone(),
            change,
        },
    }
}

/// A p-value below which a predicted rate is not that of the counts.
const OFF: f64 = 0.05;

fn reason(change: &ModelChange, [rate, after]: [Option<f64>; 2], counts: &Counts) -> String {
    let mode = match change.subject() {
        Subject::FailureMode(id) => id.replace('_', " "),
        subject @ Subject::Requirement(_) => subject.in_words(),
    };
    let rate = rate.unwrap_or(0.0);
    match change {
        ModelChange::Branch {
            at: Some(_), name, ..
        } => format!(
            "No command of the model leads to {}, so that its rate of {mode} is {rate}, and it was counted in {}. A branch that leads \
             there has the probability with which both are the same.",
            name.replace('_', " "),
            counts.words()
        ),
        ModelChange::Branch { .. } => format!(
            "The model does not know {mode}, which was seen in {}.",
            counts.words()
        ),
        ModelChange::Rate { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}.",
            counts.words()
        ),
        ModelChange::Solve {
            subject: Subject::Requirement(_),
            ..
        } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. One number of the model is solved for so that \
             both are the same.",
            counts.words()
        ),
        ModelChange::Solve { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. No constant is that share: what decides it \
             acts more than once in a run, or several act together, so that it is solved for.",
            counts.words()
        ),
        ModelChange::Split { split, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. It declares `{}` and uses it nowhere. With a branch that \
             has this probability they agree, and nothing has to be fitted for it.",
            counts.words(),
            split.constant
        ),
        ModelChange::Idle { change, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. In the model's text {}. With this change they agree, \
             and nothing has to be fitted for it.",
            counts.words(),
            change.hint()
        ),
        ModelChange::Slip { change, .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. If {}, they agree, and nothing has to be fitted for it.",
            counts.words(),
            change.supposed()
        ),
        ModelChange::Branchless { .. } => format!(
            "The model's rate of {mode} is {rate:.6}, and it was counted in {}. Without one branch of a command they {}, and \
             nothing has to be fitted for it.",
            counts.words(),
            match after.and_then(|after| counts.p_value(after)) {
                Some(p) if p < OFF => "come within the margin of each other",
                _ => "agree",
            }
        ),
        ModelChange::Once { .. } => format!(
            "The model's constant is the counted share ({}), but its rate of {mode} is {rate:.6}: it draws again and \
             again where the counts have one opportunity.",
            counts.words()
        ),
    }
}

/// That nothing but the rate to which a number is fitted speaks for it.
fn alone(change: &ModelChange, tried: &Trial) -> Option<String> {
    let ModelChange::Solve { subject, .. } = change else {
        return None;
    };
    let is_checked = tried.repairs.iter().any(|it| it.subject != *subject);
    (!is_checked && !tried.repairs.is_empty()).then(|| {
        format!(
            "Nothing but the rate of {} speaks for this number, and one number can be made to give one rate whatever is wrong: look at \
             the guards and branches that bear on it first.",
            match subject {
                Subject::FailureMode(id) => id.replace('_', " "),
                subject @ Subject::Requirement(_) => subject.in_words(),
            }
        )
    })
}

/// What a change of a rate does not yet fix.
fn remains(change: &ModelChange, changed: &Changed) -> Option<String> {
    let ModelChange::Rate { counts, mode, .. } = change else {
        return None;
    };
    let rate = rate_of(&changed.values, mode)?;
    let is_far = (rate - counts.rate()).abs() > SAME * counts.rate().max(SAME);
    is_far.then(|| {
        format!(
            "The rate then still is {rate:.6} and not {:.6}; refine again after this one.",
            counts.rate()
        )
    })
}

/// Requirements that the data of the real system miss, and that the changed model would meet: the change would hide it.
fn hides(
    result: &StudyResult,
    change: &ModelChange,
    before: &Values,
    after: &Values,
) -> Vec<String> {
    let counts = change.counts();
    let of = |requirement: &evidence::Requirement| {
        let subject = Subject::Requirement(requirement.id.clone());
        let value = |values: &Values| values.get(&subject).copied().flatten();
        let (now, then) = (value(before)?, value(after)?);
        let meets = |rate: f64| is_met(requirement, rate);
        let missed = result.evidence.iter().filter(|piece| {
            let is_real = piece.technique.is_of_system();
            is_real && piece.id != counts.evidence && !piece.intermediate
        });
        let mut missed = missed.filter_map(|piece| {
            let counted = Counts::of(&result.evidence, &piece.id, &subject)?;
            let misses = !meets(counted.rate());
            misses.then(|| counted.words())
        });
        let missed = missed.next().filter(|_| meets(then) && !meets(now))?;
        Some(format!(
            "The model then meets requirement {}, which the system misses ({missed}): this would hide a defect.",
            requirement.id
        ))
    };
    result.requirements.iter().filter_map(of).collect()
}

/// Whether a rate is on the side of the threshold that is required.
fn is_met(requirement: &evidence::Requirement, rate: f64) -> bool {
    match requirement.threshold {
        Some(threshold) => match threshold.direction {
            evidence::Direction::AtLeast => rate >= threshold.value,
            evidence::Direction::AtMost => rate <= threshold.value,
        },
        None => rate >= 1.0,
    }
}

pub(super) fn effects(
    result: &StudyResult,
    before: &Values,
    after: &Values,
    mode: &Subject,
    counts: &Counts,
) -> Vec<Effect> {
    let value = |values: &Values, subject: &Subject| values.get(subject).copied().flatten();
    let is_moved = |subject: &&Subject| match (value(before, subject), value(after, subject)) {
        (Some(old), Some(new)) => (old - new).abs() > 1e-9,
        (old, new) => old.is_some() != new.is_some(),
    };
    let mut subjects = vec![mode.clone()];
    let is_own = |subject: &&Subject| {
        let mut all = result.requirements.iter();
        !all.any(|r| r.id == subject.id() && r.same_quantity_as.is_some())
    };
    let others = after
        .keys()
        .filter(|subject| *subject != mode)
        .filter(is_own);
    subjects.extend(others.filter(is_moved).cloned());
    let effect = |subject: Subject| {
        let counted = match &subject == mode {
            true => Some(counts.clone()),
            false => Counts::of(&result.evidence, &counts.evidence, &subject),
        };
        let new = value(after, &subject);
        Effect {
            before: value(before, &subject),
            after: new,
            p_value: counted
                .as_ref()
                .zip(new)
                .and_then(|(c, new)| c.p_value(new)),
            counted,
            subject,
        }
    };
    subjects.into_iter().map(effect).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proposal(suspect: Option<u32>, change: Change, moves: &str) -> Proposal {
        Proposal {
            number: 0,
            suspect,
            title: String::new(),
            reason: String::new(),
            file: String::new(),
            also: Vec::new(),
            diff: String::new(),
            effects: vec![Effect {
                subject: Subject::FailureMode(moves.into()),
                before: Some(0.1),
                after: Some(0.2),
                counted: None,
                p_value: None,
            }],
            tried: Trial::default(),
            notes: Vec::new(),
            needs_decision: false,
            change,
        }
    }

    fn value() -> Change {
        Change::Value {
            file: "m.prism".into(),
            value: OneValue {
                line: 1,
                old: "0.1".into(),
                new: "0.2".into(),
            },
            fitted: None,
        }
    }

    #[test]
    fn what_moves_an_exchanged_subject_waits_for_the_exchange() {
        let subjects = ["slip", "miss"].map(|id| Subject::FailureMode(id.into()));
        let exchange = Change::Exchange { texts: Vec::new() };
        let mut offered = Offered::default();
        offered.add(proposal(None, value(), "slip"));
        offered.add(proposal(Some(1), exchange, "slip"));
        offered.add(proposal(None, value(), "another"));
        offered.add(proposal(Some(0), value(), "miss"));
        offered.in_order(&[]);
        offered.await_exchanges(&[(1, &subjects)]);
        let waits = |moves: &str| {
            let of = Subject::FailureMode(moves.into());
            let mut values = offered.proposals.iter().filter(|it| !it.is_exchange());
            values
                .find(|it| it.effects[0].subject == of)
                .map(|it| it.needs_decision)
        };
        assert_eq!(waits("slip"), Some(true));
        assert_eq!(waits("another"), Some(false));
        // What is suspected more than the exchange does not wait for it.
        assert_eq!(waits("miss"), Some(false));
    }
}
