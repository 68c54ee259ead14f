//! What compositions, rewards, optima, filters and open constants mean once they are resolved.

use std::collections::BTreeSet;

use prism_lang::property::{
    FilterOperand, FilterOperator, Horizon, Objective, Optimum, Path, Property, Quantity,
    RewardObjective, StateFormula, TimedOperator,
};
use prism_lang::resolved::{Composition, Init, Model, ModelType, VariableKind};
use prism_lang::{
    Arithmetic, Constants, EvalErrorKind, Number, Rational, parse_model, parse_properties, resolve,
    resolve_open, resolve_properties,
};

fn model(text: &str) -> Model {
    let parsed = parse_model(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    resolve(&parsed.tree, &Constants::new()).unwrap_or_else(|d| panic!("{d:?}"))
}

/// The last property of a file, over a model of this type.
fn property(model_type: &str, text: &str) -> Property {
    let model = model(&format!(
        "{model_type} module m x : [0..3]; [a] x<3 -> (x'=x+1); endmodule label \"done\" = x=3; \
         rewards \"time\" true : 1; endrewards rewards \"cost\" [a] true : 2; endrewards"
    ));
    let parsed = parse_properties(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let resolved = resolve_properties(&parsed.tree, &model, &Constants::new());
    resolved
        .unwrap_or_else(|d| panic!("{text}: {d:?}"))
        .pop()
        .unwrap()
        .property
}

const THREE: &str = "mdp module a x : [0..1]; [go] x=0 -> (x'=1); [up] true -> true; endmodule \
    module b = a [x=y] endmodule module c = b [y=z, up=down] endmodule ";

#[test]
fn compositions_keep_their_operators_and_have_alphabets() {
    let text = format!("{THREE} system (a ||| b) |[go]| (c / {{down}} {{go<-stop}}) endsystem");
    let model = model(&text);
    assert_eq!(model.actions, ["go", "up", "down", "stop"]);
    let composition = model.composition.as_ref().unwrap();
    let Composition::On(left, actions, right) = composition else {
        panic!("{composition:?}")
    };
    assert_eq!(actions, &[0]);
    assert!(matches!(&**left, Composition::Interleaved(parts) if parts.len() == 2));
    let set = |actions: &[usize]| actions.iter().copied().collect::<BTreeSet<_>>();
    assert_eq!(left.alphabet(&model.modules), set(&[0, 1]));
    // `down` is hidden, `go` has become `stop`.
    assert_eq!(right.alphabet(&model.modules), set(&[3]));
    assert_eq!(composition.modules(), [0, 1, 2]);
}

#[test]
fn full_composition_of_all_modules_is_the_standard_one() {
    for system in [
        "",
        "system a || b || c endsystem",
        "system (a || b) || c endsystem",
        "system \"all\" c || \"rest\" endsystem system \"rest\" a || b endsystem",
    ] {
        assert_eq!(
            model(&format!("{THREE} {system}")).composition,
            None,
            "{system}"
        );
    }
    let other = model(&format!("{THREE} system a ||| b ||| c endsystem"));
    assert!(matches!(other.composition, Some(Composition::Interleaved(parts)) if parts.len() == 3));
}

#[test]
fn copies_of_copies_rename_twice() {
    let model = model(THREE);
    let names: Vec<&str> = model.variables.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["x", "y", "z"]);
    let last = &model.modules[2];
    assert_eq!(last.commands[1].action, Some(2));
    assert_eq!(last.commands[0].updates[0].assignments[0].0, 2);
    assert_eq!(last.commands[0].guard.eval_bool(&[1, 1, 0]), Ok(true));
    assert_eq!(last.commands[0].guard.eval_bool(&[0, 0, 1]), Ok(false));
}

#[test]
fn model_types_follow_from_the_text_as_in_prism() {
    let without = parse_model("module m x : int init -4; [] true -> (x'=x+1); endmodule");
    let lts = resolve(&without.tree, &Constants::new()).unwrap();
    assert_eq!(
        (lts.model_type, lts.warnings[0].code),
        (ModelType::Lts, "no-model-type")
    );
    assert_eq!(lts.variables[0].kind, VariableKind::Unbounded);
    assert_eq!(lts.init, Init::Single(vec![-4]));
    let with = parse_model("module m x : int; [] true -> 0.5:(x'=1) + 0.5:true; endmodule");
    let mdp = resolve(&with.tree, &Constants::new()).unwrap();
    assert_eq!(
        (mdp.model_type, mdp.init),
        (ModelType::Mdp, Init::Single(vec![0]))
    );
    assert_eq!(
        model("stochastic module m x : bool; endmodule").model_type,
        ModelType::Ctmc
    );
}

/// Rational functions of one parameter, at the point 1/3: enough to see that it reaches the domain.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
struct AtOneThird(Number);

impl Arithmetic for AtOneThird {
    const EXACT: bool = false;
    fn zero() -> Self {
        Self(Number::from_i64(0))
    }
    fn one() -> Self {
        Self(Number::from_i64(1))
    }
    fn from_i64(value: i64) -> Self {
        Self(Number::from_i64(value))
    }
    fn from_literal(number: &Number) -> Option<Self> {
        Some(Self(number.clone()))
    }
    fn parameter(index: usize) -> Option<Self> {
        let third = Number::from_rational(Rational::new(1.into(), 3.into()));
        (index == 0).then_some(Self(third))
    }
    fn to_f64(&self) -> f64 {
        self.0.to_f64()
    }
    fn add(&self, other: &Self) -> Self {
        Self(self.0.add(&other.0))
    }
    fn sub(&self, other: &Self) -> Self {
        Self(self.0.sub(&other.0))
    }
    fn mul(&self, other: &Self) -> Self {
        Self(self.0.mul(&other.0))
    }
    fn div(&self, other: &Self) -> Option<Self> {
        self.0.div(&other.0).map(Self)
    }
    fn pow(&self, exponent: &Self) -> Option<Self> {
        self.0.pow(&exponent.0).map(Self)
    }
    fn log(&self, base: &Self) -> Option<Self> {
        self.0.log(&base.0).map(Self)
    }
    fn floor(&self) -> Option<i64> {
        self.0.floor()
    }
    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }
    fn is_non_negative(&self) -> bool {
        self.0.is_non_negative()
    }
}

