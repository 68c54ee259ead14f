//! Right certificates pass, planted errors do not.

use certifier::{Certificate, Certified, Failure, certify};
use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};

fn check(text: &str, asked: &str, certificate: &Certificate) -> Result<Certified, Failure> {
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let asked = parse_properties(asked).into_result().unwrap();
    let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
    certify(&model, &asked[0].property, certificate)
}

fn certificate(lower: &[f64], upper: &[f64]) -> Certificate {
    Certificate {
        states: (0..lower.len() as i64).map(|s| vec![s]).collect(),
        lower: lower.to_vec(),
        upper: upper.to_vec(),
        scheduler: None,
    }
}

fn broken(found: Result<Certified, Failure>, state: i64, words: &str) {
    match found {
        Err(Failure::Broken { state: at, what }) => {
            assert_eq!(at, [state], "{what}");
            assert!(what.contains(words), "{what}");
        }
        other => panic!("{words}: {other:?}"),
    }
}

/// A walk that is up with 1/4: from 1 of 3, the top is reached with 1/13.
const WALK: &str = "dtmc module walk s : [0..3] init 1;
    [] s=1 | s=2 -> 1/4:(s'=s+1) + 3/4:(s'=s-1); [] s=0 | s=3 -> true; endmodule
    rewards s=1 | s=2 : 1; endrewards";

#[test]
fn inductive_bounds_of_a_chain_pass_and_others_do_not() {
    let asked = "P=? [ F s=3 ]";
    let exact = [0.0, 1.0 / 13.0, 4.0 / 13.0, 1.0];
    let lower = [0.0, 0.0769, 0.3076, 1.0];
    let upper = [0.0, 0.077, 0.308, 1.0];
    let found = check(WALK, asked, &certificate(&lower, &upper)).unwrap();
    assert_eq!((found.low, found.high, found.states), (0.0769, 0.077, 4));
    assert!(found.low <= exact[1] && exact[1] <= found.high && found.inequalities >= 4);
    let contrary = check(WALK, "P=? [ G s<3 ]", &certificate(&lower, &upper)).unwrap();
    assert!((contrary.low - 0.923).abs() < 1e-12 && (contrary.high - 0.9231).abs() < 1e-12);
    // Each bound corrupted in one state, by little.
    broken(
        check(WALK, asked, &certificate(&lower, &[0.0, 0.076, 0.308, 1.0])),
        1,
        "exceeds",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&lower, &[0.0, 0.07699, 0.308, 1.0]),
        ),
        1,
        "inductive",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&[0.0, 0.07691, 0.3076, 1.0], &upper),
        ),
        1,
        "inductive",
    );
    broken(
        check(WALK, asked, &certificate(&lower, &[0.0, 0.077, 0.308, 0.9])),
        3,
        "exceeds",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&[0.0, 0.0769, 0.3076, 0.9], &[0.0, 0.077, 0.308, 0.9]),
        ),
        3,
        "known",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&[0.1, 0.0769, 0.3076, 1.0], &[0.1, 0.077, 0.308, 1.0]),
        ),
        0,
        "progress",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&[f64::NAN, 0.0, 0.0, 1.0], &upper),
        ),
        0,
        "exceeds",
    );
    let negative = certificate(&[-1.0, -1.0, -1.0, 1.0], &[-1.0, 0.077, 0.308, 1.0]);
    broken(check(WALK, asked, &negative), 0, "negative");
}

#[test]
fn a_certificate_must_fit_the_model() {
    let fewer = certificate(&[0.0, 0.0, 0.0], &[1.0, 1.0, 1.0]);
    let found = check(WALK, "P=? [ F s=3 ]", &fewer);
    assert!(matches!(found, Err(Failure::Incomplete(_))), "{found:?}");
    let mut short = certificate(&[0.0; 4], &[1.0; 4]);
    short.upper.pop();
    assert!(matches!(
        check(WALK, "P=? [ F s=3 ]", &short),
        Err(Failure::Incomplete(_))
    ));
    let loose = certificate(&[0.0; 4], &[1.0; 4]);
    let nested = check(WALK, "P=? [ F P>0.1 [ X s=3 ] ]", &loose);
    assert!(matches!(nested, Err(Failure::Unsupported(_))), "{nested:?}");
    let bounded = check(WALK, "P=? [ F<=3 s=3 ]", &loose);
    assert!(
        matches!(bounded, Err(Failure::Unsupported(_))),
        "{bounded:?}"
    );
    let bad = "dtmc module m s : [0..1]; [] s=0 -> 0.5:(s'=1) + 0.25:(s'=0); endmodule";
    let model = resolve(&parse_model(bad).tree, &Constants::new());
    assert!(model.is_err(), "the text itself is refused");
    let bad = "dtmc module m s : [0..1]; [] s=0 -> 0.5*(s+1):(s'=1) + 0.25*(s+1):(s'=0); endmodule";
    let found = check(bad, "P=? [ F s=1 ]", &certificate(&[0.0; 2], &[1.0; 2]));
    assert!(matches!(found, Err(Failure::Model(_))), "{found:?}");
}

