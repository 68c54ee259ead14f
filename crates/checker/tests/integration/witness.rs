//! Most probable paths that show why, for each type of model; and the chain of a scheduler as a model.

use checker::explore::explore;
use checker::{Answer, AnswerValue, Method, Options, Witness, check, check_space, witness};
use prism_lang::{
    Constants, NamedProperty, parse_model, parse_properties, resolve, resolve_properties,
};

struct Asked {
    space: checker::state_space::StateSpace<f64>,
    properties: Vec<NamedProperty>,
    answers: Vec<Answer>,
}

fn asked(text: &str, properties: &str) -> Asked {
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let properties = parse_properties(properties).tree;
    let properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
    let space = explore::<f64>(&model).unwrap();
    let options = Options::default();
    let answer = |p: &NamedProperty| check(&space, &model, &p.property, &options).unwrap();
    let answers = properties.iter().map(answer).collect();
    Asked {
        space,
        properties,
        answers,
    }
}

impl Asked {
    fn witness(&self, place: usize) -> Option<Witness> {
        let property = &self.properties[place].property;
        witness(
            &self.space,
            property,
            &self.answers[place],
            &Options::default(),
        )
        .unwrap()
    }
}

#[test]
fn in_continuous_time_the_path_is_one_of_jumps() {
    let text =
        "ctmc module m x : [0..3]; [] x=0 -> 3:(x'=1) + 1:(x'=2); [] x=1 -> 1:(x'=2) + 4:(x'=0);
        [] x=2 -> 5:(x'=3); endmodule";
    let found = asked(text, "P=? [ F x=3 ]; S=? [ x=3 ]");
    let path = found.witness(0).unwrap();
    assert_eq!(path.states, ["(x=0)", "(x=2)", "(x=3)"]);
    assert_eq!((path.probability, path.violates), (0.25, false));
    assert_eq!(found.witness(1), None);
}

#[test]
fn what_must_always_hold_is_shown_to_be_violated_within_its_bound() {
    let text = "dtmc module m x : [0..3]; [] x=0 -> 0.1:(x'=3) + 0.9:(x'=1); [] x=1 -> (x'=2);
        [] x=2 -> (x'=3); endmodule";
    let found = asked(
        text,
        "P=? [ G x<3 ]; P>=0.5 [ G<=1 x<3 ]; P=? [ (x!=1) U x=3 ]; P=? [ G x<=3 ]",
    );
    let path = found.witness(0).unwrap();
    assert!(path.violates && path.states.len() == 4 && path.probability == 0.9);
    // The most probable one takes three steps, so it shows nothing of the first.
    assert_eq!(found.witness(1), None);
    assert_eq!(found.witness(2).unwrap().states, ["(x=0)", "(x=3)"]);
    assert_eq!(found.witness(3), None);
}

#[test]
fn the_chain_of_a_scheduler_has_the_value_and_the_rewards_of_the_scheduler() {
    let text = "mdp module m x : [0..3]; [slow] x=0 -> 0.5:(x'=1) + 0.5:(x'=0); [fast] x=0 -> 0.2:(x'=1) + 0.8:(x'=3);
        [] x=1 -> (x'=2); [] x>1 -> true; endmodule
        label \"done\" = x=2;
        rewards [slow] true : 3; [fast] true : 1; x=1 : 2; endrewards";
    let found = asked(text, "Pmax=? [ F \"done\" ]; Rmin=? [ F x>=2 ]");
    for (place, expected) in [(0, 1.0), (1, 1.4)] {
        let scheduler = found.answers[place].scheduler.as_ref().unwrap();
        let chain = found.space.induced(scheduler);
        let answer = check_space(
            &chain,
            &found.properties[place].property,
            &Options::default(),
        );
        let answer = answer.unwrap();
        assert_eq!(answer.value, found.answers[place].value);
        let AnswerValue::Number(value) = answer.value else {
            panic!("{answer:?}")
        };
        assert!((value - expected).abs() < 1e-9, "{value}");
    }
    assert_eq!(
        found.witness(0).unwrap().actions[0].as_deref(),
        Some("slow")
    );
}

#[test]
fn open_comparisons_are_tried_with_tighter_bounds_before_rational_arithmetic() {
    // Iteration leaves 1e-6 open here; the bound is nearer to the value, but not the value.
    let text = "mdp module m x : [0..20] init 10; [] x>0 & x<20 -> 0.5:(x'=x+1) + 0.5:(x'=x-1);
        [] x>0 & x<20 -> 0.49:(x'=x+1) + 0.51:(x'=x-1); endmodule";
    let found = asked(text, "P<=0.50000001 [ F x=20 ]; P<0.5 [ F x=20 ]");
    assert_eq!(found.answers[0].value, AnswerValue::Truth(true));
    assert_eq!(found.answers[1].value, AnswerValue::Truth(false));
    assert_eq!(found.answers[1].method, Method::Exact);
    assert_eq!(found.answers[0].method, Method::Sound);
}
