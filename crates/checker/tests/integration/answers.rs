//! What an answer says: on small models whose values are known in closed form.

use checker::explore::explore;
use checker::{Answer, AnswerValue, CheckError, Guarantee, Method, Options, check};
use prism_lang::resolved::Model;
use prism_lang::{
    Constants, Property, Rational, parse_model, parse_properties, resolve, resolve_properties,
};

fn model(text: &str) -> Model {
    let parsed = parse_model(text);
    assert_eq!(parsed.diagnostics, []);
    resolve(&parsed.tree, &Constants::new()).unwrap()
}

fn property(text: &str, model: &Model) -> Property {
    let parsed = parse_properties(text);
    assert_eq!(parsed.diagnostics, []);
    let properties = resolve_properties(&parsed.tree, model, &Constants::new()).unwrap();
    properties.into_iter().next().unwrap().property
}

fn answer(model: &Model, text: &str, options: &Options<'_>) -> Result<Answer, CheckError> {
    let space = explore::<f64>(model).unwrap();
    check(&space, model, &property(text, model), options)
}

fn exact(model: &Model, text: &str) -> AnswerValue {
    answer(model, text, &Options::with_method(Method::Exact))
        .unwrap()
        .value
}

fn ratio(above: i64, below: i64) -> AnswerValue {
    AnswerValue::Exact(Rational::new(above.into(), below.into()))
}

