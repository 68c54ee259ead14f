use prism_lang::resolved::Model;
use prism_lang::{Constants, NamedProperty, Rational};
use prism_lang::{parse_model, parse_properties, resolve, resolve_properties};
use proptest::prelude::*;

use super::*;
use crate::explore::{ExploreOptions, explore, explore_with};
use crate::state_space::{Represented, StateSpace};
use crate::{AnswerValue, Guarantee, Options, check_exact, check_space};

fn read(model: &str, properties: &str) -> (Model, Vec<NamedProperty>) {
    let tree = parse_model(model).into_result().expect("it parses");
    let model = resolve(&tree, &Constants::new()).expect("a correct model");
    let tree = parse_properties(properties).tree;
    let properties = resolve_properties(&tree, &model, &Constants::new()).expect("correct");
    (model, properties)
}

fn folded<N: prism_lang::Arithmetic>(model: &Model, asked: &[NamedProperty]) -> StateSpace<N> {
    let options = ExploreOptions {
        symmetry: Symmetry::of(model, asked.iter().map(|p| &p.property)),
        ..ExploreOptions::default()
    };
    explore_with(model, options, &|_| true).expect("a state space")
}

/// Bounds of a value, or of the ends of a range.
fn bounds(guarantee: &Guarantee, value: &AnswerValue) -> (f64, f64) {
    match (guarantee, value) {
        (Guarantee::Bounded { low, high }, _) => (*low, *high),
        (_, AnswerValue::Number(value)) => (*value, *value),
        (_, AnswerValue::Range { low, high }) => (*low, *high),
        other => panic!("no number: {other:?}"),
    }
}

/// Holds the states up to symmetry against all states: counts, exact values, bounds. The numbers of states, all and explored.
fn compare(model: &str, properties: &str) -> (usize, usize) {
    let (model, asked) = read(model, properties);
    let all = explore::<Rational>(&model).unwrap();
    let some = folded::<Rational>(&model, &asked);
    let counts = Represented {
        states: all.num_states() as u64,
        transitions: all.num_transitions() as u64,
        initial: all.initial_states().len() as u64,
        deadlocks: all.deadlocks().len() as u64,
    };
    assert_eq!(some.represented().unwrap_or(counts), counts);
    let sound = folded::<f64>(&model, &asked);
    assert_eq!(sound.num_states(), some.num_states());
    let options = Options::default();
    for NamedProperty { property, text, .. } in &asked {
        let continuous = text.contains("<=0.5");
        if !continuous {
            let expected = check_exact(&all, property, &options).unwrap().value;
            let found = check_exact(&some, property, &options).unwrap().value;
            assert_eq!(found, expected, "{text}");
        }
        let full = explore::<f64>(&model).unwrap();
        let expected = check_space(&full, property, &options).unwrap();
        let found = check_space(&sound, property, &options).unwrap();
        if let AnswerValue::Truth(_) = expected.value {
            assert_eq!(found.value, expected.value, "{text}");
            continue;
        }
        let expected = bounds(&expected.guarantee, &expected.value);
        let found = bounds(&found.guarantee, &found.value);
        assert!(
            found.0 <= expected.1 && expected.0 <= found.1,
            "{text} {found:?} {expected:?}"
        );
    }
    (all.num_states(), some.num_states())
}

