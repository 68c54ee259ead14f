//! Paths sampled from a formal model, as traces of the vocabulary's propositions.
//!
//! # Definition
//! Each step of the path is one instant. What holds there is the vocabulary's meaning of a proposition to
//! the model; a proposition without one, whose meaning to traces is put together of propositions that
//! have one, follows from them. Steps that change no proposition are left out, which no untimed formula
//! without a next-step operator can see (L. Lamport, "What good is temporal logic?", 1983). If study.toml
//! declares how long a step takes (in continuous time, a unit of time), all steps are kept and time is counted;
//! otherwise forms with limits in seconds cannot be judged. A model that leaves choices open has no paths to be sampled:
//! its answers are ranges, and no one way of choosing stands for all.
//!
//! A path ends where the model can only stay as it is; from there on LTL on finite traces and on infinite
//! ones agree. One that is cut after [`LONGEST`] steps is incomplete, so that what the rest might decide is
//! undecided.
//!
//! # Assumes
//! Draws from the seeds are as good as independent uniform ones.
//!
//! # Guarantee
//! Paths are independent samples of the model's distribution over paths, each with a seed of its own. A path of which the rest
//! could decide is undecided, never kept or violated.

use super::super::exploration::{Formal, Meaning};
use checker::{Visit, sample_path};
use diagnostic::Problem;
use evidence::{JudgedBy, Subject};
use host::Cancel;
use judging::forms::judged_on_paths;
use std::collections::{BTreeMap, BTreeSet};
use study::{JudgingForm, Rule, Study, SubjectForm, TriggerForm, Vocabulary};
use temporal::formula::{Formula, TimeModel, TimeUnit};
use temporal::monitor::Stage;
use trace::{Field, Trace};

/// Steps after which a path is cut: of a chain that never comes to rest all paths are this long, thousands of them.
const LONGEST: u64 = 10_000;

/// The topic of the propositions.
const TOPIC: &str = "/model";

/// A formal model whose paths can be judged.
pub struct ModelPaths {
    formal: Formal,
    vocabulary: Vocabulary,
    /// The propositions that the model expresses, with the states in which they hold.
    holds: BTreeMap<String, Vec<bool>>,
    step_secs: Option<f64>,
}

/// A form of a requirement that can be judged on paths.
pub struct PathForm<'a> {
    pub subject: &'a Subject,
    pub judged_by: JudgedBy,
    /// Of a property: whether this is what triggers it, the opportunity of a failure mode.
    pub opportunity: bool,
    pub judging: Result<JudgingForm, String>,
}

/// A step that changes what holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownStep {
    /// Its number, from 0.
    pub step: usize,
    /// The model's state.
    pub state: String,
    /// What holds.
    pub holds: Vec<String>,
}

impl ModelPaths {
    /// The model of a ledger's entry.
    pub fn of_entry(study: &Study, id: &str, interrupt: &Cancel) -> Result<Self, Problem> {
        let formal = Formal::of_entry(study, id, interrupt)?;
        if !formal.space.choice_start.is_empty() {
            return Err(Problem::new(
                "open-choices",
                format!("{id} leaves choices open, so it has no single distribution of paths"),
            )
            .remedy("ask for the least and the greatest value over all schedulers instead"));
        }
        let mut holds = BTreeMap::new();
        for (name, proposition) in &study.vocabulary.propositions {
            if let Some(binding) = &proposition.model
                && let Meaning::Holds(flags) = formal.meaning(&binding.text)?
            {
                holds.insert(name.clone(), flags);
            }
        }
        let vocabulary = of_model(study, &holds)?;
        Ok(Self {
            formal,
            vocabulary,
            holds,
            step_secs: study.about.model.step_secs(),
        })
    }

    /// What the propositions mean on its paths.
    pub fn vocabulary(&self) -> &Vocabulary {
        &self.vocabulary
    }

    /// The path with this seed, as a trace.
    pub fn trace(&self, seed: u64) -> Result<Trace, Problem> {
        let path = self.path(seed);
        let fields = self.holds.keys().map(|name| Field::bool(name.as_str()));
        let mut trace = Trace::new();
        let bad = |error: trace::TraceError| Problem::new("bad-recording", error.to_string());
        let place = trace.add_channel(TOPIC, fields.collect()).map_err(bad)?;
        let step_secs = self.step_secs.unwrap_or(1.0);
        let mut before: Option<Vec<f64>> = None;
        for (step, visit) in path.iter().enumerate() {
            let values = self.values(visit.state);
            let is_last = step + 1 == path.len();
            if self.step_secs.is_none() && !is_last && before.as_ref() == Some(&values) {
                continue;
            }
            trace.channels[place]
                .push(visit.time * step_secs, &values)
                .map_err(bad)?;
            before = Some(values);
        }
        trace.complete = path.last().is_some_and(|visit| self.stays(visit.state));
        Ok(trace)
    }

    /// The steps of the path with this seed that change what holds.
    pub fn shown(&self, seed: u64) -> Vec<ShownStep> {
        let path = self.path(seed);
        let mut shown: Vec<ShownStep> = Vec::new();
        for (step, Visit { state, .. }) in path.iter().enumerate() {
            let all = self.holds.iter().filter(|(_, flags)| flags[*state]);
            let holds: Vec<String> = all.map(|(name, _)| name.clone()).collect();
            if shown.last().is_none_or(|last| last.holds != holds) || step + 1 == path.len() {
                let state = self.formal.space.describe(*state);
                shown.push(ShownStep { step, state, holds });
            }
        }
        shown
    }