#[test]
fn open_constants_stay_in_expressions_and_out_of_states() {
    let text = "dtmc const double p; const double q = (1-p)/2; const int n = 3; \
        module m x : [0..n]; [] x=0 -> p:(x'=1) + q:(x'=2) + q:(x'=3); endmodule";
    let none = Constants::new();
    let tree = parse_model(text).tree;
    let model = resolve_open(&tree, &none, &none, &["p"]).unwrap();
    assert_eq!((model.parameters.len(), model.constants.len()), (1, 1));
    let probability = &model.modules[0].commands[0].updates[1].probability;
    let refused = probability.eval_number::<f64>(&[0]).unwrap_err();
    assert_eq!(refused.kind, EvalErrorKind::OpenParameter);
    let value = probability.eval_number::<AtOneThird>(&[0]).unwrap();
    assert_eq!(
        value.0,
        Number::from_rational(Rational::new(1.into(), 3.into()))
    );
    let codes = |open: &[&str]| match resolve_open(&tree, &none, &none, open) {
        Ok(_) => Vec::new(),
        Err(found) => found.iter().map(|d| d.code).collect::<Vec<_>>(),
    };
    // A range must not depend on it; a name must exist; what is not left open must have a value.
    assert_eq!(codes(&["p", "n"]), ["not-constant"]);
    assert_eq!(codes(&["p", "r"]), ["unknown-constant"]);
    assert_eq!(codes(&[]), ["undefined-constant"]);
    for text in [
        "[] x<n -> true;",
        "[] true -> (x'=n);",
        "endmodule label \"l\" = x=n; module k y : bool;",
    ] {
        let tree = parse_model(&format!(
            "dtmc const int n; module m x : [0..9]; {text} endmodule"
        ))
        .tree;
        let found = resolve_open(&tree, &none, &none, &["n"]).unwrap_err();
        assert_eq!(
            found.iter().map(|d| d.code).collect::<Vec<_>>(),
            ["not-constant"],
            "{text}"
        );
    }
}

#[test]
fn rewards_are_numbered_and_bounded_in_the_time_of_the_model() {
    let of = |model_type: &str, text: &str| match property(model_type, text) {
        Property::Number(Quantity::Reward { optimum, reward }) => (optimum, reward),
        other => panic!("{other:?}"),
    };
    let (optimum, reward) = of("mdp", "R{\"cost\"}max=? [ C<=3 ]");
    assert_eq!((optimum, reward.structure), (Some(Optimum::Max), 1));
    assert_eq!(
        reward.objective,
        RewardObjective::Cumulative(Horizon::Steps(3))
    );
    let (optimum, reward) = of("ctmc", "R=? [ I=1/2 ]");
    let half = Number::from_rational(Rational::new(1.into(), 2.into()));
    assert_eq!((optimum, reward.structure), (None, 0));
    assert_eq!(
        reward.objective,
        RewardObjective::Instantaneous(Horizon::Time(half))
    );
    let (_, reward) = of("dtmc", "R{2}/{1}=? [ F \"done\" ]");
    assert_eq!((reward.structure, reward.divisor), (1, Some(0)));
    let done = Box::new(StateFormula::Label("done".into()));
    assert_eq!(reward.objective, RewardObjective::Reach(done));
    let (_, reward) = of("dtmc", "R=? [ !(G (x<2 => !(X x=3))) ]");
    assert!(matches!(reward.objective, RewardObjective::CoSafe(_)));
}

