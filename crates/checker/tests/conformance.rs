//! Every model of `conformance/models` under every method, held against the exact values beside its properties.
//!
//! In a `.props` file each property is preceded by lines `// RESULT: value`, or `// RESULT (N=3,p=0.5): value` with values
//! of the model's constants. A value is an arithmetic expression over decimal numbers (`+ - * / ^` and parentheses,
//! computed exactly), `true`, `false`, or `[low, high]` over several initial states. Models may state their size in lines
//! `// STATES: n` and `// TRANSITIONS: n`.
//!
//! The exact method must give the value itself, the sound method bounds that contain it and are narrow. The method of
//! PRISM's default settings may be far off, but then a line `// PRISM-DEFAULT: off, reason` (with constants as above) must
//! say so, and it must really be off. There are no exceptions for the other methods, and no way to state one.

mod support;

use checker::explore::explore;
use checker::{
    Answer, AnswerValue, CheckError, Guarantee, Method, Options, check_exact, check_space,
};
use num_traits::Signed;
use prism_lang::property::Quantity;
use prism_lang::{Arithmetic, Constants, NamedProperty, Property, Rational, rational_to_f64};
use std::path::{Path, PathBuf};
use support::value::{Expected, exact_of};

/// Relative width that the sound method is asked for.
const PRECISION: f64 = 1e-6;

/// Below this the sound method promises an upper bound alone.
const SMALLEST: f64 = 1.001e-150;

/// Relative error up to which the method of PRISM's default settings counts as right.
const CLOSE: f64 = 1e-4;

fn models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/models");
    let entries = std::fs::read_dir(&folder).expect("conformance/models can be listed");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "prism"));
    paths.sort();
    assert!(paths.len() >= 20, "only {} models", paths.len());
    paths
}

/// A property with the values of constants for which its result is known.
struct Case {
    model: PathBuf,
    place: String,
    constants: String,
    property: NamedProperty,
    expected: Expected,
    /// Whether PRISM's stopping rule is stated to be off here.
    off: bool,
}

/// All cases of a model, and the values of constants they use.
fn cases(model: &Path) -> Vec<Case> {
    let path = model.with_extension("props");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let parsed = prism_lang::parse_properties(&text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{}: {:?}",
        path.display(),
        parsed.diagnostics
    );
    let mut cases = Vec::new();
    let mut from = 0;
    let places: Vec<usize> = parsed
        .tree
        .properties
        .iter()
        .map(|p| p.span.start)
        .collect();
    for (index, place) in places.into_iter().enumerate() {
        let notes = &text[from..place];
        from = place;
        let line = text[..place].lines().count() + 1;
        let results = noted(notes, "RESULT");
        assert!(!results.is_empty(), "{}:{line}: no RESULT", path.display());
        let off = noted(notes, "PRISM-DEFAULT");
        for (constants, value) in results {
            let file = path.file_name().and_then(|n| n.to_str()).unwrap_or("?");
            cases.push(Case {
                model: model.to_owned(),
                place: format!("{file}:{line} ({constants})"),
                off: off.iter().any(|(c, _)| *c == constants),
                property: property_of(model, &parsed.tree, &constants, index),
                expected: Expected::parse(&value).unwrap_or_else(|e| panic!("{file}:{line}: {e}")),
                constants,
            });
        }
    }
    assert!(!cases.is_empty(), "{} has no properties", path.display());
    cases
}

fn property_of(
    model: &Path,
    tree: &prism_lang::ast::PropertyFile,
    constants: &str,
    index: usize,
) -> NamedProperty {
    let given = Constants::parse(constants).expect("constants in a RESULT line");
    let resolved = resolved(model, constants);
    let mut all = prism_lang::resolve_properties(tree, &resolved, &given)
        .unwrap_or_else(|found| panic!("{}: {found:?}", model.display()));
    all.swap_remove(index)
}

/// The lines `// KEY (constants): value` of a comment.
fn noted(comment: &str, key: &str) -> Vec<(String, String)> {
    let lines = comment
        .lines()
        .filter_map(|line| line.trim().strip_prefix("// "));
    lines
        .filter_map(|line| line.strip_prefix(key))
        .filter_map(|rest| match rest.strip_prefix(" (") {
            Some(rest) => rest.split_once("): "),
            None => rest.strip_prefix(": ").map(|value| ("", value)),
        })
        .map(|(constants, value)| (constants.to_owned(), value.trim().to_owned()))
        .collect()
}

fn resolved(model: &Path, constants: &str) -> prism_lang::resolved::Model {
    let text = std::fs::read_to_string(model).expect("the model can be read");
    let parsed = prism_lang::parse_model(&text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{}: {:?}",
        model.display(),
        parsed.diagnostics
    );
    let given = Constants::parse(constants).expect("constants in a RESULT line");
    prism_lang::resolve(&parsed.tree, &given)
        .unwrap_or_else(|found| panic!("{}: {found:?}", model.display()))
}

