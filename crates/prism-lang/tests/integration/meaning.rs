//! What models and properties mean once they are resolved.

use num_bigint::BigInt;
use prism_lang::property::{Comparison, Path, Property, StateFormula, TimeBound};
use prism_lang::resolved::{Init, Model, VariableKind};
use prism_lang::{
    Constants, EvalErrorKind, Expr, ExprKind, Number, Rational, Value, parse_model,
    parse_properties, resolve, resolve_properties, resolve_with,
};

fn model(text: &str) -> Model {
    let parsed = parse_model(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    resolve(&parsed.tree, &Constants::new()).unwrap_or_else(|d| panic!("{d:?}"))
}

/// The expression `text` over `x : [-9..9]` and `b : bool`.
fn expression(text: &str) -> Expr {
    let body = format!("dtmc formula f = {text}; module m x : [-9..9]; b : bool; endmodule");
    model(&body).formulas.remove(0).1
}

fn rational(above: i64, below: i64) -> Rational {
    Rational::new(BigInt::from(above), BigInt::from(below))
}

#[test]
fn expressions_have_the_values_that_prism_gives_them() {
    for (text, x, value) in [
        ("x*2-1", 3, 5),
        ("-x", 3, -3),
        ("min(x, 4, 2)", 3, 2),
        ("max(x, 4, 2)", 3, 4),
        ("floor(x/2)", 3, 1),
        ("floor(x/2)", -3, -2),
        ("ceil(x/2)", 3, 2),
        ("ceil(x/2)", -3, -1),
        ("round(x/2)", 3, 2),
        ("round(x/2)", -3, -1),
        ("mod(x, 4)", -3, 1),
        ("pow(2, x)", 3, 8),
        ("x^2", -3, 9),
        ("x>0 ? 1 : x", -3, -3),
        ("ceil(log(x, 2))", 8, 3),
    ] {
        assert_eq!(
            expression(text).eval_int(&[x, 0]),
            Ok(value),
            "{text} at {x}"
        );
    }
    for (text, x, value) in [
        ("b => x=1", 1, true),
        ("b => x=1", 2, false),
        ("b <=> x=1", 2, false),
        ("x>1 & 1/(x-1)>0.4", 1, false),
        ("x=1 | 1/(x-1)>0.4", 1, true),
        ("x*0.1 = 0.3", 3, true),
        ("x/3 = 1", 3, true),
        ("b = (x>0)", 1, true),
    ] {
        assert_eq!(
            expression(text).eval_bool(&[x, 1]),
            Ok(value),
            "{text} at {x}"
        );
    }
}

#[test]
fn real_numbers_are_exact_or_rounded_as_asked() {
    let third = expression("(x+0.5)/3");
    assert_eq!(third.eval_number::<Rational>(&[1, 0]), Ok(rational(1, 2)));
    assert_eq!(third.eval_number::<f64>(&[1, 0]), Ok(0.5));
    let power = expression("0.5^x");
    assert_eq!(power.eval_number::<Rational>(&[3, 0]), Ok(rational(1, 8)));
    let root = expression("(x+0.0)^0.5");
    assert_eq!(root.eval_number::<f64>(&[4, 0]), Ok(2.0));
    assert_eq!(
        root.eval_number::<Rational>(&[4, 0]).unwrap_err().kind,
        EvalErrorKind::NotRational
    );
}

#[test]
fn what_has_no_value_is_an_error() {
    let failure = |text: &str, x| match expression(text) {
        e if e.ty == prism_lang::ast::Type::Int => {
            e.eval_int(&[x, 0]).map(|_| ()).unwrap_err().kind
        }
        e => {
            e.eval_number::<Number>(&[x, 0])
                .map(|_| ())
                .unwrap_err()
                .kind
        }
    };
    assert_eq!(failure("1/x", 0), EvalErrorKind::DivisionByZero);
    assert_eq!(failure("mod(1, x)", 0), EvalErrorKind::NonPositiveModulus);
    assert_eq!(failure("pow(2, x)", -1), EvalErrorKind::NegativeExponent);
    assert_eq!(failure("pow(10, 3*x)", 9), EvalErrorKind::Overflow);
    assert_eq!(failure("x*9223372036854775807", 9), EvalErrorKind::Overflow);
    assert_eq!(failure("log(x, 2)", -1), EvalErrorKind::NotReal);
}

#[test]
fn constants_are_computed_exactly_and_can_be_overridden() {
    let tree = parse_model("dtmc const double p = 0.95; const double q = 1-p; const int n = ceil(2*q); module m x : [0..n]; endmodule").tree;
    let value = |m: &Model, name: &str| match m.constant(name) {
        Some(Value::Double(number)) => number.exact().cloned(),
        _ => None,
    };
    let plain = resolve(&tree, &Constants::new()).unwrap();
    assert_eq!(value(&plain, "q"), Some(rational(1, 20)));
    assert_eq!(
        plain.variables[0].kind,
        VariableKind::Int { low: 0, high: 1 }
    );
    let overridden = resolve_with(
        &tree,
        &Constants::new(),
        &Constants::parse("p=1/3").unwrap(),
    )
    .unwrap();
    assert_eq!(value(&overridden, "q"), Some(rational(2, 3)));
    assert_eq!(
        overridden.variables[0].kind,
        VariableKind::Int { low: 0, high: 2 }
    );
}

#[test]
fn renamed_modules_rename_variables_actions_and_the_contents_of_formulas() {
    let model = model(
        "dtmc const int n = 2; formula full = x=n;
         module first x : [0..n] init 1; [up] !full -> (x'=x+1); [] full -> (x'=0); endmodule
         module second = first [x=y, up=rise] endmodule",
    );
    let names: Vec<_> = model
        .variables
        .iter()
        .map(|v| (v.name.as_str(), v.module.as_deref(), v.init))
        .collect();
    assert_eq!(names, [("x", Some("first"), 1), ("y", Some("second"), 1)]);
    assert_eq!(model.actions, ["up", "rise"]);
    let second = &model.modules[1];
    assert_eq!(second.commands[0].action, Some(1));
    assert_eq!(second.commands[0].updates[0].assignments[0].0, 1);
    assert_eq!(second.commands[1].guard.eval_bool(&[0, 2]), Ok(true));
    assert_eq!(second.commands[1].guard.eval_bool(&[2, 0]), Ok(false));
    assert_eq!(model.init, Init::Single(vec![1, 1]));
}

#[test]
fn globals_come_first_and_init_may_be_a_predicate() {
    let model = model(
        "dtmc global g : bool; module m x : [1..3]; [] true -> (g'=!g) & (x'=1); endmodule init x>1 endinit",
    );
    assert_eq!(
        (
            model.variables[0].name.as_str(),
            model.variables[0].module.as_ref()
        ),
        ("g", None)
    );
    let Init::Predicate(predicate) = &model.init else {
        panic!("a predicate")
    };
    assert_eq!(predicate.eval_bool(&[0, 2]), Ok(true));
}

fn property(text: &str) -> Property {
    let model = model(
        "dtmc const int n = 2; formula low = x<n; module m x : [0..3]; endmodule label \"done\" = x=3;",
    );
    let parsed = parse_properties(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let mut resolved = resolve_properties(&parsed.tree, &model, &Constants::new()).unwrap();
    resolved.pop().unwrap().property
}

fn path(text: &str) -> Path {
    match property(&format!("P=? [ {text} ]")) {
        Property::Probability { bound: None, path } => path,
        other => panic!("{other:?}"),
    }
}

#[test]
fn step_bounds_are_kept_as_written() {
    let bound = |text: &str| match path(&format!("F{text} \"done\"")) {
        Path::Finally { bound, .. } => (bound, bound.first_step(), bound.last_step()),
        other => panic!("{other:?}"),
    };
    let of = |lower, upper| TimeBound { lower, upper };
    assert_eq!(bound(""), (of(None, None), 0, None));
    assert_eq!(bound("<=n+1"), (of(None, Some((3, false))), 0, Some(3)));
    assert_eq!(bound("<3"), (of(None, Some((3, true))), 0, Some(2)));
    assert_eq!(bound(">=2"), (of(Some((2, false)), None), 2, None));
    assert_eq!(bound(">2"), (of(Some((2, true)), None), 3, None));
    assert_eq!(
        bound("=4"),
        (of(Some((4, false)), Some((4, false))), 4, Some(4))
    );
    assert_eq!(
        bound("[2,7]"),
        (of(Some((2, false)), Some((7, false))), 2, Some(7))
    );
}

#[test]
fn state_and_path_formulas_are_told_apart() {
    let Path::And(left, right) = path("(low & \"done\") & (G F !low)") else {
        panic!("a conjunction of paths")
    };
    assert!(matches!(*left, Path::State(state) if matches!(*state, StateFormula::And(..))));
    assert!(
        matches!(*right, Path::Globally { operand, .. } if matches!(*operand, Path::Finally { .. }))
    );
    let nested = property("P>=0.25 [ X P<1/3 [ \"done\" W x=1 ] ] & !\"init\"");
    let Property::State(StateFormula::And(p, _)) = nested else {
        panic!("a state formula")
    };
    let StateFormula::Probability {
        bound: (comparison, bound),
        ..
    } = *p
    else {
        panic!("a bounded probability")
    };
    assert_eq!(
        (comparison, bound.exact().cloned()),
        (Comparison::GreaterEqual, Some(rational(1, 4)))
    );
}

#[test]
fn labels_and_properties_of_the_file_are_written_out() {
    let file = "label \"far\" = x>=n; const int k = 2; \"safe\": P>=1 [ G x<=k ]; \"both\": \"safe\" & \"far\" & \"done\"";
    let Property::State(StateFormula::And(left, done)) = property(file) else {
        panic!("a conjunction")
    };
    assert_eq!(*done, StateFormula::Label("done".into()));
    let StateFormula::And(safe, far) = *left else {
        panic!("a conjunction")
    };
    assert!(matches!(*safe, StateFormula::Probability { .. }));
    assert!(matches!(*far, StateFormula::Expr(e) if matches!(e.kind, ExprKind::Binary(..))));
}
