//! The text of each property is read by the parser of the PRISM language as the formula it prints.

use crate::support;

use prism_lang::property::{Path, StateFormula, TimeBound};
use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};
use requirement_lang::compile::property::{Model, label_of_name, property};
use requirement_lang::sentence::Timing;
use temporal::ltl::{Ltl, StepBound};

const MODEL: &str = "
    dtmc
    module any
      x : [0..31] init 0;
      [] true -> (x'=mod(x+1,32));
    endmodule
    label \"m\" = mod(x,2)=1;
    label \"c\" = mod(floor(x/2),2)=1;
    label \"r\" = mod(floor(x/4),2)=1;
    label \"q\" = mod(floor(x/8),2)=1;
    label \"s\" = mod(floor(x/16),2)=1;
";

#[test]
fn property_texts_are_read_as_the_formulas_they_print() {
    let none = Constants::parse("").unwrap();
    let model = resolve(&parse_model(MODEL).into_result().unwrap(), &none).unwrap();
    let mut sentences = support::single_stage_sentences();
    for first in support::timings().into_iter().filter(Timing::completes) {
        let stages = vec![
            (first, support::name(2)),
            (Timing::Eventually, support::name(4)),
        ];
        sentences.push(support::sentence(
            requirement_lang::sentence::ScopeKind::In,
            support::CONDITIONS[1],
            stages,
        ));
    }
    let plain = Model {
        step_secs: None,
        proposition: &label_of_name,
    };
    for sentence in sentences {
        let property = property(&sentence, &plain).unwrap();
        let text = property.query();
        let file = parse_properties(&text).into_result().unwrap();
        let read = resolve_properties(&file, &model, &none).unwrap();
        let Property::Probability { path, .. } = &read[0].property else {
            panic!("{text} is no probability");
        };
        let names: Vec<&str> = property
            .propositions
            .iter()
            .map(|name| name.trim_matches('"'))
            .collect();
        assert_eq!(ltl(path, &names), property.ltl, "{text}");
    }
}

fn ltl(path: &Path, names: &[&str]) -> Ltl {
    let of = |path: &Path| ltl(path, names);
    match path {
        Path::State(state) => state_ltl(state, names),
        Path::Not(inner) => Ltl::negate(of(inner)),
        Path::And(left, right) => Ltl::and(of(left), of(right)),
        Path::Or(left, right) => Ltl::or(of(left), of(right)),
        Path::Implies(left, right) => Ltl::implies(of(left), of(right)),
        Path::Iff(left, right) => Ltl::iff(of(left), of(right)),
        Path::Next(inner) => Ltl::next(of(inner)),
        Path::Finally { operand, bound } => Ltl::finally(of(operand)).within(steps(bound)),
        Path::Globally { operand, bound } => Ltl::globally(of(operand)).within(steps(bound)),
        Path::Until { left, right, bound } => Ltl::until(of(left), of(right)).within(steps(bound)),
        Path::WeakUntil { left, right, bound } => {
            Ltl::weak_until(of(left), of(right)).within(steps(bound))
        }
        Path::Release { left, right, bound } => {
            Ltl::release(of(left), of(right)).within(steps(bound))
        }
        Path::Timed { .. } => panic!("no property has a bound in time"),
    }
}

fn state_ltl(state: &StateFormula, names: &[&str]) -> Ltl {
    let of = |state: &StateFormula| state_ltl(state, names);
    match state {
        StateFormula::Label(label) => Ltl::Ap(names.iter().position(|name| name == label).unwrap()),
        StateFormula::Not(inner) => Ltl::negate(of(inner)),
        StateFormula::And(left, right) => Ltl::and(of(left), of(right)),
        StateFormula::Or(left, right) => Ltl::or(of(left), of(right)),
        StateFormula::Implies(left, right) => Ltl::implies(of(left), of(right)),
        StateFormula::Iff(left, right) => Ltl::iff(of(left), of(right)),
        other => panic!("no property has {other:?}"),
    }
}

/// Whole bounds; the texts have no strict ones.
fn steps(bound: &TimeBound) -> StepBound {
    let whole = |end: Option<(i64, bool)>| {
        end.map(|(steps, strict)| {
            assert!(!strict);
            u64::try_from(steps).unwrap()
        })
    };
    StepBound {
        lower: whole(bound.lower).unwrap_or(0),
        upper: whole(bound.upper),
    }
}