#[test]
fn rewards_need_progress_for_their_upper_bounds() {
    let asked = "R=? [ F s=0 | s=3 ]";
    // x_1 = 1 + x_2/4, x_2 = 1 + 3 x_1/4: x_1 = 20/13, x_2 = 28/13.
    let (lower, upper) = ([0.0, 1.5384, 2.1538, 0.0], [0.0, 1.5385, 2.1539, 0.0]);
    let found = check(WALK, asked, &certificate(&lower, &upper)).unwrap();
    assert!(found.low <= 20.0 / 13.0 && 20.0 / 13.0 <= found.high);
    broken(
        check(
            WALK,
            asked,
            &certificate(&lower, &[0.0, 1.5384, 2.1538, 0.0]),
        ),
        1,
        "inductive",
    );
    broken(
        check(
            WALK,
            asked,
            &certificate(&[0.0, 1.5385, 2.154, 0.0], &[0.0, 1.6, 2.3, 0.0]),
        ),
        2,
        "inductive",
    );
    // The top is missed, so that no finite number is right, though a cycle without reward would take any.
    let asked = "R=? [ F s=3 ]";
    let wrong = certificate(&[0.0; 4], &[5.0, 8.0, 8.0, 0.0]);
    broken(check(WALK, asked, &wrong), 0, "progress");
    let infinity = f64::INFINITY;
    let right = [infinity, infinity, infinity, 0.0];
    assert_eq!(
        check(WALK, asked, &certificate(&right, &right))
            .unwrap()
            .low,
        infinity
    );
    // Where the target is sure, infinity is wrong.
    let asked = "R=? [ F s=0 | s=3 ]";
    let wrong = [0.0, infinity, infinity, 0.0];
    broken(
        check(WALK, asked, &certificate(&wrong, &wrong)),
        1,
        "infinite",
    );
}

/// State 0 chooses between waiting, a fair coin, and a coin that shows 1 with 0.9.
const COINS: &str = "mdp module m s : [0..2];
    [wait] s=0 -> true; [fair] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [good] s=0 -> 0.9:(s'=1) + 0.1:(s'=2);
    [] s>0 -> true; endmodule";

#[test]
fn schedulers_are_checked_and_cycles_prove_nothing() {
    let with = |lower: f64, upper: f64, taken: Option<Vec<(usize, f64)>>| Certificate {
        scheduler: taken.map(|taken| vec![Some(taken), None, None]),
        ..certificate(&[lower, 1.0, 0.0], &[upper, 1.0, 0.0])
    };
    let good = Some(vec![(1, 0.9), (2, 0.1)]);
    let fair = Some(vec![(1, 0.5), (2, 0.5)]);
    let found = check(
        COINS,
        "Pmax=? [ F s=1 ]",
        &with(0.8999999, 0.9000001, good.clone()),
    )
    .unwrap();
    assert_eq!((found.low, found.high), (0.8999999, 0.9000001));
    // Waiting for ever would meet any lower bound, but makes no progress.
    let wait = Some(vec![(0, 1.0)]);
    broken(
        check(COINS, "Pmax=? [ F s=1 ]", &with(0.9, 1.0, wait.clone())),
        0,
        "progress",
    );
    broken(
        check(COINS, "Pmax=? [ F s=1 ]", &with(0.95, 1.0, None)),
        0,
        "progress",
    );
    // Another scheduler than the one that attains the bound.
    broken(
        check(COINS, "Pmax=? [ F s=1 ]", &with(0.9, 1.0, fair.clone())),
        0,
        "inductive",
    );
    // An upper bound that only some choices keep.
    broken(
        check(COINS, "Pmax=? [ F s=1 ]", &with(0.5, 0.6, None)),
        0,
        "inductive",
    );
    // A choice that there is not.
    let odd = check(
        COINS,
        "Pmax=? [ F s=1 ]",
        &with(0.5, 1.0, Some(vec![(1, 0.7), (2, 0.3)])),
    );
    assert!(matches!(odd, Err(Failure::Incomplete(_))), "{odd:?}");
    // The least is 0, by waiting; one half is not, though both coins keep it.
    assert_eq!(
        check(COINS, "Pmin=? [ F s=1 ]", &with(0.0, 0.0, wait))
            .unwrap()
            .high,
        0.0
    );
    broken(
        check(COINS, "Pmin=? [ F s=1 ]", &with(0.5, 0.5, fair)),
        0,
        "progress",
    );
    let forced = COINS.replace("[wait] s=0 -> true;", "");
    let fair = Some(vec![(1, 0.5), (2, 0.5)]);
    assert_eq!(
        check(&forced, "Pmin=? [ F s=1 ]", &with(0.5, 0.5, fair))
            .unwrap()
            .low,
        0.5
    );
    broken(
        check(&forced, "Pmin=? [ F s=1 ]", &with(0.6, 0.9, good)),
        0,
        "inductive",
    );
}

#[test]
fn modules_synchronise_and_rates_race() {
    let text = "ctmc module a x : [0..2]; [go] x=0 -> 2:(x'=1); [] x=0 -> 3:(x'=2); endmodule
        module b y : [0..1]; [go] y=0 -> 0.5:(y'=1); endmodule rewards x=0 : 8; [go] true : 4; endrewards";
    // `go` has rate 1, the other 3.
    let states = vec![vec![0, 0], vec![1, 1], vec![2, 0]];
    let of = |value: f64, ends: [f64; 2]| Certificate {
        states: states.clone(),
        lower: vec![value, ends[0], ends[1]],
        upper: vec![value, ends[0], ends[1]],
        scheduler: None,
    };
    assert_eq!(
        check(text, "P=? [ F x=1 & y=1 ]", &of(0.25, [1.0, 0.0]))
            .unwrap()
            .low,
        0.25
    );
    // 8 per unit of time over a rate of 4, and 4 with probability 1/4.
    assert_eq!(
        check(text, "R=? [ F x>0 ]", &of(3.0, [0.0, 0.0]))
            .unwrap()
            .high,
        3.0
    );
    assert!(check(text, "R=? [ F x>0 ]", &of(3.01, [0.0, 0.0])).is_err());
    assert!(check(text, "P=? [ F x=1 ]", &of(0.26, [1.0, 0.0])).is_err());
}
