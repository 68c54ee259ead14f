//! Rational functions of open constants, against known results and against rational arithmetic at points.

use checker::explore::explore;
use checker::parametric::{ParametricAnswer, ParametricValue, RationalFunction, Region, solve};
use checker::{AnswerValue, CheckError, Options, check_exact};
use prism_lang::{
    Constants, Number, Rational, Value, parse_model, parse_properties, resolve, resolve_open,
    resolve_properties,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn answers(text: &str, region: &str, asked: &str) -> Result<Vec<ParametricAnswer>, CheckError> {
    let none = Constants::new();
    let model = resolve_open(
        &parse_model(text).tree,
        &none,
        &none,
        &Region::names(region),
    )
    .unwrap();
    let properties = parse_properties(asked).into_result().unwrap();
    let properties = resolve_properties(&properties, &model, &none).unwrap();
    let space = explore::<RationalFunction>(&model).unwrap();
    let region = Region::parse(region, &model.parameters).unwrap();
    let options = Options::default();
    let solved = properties.iter();
    solved
        .map(|p| solve(&space, &p.property, &region, &options))
        .collect()
}

/// The one value of the one part.
fn value(text: &str, region: &str, asked: &str) -> ParametricValue {
    let answer = answers(text, region, asked).unwrap().remove(0);
    assert_eq!(
        (answer.parts.len(), answer.undecided.len()),
        (1, 0),
        "{asked}: {answer:?}"
    );
    assert_eq!(answer.parts[0].values.len(), 1);
    answer.parts[0].values[0].clone()
}

fn function(text: &str, region: &str, asked: &str) -> RationalFunction {
    match value(text, region, asked) {
        ParametricValue::Function(function) => function,
        other => panic!("{asked}: {other:?}"),
    }
}

const PCTL: &str = "dtmc const double p; module M s:[0..5];
    [] s=0 -> p:(s'=1) + 1-p:(s'=3); [] s=1 -> 0.5:(s'=0) + 0.25:(s'=2) + 0.25:(s'=4);
    [r] s=2 -> 1:(s'=5); [] s=3 -> 1:(s'=3); [] s=4 -> 1:(s'=4); [] s=5 -> 1:(s'=2); endmodule
    rewards \"time\" true : 1; endrewards rewards \"r\" s=4 : 3; [r] true : 17; endrewards
    rewards \"mine\" s<2 : p; endrewards";

#[test]
fn functions_of_a_small_chain_are_the_ones_by_hand() {
    let text = |asked: &str| function(PCTL, "p", asked).text(&["p"]);
    assert_eq!(text("P=? [ F s=2 ]"), "(-p)/(2*p-4)");
    assert_eq!(text("P=? [ F s=2|s=4 ]"), "(-p)/(p-2)");
    assert_eq!(text("P=? [ G s<2 ]"), "0");
    assert_eq!(text("P=? [ s!=1 U s=3 ]"), "-p+1");
    assert_eq!(text("P=? [ F<=3 s=3 ]"), "(-p^2-p+2)/(2)");
    assert_eq!(text("R{\"r\"}=? [ S ]"), "(-23*p)/(4*p-8)");
    assert_eq!(text("R{\"time\"}=? [ F s>1 ]"), "(-2*p-2)/(p-2)");
    assert_eq!(text("R{\"mine\"}=? [ F s>1 ]"), "(-2*p^2-2*p)/(p-2)");
    assert_eq!(text("P=? [ G F s=5 ]"), "(-p)/(2*p-4)");
    assert_eq!(text("1 - P=? [ F s=2 ]"), "(3*p-4)/(2*p-4)");
    assert_eq!(
        value(PCTL, "p", "R{\"time\"}=? [ F s=2 ]"),
        ParametricValue::Infinite
    );
    assert_eq!(
        value(PCTL, "p", "P>0 [ F s=2 ]"),
        ParametricValue::Truth(true)
    );
}

#[test]
fn rates_are_functions_too() {
    let text = "ctmc const double x; module M s : [0..3]; [] s=0 -> x: (s'=1); [] s=1 -> 7: (s'=2);
        [] s=2 -> 11: (s'=3); [] s>2 -> 13: true; endmodule
        rewards \"a\" s=0: 2; s=1: 5; s=2: 11; endrewards";
    let asked = |asked: &str| function(text, "x=1:10", asked).text(&["x"]);
    assert_eq!(asked("R{\"a\"}=? [ F s=1 ]"), "(2)/(x)");
    assert_eq!(asked("R{\"a\"}=? [ F s=2 ]"), "(5*x+14)/(7*x)");
    assert_eq!(asked("R{\"a\"}=? [ S ]"), "0");
    let timed = answers(text, "x=1:10", "P=? [ F<=2.5 s=3 ]");
    assert!(
        matches!(timed, Err(CheckError::Unsupported(_))),
        "{timed:?}"
    );
}

#[test]
fn bounds_split_the_region_where_they_change() {
    let answer = answers(PCTL, "p", "P>=0.25 [ F s=2 ]").unwrap().remove(0);
    // -p/(2p-4) >= 1/4 iff p >= 2/3.
    let two_thirds = Rational::new(2.into(), 3.into());
    let mut sizes = [
        Rational::from_integer(0.into()),
        Rational::from_integer(0.into()),
    ];
    for part in &answer.parts {
        let (low, high) = &part.region.ranges[0];
        let expected = *low >= two_thirds;
        assert!(expected || *high <= two_thirds);
        assert_eq!(part.values, [ParametricValue::Truth(expected)]);
        sizes[usize::from(expected)] += high - low;
    }
    assert!(answer.parts.len() > 1 && !answer.undecided.is_empty());
    let undecided: Vec<_> = answer.undecided.iter().map(|r| &r.ranges[0]).collect();
    assert!(
        undecided
            .iter()
            .any(|(low, high)| *low <= two_thirds && two_thirds <= *high)
    );
    let open = undecided.iter().map(|(low, high)| high - low);
    let open = open.fold(Rational::from_integer(0.into()), |a, b| a + b);
    assert!(open <= Rational::new(1.into(), 20.into()));
}

#[test]
fn the_state_with_the_greatest_value_is_not_guessed() {
    let text = "dtmc const double p; const double q; module m s:[0..2];
        [] s=0 -> p:(s'=2) + 1-p:(s'=1); [] s=1 -> q:(s'=2) + 1-q:(s'=0); [] s=2 -> true; endmodule";
    let asked = "filter(argmax, P=? [ X s=2 ], s<2)";
    let known = value(text, "p,q", "filter(argmin, P=? [ F s=2 ], s<2)");
    assert_eq!(known, ParametricValue::Truth(true));
    let open = answers(text, "p,q", asked);
    assert!(
        matches!(open, Err(CheckError::Undecided { .. })),
        "{open:?}"
    );
}

#[test]
fn what_a_solution_rests_on_is_told() {
    let text =
        "dtmc const double p; module m s : [0..2]; [] s=0 -> 2*p:(s'=1) + 1-2*p:(s'=2); endmodule";
    let whole = answers(text, "p", "P=? [ F s=1 ]").unwrap().remove(0);
    assert!(!whole.conditions.hold());
    let half = answers(text, "p=0:0.5", "P=? [ F s=1 ]").unwrap().remove(0);
    assert!(half.conditions.hold());
    let conditions: Vec<_> = half
        .conditions
        .each
        .iter()
        .map(|c| c.function.text(&["p"]))
        .collect();
    assert_eq!(conditions, ["2*p", "-2*p+1"]);
    let none = answers(text, "p=0.6:0.7", "P=? [ F s=1 ]")
        .unwrap()
        .remove(0);
    assert!(none.conditions.never_hold());
}

#[test]
fn the_best_choices_of_a_decision_process_hold_on_their_part() {
    let text = "mdp const double p; module m s : [0..3];
        [safe] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [risky] s=0 -> p:(s'=1) + 1-p:(s'=3);
        [again] s=3 -> 0.5:(s'=0) + 0.5:(s'=2); [stop] s>0 -> true; endmodule
        rewards [] true : 0; [safe] true : 3; [risky] true : 1; [again] true : 1; endrewards";
    let answer = answers(text, "p", "Pmax=? [ F s=1 ]").unwrap().remove(0);
    // Risky again and again: p / (1 - (1-p)/2) = 2p/(1+p), which is more than 1/2 iff p > 1/3.
    let third = Rational::new(1.into(), 3.into());
    let half = RationalFunction::constant(Rational::new(1.into(), 2.into()));
    for part in &answer.parts {
        let ParametricValue::Function(found) = &part.values[0] else {
            panic!()
        };
        match part.region.ranges[0].0 >= third {
            true => assert_eq!(found.text(&["p"]), "(2*p)/(p+1)"),
            false => {
                assert!(part.region.ranges[0].1 <= third);
                assert_eq!(*found, half);
            }
        }
    }
    assert!(answer.parts.len() > 2);
    assert_eq!(
        function(text, "p=0.4:1", "Pmax=? [ F s=1 ]").text(&["p"]),
        "(2*p)/(p+1)"
    );
    assert_eq!(
        function(text, "p=0.4:1", "1-Pmax=? [ F s=1 ]").text(&["p"]),
        "(-p+1)/(p+1)"
    );
    assert_eq!(
        function(text, "p=0.1:0.3", "Pmin=? [ F s=1 ]").text(&["p"]),
        "p"
    );
    assert_eq!(
        value(text, "p", "Rmax=? [ F s=1 ]"),
        ParametricValue::Infinite
    );
}

/// A random chain (or decision process) over two parameters as text: probabilities are products and complements.
fn random_model(random: &mut ChaCha8Rng, kind: &str) -> String {
    let mut pick = |n: u32| random.next_u32() % n;
    let states = 4 + pick(6);
    let mut text = format!("{kind} const double p; const double q; module m s : [0..{states}];\n");
    for state in 0..states {
        let commands = if kind == "mdp" { 1 + pick(2) } else { 1 };
        for command in 0..commands {
            let mut to = || pick(states + 1);
            let (a, b, c) = (to(), to(), to());
            let outcomes = match pick(4) {
                0 => format!("p:(s'={a}) + 1-p:(s'={b})"),
                1 => format!("q/2:(s'={a}) + 1-q/2:(s'={b})"),
                2 => format!("p*q:(s'={a}) + (1-p)*q:(s'={b}) + 1-q:(s'={c})"),
                _ => format!("1/3:(s'={a}) + 2/3:(s'={b})"),
            };
            text += &format!("[a{command}] s={state} -> {outcomes};\n");
        }
    }
    text + &format!(
        "[a1] s={states} -> true; endmodule label \"goal\" = s={states};
        rewards s<{states} : 1+p; [a0] true : q; [a1] true : 2; endrewards\n"
    )
}

/// The exact value at a point.
fn at(text: &str, asked: &str, point: &[Rational]) -> AnswerValue {
    let mut given = Constants::new();
    for (name, value) in ["p", "q"].iter().zip(point) {
        given.set(*name, Value::Double(Number::from_rational(value.clone())));
    }
    let model = resolve(&parse_model(text).tree, &given).unwrap();
    let property = parse_properties(asked).tree;
    let property = resolve_properties(&property, &model, &given)
        .unwrap()
        .remove(0);
    let space = explore::<Rational>(&model).unwrap();
    check_exact(&space, &property.property, &Options::default())
        .unwrap()
        .value
}

fn agrees(found: &ParametricValue, exact: &AnswerValue, point: &[Rational], what: &str) {
    match (found, exact) {
        (ParametricValue::Function(f), AnswerValue::Exact(value)) => {
            assert_eq!(f.at(point).as_ref(), Some(value), "{what}");
            let floats: Vec<f64> = point.iter().map(prism_lang::rational_to_f64).collect();
            // The point itself, as floating point has it.
            let rounded: Vec<_> = floats
                .iter()
                .map(|x| Rational::from_float(*x).unwrap())
                .collect();
            let bounds = f.compiled().unwrap().at(&floats);
            let exact = f.at(&rounded).unwrap();
            let end = |x: f64| Rational::from_float(x).unwrap();
            assert!(
                end(bounds.low) <= exact && exact <= end(bounds.high),
                "{what}"
            );
        }
        (ParametricValue::Infinite, AnswerValue::Number(value)) => {
            assert_eq!(*value, f64::INFINITY, "{what}");
        }
        other => panic!("{what}: {other:?}"),
    }
}

fn point(random: &mut ChaCha8Rng, region: &Region) -> Vec<Rational> {
    let mut between = |(low, high): &(Rational, Rational)| {
        let share = Rational::new((1 + random.next_u32() % 97).into(), 98.into());
        low + (high - low) * share
    };
    region.ranges.iter().map(&mut between).collect()
}

#[test]
fn random_chains_agree_with_rational_arithmetic_at_random_points() {
    let asked = [
        "P=? [ F \"goal\" ]",
        "P=? [ s!=1 U s=2|s=3 ]",
        "P=? [ F<=4 \"goal\" ]",
        "P=? [ X s>1 ]",
        "R=? [ F \"goal\" ]",
        "R=? [ C<=3 ]",
        "R=? [ I=3 ]",
        "R=? [ S ]",
        "S=? [ s>2 ]",
        "P=? [ G F s>1 ]",
        "P=? [ (F s=1) & (F s=2) ]",
        "P=? [ G (s=0 => (X s>0)) ]",
    ];
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let text = random_model(&mut random, "dtmc");
        let asked = asked[seed as usize % asked.len()];
        let answer = answers(&text, "p,q", asked).unwrap().remove(0);
        assert!(answer.conditions.hold());
        for _ in 0..3 {
            let point = point(&mut random, &Region::unit(2));
            let what = format!("seed {seed}: {asked} at {point:?} of\n{text}");
            agrees(
                &answer.parts[0].values[0],
                &at(&text, asked, &point),
                &point,
                &what,
            );
        }
    }
}

#[test]
fn random_decision_processes_agree_on_every_part_of_the_region() {
    let asked = [
        "Pmax=? [ F \"goal\" ]",
        "Pmin=? [ F \"goal\" ]",
        "Rmin=? [ F \"goal\" ]",
        "Rmax=? [ F \"goal\" ]",
        "Pmax=? [ s!=1 U \"goal\" ]",
        "Pmax=? [ G F s>1 ]",
    ];
    for seed in 0..18 {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        let text = random_model(&mut random, "mdp");
        let asked = asked[seed as usize % asked.len()];
        let answer = answers(&text, "p=0.1:0.9,q=0.1:0.9", asked)
            .unwrap()
            .remove(0);
        assert!(!answer.parts.is_empty(), "seed {seed}: {asked} of\n{text}");
        for part in answer.parts.iter().take(4) {
            let point = point(&mut random, &part.region);
            let what = format!("seed {seed}: {asked} at {point:?} of\n{text}");
            agrees(&part.values[0], &at(&text, asked, &point), &point, &what);
        }
    }
}

#[test]
fn derivatives_are_the_limits_of_differences() {
    let text = random_model(&mut ChaCha8Rng::seed_from_u64(7), "dtmc");
    let f = function(&text, "p,q", "R=? [ C<=5 ]");
    let tiny = Rational::new(1.into(), (1u64 << 40).into());
    for parameter in 0..2 {
        let slope = f.derivative(parameter);
        let here = vec![
            Rational::new(1.into(), 3.into()),
            Rational::new(2.into(), 5.into()),
        ];
        let mut there = here.clone();
        there[parameter] += &tiny;
        let difference = (f.at(&there).unwrap() - f.at(&here).unwrap()) / &tiny;
        let error = difference - slope.at(&here).unwrap();
        assert!(prism_lang::rational_to_f64(&error).abs() < 1e-9);
    }
}

#[test]
fn constants_that_states_depend_on_are_refused() {
    let none = Constants::new();
    for command in ["[] s<=floor(p) -> (s'=1);", "[] true -> (s'=floor(p));"] {
        let text = format!("dtmc const double p; module m s : [0..1]; {command} endmodule");
        assert!(
            resolve_open(&parse_model(&text).tree, &none, &none, &["p"]).is_err(),
            "{command}"
        );
    }
    for probability in ["min(p, 1/3)", "max(p, 1/3)", "(p>0.5 ? 1 : 0)"] {
        let text = format!(
            "dtmc const double p; module m s : [0..2]; [] s=0 -> {probability}:(s'=1) + 1-{probability}:(s'=2); endmodule"
        );
        let model = resolve_open(&parse_model(&text).tree, &none, &none, &["p"]).unwrap();
        let found = explore::<RationalFunction>(&model);
        assert!(
            found.unwrap_err().to_string().contains("left open"),
            "{probability}"
        );
    }
}