/// Workers with a counter of what is done, in a model of this kind.
fn workers(kind: &str, renamed: &[&str]) -> String {
    let copies = renamed.iter().map(|name| {
        format!("module w{name} = wa [a={name}, busya=busy{name}, starta=start{name}] endmodule ")
    });
    let copies: String = copies.collect();
    let slots = ["a"]
        .iter()
        .chain(renamed)
        .map(|name| format!("[start{name}] free -> 1 : (free'=false); "));
    let slots: String = slots.collect();
    let back = ["a"]
        .iter()
        .chain(renamed)
        .map(|name| format!("[] !free & a>{} -> 1 : (free'=true); ", name.len()));
    let back: String = back.collect();
    format!(
        "{kind} global done : [0..3];
         module wa a : [0..2]; busya : bool;
           [starta] !busya & a<2 -> 1/2 : (busya'=true) + 1/2 : (a'=a+1);
           [] busya & done<3 -> 1/3 : (busya'=false) & (a'=0) & (done'=done+1) + 2/3 : (busya'=false);
           [tick] !busya & a=2 -> (a'=0);
         endmodule {copies}
         module slot free : bool init true; {slots} {back} [] !free -> 1/4 : (free'=true) + 3/4 : true; endmodule
         rewards \"r\" busya : 2; true : done; endrewards
         rewards \"t\" [tick] true : 1; [starta] a=1 : 3; {} endrewards",
        renamed.iter().map(|n| format!("[start{n}] {n}=1 : 3; ")).collect::<String>()
    )
}

#[test]
fn copies_of_a_module_may_be_exchanged() {
    // Commands of `slot` that say the same of one worker only spoil the symmetry; without them it is full.
    let text = |kind| workers(kind, &["b", "c"]).replace(" & a>1", "");
    let probability = |op: &str| {
        format!(
            "P{op}=? [ F a=2 & b=2 & c=2 ]; P{op}=? [ F<=7 done>1 ]; P{op}=? [ X busya | busyb | busyc ];
             R{{\"t\"}}{op}=? [ C<=6 ]; P{op}=? [ G F (done=3 & (a=1 | b=1 | c=1)) ]"
        )
    };
    for (kind, op) in [("dtmc", ""), ("mdp", "max")] {
        let (all, some) = compare(&text(kind), &probability(op));
        assert!(some * 3 < all, "{kind} {some} {all}");
    }
    let timed = "P=? [ F<=0.5 a=2 & b=2 & c=2 ]; R{\"t\"}=? [ C<=0.5 ]; S=? [ a=1 & b=1 & c=1 ]; R{\"t\"}=? [ S ];
                 P=? [ F done=2 & !free ]; P>0.1 [ F done=2 & !free ]";
    let (all, some) = compare(&text("ctmc"), timed);
    assert!(some * 3 < all, "{some} {all}");
}

#[test]
fn what_notices_one_copy_keeps_it_apart() {
    let text = workers("mdp", &["b", "c"]).replace(" & a>1", "");
    let count = |properties: &str| {
        let (model, asked) = read(&text, properties);
        folded::<f64>(&model, &asked).num_states()
    };
    let all = explore::<f64>(&read(&text, "").0).unwrap().num_states();
    let none = count("Pmax=? [ F done=3 ]");
    let one = count("Pmax=? [ F done=3 & b=1 ]");
    assert!(none < one && one < all, "{none} {one} {all}");
    // The state reward speaks of `busya` alone.
    assert_eq!(count("R{\"r\"}max=? [ C<=5 ]"), one);
    assert_eq!(compare(&text, "Pmax=? [ F done=3 & b=1 ]"), (all, one));
    assert_eq!(count("filter(count, done=3)"), all);
    assert_eq!(count("Pmax=? [ F a=1 & b=2 & c=0 ]"), all);
}

#[test]
fn differences_in_the_model_are_seen() {
    let text = workers("mdp", &["b"]).replace(" & a>1", "");
    let is_symmetric = |text: &str| {
        let (model, asked) = read(text, "Pmax=? [ F done=3 ]");
        !Symmetry::of(&model, asked.iter().map(|p| &p.property)).is_none()
    };
    assert!(is_symmetric(&text));
    // A guard of a third module, a probability, an initial value, a composition.
    assert!(!is_symmetric(&workers("mdp", &["b"])));
    assert!(!is_symmetric(&text.replace(
        "[startb] free -> 1 :",
        "[startb] free -> 1/2 : true + 1/2 :"
    )));
    let other = text.replace("module wb = wa [a=b, busya=busyb, starta=startb] endmodule", "
        module wb b : [0..2] init 1; busyb : bool;
           [startb] !busyb & b<2 -> 1/2 : (busyb'=true) + 1/2 : (b'=b+1);
           [] busyb & done<3 -> 1/3 : (busyb'=false) & (b'=0) & (done'=done+1) + 2/3 : (busyb'=false);
           [tick] !busyb & b=2 -> (b'=0);
         endmodule");
    assert!(!is_symmetric(&other));
    assert!(is_symmetric(&other.replace(" init 1", "")));
    assert!(!is_symmetric(&format!(
        "{text} system (wa ||| wb) || slot endsystem"
    )));
}

#[test]
fn two_pairs_are_exchanged_together_where_one_is_noticed() {
    let text = "ctmc
        module left n : [0..3] init 3; [] n>0 -> 0.1*n : (n'=n-1); [] n<3 -> 1 : (n'=n+1); endmodule
        module right = left [n=m] endmodule
        module here on : bool init true; [] on -> 0.5 : (on'=false); [] !on -> 2 : (on'=true); endmodule
        module there = here [on=off] endmodule
        label \"good\" = (n>=2 & on) | (off & m>=2);";
    let (all, some) = compare(text, "S=? [ \"good\" ]; P=? [ F<=0.5 !\"good\" ]");
    assert_eq!((all, some), (64, 36));
}

#[test]
fn rings_are_turned() {
    let process = |i: usize| format!("module p{i} = p1 [x1=x{i}, x7=x{}] endmodule ", i - 1);
    let others: String = (2..8).map(process).collect();
    let text = format!(
        "dtmc module p1 x1 : [0..1];
           [step] x1=x7 -> 1/2 : (x1'=0) + 1/2 : (x1'=1); [step] x1!=x7 -> (x1'=x7);
         endmodule {others} init true endinit
         rewards true : 1; endrewards
         label \"stable\" = (x1=x2?1:0)+(x2=x3?1:0)+(x3=x4?1:0)+(x4=x5?1:0)+(x5=x6?1:0)+(x6=x7?1:0)+(x7=x1?1:0)=1;"
    );
    // Necklaces of seven beads in two colours: (2^7 - 2) / 7 + 2.
    let properties = "R=? [ F \"stable\" ]; P=? [ F<=3 \"stable\" ]";
    assert_eq!(compare(&text, properties), (128, 20));
}

#[test]
fn the_order_of_evaluation_is_kept_where_it_matters() {
    let text = |b: &str| {
        format!(
            "mdp module a x : [0..2]; [] x!=0 & 2/x>1 -> (x'=0); [] x<2 -> (x'=x+1); endmodule
             module b y : [0..2]; {b} -> (y'=0); [] y<2 -> (y'=y+1); endmodule"
        )
    };
    let is_symmetric = |text: &str| {
        let (model, asked) = read(text, "Pmax=? [ F x=2 & y=2 ]");
        !Symmetry::of(&model, asked.iter().map(|p| &p.property)).is_none()
    };
    assert!(is_symmetric(&text("[] y!=0 & 2/y>1")));
    assert!(!is_symmetric(&text("[] 2/y>1 & y!=0")));
}

/// A command of a copy: its action, guard and update, in terms of its own variable `v` and of the shared `g`.
fn command() -> impl Strategy<Value = String> {
    let action = prop_oneof![Just(""), Just("s"), Just("own_v")];
    let guard = prop_oneof![
        Just("v<2"),
        Just("v=1 | g=2"),
        Just("g>0 & v!=2"),
        Just("v=g")
    ];
    let update = prop_oneof![
        Just("1/2 : (v'=2) + 1/2 : (v'=0)"),
        Just("1/3 : (v'=g) + 2/3 : true"),
        Just("(v'=2-v)"),
        Just("(v'=min(v+1,2))"),
    ];
    (action, guard, update).prop_map(|(a, g, u)| format!("[{a}] {g} -> {u};"))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]
    #[test]
    fn random_copies_have_the_values_of_all_states(
        commands in prop::collection::vec(command(), 1..4),
        kind in prop_oneof![Just("dtmc"), Just("mdp"), Just("ctmc")],
        copies in 2_usize..5,
        odd in prop::option::of(command()),
    ) {
        let module = |i: usize, commands: &[String]| {
            let body = commands.concat().replace('v', &format!("v{i}"));
            format!("module m{i} v{i} : [0..2]; {body} endmodule ")
        };
        let mut modules: String = (1..=copies).map(|i| module(i, &commands)).collect();
        if let Some(odd) = odd {
            modules += &module(9, &[odd]);
        }
        let own: String = (1..=copies).map(|i| format!("[own_v{i}] g<2 -> (g'=g+1); ")).collect();
        let all = |what: &str| (1..=copies).map(|i| format!("v{i}{what}")).collect::<Vec<_>>();
        let text = format!(
            "{kind} {modules} module shared g : [0..2]; {own} [s] g<2 -> true; [] g=2 -> 1/2 : (g'=0) + 1/2 : (g'=1); endmodule
             rewards {} : g; [s] true : 2; endrewards", all("=2").join(" | ")
        );
        let (end, most) = (all("=2").join(" & "), if kind == "mdp" { "max" } else { "" });
        let timed = match kind {
            "ctmc" => format!("P=? [ F<=0.5 {end} ]; R=? [ C<=0.5 ]; S=? [ {end} ]"),
            _ => format!("P{most}=? [ F<=4 {end} ]; R{most}=? [ C<=4 ]"),
        };
        let properties = format!("P{most}=? [ F {end} ]; P{most}=? [ (g<2 | v1=v1) U (g=2 & {}) ]; {timed}",
            all("!=1").join(" & "));
        let (all, some) = compare(&text, &properties);
        prop_assert!(some <= all);
    }
}

/// Copies of a module that move together, and a module that says which of them may go back.
fn many(copies: usize) -> String {
    let module = |i: usize| format!("module m{i} = m0 [x0=x{i}, back0=back{i}] endmodule ");
    let modules: String = (1..copies).map(module).collect();
    let slot = |i: usize| format!("[back{i}] free -> (free'=false); ");
    let slots: String = (0..copies).map(slot).collect();
    let all: Vec<String> = (0..copies).map(|i| format!("x{i}=1")).collect();
    format!(
        "mdp module m0 x0 : [0..1]; [go] x0=0 -> 1/2 : (x0'=1) + 1/2 : true; [back0] x0=1 -> (x0'=0); endmodule {modules}
         module slot free : bool; {slots} [] !free -> (free'=true); endmodule
         label \"all\" = {};",
        all.join(" & ")
    )
}

/// How many parts are brought into a normal form in the search, and the symmetries.
fn searched(copies: usize, go_on: &dyn Fn() -> bool) -> (u64, Vec<Class>) {
    let (model, asked) = read(&many(copies), "Pmax=? [ F \"all\" ]");
    let asked = Asked::of(&model, asked.iter().map(|p| &p.property)).expect("no filters");
    let mut search = Search::new(&model, &asked, go_on).expect("no rewards");
    let found = search.generators();
    let classes = classes(&found, model.variables.len());
    (search.terms.formed(), classes)
}

fn blocks_of(classes: &[Class]) -> usize {
    match classes {
        [Class::Blocks(blocks)] => blocks.len(),
        other => panic!("one class of blocks: {other:?}"),
    }
}

#[test]
fn work_grows_with_the_number_of_copies_and_not_faster() {
    let (few, classes) = searched(100, &|| true);
    assert_eq!(blocks_of(&classes), 100);
    let (many, classes) = searched(1_000, &|| true);
    assert_eq!(blocks_of(&classes), 1_000);
    assert!(many < 11 * few, "{few} {many}");
}

#[test]
fn a_search_that_is_stopped_keeps_what_it_has() {
    let left = std::cell::Cell::new(7);
    let go_on = || {
        left.set(left.get() - 1);
        left.get() > 0
    };
    let (_, classes) = searched(100, &go_on);
    assert_eq!(blocks_of(&classes), 7);
    assert_eq!(searched(100, &|| false).1, []);
}
