//! Formal evidence: the study's questions, answered on a model in the PRISM language.

use crate::carried::Open;
use crate::requirements::Forms;
use crate::words::Words;
use checker::explore::explore;
use checker::state_space::StateSpace;
use checker::{AnswerValue, Method, Options, check_space};
use evidence::{Finding, Guarantee, Measure, MethodAnswer, Subject};
use prism_lang::{Constants, Number, Property, Value, parse_model, parse_properties};
use stats::{Confidence, EffectiveSample};
use std::collections::BTreeMap;

/// One subject's question.
#[derive(Clone, Debug)]
pub struct Question {
    /// What is asked about.
    pub subject: Subject,
    /// The property, and for a failure mode that of its opportunity; `None` if the model cannot
    /// express it.
    pub property: Option<(String, Option<String>)>,
}

/// A model and the questions to it.
#[derive(Clone, Debug)]
pub struct Formal {
    /// The model's text.
    pub text: String,
    /// Labels for the properties.
    pub labels: String,
    /// Constants that were set to counts, with what those are worth in independent trials.
    pub counted: Vec<(String, EffectiveSample)>,
    /// The questions.
    pub questions: Vec<Question>,
    /// The methods by which each is answered; the first is the answer that counts.
    pub methods: Vec<Method>,
}

impl Formal {
    /// A model, asked about the requirements and about the failure modes of the vocabulary, of which it may lack some.
    ///
    /// # Errors
    /// What is wrong with the model or with a requirement's form.
    pub fn new(text: String, words: &Words, forms: &[Forms]) -> Result<Self, String> {
        let tree = parse_model(&text)
            .into_result()
            .map_err(|e| format!("{e:?}"))?;
        let model = prism_lang::resolve(&tree, &Constants::new());
        let model = model.map_err(|e| format!("{e:?}"))?;
        let mut formal = Self {
            labels: words.labels(),
            text,
            counted: Vec::new(),
            questions: Vec::new(),
            methods: vec![Method::Sound],
        };
        for form in forms {
            let property = match words.expresses(form) {
                true => Some((form.query()?, None)),
                false => None,
            };
            formal.questions.push(Question {
                subject: Subject::Requirement(form.id.to_owned()),
                property,
            });
        }
        for asked in &words.asked {
            let questions = words.questions(&asked.mode);
            let known = questions.filter(|(occurs, _)| formal.property(&model, occurs).is_ok());
            formal.questions.push(Question {
                subject: Subject::FailureMode(asked.mode.clone()),
                property: known.map(|(occurs, after)| (occurs, Some(after))),
            });
        }
        Ok(formal)
    }

    /// The sound answers to all questions; `None` where the model has none.
    ///
    /// # Errors
    /// What is wrong with the model or a property, in words.
    pub fn values(&self) -> Result<Vec<(Subject, Option<f64>)>, String> {
        let tree = parse_model(&self.text)
            .into_result()
            .map_err(|e| format!("{e:?}"))?;
        let solved = self.solve(&tree, &[], &[Method::Sound])?;
        let questions = self.questions.iter().zip(solved);
        Ok(questions
            .map(|(question, answers)| {
                let value = answers.and_then(|all| all.first().map(|answer| answer.value));
                (question.subject.clone(), value)
            })
            .collect())
    }

    /// The findings on all questions.
    ///
    /// # Errors
    /// What is wrong with the model or a property, in words.
    pub fn findings(&self, level: Confidence, seed: u64) -> Result<Vec<Finding>, String> {
        let tree = parse_model(&self.text)
            .into_result()
            .map_err(|e| format!("{e:?}"))?;
        let solved = self.solve(&tree, &[], &self.methods)?;
        let asked = self.questions.iter().zip(solved);
        let mut measures: Vec<Measure> = asked.map(|(it, answers)| measure(it, answers)).collect();
        if !self.counted.is_empty() {
            Open::new(self)?.carry(level, seed, &mut measures)?;
        }
        let findings = self.questions.iter().zip(measures);
        Ok(findings
            .map(|(question, measure)| Finding {
                subject: question.subject.clone(),
                measure,
                denominator: evidence::Denominator::default(),
                trigger: None,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            })
            .collect())
    }