/// Runs every case of every model with the state space in the domain `N`, and reports all failures together.
fn for_all<N: Arithmetic>(
    judge: impl Fn(&checker::state_space::StateSpace<N>, &Case) -> Result<(), String>,
) {
    let (mut failures, mut count) = (Vec::new(), 0);
    for model in models() {
        let mut last = None;
        for case in cases(&model) {
            if last
                .as_ref()
                .is_none_or(|(constants, _)| *constants != case.constants)
            {
                let space = explore::<N>(&resolved(&model, &case.constants));
                let space = space.unwrap_or_else(|error| panic!("{}: {error}", case.place));
                last = Some((case.constants.clone(), space));
            }
            let Some((_, space)) = &last else { continue };
            count += 1;
            if let Err(reason) = judge(space, &case) {
                failures.push(format!("{}: {}: {reason}", case.place, case.property.text));
            }
        }
    }
    assert!(count > 150, "only {count} cases were found");
    assert!(
        failures.is_empty(),
        "{} of {count} cases:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

#[test]
fn the_exact_method_gives_the_value_itself() {
    for_all::<Rational>(|space, case| {
        let options = Options::with_method(Method::Exact);
        let answer =
            check_exact(space, &case.property.property, &options).map_err(|e| e.to_string())?;
        exactly(&answer, &case.expected)
    });
}

fn exactly(answer: &Answer, expected: &Expected) -> Result<(), String> {
    let found = match &answer.value {
        AnswerValue::Exact(value) => Expected::Number(value.clone()),
        AnswerValue::ExactRange { low, high } => Expected::Range(low.clone(), high.clone()),
        AnswerValue::Truth(truth) => Expected::Truth(*truth),
        other => return Err(format!("the exact method answered {other:?}")),
    };
    if answer.guarantee != Guarantee::Exact {
        return Err(format!("its guarantee is {:?}", answer.guarantee));
    }
    if found == *expected {
        Ok(())
    } else {
        Err(format!("{found:?}"))
    }
}

#[test]
fn the_sound_method_encloses_the_value_narrowly() {
    for_all::<f64>(|space, case| {
        let options = Options {
            precision: PRECISION,
            ..Options::with_method(Method::Sound)
        };
        match check_space(space, &case.property.property, &options) {
            Ok(answer) => sound(&answer, &case.property.property, &case.expected),
            // A bound that lies within the bounds of the computation is not guessed at.
            Err(CheckError::Undecided { bounds, .. }) if bounds.low <= bounds.high => {
                decided_exactly(case)
            }
            Err(error) => Err(error.to_string()),
        }
    });
}

/// What `CheckError::Undecided` tells its reader to do.
fn decided_exactly(case: &Case) -> Result<(), String> {
    let has_bound = ["P<", "P>"].iter().any(|p| case.property.text.contains(p));
    if !has_bound {
        return Err("undecided, but there is no bound to decide".to_owned());
    }
    let space = explore::<Rational>(&resolved(&case.model, &case.constants));
    let space = space.map_err(|e| e.to_string())?;
    let options = Options::with_method(Method::Exact);
    let answer = check_exact(&space, &case.property.property, &options);
    exactly(&answer.map_err(|e| e.to_string())?, &case.expected)
}

fn sound(answer: &Answer, property: &Property, expected: &Expected) -> Result<(), String> {
    let is_probability = matches!(
        property,
        Property::Probability { .. } | Property::Number(Quantity::Probability { .. })
    );
    match (&answer.value, expected) {
        (AnswerValue::Truth(found), Expected::Truth(expected)) if found == expected => Ok(()),
        (AnswerValue::Number(value), Expected::Number(exact)) => {
            encloses(answer, *value, exact)?;
            match is_probability {
                true => complement_encloses(answer, exact),
                false => Ok(()),
            }
        }
        (AnswerValue::Range { low, high }, Expected::Range(exact_low, exact_high)) => {
            for exact in [exact_low, exact_high] {
                let initial = answer.initial.iter().any(|i| {
                    let bounds = bounds_of(&i.value, &i.guarantee);
                    bounds.is_some_and(|(low, high)| contains(low, high, exact))
                });
                if !initial {
                    return Err(format!(
                        "no initial state's bounds contain {exact}: {:?}",
                        answer.initial
                    ));
                }
            }
            near(*low, exact_low, PRECISION)?;
            near(*high, exact_high, PRECISION)
        }
        (found, _) => Err(format!("{found:?}")),
    }
}

/// What the guarantee says of a number.
fn bounds_of(value: &AnswerValue, guarantee: &Guarantee) -> Option<(f64, f64)> {
    match (value, guarantee) {
        (AnswerValue::Number(value), Guarantee::Exact) => Some((*value, *value)),
        (_, Guarantee::Bounded { low, high }) => Some((*low, *high)),
        _ => None,
    }
}

fn encloses(answer: &Answer, value: f64, exact: &Rational) -> Result<(), String> {
    let (low, high) = bounds_of(&answer.value, &answer.guarantee)
        .ok_or_else(|| format!("the sound method's guarantee is {:?}", answer.guarantee))?;
    if !contains(low, high, exact) {
        return Err(format!(
            "{low:e} to {high:e} does not contain {:e}",
            rational_to_f64(exact)
        ));
    }
    if !(low <= value && value <= high) {
        return Err(format!(
            "{value:e} is not between its bounds {low:e} and {high:e}"
        ));
    }
    narrow(low, high)
}

/// The probability of the contrary keeps its digits too.
fn complement_encloses(answer: &Answer, exact: &Rational) -> Result<(), String> {
    let Some(complement) = answer.complement else {
        return Err("the complement is missing".to_owned());
    };
    let exact = <Rational as Arithmetic>::one() - exact;
    let (low, high) = answer.complement_bounds.unwrap_or((complement, complement));
    if !contains(low, high, &exact) {
        return Err(format!(
            "complement: {low:e} to {high:e} does not contain {:e}",
            rational_to_f64(&exact)
        ));
    }
    narrow(low, high).map_err(|reason| format!("complement: {reason}"))
}

fn contains(low: f64, high: f64, exact: &Rational) -> bool {
    exact_of(low) <= *exact && *exact <= exact_of(high)
}

/// The relative width is as asked, rounding to neighbouring doubles allowed; of values below the least that floating
/// point is used for, only that is known.
fn narrow(low: f64, high: f64) -> Result<(), String> {
    if high - low <= PRECISION * high * (1.0 + 1e-9) || high <= SMALLEST {
        Ok(())
    } else {
        Err(format!("{low:e} to {high:e} is wider than asked"))
    }
}

fn near(value: f64, exact: &Rational, tolerance: f64) -> Result<(), String> {
    if !value.is_finite() {
        return Err(format!("{value} is no probability"));
    }
    let error = (exact_of(value) - exact).abs();
    if Arithmetic::is_zero(exact) && value == 0.0
        || rational_to_f64(&error) <= tolerance * rational_to_f64(&exact.abs())
    {
        Ok(())
    } else {
        Err(format!(
            "{value:e} is not near {:e}",
            rational_to_f64(exact)
        ))
    }
}

#[test]
fn the_method_of_prisms_default_is_close_or_stated_to_be_off() {
    for_all::<f64>(|space, case| {
        let options = Options::with_method(Method::PrismDefault);
        let outcome = match check_space(space, &case.property.property, &options) {
            Ok(answer) => default_is_close(&answer, &case.expected),
            Err(error @ (CheckError::NotConverged { .. } | CheckError::NotFinite { .. })) => {
                Err(error.to_string())
            }
            Err(error) => return Err(error.to_string()),
        };
        match (outcome, case.off) {
            (Err(reason), false) => Err(reason),
            (Ok(()), true) => Err("is stated to be off but is close".to_owned()),
            _ => Ok(()),
        }
    });
}

fn default_is_close(answer: &Answer, expected: &Expected) -> Result<(), String> {
    if answer.guarantee == Guarantee::Exact && !matches!(answer.value, AnswerValue::Truth(_)) {
        return Err("an iteration that stopped calls itself exact".to_owned());
    }
    match (&answer.value, expected) {
        (AnswerValue::Truth(found), Expected::Truth(expected)) if found == expected => Ok(()),
        (AnswerValue::Number(value), Expected::Number(exact)) => near(*value, exact, CLOSE),
        (AnswerValue::Range { low, high }, Expected::Range(exact_low, exact_high)) => {
            near(*low, exact_low, CLOSE)?;
            near(*high, exact_high, CLOSE)
        }
        (found, _) => Err(format!("{found:?}")),
    }
}

#[test]
fn models_have_the_stated_sizes() {
    let mut stated = 0;
    for model in models() {
        let text = std::fs::read_to_string(&model).expect("the model can be read");
        let number = |key| {
            let noted = noted(&text, key);
            noted.first().map(|(_, n)| {
                n.parse::<usize>()
                    .expect("a number of states or transitions")
            })
        };
        let (states, transitions) = (number("STATES"), number("TRANSITIONS"));
        if states.is_none() && transitions.is_none() {
            continue;
        }
        let space = explore::<f64>(&resolved(&model, "")).expect("a state space");
        assert!(
            states.is_none_or(|n| n == space.num_states()),
            "{}: {} states",
            model.display(),
            space.num_states()
        );
        assert!(
            transitions.is_none_or(|n| n == space.num_transitions()),
            "{}: {} transitions",
            model.display(),
            space.num_transitions()
        );
        stated += 1;
    }
    assert!(stated >= 10, "only {stated} models state their size");
}
