//! State spaces of all kinds of models, compositions and rewards, on models small enough to be worked out by hand.

use checker::explore::{ExploreError, ExploreOptions, explore, explore_with};
use checker::state_space::{StateSpace, TransitionRewards};
use prism_lang::resolved::ModelType;
use prism_lang::{Constants, Rational, parse_model, resolve};

fn space(text: &str) -> StateSpace<Rational> {
    let parsed = parse_model(text).into_result().expect("it parses");
    let model = resolve(&parsed, &Constants::new()).expect("a correct model");
    explore(&model).expect("it explores")
}

/// Action, then target and value, of each choice.
type Choices<'a> = Vec<(Option<&'a str>, Vec<(String, Rational)>)>;

fn q(numerator: i64, denominator: i64) -> Rational {
    Rational::new(numerator.into(), denominator.into())
}

/// Action, then target and value, of each choice of a state.
fn choices(space: &StateSpace<Rational>, state: usize) -> Choices<'_> {
    let row = |choice: usize| {
        let entries = space.matrix.row(choice);
        entries
            .map(|(to, p)| (space.describe(to), p.clone()))
            .collect()
    };
    let action = |c| space.action(c).map(|a| space.actions()[a].as_str());
    space.choices(state).map(|c| (action(c), row(c))).collect()
}

fn at(space: &StateSpace<Rational>, state: &str) -> usize {
    let found = (0..space.num_states()).find(|s| space.describe(*s) == state);
    found.unwrap_or_else(|| panic!("no state {state}"))
}

const TWO: &str = "
module a x : [0..2]; [go] x=0 -> 1/2:(x'=1) + 1/2:(x'=2); [] x=0 -> (x'=1); [on] x=1 -> (x'=2); endmodule
module b y : [0..1]; [go] y=0 -> 1/3:(y'=1) + 2/3:true; [go] true -> (y'=0); endmodule
rewards \"r\" x=0 : 3; true : y; [go] x=0 : 4; [on] true : 5; [] true : 1/2; endrewards
";

#[test]
fn a_decision_process_keeps_each_choice_with_its_action() {
    let space = space(&format!("mdp {TWO}"));
    assert_eq!(space.kind, ModelType::Mdp);
    let s0 = at(&space, "(x=0,y=0)");
    let found = choices(&space, s0);
    let to = |name: &str, p| (name.to_owned(), p);
    let expected = vec![
        (None, vec![to("(x=1,y=0)", q(1, 1))]),
        (
            Some("go"),
            vec![
                to("(x=1,y=0)", q(1, 3)),
                to("(x=1,y=1)", q(1, 6)),
                to("(x=2,y=1)", q(1, 6)),
                to("(x=2,y=0)", q(1, 3)),
            ],
        ),
        (
            Some("go"),
            vec![to("(x=1,y=0)", q(1, 2)), to("(x=2,y=0)", q(1, 2))],
        ),
    ];
    let sorted = |mut list: Choices<'_>| {
        list.iter_mut().for_each(|(_, row)| row.sort());
        format!("{list:?}")
    };
    assert_eq!(sorted(found), sorted(expected));
    // x=2 has nothing to do.
    let ends = [at(&space, "(x=2,y=0)"), at(&space, "(x=2,y=1)")];
    let mut deadlocks = space.deadlocks().to_vec();
    deadlocks.sort_unstable();
    assert!(ends.iter().all(|e| deadlocks.contains(e)) && deadlocks.len() == 2);
    let rewards = space.rewards(space.reward_index("r").unwrap()).unwrap();
    assert_eq!(rewards.state[s0], q(3, 1));
    assert_eq!(rewards.state[at(&space, "(x=1,y=1)")], q(1, 1));
    let TransitionRewards::Row(of_choices) = &rewards.transition else {
        panic!("per choice")
    };
    assert_eq!(of_choices[space.choices(s0)], [q(1, 2), q(4, 1), q(4, 1)]);
    assert_eq!(of_choices[space.choices(ends[0])], [q(0, 1)]);
}

