//! Reading texts, and values of models by the model checker.

use behaviour_tree::{Reading, read};
use checker::explore::explore;
use checker::{AnswerValue, Options, check};
use diagnostic::{Problem, Source};
use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};

pub fn try_read(text: &str) -> Result<Reading, Problem> {
    let none = |path: &str, _: &str| Err(Problem::new("cannot-read", format!("no file {path}")));
    read(&Source::new("tree.xml", text), None, &mut { none })
}

pub fn reading(text: &str) -> Reading {
    try_read(text).unwrap_or_else(|problem| panic!("{text}\n{problem:?}"))
}

/// The values of properties of a model without open constants, and its number of states.
pub fn values(model: &str, properties: &[String]) -> (Vec<f64>, usize) {
    let parsed = parse_model(model).into_result();
    let parsed = parsed.unwrap_or_else(|error| panic!("{model}\n{error:?}"));
    let model =
        resolve(&parsed, &Constants::new()).unwrap_or_else(|error| panic!("{model}\n{error:?}"));
    let space = explore::<f64>(&model).expect("a state space");
    let values = properties.iter().map(|text| {
        let property = parse_properties(text).into_result().expect("a property");
        let property = resolve_properties(&property, &model, &Constants::new()).expect("resolved");
        let answer = check(&space, &model, &property[0].property, &Options::default());
        match answer.expect("an answer").value {
            AnswerValue::Number(value) => value,
            other => panic!("{other:?}"),
        }
    });
    (values.collect(), space.num_states())
}