#[test]
fn bounds_are_times_in_continuous_time_only() {
    let Property::Probability { path, .. } = property("ctmc", "P=? [ x=0 U[0.5,2] x=1 ]") else {
        panic!("a probability")
    };
    let Path::Timed {
        operator,
        left,
        interval,
        ..
    } = path
    else {
        panic!("{path:?}")
    };
    assert_eq!((operator, left.is_some()), (TimedOperator::Until, true));
    let ends = (
        interval.lower.unwrap().0.to_f64(),
        interval.upper.unwrap().0.to_f64(),
    );
    assert_eq!(ends, (0.5, 2.0));
    let steps = property("dtmc", "P=? [ F<=2 x=1 ]");
    assert!(matches!(
        steps,
        Property::Probability {
            path: Path::Finally { .. },
            ..
        }
    ));
}

#[test]
fn optima_and_strategies_say_over_which_schedulers() {
    let least = property("mdp", "Pmin=? [ F x=3 ]");
    let is_least = |p: &Property| {
        matches!(
            p,
            Property::Number(Quantity::Probability {
                optimum: Some(Optimum::Min),
                ..
            })
        )
    };
    assert!(is_least(&least) && is_least(&property("mdp", "[[*]] Pmin=? [ F x=3 ]")));
    // In a chain there is nothing to choose.
    let chain = property("dtmc", "Pmin=? [ F x=3 ]");
    assert!(matches!(chain, Property::Probability { bound: None, .. }));
    // PRISM: an empty coalition turns the quantifier round.
    for (players, by_some) in [
        ("<<*>>", true),
        ("<<>>", false),
        ("[[*]]", false),
        ("[[]]", true),
    ] {
        let found = property("mdp", &format!("{players} P>0.5 [ F x=3 ]"));
        let some = matches!(found, Property::State(StateFormula::SomeScheduler(_)));
        assert_eq!(some, by_some, "{players}");
    }
    let Property::Objectives(found) = property("mdp", "multi(Pmax=? [ F x=3 ], R<=5 [ C ])") else {
        panic!("objectives")
    };
    assert!(matches!(found[0], Objective::Optimise(Optimum::Max, _)));
    assert!(matches!(
        found[1],
        Objective::Require(StateFormula::Reward { .. })
    ));
}

#[test]
fn filters_have_the_kind_of_their_value() {
    let Property::Number(Quantity::Filter(filter)) =
        property("dtmc", "filter(+, P=? [ F x=3 ], x<2)")
    else {
        panic!("a number")
    };
    assert_eq!(filter.operator, FilterOperator::Sum);
    assert!(filter.states.is_some() && matches!(filter.operand, FilterOperand::Number(_)));
    let old = property("dtmc", "P=? [ F x=3 {x<2}{max} ]");
    assert!(
        matches!(old, Property::Number(Quantity::Filter(f)) if f.operator == FilterOperator::Max)
    );
    let both = property("dtmc", "P=? [ F x=3 {x<2}{min}{max} ]");
    assert!(matches!(both, Property::Range(_)));
    let bounded = property("dtmc", "P>0.1 [ F x=3 {x<2} ]");
    assert!(
        matches!(bounded, Property::State(StateFormula::Filter(f)) if f.operator == FilterOperator::ForAll)
    );
    let count = property("dtmc", "filter(count, x=1) = 2");
    assert!(matches!(count, Property::State(StateFormula::Compare(..))));
    let least = property("dtmc", "filter(argmin, x)");
    assert!(matches!(least, Property::State(StateFormula::Filter(_))));
}

#[test]
fn references_are_written_out_whatever_their_order_and_kind() {
    let sum = property(
        "dtmc",
        "\"b\": P=? [ F x=3 ]; \"c\": \"b\" + 2*\"d\"; \"d\": S=? [ x=1 ]; \"c\"/2",
    );
    let Property::Number(Quantity::Binary(_, left, _)) = sum else {
        panic!("{sum:?}")
    };
    assert!(
        matches!(*left, Quantity::Binary(_, a, _) if matches!(*a, Quantity::Probability { .. }))
    );
    // Each doubles the one before: they must not be written out without end.
    let mut text = "\"p0\": P>0.5 [ F x=3 ];".to_owned();
    for i in 0..64 {
        text += &format!("\"p{}\": \"p{i}\" & \"p{i}\";", i + 1);
    }
    let file = parse_properties(&text).tree;
    let model = model("dtmc module m x : [0..3]; endmodule");
    let found = resolve_properties(&file, &model, &Constants::new()).unwrap_err();
    assert!(found.iter().all(|d| d.code == "too-large"), "{found:?}");
}
