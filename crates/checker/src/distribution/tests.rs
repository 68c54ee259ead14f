use super::*;
use crate::explore::explore;

fn space(text: &str) -> StateSpace<f64> {
    let parsed = prism_lang::parse_model(text);
    let model = prism_lang::resolve(&parsed.tree, &prism_lang::Constants::new()).unwrap();
    explore(&model).unwrap()
}

fn near(found: &Bounds, expected: f64) {
    let slack = 1e-15 * expected;
    assert!(
        found.low - slack <= expected && expected <= found.high + slack,
        "{found:?} {expected}"
    );
    assert!(
        found.high - found.low <= 1e-9 * expected + 1e-25,
        "{found:?}"
    );
}

#[test]
fn a_switch_follows_its_formula() {
    let space =
        space("ctmc module s on : [0..1]; [] on=0 -> 2:(on'=1); [] on=1 -> 3:(on'=0); endmodule");
    let options = Options::default();
    let times = ["0", "0.001", "0.7", "40"].map(|t| Number::parse(t).unwrap());
    let found = at_times(&space, None, &times, &options).unwrap();
    for (time, found) in times.iter().zip(found) {
        let on = 0.4 * -(-5.0 * time.to_f64()).exp_m1();
        near(&found[1], on);
        near(&found[0], 1.0 - on);
    }
    let shares = in_the_long_run(&space, Some(&[0.25, 0.75]), &options).unwrap();
    near(&shares[0], 0.6);
    near(&shares[1], 0.4);
}

#[test]
fn steps_and_shares_of_a_chain_with_two_ends() {
    // Stays with 1/2; then to a ring of two, or to an end, with 1/8 and 3/8.
    let space = space(
        "dtmc module s x : [0..3]; [] x=0 -> 0.5:true + 0.125:(x'=1) + 0.375:(x'=3); [] x=1 -> (x'=2);
         [] x=2 -> 0.5:(x'=1) + 0.5:true; [] x=3 -> true; endmodule",
    );
    let options = Options::default();
    let found = after_steps(&space, None, &[0, 1, 2], &options).unwrap();
    let state = |x: &str| {
        (0..4)
            .find(|s| space.describe(*s) == format!("(x={x})"))
            .unwrap()
    };
    assert_eq!(found[0][state("0")], Bounds::ONE);
    near(&found[2][state("0")], 0.25);
    near(&found[2][state("1")], 0.0625);
    near(&found[2][state("2")], 0.125);
    near(&found[2][state("3")], 0.5625);
    assert_eq!(found[1][state("2")], Bounds::ZERO);
    let shares = in_the_long_run(&space, None, &options).unwrap();
    assert_eq!(shares[state("0")], Bounds::ZERO);
    near(&shares[state("1")], 0.25 / 3.0);
    near(&shares[state("2")], 0.5 / 3.0);
    near(&shares[state("3")], 0.75);
}
