//! The chain that a scheduler induces has the value that the scheduler attains: for questions of every kind, on a model
//! whose values are known and on random ones, in rational arithmetic.

use checker::explore::explore;
use checker::scheduler::{Meaning, Scheduler, scheduler, scheduler_exact};
use checker::state_space::StateSpace;
use checker::{AnswerValue, CheckError, Options, check_exact, check_space};
use prism_lang::{
    Constants, Property, Rational, parse_model, parse_properties, resolve, resolve_properties,
    resolved::Model,
};

fn model(text: &str) -> Model {
    let parsed = parse_model(text);
    resolve(&parsed.tree, &Constants::new()).unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

fn properties(text: &str, model: &Model) -> Vec<Property> {
    let parsed = parse_properties(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let resolved = resolve_properties(&parsed.tree, model, &Constants::new()).unwrap();
    resolved.into_iter().map(|named| named.property).collect()
}

fn applied(space: &StateSpace<Rational>, asked: &Property) -> Result<AnswerValue, CheckError> {
    let found = scheduler_exact(space, asked, &Options::default())?;
    let chain = found.induced(space);
    Ok(check_exact(&chain, asked, &Options::default())?.value)
}

/// Two ways to a goal with a reward for each try, and a place where one can go round for ever.
const ERRAND: &str = "mdp
  module robot
    x : [0..4];
    [risk] x=0 -> 2/5:(x'=1) + 3/5:(x'=2);
    [try]  x=0 -> 3/10:(x'=1) + 7/10:(x'=0);
    [left] x=1 -> (x'=3);
    [right] x=1 -> (x'=4);
    [back] x=3 -> (x'=1);
    [back] x=4 -> (x'=1);
    [] x=2 -> true;
  endmodule
  label \"left\" = x=3;
  label \"right\" = x=4;
  rewards [risk] true : 1; [try] true : 2; x=3 : 3; x=4 : 1; endrewards";

#[test]
fn each_kind_of_question_has_a_scheduler_that_attains_its_known_value() {
    let model = model(ERRAND);
    let space = explore::<Rational>(&model).unwrap();
    let q = |above: i64, below: i64| Rational::new(above.into(), below.into());
    let known = [
        ("Pmax=? [ X x=1 ]", q(2, 5)),
        // To try, then to risk it.
        ("Pmax=? [ F<=2 x=1 ]", q(58, 100)),
        ("Pmin=? [ F<=2 x=1 ]", q(40, 100)),
        ("Pmin=? [ G<=2 x=0 ]", q(0, 1)),
        ("Pmax=? [ true U[2,3] x=1 ]", q(706, 1000)),
        ("Pmax=? [ F>=5 x=1 ]", q(1, 1)),
        ("Pmax=? [ (G F \"left\") & (G F \"right\") ]", q(1, 1)),
        ("Pmin=? [ F G !\"left\" ]", q(0, 1)),
        ("Pmax=? [ (X \"left\") | (X (X \"left\")) ]", q(2, 5)),
        ("Rmin=? [ F x=1 ]", q(20, 3)),
        ("Rmax=? [ C<=2 ]", q(34, 10)),
        ("Rmax=? [ I=2 ]", q(12, 10)),
        (
            "Rmin=? [ F (\"left\" & (X (x=1 & (X \"right\")))) ]",
            q(29, 3),
        ),
        ("Pmax=? [ F x=1 || F<=1 x!=0 ]", q(1, 1)),
        ("Pmin=? [ F x=1 || F<=1 x!=0 ]", q(2, 5)),
        ("P>=1/4 [ F<=2 x=1 ]", q(1, 1)),
    ];
    for (text, expected) in known {
        let asked = &properties(text, &model)[0];
        let direct = check_exact(&space, asked, &Options::default())
            .unwrap()
            .value;
        let by_scheduler = applied(&space, asked).unwrap();
        assert_eq!(direct, by_scheduler, "{text}");
        match direct {
            AnswerValue::Truth(holds) => assert!(holds, "{text}"),
            value => assert_eq!(value, AnswerValue::Exact(expected), "{text}"),
        }
    }
    // Averages are of the sound method: (3 + 0) / 2 for going left and back for ever.
    let space = explore::<f64>(&model).unwrap();
    let asked = &properties("Rmax=? [ S ]", &model)[0];
    let found = scheduler(&space, asked, &Options::default()).unwrap();
    let answer = check_space(&found.induced(&space), asked, &Options::default()).unwrap();
    let AnswerValue::Number(value) = answer.value else {
        panic!("{answer:?}")
    };
    assert!((value - 1.5).abs() < 1e-9, "{value}");
}

#[test]
fn the_memory_is_the_number_of_steps_and_a_variable_of_the_chain() {
    let model = model(ERRAND);
    let space = explore::<f64>(&model).unwrap();
    let asked = &properties("Pmax=? [ F<=2 x=1 ]", &model)[0];
    let found = scheduler(&space, asked, &Options::default()).unwrap();
    let Scheduler::WithMemory(memory) = &found else {
        panic!("{found:?}")
    };
    assert_eq!(memory.meaning, Meaning::Steps);
    let action = |place: usize| {
        let row = memory.nodes[place].moves[0].row;
        space
            .action(row)
            .map(|action| space.actions()[action].as_str())
    };
    let chain = found.induced(&space);
    assert_eq!(chain.describe(0), "(x=0,_mem=0)");
    assert_eq!(action(0), Some("try"));
    let again = (0..chain.num_states()).find(|s| chain.describe(*s) == "(x=0,_mem=1)");
    assert_eq!(action(again.unwrap()), Some("risk"));
    // An inner operator speaks of the model, all of its schedulers: of states, which are then like a label.
    let inner = properties("Pmax=? [ F<=2 (P>=1 [ X true ] & x=1) ]", &model);
    assert_eq!(
        scheduler(&space, &inner[0], &Options::default()).unwrap(),
        found
    );
    // What is not asked for by a scheduler is refused.
    for refused in ["filter(max, Pmax=? [ F x=1 ])", "Pmax=? [ F x=1 ] + 1"] {
        let asked = &properties(refused, &model)[0];
        let error = scheduler(&space, asked, &Options::default()).unwrap_err();
        assert!(error.to_string().contains("no scheduler"), "{error}");
    }
}

/// The same numbers for the same seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

const STATES: u64 = 6;

fn random_model(dice: &mut Dice) -> String {
    let mut text = format!("mdp module m x : [0..{}];\n", STATES - 1);
    for state in 0..STATES {
        for _ in 0..1 + dice.below(3) {
            let action = ["a", "b", "c"][dice.below(3) as usize];
            let (first, second) = (dice.below(STATES), dice.below(STATES));
            let p = 1 + dice.below(4);
            text += &format!(
                "[{action}] x={state} -> {p}/5:(x'={first}) + {}/5:(x'={second});\n",
                5 - p
            );
        }
    }
    text += "endmodule\n";
    for label in ["p", "r"] {
        let states = (0..STATES).filter(|_| dice.below(3) == 0);
        let states: Vec<String> = states.map(|s| format!("x={s}")).collect();
        let states = if states.is_empty() {
            "x=5".to_owned()
        } else {
            states.join(" | ")
        };
        text += &format!("label \"{label}\" = {states};\n");
    }
    text + &format!(
        "rewards x={} : 2; [a] x={} : 1; [b] x>{} : 3/2; endrewards\n",
        dice.below(STATES),
        dice.below(STATES),
        dice.below(STATES)
    )
}

const PATHS: [&str; 13] = [
    "X \"p\"",
    "F \"p\"",
    "\"p\" U \"r\"",
    "F<=3 \"r\"",
    "(!\"p\") U[1,3] \"r\"",
    "F>=2 \"r\"",
    "G<=3 !\"p\"",
    "G F \"p\"",
    "F G !\"p\"",
    "(G F \"p\") & (F G !\"r\")",
    "(G F \"p\") & (G F \"r\")",
    "G (\"p\" => (F \"r\"))",
    "(F (\"p\" & (X \"p\"))) | (G F \"r\")",
];

#[test]
fn chains_of_schedulers_of_random_models_have_the_value() {
    let mut dice = Dice(20201);
    let (mut checked, mut without) = (0, 0);
    for _ in 0..25 {
        let text = random_model(&mut dice);
        let model = model(&text);
        let space = explore::<Rational>(&model).unwrap();
        let mut all = String::new();
        for opt in ["max", "min"] {
            for path in PATHS {
                all += &format!("P{opt}=? [ {path} ];\n");
            }
            all += &format!(
                "P{opt}=? [ F \"p\" || F<=2 \"r\" ];\nP{opt}=? [ G F \"p\" || F G !\"r\" ];\n"
            );
            for reward in ["F \"p\"", "C", "C<=4", "I=3", "F (\"p\" & (X \"r\"))"] {
                all += &format!("R{opt}=? [ {reward} ];\n");
            }
        }
        for (asked, line) in properties(&all, &model).iter().zip(all.lines()) {
            let direct = check_exact(&space, asked, &Options::default())
                .unwrap()
                .value;
            match applied(&space, asked) {
                Ok(value) => assert_eq!(value, direct, "{line}\n{text}"),
                Err(CheckError::Unsupported(why)) => {
                    // Conditions that no scheduler, or every one, tells apart.
                    assert!(line.contains("||"), "{line}: {why}");
                    without += 1;
                    continue;
                }
                Err(error) => panic!("{line}: {error}\n{text}"),
            }
            checked += 1;
        }
        averages(&model);
    }
    assert!(checked > 900 && without < 60, "{checked} {without}");
}

fn averages(model: &Model) {
    let space = explore::<f64>(model).unwrap();
    for asked in properties("Rmax=? [ S ]; Rmin=? [ S ]", model) {
        let direct = check_space(&space, &asked, &Options::default())
            .unwrap()
            .value;
        let found = scheduler(&space, &asked, &Options::default()).unwrap();
        let answer = check_space(&found.induced(&space), &asked, &Options::default()).unwrap();
        let (AnswerValue::Number(direct), AnswerValue::Number(value)) = (&direct, &answer.value)
        else {
            panic!("{direct:?} {answer:?}")
        };
        assert!(
            (direct - value).abs() <= 2e-6 * direct.abs(),
            "{direct} {value}"
        );
    }
}

/// Each objective on its own, as a question to a chain.
fn alone(objectives: &str) -> Vec<String> {
    let inner = objectives
        .trim_start_matches("multi(")
        .trim_end_matches(')');
    let questions = inner.split("; ").map(|objective| {
        let (operator, rest) = objective.split_at(objective.find(" [").expect("a bracket"));
        let end = operator
            .find(['<', '>', '=', 'm'])
            .expect("a bound or a question");
        format!("{}max=?{rest}", &operator[..end])
    });
    questions.collect()
}

#[test]
fn several_objectives_have_a_mixture_that_achieves_them() {
    let text = ERRAND.replace(
        "rewards [risk] true : 1; [try] true : 2; x=3 : 3; x=4 : 1;",
        "rewards \"cost\" [risk] true : 1; [try] true : 2;",
    );
    let model = model(&text);
    let space = explore::<Rational>(&model).unwrap();
    let q = |above: i64, below: i64| Rational::new(above.into(), below.into());
    let value = |space: &StateSpace<Rational>, asked: &Property| match check_exact(
        space,
        asked,
        &Options::default(),
    )
    .unwrap()
    .value
    {
        AnswerValue::Exact(value) => value,
        other => panic!("{other:?}"),
    };
    // What is asked, with `; ` between the objectives, and for each what must come out: at least (1), at most (-1) or just so.
    let known = [
        // To risk it costs 1 and succeeds in 2 of 5, to try costs 2 for each of 10/3 tries: a mixture of both.
        (
            "multi(Pmax=? [ F x=1 ]; R{\"cost\"}<=4 [ C ])",
            vec![(0, q(0, 1)), (-1, q(4, 1))],
        ),
        (
            "multi(R{\"cost\"}<=4 [ C<=9 ]; P>=7/10 [ F x=1 ])",
            vec![(-1, q(4, 1)), (1, q(7, 10))],
        ),
        // The errands need to go round for ever.
        (
            "multi(P>=1/4 [ F (G !\"left\") ]; P>=1/2 [ (G F \"left\") & (G F \"right\") ])",
            vec![(1, q(1, 4)), (1, q(1, 2))],
        ),
        (
            "multi(P>=1/5 [ G F \"left\" ]; P>1/5 [ (F x=2) & (F<=2 x=0) ]; P<=1/2 [ G F \"right\" ])",
            vec![(1, q(1, 5)), (1, q(1, 5)), (-1, q(1, 2))],
        ),
        (
            "multi(P>=58/100 [ F<=2 x=1 ]; P>=4/10 [ F x=1 ])",
            vec![(1, q(58, 100)), (1, q(4, 10))],
        ),
    ];
    for (text, expected) in known {
        let asked = &properties(&text.replace("; ", ", "), &model)[0];
        let found = scheduler_exact(&space, asked, &Options::default())
            .unwrap_or_else(|error| panic!("{text}: {error}"));
        let chain = found.induced(&space);
        for (question, (sense, bound)) in alone(text).iter().zip(expected) {
            let question = &properties(question, &model)[0];
            let reached = value(&chain, question);
            match sense {
                1 => assert!(reached >= bound, "{text}: {reached}"),
                -1 => assert!(reached <= bound, "{text}: {reached}"),
                _ => assert_eq!(reached, value(&space, asked), "{text}"),
            }
        }
    }
    let impossible = &properties("multi(P>=9/10 [ F x=1 ], R{\"cost\"}<=1 [ C ])", &model)[0];
    let refused = scheduler_exact(&space, impossible, &Options::default());
    assert!(
        matches!(refused, Err(CheckError::Unsupported(_))),
        "{refused:?}"
    );
}
