//! Proposals: what may be changed, why, and what it is predicted to do.

mod offered;
mod words;

pub use offered::Offered;

use super::command::CommandFit;
use super::ledger_text::Names;
use super::lineage::ChosenFor;
use super::one_value::OneValue;
use super::simulator::Recalibration;
use super::solver::Solver;
use diagnostic::Problem;
use evidence::{Evidence, Measure, StudyResult, Subject};
use refinement::{
    Asked, Changed, Counts, Exchange, FormChange, Ground, Model, ModelChange, ModelOffers,
    TextChange, Trial, Values, Word, unified,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use study::{Entry, Simulated, Study, quoted_names};
use words::{alone, hides, reason, remains};

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
    /// With what evidence agreement is a fit once it is made, as the ledger then says; numbers that are set to counts have their own
    /// lineage.
    pub chosen: Vec<ChosenFor>,
    /// The numbers of other proposals that make the same evidence agree: the evidence does not tell which is right.
    pub rivals: Vec<usize>,
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

/// Whether a change says which branches a model has.
pub fn is_of_structure(change: &ModelChange) -> bool {
    matches!(
        change,
        ModelChange::Branchless { .. } | ModelChange::Slip { .. }
    ) || change.is_of_lacking_branch()
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

/// The models and simulations that are current: those that say something of a subject of which none behind them in the ledger, of the
/// same technique and under the same conditions, says anything. A later version of a model speaks of all that the earlier one does; a
/// model of another part of the system does not, and takes no place but its own.
pub fn current<'s>(study: &'s Study, evidence: &[Evidence]) -> Vec<&'s Entry> {
    let is_meant = |entry: &&Entry| {
        !entry.intermediate && (entry.work.model().is_some() || is_simulated(entry))
    };
    let all: Vec<&Entry> = study.ledger.iter().filter(is_meant).collect();
    let spoken_of = |entry: &Entry| -> BTreeSet<&Subject> {
        let piece = evidence.iter().find(|piece| piece.id == entry.id);
        let findings = piece.into_iter().flat_map(|piece| &piece.findings);
        let said = findings.filter(|it| match it.measure {
            Measure::Counts { .. } | Measure::Probability { .. } => true,
            Measure::NotCovered { .. } | Measure::NotExpressible { .. } => false,
        });
        said.map(|it| &it.subject).collect()
    };
    let is_current = |(place, entry): (usize, &&Entry)| {
        let behind = all.iter().skip(place + 1).filter(|other| {
            other.work.technique() == entry.work.technique() && other.conditions == entry.conditions
        });
        let mut behind = behind.peekable();
        if behind.peek().is_none() {
            return true;
        }
        let taken_over: BTreeSet<&Subject> = behind.flat_map(|it| spoken_of(it)).collect();
        !spoken_of(entry).is_subset(&taken_over)
    };
    let current = all.iter().enumerate().filter(|it| is_current(*it));
    current.map(|(_, entry)| *entry).collect()
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
        mode.in_words()
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
        chosen: Vec::new(),
        rivals: Vec::new(),
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
