//! Situations: what an episode was like, in the words of the plan.

use super::plan::{Plan, SituationData};
use campaign::{ActionPattern, Coverage, CoverageModel, Situation, Variable};
use diagnostic::{Problem, Source};
use stimulus::{Setting, Stimulus};
use study::{Study, Vocabulary};
use trace::{BoundPredicate, Cursor, Predicate, Sampling, Trace, ticks};

/// How situations are told.
pub struct Situations {
    /// The variables and their crosses.
    pub model: CoverageModel,
    /// The plan and the vocabulary, for diagnostics.
    source: Source,
    vocabulary: Vocabulary,
    kinds: Vec<(Variable, Kind)>,
}

enum Kind {
    /// Whether a proposition held when another first did, or ever.
    Held {
        proposition: Written,
        when: Option<Written>,
    },
    /// The value of what this key sets.
    Parameter(String),
    /// Whether the test has an action.
    Action(ActionPattern),
}

/// A predicate as the plan has it.
struct Written {
    predicate: Predicate,
    text: String,
}

const YES_NO: [&str; 2] = ["yes", "no"];
const NEVER: &str = "not met";

impl Situations {
    /// What a plan declares.
    pub fn new(study: &Study, plan: &Plan) -> Result<Self, Problem> {
        let kinds = plan.data.situation.iter();
        let kinds = kinds.map(|data| kind_of(study, plan, data));
        let kinds: Vec<(Variable, Kind)> = kinds.collect::<Result<_, _>>()?;
        let model = CoverageModel {
            variables: kinds.iter().map(|(variable, _)| variable.clone()).collect(),
            crosses: plan.data.cross.clone(),
        };
        let checked = model.check();
        checked.map_err(|error| plan.mistake("[[cross]]", error.to_string()))?;
        Ok(Self {
            model,
            source: plan.source.clone(),
            vocabulary: study.vocabulary.clone(),
            kinds,
        })
    }

    /// What an episode was like.
    pub fn of(&self, stimulus: &Stimulus, trace: &Trace) -> Result<Situation, Problem> {
        let mut situation = Situation::new();
        for (variable, kind) in &self.kinds {
            let label = match kind {
                Kind::Held { proposition, when } => {
                    let bound = |it: &Written| self.bound(it, trace);
                    let when = when.as_ref().map(bound).transpose();
                    let held =
                        when.and_then(|when| held(&bound(proposition)?, when.as_ref(), trace));
                    let named =
                        |problem: Problem| problem.about(&format!("situation `{}`", variable.name));
                    Some(held.map_err(named)?)
                }
                Kind::Parameter(key) => match stimulus.settings.get(key) {
                    Some(Setting::Number(value)) => variable.label_of(*value),
                    _ => None,
                },
                Kind::Action(pattern) => Some(yes_no(pattern.is_in(&stimulus.test))),
            };
            if let Some(label) = label {
                situation.insert(variable.name.clone(), label);
            }
        }
        Ok(situation)
    }

    /// A predicate over the channels of a trace. One that does not fit them, as where it compares a speed with a force, is a
    /// mistake at its place in the vocabulary or in the plan.
    fn bound(&self, written: &Written, trace: &Trace) -> Result<BoundPredicate, Problem> {
        written.predicate.bind(trace).map_err(|error| {
            if error.entry.is_some() {
                return self.vocabulary.predicate_problem(&error);
            }
            let problem = Problem::new("bad-predicate", error.kind.to_string())
                .remedy("correct the predicate, or name it in the vocabulary");
            match self.source.text.find(&written.text) {
                Some(at) => problem.at(&self.source, at + error.span.start..at + error.span.end),
                None => problem.about(&format!("{}: `{}`", self.source.name, written.text)),
            }
        })
    }

    /// Actions by which situations are told apart, each with the weight that
    /// the holes of the crosses give it.
    pub fn wanted_actions(
        &self,
        coverage: &Coverage,
    ) -> Result<Vec<(ActionPattern, f64)>, Problem> {
        let mut wanted = Vec::new();
        for cross in &coverage.model().crosses {
            let weights = coverage.label_weights(&cross.name);
            let weights = weights.map_err(|e| Problem::new("bad-exploration", e.to_string()))?;
            for (name, labels) in weights {
                let mut kinds = self.kinds.iter();
                let Some((_, Kind::Action(pattern))) = kinds.find(|(v, _)| v.name == name) else {
                    continue;
                };
                let yes = labels.iter().find(|(label, _)| label == YES_NO[0]);
                wanted.extend(yes.map(|(_, weight)| (pattern.clone(), *weight)));
            }
        }
        Ok(wanted)
    }

