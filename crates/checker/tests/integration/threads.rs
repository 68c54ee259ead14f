//! The state space is the same on one thread and on two, and so is the first error.

use checker::explore::{ExploreError, ExploreOptions, explore_with};
use checker::state_space::StateSpace;
use checker::symmetry::Symmetry;
use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};

fn explored(text: &str, threads: usize) -> Result<StateSpace<f64>, ExploreError> {
    let tree = parse_model(text).into_result().expect("it parses");
    let model = resolve(&tree, &Constants::new()).expect("a correct model");
    let options = ExploreOptions {
        threads,
        ..ExploreOptions::default()
    };
    explore_with(&model, options, &|_| true)
}

/// Four counters, so that many states are open at a time.
fn counters(kind: &str, top: i64, extra: &str) -> String {
    let module = |name: &str| {
        format!(
            "module m{name} {name} : [0..18]; [] {name}<{top} -> 0.3:({name}'={name}+1) + 0.7:true;
             [s] {name}>1 -> ({name}'={name}-2); endmodule "
        )
    };
    let modules: String = ["a", "b", "c", "d"].map(module).concat();
    format!("{kind} {modules} {extra} rewards \"r\" a=b : 0.1; [s] true : c; endrewards")
}

#[test]
fn two_threads_give_the_same_bytes_as_one() {
    for kind in ["dtmc", "ctmc", "mdp"] {
        let text = counters(kind, 12, "");
        let (one, two) = (explored(&text, 1).unwrap(), explored(&text, 2).unwrap());
        assert_eq!(one.num_states(), 13_usize.pow(4));
        assert!(one.matrix == two.matrix && one.choice_start == two.choice_start);
        assert_eq!(one.choice_action, two.choice_action);
        let values =
            |s: &StateSpace<f64>| (0..s.num_states()).map(|x| s.state(x)).collect::<Vec<_>>();
        assert!(values(&one) == values(&two));
        assert_eq!(one.rewards(0), two.rewards(0));
        assert_eq!(one.deadlocks(), two.deadlocks());
        assert_eq!(one.relative_error(), two.relative_error());
    }
}

#[test]
fn two_threads_give_the_same_bytes_as_one_up_to_symmetry() {
    let tree = parse_model(&counters("mdp", 18, "")).into_result().unwrap();
    let model = resolve(&tree, &Constants::new()).unwrap();
    // Two of the counters may be exchanged, the others are told apart.
    let asked = parse_properties("Pmax=? [ F c=3 & d=1 ]").tree;
    let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
    let explored = |threads: usize| {
        let options = ExploreOptions {
            threads,
            symmetry: Symmetry::of(&model, [&asked[0].property]),
            ..ExploreOptions::default()
        };
        explore_with::<f64>(&model, options, &|_| true).unwrap()
    };
    let (one, two) = (explored(1), explored(2));
    assert_eq!(one.num_states(), 19_usize.pow(2) * (19 * 20 / 2));
    assert!(one.matrix == two.matrix && one.choice_start == two.choice_start);
    assert!((0..one.num_states()).all(|s| one.state(s) == two.state(s)));
    assert_eq!(one.represented(), two.represented());
    assert_eq!(one.represented().unwrap().states, 19_u64.pow(4));
}

#[test]
fn the_first_error_is_the_same() {
    let late = "module e x : [0..1]; [] a=12 & b=11 & c=10 -> (x'=a); endmodule";
    let text = counters("mdp", 12, late);
    let (one, two) = (
        explored(&text, 1).unwrap_err(),
        explored(&text, 2).unwrap_err(),
    );
    assert!(matches!(one, ExploreError::OutOfRange { .. }), "{one}");
    assert_eq!(one, two);
}

#[test]
fn states_with_very_many_transitions_are_expanded_piece_by_piece() {
    // Eleven bits that change at random together, twice: 2^11 states with 2^11 transitions each.
    let module = |i: usize| {
        format!(
            "module m{i} x{i} : bool; [t] n<2 -> 0.5:(x{i}'=true) + 0.5:(x{i}'=false); endmodule "
        )
    };
    let bits: String = (0..11).map(module).collect();
    let text = format!("mdp {bits} module c n : [0..2]; [t] n<2 -> (n'=n+1); endmodule");
    for threads in [1, 2] {
        let space = explored(&text, threads).unwrap();
        assert_eq!(space.num_states(), 1 + 2 * (1 << 11));
        assert_eq!(space.num_transitions(), (1 << 11) + (1 << 22) + (1 << 11));
    }
}
