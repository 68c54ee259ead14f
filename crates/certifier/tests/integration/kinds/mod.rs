//! Questions of every kind: what is known is certified, and a bound that is a little wrong is refused.
//!
//! The oracle here is value iteration in floating point, whose bounds can be spoilt; what needs no oracle is compared
//! with what was worked out by hand.

mod exact;
mod objectives;
mod oracle;
mod timed;

use certifier::{Certified, Failure};
use oracle::{Iteration, certified, holds};

/// Up with 1/4, down with 3/4, between two ends that are never left.
const WALK: &str = "dtmc module walk s : [0..3] init 1;
    [] s=1 | s=2 -> 1/4:(s'=s+1) + 3/4:(s'=s-1); [] s=0 | s=3 -> true; endmodule
    label \"low\" = s=0; label \"top\" = s=3; rewards s=1 | s=2 : 1; endrewards";

/// From 0 to one of two machines that run for ever; the first is up 1/3, the second 3/4 of the time.
const MACHINES: &str = "dtmc module m s : [0..4];
    [] s=0 -> 1/5:(s'=1) + 4/5:(s'=3);
    [] s=1 -> 1/2:(s'=2) + 1/2:(s'=1); [] s=2 -> (s'=1);
    [] s=3 -> 1/4:(s'=4) + 3/4:(s'=3); [] s=4 -> 3/4:(s'=3) + 1/4:(s'=4); endmodule
    label \"rest\" = s=2 | s=4; label \"first\" = s=1 | s=2;
    rewards s=2 : 3; s=4 : 8; endrewards";

#[test]
fn steps_and_rewards_within_them_are_computed_anew() {
    holds(WALK, "P=? [ X s=2 ]", 0.25);
    holds(WALK, "P=? [ F<=3 s=0 ]", 0.75 + 0.25 * 0.75 * 0.75);
    holds(WALK, "P=? [ s>0 U[2,2] s=3 ]", 0.0625);
    // What is left keeps its digits.
    let rare = "dtmc module m s : [0..2]; [] s=0 -> 1e-30:(s'=2) + 1-1e-30:(s'=1); [] s>0 -> true; endmodule";
    holds(rare, "P=? [ G s!=1 ]", 1e-30);
    holds(rare, "P=? [ G<=3 s!=1 ]", 1e-30);
    holds(rare, "P=? [ G[1,3] s!=1 ]", 1e-30);
    holds(WALK, "P=? [ G<=1 s>0 ]", 0.25);
    holds(WALK, "P=? [ s<2 W<=1 s=2 ]", 1.0);
    holds(WALK, "P=? [ F>=2 s=3 ]", 1.0 / 13.0);
    holds(WALK, "R=? [ C<=2 ]", 1.25);
    holds(WALK, "R=? [ I=1 ]", 0.25);
    holds(WALK, "R=? [ C ]", 20.0 / 13.0);
    holds(WALK, "R=? [ F (\"low\" | \"top\") ]", 20.0 / 13.0);
}

#[test]
fn nested_operators_and_filters_follow_from_the_bounds_within() {
    // Only from 2 and 3 is the top within a step likely enough.
    holds(WALK, "P=? [ F (P>=0.25 [ X s=3 ]) ]", 0.25);
    holds(WALK, "filter(max, P=? [ F s=3 ], s<3)", 4.0 / 13.0);
    holds(WALK, "filter(sum, P=? [ F s=3 ], s=1|s=2)", 5.0 / 13.0);
    holds(WALK, "P=? [ F s=3 ] * 13 + 1", 2.0);
    let mut oracle = Iteration::new(0.0, 0.0);
    let found = certified(WALK, "P>0.07 [ F s=3 ] & !P>0.08 [ F s=3 ]", &mut oracle).unwrap();
    assert_eq!(found.truth, Some(true));
    let found = certified(WALK, "P<0.07 [ F s=3 ]", &mut oracle).unwrap();
    assert_eq!(found.truth, Some(false));
    // The bounds are not narrow enough to tell.
    let asked = "filter(forall, P>=0.07692307692307 [ F s=3 ], s=1)";
    let found = certified(WALK, asked, &mut oracle);
    assert!(matches!(found, Err(Failure::Unsupported(_))), "{found:?}");
}

#[test]
fn formulas_are_judged_on_end_components() {
    holds(MACHINES, "P=? [ G F s=2 ]", 0.2);
    holds(MACHINES, "P=? [ F G !s=2 ]", 0.8);
    holds(MACHINES, "P=? [ (G F s=4) | (F G s=1) ]", 0.8);
    holds(MACHINES, "P=? [ G (s=2 => (X s=1)) ]", 1.0);
    holds(MACHINES, "P=? [ G (\"rest\" => (F<=1 s=3)) ]", 0.0);
    holds(MACHINES, "P=? [ F (s=1 & (X (s=1 & (X s=1)))) ]", 0.2);
    holds(MACHINES, "P=? [ G F s=2 || F<=1 \"first\" ]", 1.0);
    holds(MACHINES, "P=? [ X (X s=2) || F<=1 \"first\" ]", 0.5);
    holds(WALK, "R=? [ F (s=1 & (X s=0)) ]", f64::INFINITY);
    holds(WALK, "R=? [ F (s=1 & (X s!=1)) ]", 1.0);
    holds(
        "dtmc module m s : [0..1]; [] true -> (s'=1-s); endmodule rewards true : 1; endrewards",
        "R=? [ F (s=0 & (X true)) ]",
        1.0,
    );
    let mdp = "mdp module m s : [0..3];
        [a] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [b] s=0 -> (s'=2);
        [a] s=1 -> (s'=3); [b] s=1 -> (s'=1); [] s=3 -> (s'=1); [] s=2 -> true; endmodule
        rewards s=1 : 1; s=3 : 2; [b] s=0 : 5; endrewards";
    holds(mdp, "Pmax=? [ (G F s=1) & (G F s=3) ]", 0.5);
    holds(mdp, "Pmin=? [ F G s=2 ]", 0.5);
    holds(mdp, "Pmax=? [ F<=2 s=3 ]", 0.5);
    holds(mdp, "Rmax=? [ S ]", 0.75);
    holds(mdp, "Rmin=? [ S ]", 0.0);
    holds(mdp, "Rmin=? [ C ]", 5.0);
    holds(mdp, "Rmax=? [ C ]", f64::INFINITY);
}

#[test]
fn averages_have_a_gain_and_a_bias() {
    // Of the first machine 1/3 of the time in 2, of the second 1/4 in 4.
    holds(MACHINES, "S=? [ s=2 ]", 0.2 / 3.0);
    holds(MACHINES, "S=? [ \"rest\" ]", 0.2 / 3.0 + 0.8 / 4.0);
    holds(MACHINES, "R=? [ S ]", 0.2 + 0.8 * 2.0);
    let ctmc = "ctmc module m s : [0..1]; [] s=0 -> 2:(s'=1); [] s=1 -> 3:(s'=0); endmodule
        rewards s=1 : 5; endrewards";
    holds(ctmc, "S=? [ s=1 ]", 0.4);
    holds(ctmc, "R=? [ S ]", 2.0);
}

/// What is shown of the least and the greatest value, each to within 1e-6, and refused where it is spoilt.
fn range(text: &str, asked: &str, [least, greatest]: [f64; 2]) {
    let found = certified(text, asked, &mut Iteration::new(0.0, 0.0)).unwrap();
    for (shown, expected) in found.ends.iter().zip([least, greatest]) {
        let wide = 1e-6 * expected.max(1e-3);
        let is_inside = shown.low <= expected + 1e-15 && expected - 1e-15 <= shown.high;
        assert!(
            is_inside && shown.high - shown.low <= wide,
            "{asked}: {found:?}"
        );
    }
    let spoilt = certified(text, asked, &mut Iteration::new(1e-3, -1e-2));
    let is_refused = matches!(spoilt, Err(Failure::Broken { .. }));
    let still_holds = |found: Certified| found.low <= least && greatest <= found.high;
    assert!(is_refused || spoilt.is_ok_and(still_holds), "{asked}");
}

fn truth(text: &str, asked: &str) -> Option<bool> {
    certified(text, asked, &mut Iteration::new(0.0, 0.0))
        .unwrap_or_else(|e| panic!("{asked}: {e}"))
        .truth
}

#[test]
fn models_start_in_all_states_that_they_say() {
    let walk = WALK.replace("init 1", "") + " init s>0 & s<3 endinit";
    range(&walk, "P=? [ F s=3 ]", [1.0 / 13.0, 4.0 / 13.0]);
    range(
        &walk,
        "R=? [ F (\"low\" | \"top\") ]",
        [20.0 / 13.0, 28.0 / 13.0],
    );
    range(
        &walk,
        "filter(range, P=? [ F s=3 ], s<3)",
        [0.0, 4.0 / 13.0],
    );
    assert_eq!(truth(&walk, "P>0.07 [ F s=3 ]"), Some(true));
    assert_eq!(truth(&walk, "P>0.08 [ F s=3 ]"), Some(false));
    let nowhere = WALK.replace("init 1", "") + " init s>3 endinit";
    let found = certified(&nowhere, "P=? [ F s=3 ]", &mut Iteration::new(0.0, 0.0));
    assert_eq!(found, Err(Failure::NoInitialState));
}

#[test]
fn modules_are_composed_as_system_says() {
    let modules = "dtmc module a x : [0..1]; [go] x=0 -> 1/4:(x'=1) + 3/4:true; endmodule
        module b y : [0..1]; [go] y=0 -> 1/2:(y'=1) + 1/2:true; endmodule
        rewards [go] true : 4; [] true : 2; [other] true : 1; endrewards
        module c z : [0..0]; [other] z>0 -> true; endmodule";
    // Together, or one of them; the probability that both are up after two steps, and what the first earns.
    for (system, both, earned) in [
        ("a || b", 1.0 / 8.0 + 3.0 / 64.0, 4.0),
        ("a ||| b", 1.0 / 8.0, 4.0),
        ("a |[go]| b", 1.0 / 8.0 + 3.0 / 64.0, 4.0),
        ("(a / {go}) || b", 1.0 / 8.0, 3.0),
        ("(a || b) / {go}", 1.0 / 8.0 + 3.0 / 64.0, 2.0),
        (
            "(a {go <- other}) |[other]| (b {go <- other})",
            1.0 / 8.0 + 3.0 / 64.0,
            1.0,
        ),
        ("(a {go <- other}) || b", 1.0 / 8.0, 2.5),
    ] {
        let text = format!("{modules} system ({system}) ||| c endsystem");
        holds(&text, "P=? [ F<=2 x=1 & y=1 ]", both);
        holds(&text, "R=? [ C<=1 ]", earned);
    }
}

#[test]
fn paths_are_quantified_by_fixpoints() {
    let mdp = "mdp module m s : [0..3];
        [a] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [b] s=0 -> (s'=0); [] s=1 -> (s'=0); [] s=2 -> (s'=3); [] s=3 -> true;
        endmodule";
    for (asked, expected) in [
        ("E [ F s=3 ]", true),
        // Between 0 and 1 for ever, though that has probability 0.
        ("A [ F s=3 ]", false),
        ("A [ s<3 W s=3 ]", true),
        ("E [ G s<2 ]", true),
        ("A [ G s<3 ]", false),
        ("E [ s=0 U s=3 ]", false),
        ("E [ s!=1 U<=3 s=3 ]", true),
        ("E [ F<=1 s=3 ]", false),
        ("E [ G[2,4] s=1 ]", false),
        ("A [ X s<3 ]", true),
        ("E [ X s=3 ]", false),
        ("E [ (G F s=0) & (G F s=1) ]", true),
        ("A [ (F G s=3) | (G F s=0) ]", true),
        ("E [ (G F s=0) & (F s=3) ]", false),
        ("A [ s=0 R s<3 ]", true),
        ("A [ G (E [ F s=0 ]) ]", false),
    ] {
        assert_eq!(truth(mdp, asked), Some(expected), "{asked}");
        let lts = mdp
            .replace("mdp", "lts")
            .replace("1/2:(s'=1) + 1/2:(s'=2)", "(s'=1)");
        let lts = lts.replace(
            "[b] s=0 -> (s'=0);",
            "[b] s=0 -> (s'=0); [a] s=0 -> (s'=2);",
        );
        assert_eq!(
            truth(&lts, asked),
            Some(expected),
            "{asked} without probabilities"
        );
    }
}

#[test]
fn what_is_given_is_met_by_restarts() {
    let text = "mdp module m s : [0..3];
        [x] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [y] s=0 -> 1/5:(s'=1) + 4/5:(s'=3);
        [z] s=0 -> 3/10:(s'=1) + 6/10:(s'=2) + 1/10:(s'=3); [] s>0 -> true; endmodule";
    holds(text, "Pmax=? [ F s=1 || F (s<3 & s>0) ]", 1.0);
    holds(text, "Pmin=? [ F s=1 || F (s<3 & s>0) ]", 1.0 / 3.0);
    holds(text, "Pmax=? [ F s=2 || G s!=1 ]", 1.0);
    holds(text, "Pmin=? [ F s=2 || G s!=1 ]", 0.0);
    holds(text, "Pmax=? [ F s=2 || G s!=3 ]", 2.0 / 3.0);
    let found = certified(
        text,
        "Pmax=? [ F s=1 || F s>3 ]",
        &mut Iteration::new(0.0, 0.0),
    );
    assert!(matches!(found, Err(Failure::Unsupported(_))), "{found:?}");
}

#[test]
fn losses_are_taken_off() {
    let text = WALK.replace("s=1 | s=2 : 1;", "s=1 : -1; s=2 : 2;");
    // x_1 = -1 + x_2/4, x_2 = 2 + 3 x_1/4.
    let found = certified(
        &text,
        "R=? [ F (s=0 | s=3) ]",
        &mut Iteration::new(0.0, 0.0),
    )
    .unwrap();
    assert!(found.low <= -8.0 / 13.0 && -8.0 / 13.0 <= found.high && found.high - found.low < 1e-6);
    holds(&text, "R=? [ F (s=0 | s=3) ] + 1", 5.0 / 13.0);
    holds(&text, "R=? [ C ] + 1", 5.0 / 13.0);
    holds(&text, "R=? [ C<=2 ] + 1", 0.5);
    holds(&text, "R=? [ I=1 ]", 0.5);
    holds(
        &MACHINES.replace("s=2 : 3", "s=2 : -3"),
        "R=? [ S ]",
        -0.2 + 1.6,
    );
    let choices =
        "mdp module m s : [0..1]; [] s=0 -> (s'=1); [] s=0 -> true; [] s=1 -> true; endmodule
        rewards s=0 : -1; endrewards";
    holds(choices, "3 + Rmin=? [ C<=2 ]", 1.0);
    let found = certified(choices, "Rmin=? [ F s=1 ]", &mut Iteration::new(0.0, 0.0));
    assert!(matches!(found, Err(Failure::Unsupported(_))), "{found:?}");
    let ctmc = "ctmc module m s : [0..1]; [] s=0 -> 2:(s'=1); endmodule rewards s=0 : -5; s=1 : 1; endrewards";
    let gone = 1.0 - (-2.0f64).exp();
    holds(
        ctmc,
        "R=? [ C<=1 ] + 4",
        4.0 - 2.5 * gone + (1.0 - 0.5 * gone),
    );
    holds(ctmc, "R=? [ I=1 ]", gone - 5.0 * (1.0 - gone));
}

#[test]
fn any_formula_of_linear_time_is_judged() {
    holds(WALK, "P=? [ s=1 U (G s=0) ]", 0.75);
    holds(WALK, "P=? [ (s>0 & (X s!=1)) U (G s=3) ]", 0.0625);
    holds(WALK, "P=? [ G (s=1 | (F (G s=0))) ]", 12.0 / 13.0);
    let mdp = "mdp module m s : [0..2];
        [a] s=0 -> 1/4:(s'=1) + 3/4:(s'=2); [b] s=0 -> true; [a] s=1 -> (s'=0); [b] s=1 -> true; [] s=2 -> true; endmodule";
    holds(mdp, "Pmax=? [ s=0 U (G s=1) ]", 0.25);
    holds(mdp, "Pmin=? [ (F s=1) U (G s!=0) ]", 0.0);
    holds(mdp, "Pmax=? [ G ((F (G s=2)) | (s=0 U (G s=1))) ]", 1.0);
    holds(mdp, "Pmin=? [ (s=0 U (G s=2)) | (F s=1) ]", 0.0);
}

#[test]
fn filters_and_functions_of_values() {
    let back = "dtmc module m s : [0..2] init 1; [] s=1 -> (s'=0); [] s=0 -> 1/2:(s'=2) + 1/2:(s'=0); [] s=2 -> true; endmodule";
    // The first state is 0, though 1 is where it starts.
    holds(back, "filter(first, P=? [ X s=0 ], true)", 0.5);
    holds(back, "filter(state, P=? [ X s=0 ], s=2)", 0.0);
    holds(back, "filter(printall, P=? [ X s=0 ], true)", 1.0);
    assert_eq!(
        truth(back, "filter(argmax, P=? [ X s=0 ], true)"),
        Some(true)
    );
    assert_eq!(
        truth(back, "filter(argmin, P=? [ X s=0 ], true)"),
        Some(false)
    );
    assert_eq!(truth(back, "filter(first, s=1, true)"), Some(false));
    assert_eq!(truth(back, "filter(print, s=1, true)"), Some(true));
    holds(WALK, "P=? [ F s=3 ] ^ 2", 1.0 / 169.0);
    holds(WALK, "pow(P=? [ F s=3 ], -1)", 13.0);
    holds(WALK, "pow(P=? [ F s=3 ], 1.5)", 13.0_f64.powf(-1.5));
    holds(
        WALK,
        "round(7 * P=? [ F s=3 ]) + round(6 * P=? [ F s=3 ])",
        1.0,
    );
    holds(WALK, "floor(14 * P=? [ F s=3 ]) + ceil(P=? [ F s=3 ])", 2.0);
}

#[test]
fn what_is_not_certified_is_refused_by_name() {
    let mut oracle = Iteration::new(0.0, 0.0);
    for (asked, name) in [
        ("P=? [ F s=3 ] ^ 0.3", "integer"),
        ("log(P=? [ F s=3 ], 2)", "logarithm"),
    ] {
        match certified(WALK, asked, &mut oracle) {
            Err(Failure::Unsupported(what)) => assert!(what.contains(name), "{asked}: {what}"),
            other => panic!("{asked}: {other:?}"),
        }
    }
}