    /// For each question the answers of each method; `None` where the model has no answer, as for a rate whose
    /// opportunity never comes.
    pub(crate) fn solve(
        &self,
        tree: &prism_lang::ast::Model,
        constants: &[(String, f64)],
        methods: &[Method],
    ) -> Result<Vec<Option<Vec<MethodAnswer>>>, String> {
        let mut overrides = Constants::new();
        for (name, value) in constants {
            let value = Value::Double(Number::from_approximate(*value));
            overrides.set(name.clone(), value);
        }
        let model = prism_lang::resolve_with(tree, &Constants::new(), &overrides)
            .map_err(|found| format!("{found:?}"))?;
        let space = explore::<f64>(&model).map_err(|error| error.to_string())?;
        let mut known: BTreeMap<&str, Vec<MethodAnswer>> = BTreeMap::new();
        for text in self.texts() {
            let property = self.property(&model, text)?;
            let answers = methods
                .iter()
                .map(|method| answer(&property, *method, &space));
            known.insert(text, answers.collect::<Result<_, _>>()?);
        }
        let answered = self.questions.iter().map(|question| {
            let (text, opportunity) = question.property.as_ref()?;
            let occurs = known.get(text.as_str())?;
            let Some(opportunity) = opportunity else {
                return Some(occurs.clone());
            };
            let opportunities = known.get(opportunity.as_str())?;
            if opportunities.iter().any(|one| one.value <= 0.0) {
                return None;
            }
            let pairs = occurs.iter().zip(opportunities);
            Some(pairs.map(|(one, other)| one.quotient(other)).collect())
        });
        Ok(answered.collect())
    }

    /// The texts of all properties, each once.
    pub(crate) fn texts(&self) -> Vec<&str> {
        let mut texts: Vec<&str> = Vec::new();
        for (text, opportunity) in self.questions.iter().filter_map(|q| q.property.as_ref()) {
            texts.push(text);
            texts.extend(opportunity.as_deref());
        }
        texts.sort_unstable();
        texts.dedup();
        texts
    }

    pub(crate) fn property(
        &self,
        model: &prism_lang::resolved::Model,
        text: &str,
    ) -> Result<Property, String> {
        let whole = format!("{}{text}", self.labels);
        let tree = parse_properties(&whole)
            .into_result()
            .map_err(|e| format!("{e:?}"))?;
        let found = prism_lang::resolve_properties(&tree, model, &Constants::new());
        let mut found = found.map_err(|e| format!("{text}: {e:?}"))?;
        found
            .pop()
            .map(|p| p.property)
            .ok_or_else(|| "no property".into())
    }
}

fn measure(question: &Question, answers: Option<Vec<MethodAnswer>>) -> Measure {
    let mut answers = answers.unwrap_or_default().into_iter();
    match answers.next() {
        Some(answer) => Measure::Probability {
            answer,
            others: answers.collect(),
            credible: None,
        },
        None if question.property.is_some() => Measure::NotCovered {
            reason: "In the model, the opportunity has probability 0.".into(),
            constant: None,
        },
        None => Measure::NotExpressible {
            reason: "The model does not express it.".into(),
        },
    }
}

fn answer(
    property: &Property,
    method: Method,
    space: &StateSpace<f64>,
) -> Result<MethodAnswer, String> {
    let answer = check_space(space, property, &Options::with_method(method));
    let answer = answer.map_err(|error| error.to_string())?;
    let AnswerValue::Number(value) = answer.value else {
        return Err("the answer is not a number".into());
    };
    Ok(MethodAnswer {
        method: match method {
            Method::PrismDefault => "prism-default".into(),
            _ => "sound".into(),
        },
        value,
        complement: answer.complement,
        guarantee: Guarantee::of(&answer.guarantee, None),
        iterations: (answer.iterations > 0).then_some(answer.iterations),
    })
}