/// Knuth and Yao's die from a fair coin.
const DIE: &str = "dtmc
module die
  s : [0..7] init 0;
  d : [0..6] init 0;
  [] s=0 -> 0.5:(s'=1) + 0.5:(s'=2);
  [] s=1 -> 0.5:(s'=3) + 0.5:(s'=4);
  [] s=2 -> 0.5:(s'=5) + 0.5:(s'=6);
  [] s=3 -> 0.5:(s'=1) + 0.5:(s'=7)&(d'=1);
  [] s=4 -> 0.5:(s'=7)&(d'=2) + 0.5:(s'=7)&(d'=3);
  [] s=5 -> 0.5:(s'=7)&(d'=4) + 0.5:(s'=7)&(d'=5);
  [] s=6 -> 0.5:(s'=2) + 0.5:(s'=7)&(d'=6);
  [] s=7 -> true;
endmodule
label \"done\" = s=7;";

#[test]
fn the_die_is_fair_by_every_method() {
    let die = model(DIE);
    assert_eq!(exact(&die, "P=? [ F s=7 & d=3 ]"), ratio(1, 6));
    let sound = answer(&die, "P=? [ F s=7 & d=3 ]", &Options::default()).unwrap();
    let Guarantee::Bounded { low, high } = sound.guarantee else {
        panic!("{sound:?}");
    };
    assert!(low < 1.0 / 6.0 && 1.0 / 6.0 < high && high - low < 1e-14);
    let options = Options::with_method(Method::PrismDefault);
    let prism = answer(&die, "P=? [ F s=7 & d=3 ]", &options).unwrap();
    let AnswerValue::Number(value) = prism.value else {
        panic!("{prism:?}");
    };
    // Stopped early, from below.
    assert!(value < 1.0 / 6.0 && value > 1.0 / 6.0 - 1e-6 && prism.iterations > 5);
    assert!(matches!(prism.guarantee, Guarantee::Estimated { .. }));
}

#[test]
fn windows_and_nesting_have_the_values_worked_out_by_hand() {
    let die = model(DIE);
    // Done after three throws of the coin unless both of the first round's detours are taken: 1 - 1/4.
    assert_eq!(exact(&die, "P=? [ F<=3 \"done\" ]"), ratio(3, 4));
    assert_eq!(exact(&die, "P=? [ F<4 \"done\" ]"), ratio(3, 4));
    // Each detour costs two throws more and is taken with 1/4.
    assert_eq!(exact(&die, "P=? [ F[4,5] \"done\" ]"), ratio(15, 16));
    assert_eq!(
        exact(&die, "P=? [ !\"done\" U[4,5] \"done\" ]"),
        ratio(3, 16)
    );
    assert_eq!(exact(&die, "P=? [ G<=3 !\"done\" ]"), ratio(1, 4));
    assert_eq!(exact(&die, "P=? [ X s=1 ]"), ratio(1, 2));
    assert_eq!(exact(&die, "P=? [ F G d=6 ]"), ratio(1, 6));
    assert_eq!(exact(&die, "P=? [ X (X (X d=2)) ]"), ratio(1, 8));
    assert_eq!(exact(&die, "P=? [ (F d=1) | (F d=2) ]"), ratio(1, 3));
    assert_eq!(exact(&die, "P=? [ s<7 W d=1 ]"), ratio(1, 6));
    // From s=1 the numbers 1 to 3 follow, from s=2 the others.
    assert_eq!(exact(&die, "P=? [ X P>=1 [ F d<=3 & d>0 ] ]"), ratio(1, 2));
}

#[test]
fn bounds_that_floating_point_leaves_open_are_decided_exactly() {
    let die = model(DIE);
    for (text, holds) in [
        ("P>=1/6 [ F d=3 ]", true),
        ("P>1/6 [ F d=3 ]", false),
        ("P>=0.1666 [ F d=3 ]", true),
    ] {
        let decided = answer(&die, text, &Options::default()).unwrap();
        assert_eq!(decided.value, AnswerValue::Truth(holds), "{text}");
        assert_eq!(decided.guarantee, Guarantee::Exact);
        let open = text.contains("1/6");
        assert_eq!(decided.method == Method::Exact, open, "{text}");
        assert_eq!(decided.notes.len(), usize::from(open));
    }
    let options = Options {
        exact_limit: 3,
        ..Options::default()
    };
    let undecided = answer(&die, "P>=1/6 [ F d=3 ]", &options).unwrap_err();
    assert!(matches!(undecided, CheckError::Undecided { .. }));
    assert!(
        undecided.to_string().contains("use the exact method"),
        "{undecided}"
    );
}

/// Found by `conformance/peers/random_models.py`: the infinite values were left out.
#[test]
fn a_range_has_its_infinite_values_in_exact_arithmetic_too() {
    let walk = model(
        "dtmc module w x : [0..4]; [] x=1 -> 1/3:(x'=1) + 2/3:(x'=2); [] x=3 -> 1/2:(x'=3) + 1/2:(x'=4); endmodule
         rewards true : 1; endrewards
         init x>0 & x<4 endinit",
    );
    let ends = AnswerValue::Ends {
        low: Box::new(AnswerValue::Exact(Rational::from_integer(2.into()))),
        high: Box::new(AnswerValue::Number(f64::INFINITY)),
    };
    assert_eq!(exact(&walk, "R=? [ F x=4 ]"), ends);
    let filter = "filter(range, R=? [ F x=4 ], x>=1 & x<=3)";
    assert_eq!(exact(&walk, filter), ends);
    let AnswerValue::Range { low, high } =
        answer(&walk, filter, &Options::default()).unwrap().value
    else {
        panic!("no range");
    };
    assert!(
        (low - 2.0).abs() < 1e-5 && high == f64::INFINITY,
        "{low} {high}"
    );
    // Where no value is finite, and where a value does not exist.
    let (low, high) = (f64::INFINITY, f64::INFINITY);
    let stuck = "filter(range, R=? [ F x=4 ], x<=2)";
    assert_eq!(exact(&walk, stuck), AnswerValue::Range { low, high });
    let AnswerValue::Range { low, high } = exact(&walk, "P=? [ F x=4 || F x=2 ]") else {
        panic!("a range without the undefined value");
    };
    assert!(low.is_nan() && high.is_nan(), "{low} {high}");
}

#[test]
fn several_initial_states_give_a_range() {
    let walk = model(
        "dtmc module w x : [0..4]; [] x>0&x<4 -> 1/2:(x'=x-1) + 1/2:(x'=x+1); endmodule
         init x>0 & x<4 endinit",
    );
    let low = Rational::new(1.into(), 4.into());
    let high = Rational::new(3.into(), 4.into());
    assert_eq!(
        exact(&walk, "P=? [ F x=4 ]"),
        AnswerValue::ExactRange { low, high }
    );
    let sound = answer(&walk, "P=? [ F x=4 ]", &Options::default()).unwrap();
    assert_eq!(sound.initial.len(), 3);
    assert_eq!(sound.complement, None);
    let Guarantee::Bounded { low, high } = sound.guarantee else {
        panic!("{sound:?}");
    };
    assert!(low <= 0.25 && high >= 0.75 && low > 0.24 && high < 0.76);
    // Holds only if it holds in all of them.
    let all = answer(&walk, "P>0.3 [ F x=4 ]", &Options::default()).unwrap();
    assert_eq!(all.value, AnswerValue::Truth(false));
    assert_eq!(
        all.initial
            .iter()
            .filter(|i| i.value == AnswerValue::Truth(true))
            .count(),
        2
    );
}

#[test]
fn a_check_can_be_cancelled_and_options_are_checked() {
    let die = model(DIE);
    let options = Options {
        cancel: Some(&|| true),
        ..Options::default()
    };
    assert_eq!(
        answer(&die, "P=? [ F d=1 ]", &options),
        Err(CheckError::Cancelled)
    );
    for precision in [0.0, -1.0, 2.0, f64::NAN] {
        let options = Options {
            precision,
            ..Options::default()
        };
        let error = answer(&die, "P=? [ F d=1 ]", &options).unwrap_err();
        assert!(
            error.to_string().contains("must lie between 0 and 1"),
            "{error}"
        );
    }
}

#[test]
fn an_iteration_that_does_not_converge_is_an_error() {
    let die = model(DIE);
    let options = Options {
        max_iters: 2,
        ..Options::with_method(Method::PrismDefault)
    };
    let error = answer(&die, "P=? [ F d=1 ]", &options).unwrap_err();
    assert!(error.to_string().contains("after 2 rounds"), "{error}");
}

/// The bounds of a probability, exact or not.
fn bounds(model: &Model, text: &str) -> (f64, f64) {
    let found = answer(model, text, &Options::default()).unwrap();
    match (&found.guarantee, &found.value) {
        (Guarantee::Bounded { low, high }, _) => (*low, *high),
        (Guarantee::Exact, AnswerValue::Number(value)) => (*value, *value),
        _ => panic!("{text}: {found:?}"),
    }
}

#[test]
fn several_windows_of_time_have_their_joint_probability() {
    // Two that end on their own, with rates 2 and 3, and a switch: on with rate 2, off with rate 3.
    let text = "ctmc
        module a x : [0..1]; [] x=0 -> 2:(x'=1); endmodule
        module b y : [0..1]; [] y=0 -> 3:(y'=1); endmodule
        label \"a\" = x=1; label \"b\" = y=1;";
    let ends = model(text);
    let switch = model(
        "ctmc module s on : [0..1]; [] on=0 -> 2:(on'=1); [] on=1 -> 3:(on'=0); endmodule
        label \"on\" = on=1;",
    );
    let e = |x: f64| (-x).exp();
    let on_after = |time: f64| 0.4 * (1.0 - e(5.0 * time));
    let off_after_on = |time: f64| 0.6 * (1.0 - e(5.0 * time));
    let cases = [
        (
            &ends,
            "(F<=1 \"a\") & (F<=2 \"b\")",
            (1.0 - e(2.0)) * (1.0 - e(6.0)),
        ),
        (&ends, "(F<=1 \"a\") & (F<=1 \"a\")", 1.0 - e(2.0)),
        (
            &ends,
            "(G<=1 !\"a\") & (F[1,2] \"a\")",
            e(2.0) * (1.0 - e(2.0)),
        ),
        (&ends, "(G<=1 !\"a\") & (F<=1 \"a\")", 0.0),
        (&ends, "(G<=1 !\"a\") | (F<=1 \"a\")", 1.0),
        (
            &ends,
            "(!\"a\" U[0.5,1.5] \"a\") & (!\"b\" U[1,2] \"b\")",
            (e(1.0) - e(3.0)) * (e(3.0) - e(6.0)),
        ),
        // An end of its own for the one and none for the other, which is after it.
        (
            &ends,
            "(F<=1 \"a\") & (!\"b\" U>=1 \"b\")",
            (1.0 - e(2.0)) * e(3.0),
        ),
        // Which comes first, and when: the automaton reads jumps.
        (
            &ends,
            "(F<=1 \"a\") & (!\"b\" U \"a\")",
            0.4 * (1.0 - e(5.0)),
        ),
        (&ends, "(F<=1 \"a\") & (X \"a\")", 0.4 * (1.0 - e(5.0))),
        (
            &ends,
            "!((F<=1 \"a\") & (X \"a\")) & (F G \"b\")",
            1.0 - 0.4 * (1.0 - e(5.0)),
        ),
        (&ends, "(G F \"b\") => (\"b\" W<=1 \"a\")", 0.0),
        (
            &ends,
            "(F<=1 \"a\") <=> (F<=1 \"b\")",
            (1.0 - e(2.0)) * (1.0 - e(3.0)) + e(5.0),
        ),
        (
            &switch,
            "(G[1,2] \"on\") & (G[3,4] !\"on\")",
            on_after(1.0) * e(3.0) * off_after_on(1.0) * e(2.0),
        ),
        // At four times, each after the other.
        (
            &switch,
            "(F[1,1] \"on\") & (F[2,2] !\"on\") & (F[4,4] \"on\") & (G F \"on\")",
            on_after(1.0) * off_after_on(1.0) * on_after(2.0),
        ),
    ];
    for (model, path, expected) in cases {
        let (low, high) = bounds(model, &format!("P=? [ {path} ]"));
        let slack = 1e-14 * expected;
        assert!(
            low - slack <= expected && expected <= high + slack && high - low <= 1e-6 * expected,
            "{path}: {expected} not in [{low}, {high}]"
        );
    }
    // Of all the ways in which three formulas can hold or not, one comes true; what they share with one of them is its own.
    let from_on = model(
        "ctmc module s on : [0..1] init 1; [] on=0 -> 2:(on'=1); [] on=1 -> 3:(on'=0); endmodule
        label \"on\" = on=1;",
    );
    let parts = [
        "\"on\" U[0.3,0.9] !\"on\"",
        "G[0.4,1.1] \"on\"",
        "F (\"on\" & (X X !\"on\"))",
        "!\"on\" R<=0.5 \"on\"",
    ];
    let of = |mask: usize| {
        let part = |at: usize| ["!", ""][mask >> at & 1].to_owned() + "(" + parts[at] + ")";
        let path = (0..4).map(part).collect::<Vec<_>>().join(" & ");
        bounds(&from_on, &format!("P=? [ {path} ]"))
    };
    let all: Vec<(f64, f64)> = (0..16).map(of).collect();
    for (at, part) in parts.iter().enumerate() {
        let with = (0..16).filter(|mask| mask >> at & 1 == 1);
        let (low, high) = with.fold((0.0, 0.0), |(low, high), mask| {
            (low + all[mask].0, high + all[mask].1)
        });
        let alone = bounds(&from_on, &format!("P=? [ {part} ]"));
        let near = |a: f64, b: f64| a <= b * (1.0 + 1e-14);
        assert!(
            near(low, alone.1) && near(alone.0, high),
            "{part}: {low} {high} {alone:?}"
        );
        assert!(high - low < 1e-6, "{part}: {low} {high}");
    }
    let sum: (f64, f64) = (all.iter()).fold((0.0, 0.0), |sum, b| (sum.0 + b.0, sum.1 + b.1));
    assert!(
        sum.0 <= 1.0 + 1e-14 && sum.1 >= 1.0 - 1e-14 && sum.1 - sum.0 < 1e-6,
        "{sum:?}"
    );
    let asked = "P=? [ (F<=1 \"a\") || (F<=2 \"a\") & (X \"b\") ]";
    let (low, high) = bounds(&ends, asked);
    // b first, then a: within 1 for within 2.
    let both = |time: f64| 1.0 - e(2.0 * time) - 0.4 * (1.0 - e(5.0 * time));
    let expected = both(1.0) / both(2.0);
    assert!(
        low <= expected && expected <= high && high - low < 1e-5,
        "{low} {expected} {high}"
    );
    let refused = answer(&switch, "P=? [ G F<=1 \"on\" ]", &Options::default());
    let Err(CheckError::Unsupported(message)) = refused else {
        panic!("{refused:?}");
    };
    assert!(
        message.contains("write `P` around the inner one"),
        "{message}"
    );
}

#[test]
fn what_is_certainly_one_is_told_as_one() {
    let queue = model(
        "ctmc module q n : [0..3]; b : [0..1]; [] n<3 -> 1.7:(n'=n+1); [] n>0 -> 3.3:(n'=n-1);
        [] b=0 -> 0.3:(b'=1); endmodule",
    );
    for text in [
        "S=? [ n<=3 ]",
        "P=? [ F>=5 n=3 ]",
        "P=? [ F[1,2] n<=3 ]",
        "P=? [ (F>=5 n=3) & (F[1,2] n<=3) ]",
        "filter(avg, P=? [ F n=3 ])",
        "1 - S=? [ b>1 ]",
    ] {
        assert_eq!(bounds(&queue, text), (1.0, 1.0), "{text}");
    }
}

#[test]
fn rewards_beyond_the_range_of_floating_point_are_left_to_exact_arithmetic() {
    let steps = model(
        "dtmc module m x : [0..3]; [] x<3 -> 0.5:(x'=x+1) + 0.5:true; [] x=3 -> true; endmodule
        rewards \"tiny\" x<3 : 1e-310; endrewards rewards \"huge\" x<3 : 1e308; endrewards",
    );
    for (text, expected) in [
        ("R{\"tiny\"}=? [ C<=2 ]", "2e-310"),
        ("R{\"tiny\"}=? [ F x=3 ]", "6e-310"),
        ("R{\"huge\"}=? [ C<=2 ]", "2e308"),
        ("R{\"huge\"}=? [ F x=3 ]", "6e308"),
    ] {
        let found = answer(&steps, text, &Options::default());
        assert!(
            matches!(&found, Err(CheckError::Unsupported(why)) if why.contains("exact method")),
            "{text}: {found:?}"
        );
        let expected = prism_lang::Number::parse(expected).unwrap();
        let expected = AnswerValue::Exact(expected.exact().unwrap().clone());
        assert_eq!(exact(&steps, text), expected, "{text}");
    }
}
