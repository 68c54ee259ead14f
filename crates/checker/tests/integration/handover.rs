//! The figures that Webster et al. (2020, table 5 and equations 4 to 12) print
//! for the five versions of the handover's formal model, computed.

use checker::explore::explore;
use checker::state_space::StateSpace;
use checker::{Answer, AnswerValue, Guarantee, Method, Options, check_exact, check_space};
use prism_lang::{Constants, Property, Rational, parse_model, parse_properties, resolve};
use prism_lang::{rational_to_f64, resolve_properties, resolved};
use std::path::Path;

/// Distance at which a printed probability counts as reproduced.
const TOLERANCE: f64 = 1e-12;

const SUCCESS: &str = "P=? [ F robotState=handoverSuccessful ]";

fn model(version: usize) -> resolved::Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!(
        "../../case-studies/handover/models/handover_v{version}.prism"
    ));
    let text = std::fs::read_to_string(path).expect("the model is in the repository");
    let tree = parse_model(&text).into_result().expect("it parses");
    resolve(&tree, &Constants::new()).expect("it resolves")
}

fn property(model: &resolved::Model, text: &str) -> Property {
    let tree = parse_properties(text).into_result().expect("it parses");
    let mut properties = resolve_properties(&tree, model, &Constants::new()).expect("it resolves");
    properties.pop().expect("there is one").property
}

fn answer(version: usize, text: &str, method: Method) -> Answer {
    let model = model(version);
    let space: StateSpace<f64> = explore(&model).expect("it explores");
    let options = Options::with_method(method);
    check_space(&space, &property(&model, text), &options).expect("there is an answer")
}

fn number(answer: &Answer) -> f64 {
    match &answer.value {
        AnswerValue::Number(value) => *value,
        AnswerValue::Exact(value) => rational_to_f64(value),
        other => panic!("not a number: {other:?}"),
    }
}

#[test]
fn states_and_transitions_are_the_published_ones() {
    let published = [
        (42_960, 236_643),
        (31_120, 150_955),
        (15_614, 54_969),
        (15_615, 54_971),
        (15_623, 54_998),
    ];
    for (version, counts) in (1..).zip(published) {
        let space: StateSpace<f64> = explore(&model(version)).expect("it explores");
        assert_eq!(
            (space.num_states(), space.num_transitions()),
            counts,
            "v{version}"
        );
    }
}

#[test]
fn sound_bounds_of_v3_to_v5_hold_the_published_values() {
    let published = [
        (3, 0.9001457729154516),
        (4, 0.8821428574571426),
        (5, 0.8803785717422283),
    ];
    for (version, value) in published {
        let found = answer(version, SUCCESS, Method::Sound);
        assert!(
            (number(&found) - value).abs() < TOLERANCE,
            "v{version}: {found:?}"
        );
        let Guarantee::Bounded { low, high } = found.guarantee else {
            panic!("v{version}: {found:?}");
        };
        assert!(low <= value + TOLERANCE && value - TOLERANCE <= high && high - low < 1e-6);
    }
}

#[test]
fn the_published_digits_of_v1_and_v2_are_where_the_iteration_stops() {
    let published = [(1, 0.9999948082592586, 84), (2, 0.9999954384256133, 78)];
    for (version, value, iterations) in published {
        let found = answer(version, SUCCESS, Method::PrismDefault);
        assert!(
            (number(&found) - value).abs() < TOLERANCE,
            "v{version}: {found:?}"
        );
        assert_eq!(found.iterations, iterations, "v{version}");
        assert!(matches!(found.guarantee, Guarantee::Estimated { .. }));
    }
}

/// The exact failure probability of v1, computed once with
/// `corroborate check --method exact`, which takes minutes on this model.
const EXACT_FAILURE_OF_V1: f64 = 1.1245666762974378e-53;

#[test]
fn the_failures_of_v1_and_v2_are_tiny_and_have_sound_bounds() {
    for (version, failure) in [(1, 1.12e-53), (2, 3.67e-59)] {
        let sound = answer(version, SUCCESS, Method::Sound);
        let (low, high) = sound.complement_bounds.expect("the complement has bounds");
        assert!((high - low) / low < 1e-6, "v{version}: {low:e} to {high:e}");
        assert!((low / failure - 1.0).abs() < 0.01, "v{version}: {low:e}");
        if version == 1 {
            let exact = EXACT_FAILURE_OF_V1;
            assert!(low <= exact && exact <= high, "{low:e} to {high:e}");
        }
    }
}

#[test]
fn requirements_2_to_5b_of_v5_have_the_published_values() {
    let ready = "gazeState=ok & pressureState=ok & locationState=ok";
    let attempted = "(robotState=handoverSuccessful | robotState=handoverUnsuccessful)";
    let decides = "(F robotState=handoverSuccessful) | (F robotState=handoverUnsuccessful) \
                   | (F (robotState=waitForGPLUpdate U robotState=timedOut))";
    let requirements = [
        (format!("P=? [ G (!({ready}) => !{attempted}) ]"), 1.0),
        (
            format!("P=? [ G (({ready}) => (F robotState=handoverSuccessful)) ]"),
            0.880_378_571_742_22,
        ),
        (
            format!("P=? [ G (robotState=GPLOk => (F ({attempted} & objectReleaseTimer<=20))) ]"),
            1.0,
        ),
        (format!("P=? [ G ({decides}) ]"), 0.998),
        (
            format!("P=? [ G ({decides} | (F robotState=motionError)) ]"),
            1.0,
        ),
    ];
    for (text, value) in requirements {
        let found = answer(5, &text, Method::Sound);
        assert!(
            (number(&found) - value).abs() < TOLERANCE,
            "{text}: {found:?}"
        );
    }
}

#[test]
fn rational_arithmetic_gives_v5_as_the_product_of_its_four_constants() {
    let model = model(5);
    let space: StateSpace<Rational> = explore(&model).expect("it explores");
    let options = Options::with_method(Method::Exact);
    let found = check_exact(&space, &property(&model, SUCCESS), &options).expect("an answer");
    let part =
        |numerator: i64, denominator: i64| Rational::new(numerator.into(), denominator.into());
    let one = part(1, 1);
    let product = (one.clone() - part(71_428_571, 1_000_000_000))
        * (one.clone() - part(30_612_245, 1_000_000_000))
        * (one.clone() - part(2, 100))
        * (one - part(2, 1000));
    assert_eq!(found.value, AnswerValue::Exact(product));
}