#[test]
fn merged_transitions_of_a_chain_earn_the_mean_of_their_actions() {
    let space = space(&format!("dtmc {TWO}"));
    // Three choices in (0,0): alone to (1,0); twice together.
    let s0 = at(&space, "(x=0,y=0)");
    let target = at(&space, "(x=1,y=0)");
    let entries: Vec<_> = space.matrix.row(s0).collect();
    let place = entries.iter().position(|(to, _)| *to == target).unwrap();
    assert_eq!(*entries[place].1, (q(1, 1) + q(1, 3) + q(1, 2)) / q(3, 1));
    let rewards = space.rewards(0).unwrap();
    let TransitionRewards::Entry(each) = &rewards.transition else {
        panic!("per entry")
    };
    let mean = (q(1, 2) + q(4, 1) * q(5, 6)) / (q(1, 1) + q(5, 6));
    assert_eq!(each[space.matrix.row_start[s0] + place], mean);
}

#[test]
fn rates_of_synchronised_commands_multiply_and_of_choices_add_up() {
    let text = "ctmc module a x : [0..1]; [t] x=0 -> 2:(x'=1); [] x=0 -> 5:(x'=1); endmodule
        module b y : [0..1]; [t] true -> 3:true; [t] true -> 4:(y'=1-y); endmodule";
    let space = space(text);
    let s0 = at(&space, "(x=0,y=0)");
    let row = choices(&space, s0).remove(0).1;
    assert_eq!(
        row,
        [
            ("(x=1,y=0)".to_owned(), q(11, 1)),
            ("(x=1,y=1)".to_owned(), q(8, 1))
        ]
    );
    let end = at(&space, "(x=1,y=0)");
    assert_eq!(
        choices(&space, end)[0].1,
        [("(x=1,y=0)".to_owned(), q(1, 1))]
    );
    assert!(space.deadlocks().contains(&end));
}

#[test]
fn compositions_hide_rename_and_interleave() {
    let modules = "mdp
        module a x : [0..1]; [s] x=0 -> (x'=1); endmodule
        module b y : [0..1]; [s] y=0 -> (y'=1); endmodule
        module c z : [0..1]; [t] z=0 -> (z'=1); endmodule ";
    let count = |system: &str| {
        let text = format!("{modules} {system}");
        let space = space(&text);
        let actions: Vec<_> = (choices(&space, 0).into_iter())
            .map(|(action, _)| action.map(str::to_owned))
            .collect();
        (space.num_states(), actions)
    };
    let some = |names: &[&str]| {
        names
            .iter()
            .map(|n| Some((*n).to_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(count(""), (4, some(&["s", "t"])));
    assert_eq!(
        count("system a || b || c endsystem"),
        (4, some(&["s", "t"]))
    );
    assert_eq!(
        count("system (a ||| b) || c endsystem"),
        (8, some(&["s", "s", "t"]))
    );
    assert_eq!(
        count("system (a |[s]| b) / {s} || c endsystem"),
        (4, vec![None, Some("t".to_owned())])
    );
    assert_eq!(
        count("system a || b || c {t <- s} endsystem"),
        (2, some(&["s"]))
    );
    // `s` of the pair is blocked by `c`, which takes part and never does it.
    assert_eq!(
        count("system (a ||| b) |[s]| c endsystem"),
        (2, some(&["t"]))
    );
    assert_eq!(
        count("system ((a ||| b) |[s]| c) / {t} endsystem"),
        (2, vec![None])
    );
}

#[test]
fn a_labelled_transition_system_has_one_target_for_each_choice() {
    let space = space(
        "module m x : [0..2]; [a] x=0 -> (x'=1); [b] x=0 -> (x'=2); [] x>0 -> true; endmodule",
    );
    assert_eq!(space.kind, ModelType::Lts);
    assert_eq!((space.num_states(), space.num_choices()), (3, 4));
    assert!(space.matrix.value.iter().all(|p| *p == q(1, 1)));
}

#[test]
fn a_reward_without_value_spoils_its_structure_only() {
    let text = "dtmc module m x : [0..2]; [] x<2 -> (x'=x+1); [] x=2 -> true; endmodule
        rewards \"bad\" true : 1/(2-x); endrewards rewards \"good\" true : -x; endrewards";
    let parsed = parse_model(text).into_result().unwrap();
    let model = resolve(&parsed, &Constants::new()).unwrap();
    let space: StateSpace<f64> = explore(&model).unwrap();
    let error = space.rewards(0).unwrap_err();
    assert!(
        matches!(error, ExploreError::NoValue { state, .. } if state == "(x=2)"),
        "{error}"
    );
    assert_eq!(space.rewards(1).unwrap().state, [0.0, -1.0, -2.0]);
    assert_eq!(space.rewards(1).unwrap().relative_error, 0.0);
}

#[test]
fn several_initial_states_come_first_and_unbounded_integers_are_checked() {
    let several =
        space("ctmc module m x : [0..3]; [] x<3 -> x+1:(x'=x+1); endmodule init x<2 endinit");
    assert_eq!(several.initial_states(), [0, 1]);
    assert_eq!(choices(&several, 1)[0].1, [("(x=2)".to_owned(), q(2, 1))]);
    let text = "mdp module m x : int init 9223372036854775806; [] true -> (x'=x+1); endmodule";
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let error = explore::<f64>(&model).unwrap_err();
    assert!(
        error.to_string().contains("does not fit into 64 bits"),
        "{error}"
    );
}

#[test]
fn rates_and_probabilities_that_are_none_are_refused() {
    let refused = |text: &str| {
        let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
        explore::<f64>(&model).unwrap_err()
    };
    for text in [
        "ctmc module m x : [0..2]; [] true -> x-1:(x'=1); endmodule",
        "ctmc module m x : [0..2]; [a] true -> 1e200:true; endmodule module n y : [0..1]; [a] true -> 1e200:true; endmodule",
        "mdp module m x : [0..2]; [] true -> 3/2-x:(x'=1) + x-1/2:(x'=2); endmodule",
    ] {
        assert!(
            matches!(refused(text), ExploreError::NotAProbability { .. }),
            "{text}"
        );
    }
    let sum = "mdp module m x : [0..2]; [] true -> 1/2+0*x:(x'=1) + 1/3:(x'=2); endmodule";
    assert!(matches!(refused(sum), ExploreError::ProbabilitySum { .. }));
    let range = "mdp module m x : [0..2]; [] true -> (x'=x+1); endmodule";
    assert!(matches!(
        refused(range),
        ExploreError::OutOfRange { value: 3, .. }
    ));
}

#[test]
fn weights_are_divided_by_their_sum_on_request_only() {
    let text = "dtmc module m x : [0..2]; [] x=0 -> 2+x:(x'=1); [] x=0 -> 6-x:(x'=2); endmodule
        rewards [] true : 1; endrewards";
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    assert!(matches!(
        explore::<Rational>(&model),
        Err(ExploreError::ProbabilitySum { .. })
    ));
    let options = ExploreOptions {
        probabilities_are_weights: true,
        rewards: Some(Vec::new()),
        ..ExploreOptions::default()
    };
    let space: StateSpace<Rational> = explore_with(&model, options, &|_| true).unwrap();
    let row: Vec<_> = space.matrix.row(0).map(|(_, p)| p.clone()).collect();
    assert_eq!(row, [q(1, 4), q(3, 4)]);
    assert_eq!(space.rewards(0), Err(&ExploreError::RewardsLeftOut));
}

#[test]
fn memory_is_limited_with_a_message() {
    let text = "ctmc module m x : [0..999999]; [] x<999999 -> 2:(x'=x+1); endmodule";
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let options = ExploreOptions {
        max_bytes: 4 << 20,
        ..ExploreOptions::default()
    };
    let error = explore_with::<f64>(&model, options, &|_| true).unwrap_err();
    let ExploreError::TooMuchMemory { states, limit } = error else {
        panic!("{error}")
    };
    // At least 8 bytes for the state, 12 for its transition, 8 for the row.
    assert!(states > 10_000 && states * 28 < limit, "{states}");
}