    /// The path with this seed; a model with open choices was refused.
    fn path(&self, seed: u64) -> Vec<Visit> {
        sample_path(&self.formal.space, seed, LONGEST).unwrap_or_default()
    }

    fn values(&self, state: usize) -> Vec<f64> {
        let flags = self.holds.values();
        flags
            .map(|flags| f64::from(u8::from(flags[state])))
            .collect()
    }

    fn stays(&self, state: usize) -> bool {
        let mut row = self.formal.space.matrix.row(state);
        row.all(|(target, _)| target == state)
    }

    /// The forms of a subject, as far as they can be judged on paths.
    pub fn forms<'a>(&self, form: &'a SubjectForm) -> Vec<PathForm<'a>> {
        let of = |judged_by, opportunity, judging| PathForm {
            subject: &form.subject,
            judged_by,
            opportunity,
            judging,
        };
        let property = |text: &str| {
            let judging = judged_on_paths(&self.vocabulary, self.step_secs, text)?;
            self.able(&judging).map(|()| judging)
        };
        let mut forms = Vec::new();
        match (&form.property, &form.no_property) {
            (Some(text), _) => forms.push(of(JudgedBy::Property, false, property(&text.text))),
            (None, reason) => {
                let why = reason
                    .clone()
                    .unwrap_or_else(|| "it has no property".into());
                forms.push(of(JudgedBy::Property, false, Err(why)));
            }
        }
        let trigger = match (&form.opportunity, &form.trigger) {
            (None, TriggerForm::Runs(text)) if form.property.is_some() => Some(text),
            (opportunity, _) => opportunity.as_ref(),
        };
        if let Some(text) = trigger {
            forms.push(of(JudgedBy::Property, true, property(&text.text)));
        }
        let monitor = match &form.monitor {
            Some(monitor) => self.able(monitor).map(|()| monitor.clone()),
            None => Err("it has no monitor".to_owned()),
        };
        forms.push(of(JudgedBy::Monitor, false, monitor));
        forms
    }

    /// Whether a form can be judged here.
    fn able(&self, judging: &JudgingForm) -> Result<(), String> {
        if let Some(clock) = &judging.clock {
            return Err(format!("its clock is {clock}, which a model does not have"));
        }
        if self.step_secs.is_none() && is_timed(&judging.rule) {
            return Err(
                "it counts seconds, and a step of the model has no declared duration".into(),
            );
        }
        let known: BTreeSet<String> = self
            .holds
            .keys()
            .map(|name| format!("{TOPIC}.{name}"))
            .collect();
        let mut unknown = BTreeSet::new();
        for text in propositions(&judging.rule) {
            let predicate = self.vocabulary.signals.predicate(&text);
            let predicate = predicate.map_err(|error| error.kind.to_string())?;
            if !predicate.signals().is_subset(&known) {
                unknown.insert(text);
            }
        }
        match unknown.is_empty() {
            true => Ok(()),
            false => {
                let names: Vec<String> = unknown.iter().map(|name| format!("`{name}`")).collect();
                Err(format!("the model does not express {}", names.join(", ")))
            }
        }
    }
}

/// The study's vocabulary, with the model's meaning where it has one.
fn of_model(study: &Study, holds: &BTreeMap<String, Vec<bool>>) -> Result<Vocabulary, Problem> {
    let mut vocabulary = study.vocabulary.clone();
    for (name, proposition) in &mut vocabulary.propositions {
        if holds.contains_key(name)
            && let Some(mut binding) = proposition.model.clone()
        {
            binding.text = format!("{TOPIC}.{name}");
            proposition.trace = Some(binding);
        }
    }
    let all = vocabulary.propositions.iter();
    let bound = all.filter_map(|(name, p)| Some((name.clone(), p.trace.as_ref()?.text.clone())));
    let parameters = study.parameters.values.clone();
    vocabulary.signals =
        trace::Vocabulary::with_parameters(bound, parameters).map_err(|errors| {
            let words: Vec<String> = errors.iter().map(|error| error.kind.to_string()).collect();
            Problem::new("bad-predicate", words.join("; "))
        })?;
    Ok(vocabulary)
}

fn propositions(rule: &Rule) -> Vec<String> {
    match rule {
        Rule::Staged(spec) => spec.propositions().into_iter().map(Into::into).collect(),
        Rule::Formula(rule) => rule
            .parsed
            .atoms
            .iter()
            .map(|atom| atom.text.clone())
            .collect(),
    }
}

fn is_timed(rule: &Rule) -> bool {
    match rule {
        Rule::Staged(spec) => spec.then.iter().any(|stage| match stage {
            Stage::Assert { .. } => false,
            Stage::WaitFor { within_secs, .. } | Stage::Hold { within_secs, .. } => {
                within_secs.is_some()
            }
        }),
        Rule::Formula(rule) => rule.time == TimeModel::Dense || has_bounds(&rule.parsed.formula),
    }
}

fn has_bounds(formula: &Formula) -> bool {
    let own = formula.interval().is_some_and(|interval| {
        let ends = [Some(interval.low), interval.high];
        ends.into_iter()
            .flatten()
            .any(|end| end.value > 0.0 && matches!(end.unit, TimeUnit::Seconds | TimeUnit::Samples))
    });
    let is_next = matches!(formula, Formula::Next(_) | Formula::Previous(_));
    own || is_next || formula.operands().into_iter().any(has_bounds)
}
