//! Comparisons with the value itself.

use prism_lang::Rational;

use super::oracle::{Iteration, certified};
use super::{WALK, truth};

#[test]
fn a_bound_that_is_the_value_is_decided_by_the_value_itself() {
    let of = |numbers: &[(i64, i64)]| -> Vec<Rational> {
        let ratio = |(a, b): &(i64, i64)| Rational::new((*a).into(), (*b).into());
        numbers.iter().map(ratio).collect()
    };
    // In the order in which states are found: 1, 0, 2, 3.
    let reached = of(&[(1, 13), (0, 1), (4, 13), (1, 1)]);
    let steps = of(&[(2, 5), (0, 1), (2, 5), (0, 1)]);
    let asked = |values: &[Rational], asked: &str| {
        let mut oracle = Iteration::new(0.0, 0.0);
        oracle.exact = Some(values.to_vec());
        certified(WALK, asked, &mut oracle).map(|found| found.truth)
    };
    for (text, expected) in [
        ("P>=1/13 [ F s=3 ]", true),
        ("P>1/13 [ F s=3 ]", false),
        ("P<=1/13 [ F s=3 ]", true),
        ("P<1/13 [ F s=3 ]", false),
        ("P=? [ F s=3 ] = 1/13", true),
        ("filter(count, P>=4/13 [ F s=3 ]) = 2", true),
        // The contrary of what is asked.
        ("P>=12/13 [ G s<3 ]", true),
        ("P>12/13 [ G s<3 ]", false),
    ] {
        assert_eq!(asked(&reached, text), Ok(Some(expected)), "{text}");
    }
    // A little beside it, or not a solution in a state that does not matter.
    for (place, by) in [
        (0, (1, 10_i64.pow(18))),
        (3, (1, 10_i64.pow(18))),
        (2, (-1, 7)),
    ] {
        let mut wrong = reached.clone();
        wrong[place] += Rational::new(by.0.into(), by.1.into());
        assert!(asked(&wrong, "P>=1/13 [ F s=3 ]").is_err(), "{place}");
    }
    assert!(asked(&steps, "P>=1/13 [ F s=3 ]").is_err());
    // Within steps nothing is asked.
    for (text, expected) in [
        ("P>=1/16 [ F<=2 s=3 ]", true),
        ("P>1/16 [ F<=2 s=3 ]", false),
        ("P<=3/4 [ X s=0 ]", true),
        ("R>=5/4 [ C<=2 ]", true),
        ("R>5/4 [ C<=2 ]", false),
    ] {
        assert_eq!(truth(WALK, text), Some(expected), "{text}");
    }
}

#[test]
fn cycles_have_no_value_of_their_own() {
    // Any number solves the equation of a state that is never left: without progress it is none.
    let text = "mdp module m s : [0..2]; [] s=0 -> true; [] s=0 -> 1/3:(s'=1) + 2/3:(s'=2);
        [] s>0 -> true; endmodule";
    let of = |numbers: [i64; 3]| numbers.map(|n| Rational::new(n.into(), 3.into()));
    for (values, good) in [([1, 3, 0], true), ([2, 3, 0], false), ([3, 3, 0], false)] {
        let mut oracle = Iteration::new(0.0, 0.0);
        oracle.exact = Some(of(values).to_vec());
        let found = certified(text, "P<=1/3 [ F s=1 ]", &mut oracle);
        assert_eq!(
            found.map(|found| found.truth) == Ok(Some(true)),
            good,
            "{values:?}"
        );
    }
}