    /// The label that a stimulus's settings give a variable, if it is one of
    /// a parameter.
    pub fn parameter_label(&self, variable: &str, stimulus: &Stimulus) -> Option<String> {
        let (variable, kind) = self.kinds.iter().find(|(v, _)| v.name == variable)?;
        match (
            kind,
            kind_key(kind).and_then(|key| stimulus.settings.get(key)),
        ) {
            (Kind::Parameter(_), Some(Setting::Number(value))) => variable.label_of(*value),
            _ => None,
        }
    }
}

fn kind_key(kind: &Kind) -> Option<&String> {
    match kind {
        Kind::Parameter(key) => Some(key),
        _ => None,
    }
}

fn kind_of(study: &Study, plan: &Plan, data: &SituationData) -> Result<(Variable, Kind), Problem> {
    let predicate = |text: &String| {
        let predicate = study.vocabulary.signals.predicate(text);
        predicate
            .map(|predicate| Written {
                predicate,
                text: text.clone(),
            })
            .map_err(|error| plan.mistake(text, error.to_string()))
    };
    match (&data.proposition, &data.parameter, &data.action) {
        (Some(proposition), None, None) => {
            let kind = Kind::Held {
                proposition: predicate(proposition)?,
                when: data.when.as_ref().map(predicate).transpose()?,
            };
            let labels: &[&str] = match data.when {
                Some(_) => &["yes", "no", NEVER],
                None => &YES_NO,
            };
            Ok((Variable::new(&data.name, labels), kind))
        }
        (None, Some(name), None) => {
            let place = plan
                .space
                .index_of(name)
                .ok_or_else(|| plan.mistake(name, format!("there is no [[parameter]] `{name}`")))?;
            let parameter = &plan.space.parameters[place];
            let ascending = data.edges.windows(2).all(|pair| pair[0] < pair[1]);
            if data.edges.len() < 2 || !ascending {
                let message = "`edges` are two or more numbers, ascending";
                return Err(plan.mistake(&data.name, message));
            }
            let unit = parameter.unit.as_ref();
            let suffix = unit.map_or(String::new(), |unit| format!(" {unit}"));
            let pairs = data.edges.windows(2);
            let labels: Vec<String> = pairs
                .map(|e| format!("{}..{}{suffix}", e[0], e[1]))
                .collect();
            let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
            let variable = Variable {
                edges: data.edges.clone(),
                unit: unit.cloned(),
                ..Variable::new(&data.name, &labels)
            };
            // A parameter sets at least one key.
            let key = parameter.sets.first().cloned().unwrap_or_default();
            Ok((variable, Kind::Parameter(key)))
        }
        (None, None, Some(action)) => Ok((
            Variable::new(&data.name, &YES_NO),
            Kind::Action(action.clone()),
        )),
        _ => Err(plan.mistake(
            &data.name,
            format!(
                "situation `{}` needs exactly one of proposition, parameter and action",
                data.name
            ),
        )),
    }
}

fn yes_no(yes: bool) -> String {
    YES_NO[usize::from(!yes)].to_owned()
}

/// Whether a proposition held at the first instant at which `when` did, or
/// at any.
fn held(
    proposition: &BoundPredicate,
    when: Option<&BoundPredicate>,
    trace: &Trace,
) -> Result<String, Problem> {
    let times = ticks(trace, Sampling::EveryRow)
        .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
    let mut cursor = Cursor::new(trace);
    for time_secs in times {
        cursor.seek(time_secs);
        let holds = proposition.eval(&cursor) == Some(true);
        match when {
            Some(when) if when.eval(&cursor) == Some(true) => return Ok(yes_no(holds)),
            None if holds => return Ok(yes_no(true)),
            _ => {}
        }
    }
    Ok(match when {
        Some(_) => NEVER.to_owned(),
        None => yes_no(false),
    })
}
