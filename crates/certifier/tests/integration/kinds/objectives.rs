//! Several objectives.

use certifier::Failure;

use super::oracle::{Elimination, Iteration, certified, holds};
use super::truth;

#[test]
fn several_objectives_have_weights_and_mixtures() {
    let text = "mdp module m s : [0..4];
        [x] s=0 -> (s'=1); [y] s=0 -> (s'=2); [z] s=0 -> 1/2:(s'=1) + 1/4:(s'=2) + 1/4:(s'=3);
        [] s=1 -> true; [] s=1 -> (s'=4); [] s=4 -> (s'=1); [] s=2 | s=3 -> true; endmodule
        rewards [x] true : 4; [y] true : 1; [z] true : 1; endrewards";
    holds(text, "multi(Pmax=? [ F s=1 ], P>=0.3 [ F s=2 ])", 0.7);
    holds(
        text,
        "multi(Pmin=? [ F s=1 ], P<=0.3 [ F s=2 ])",
        7.0 / 15.0,
    );
    // All of z earns 1; the rest, a third, of what is left earns 3 more for 1/2.
    holds(text, "multi(Pmax=? [ F s=1 ], R<=2 [ C<=3 ])", 2.0 / 3.0);
    holds(text, "multi(Rmin=? [ C<=1 ], P>=0.75 [ F s=1 ])", 2.5);
    holds(
        text,
        "multi(Rmin=? [ C<=1 ], P>=0.6 [ F s=1 ], P>=0.3 [ F s=2 ])",
        2.2,
    );
    // In one component both can recur, but not both what recurs and what ends.
    holds(text, "multi(Pmax=? [ G F s=4 ], P>=0.25 [ F G s=1 ])", 0.75);
    holds(text, "multi(Pmax=? [ G F s=4 ], P>=0.9 [ G F s=1 ])", 1.0);
    for (asked, expected) in [
        ("multi(P>=0.4 [ F s=1 ], P>=0.5 [ F s=2 ])", true),
        ("multi(P>=0.6 [ F s=1 ], P>=0.5 [ F s=2 ])", false),
        ("multi(P>=0.6 [ F s=1 ], R<=1.5 [ C<=2 ])", false),
        ("multi(P>=0.55 [ F s=1 ], R<1.5 [ C<=2 ])", true),
        // Nothing meets these, so that there is no greatest value.
        (
            "multi(Pmax=? [ F s=3 ], P>=0.6 [ F s=1 ], P>=0.5 [ F s=2 ])",
            false,
        ),
    ] {
        assert_eq!(truth(text, asked), Some(expected), "{asked}");
    }
    // On the boundary nothing is claimed that does not hold.
    let boundary = "multi(P>=0.5 [ F s=1 ], P>0.5 [ F s=2 ])";
    let found = certified(text, boundary, &mut Iteration::new(0.0, 0.0));
    assert_ne!(found.map(|found| found.truth), Ok(Some(true)));
}

#[test]
fn what_is_earned_for_ever_among_several_objectives_is_shown_exactly() {
    // To 3 with 1/2 each time, for 2; to 4 at once, for 5; to 3 for 1, which fails with 1/4.
    let text = "mdp module m s : [0..5]; [a] s=0 -> 1/2:(s'=3) + 1/2:(s'=0); [b] s=0 -> (s'=4);
        [c] s=0 -> 3/4:(s'=3) + 1/4:(s'=5); [] s>2 -> true; endmodule
        rewards [a] true : 2; [b] true : 5; [c] true : 1; endrewards";
    let curve = |asked: &str| {
        let mut oracle = Elimination(Iteration::new(0.0, 0.0));
        certified(text, asked, &mut oracle).unwrap().curve.unwrap()
    };
    let value = |asked: &str| {
        let mut oracle = Elimination(Iteration::new(0.0, 0.0));
        let found = certified(text, asked, &mut oracle).unwrap_or_else(|e| panic!("{asked}: {e}"));
        assert!(found.high - found.low <= 1e-8, "{asked}: {found:?}");
        found.low
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-8, "{a} {b}");
    // A third of b, the rest c; 0.4 of c, the rest a; half of b, half of c.
    near(value("multi(Rmin=? [ C ], P>=1/3 [ F s=4 ])"), 7.0 / 3.0);
    near(
        value("multi(Rmin=? [ C ], P>=0.9 [ F s=3 ])"),
        0.4 + 0.6 * 4.0,
    );
    near(value("multi(Rmax=? [ C<=1 ], R<=3 [ C ])"), 3.0);
    let both = curve("multi(Rmin=? [ C ], Pmax=? [ F s=3 ])");
    assert_eq!(both.has_corners(&[[1.0, 0.75], [4.0, 1.0]]), Some(true));
    assert_eq!(both.has_corners(&[[1.0, 0.75], [3.9, 1.0]]), Some(false));
    assert_eq!(both.has_corners(&[[1.0, 0.75], [4.1, 1.0]]), Some(false));
    let both = curve("multi(Pmin=? [ F s=5 ], Pmax=? [ F s=4 ])");
    assert_eq!(both.has_corners(&[[0.0, 1.0]]), Some(true));
    let both = curve("multi(Pmax=? [ F s=3 ], Pmax=? [ F s=4 ])");
    assert_eq!(both.has_corners(&[[0.0, 1.0], [1.0, 0.0]]), Some(true));
    assert_eq!(both.has_corners(&[[0.5, 0.5]]), Some(false));
    // What should be large is without bound where it is earned for ever.
    let text =
        "mdp module m s : [0..1]; [a] s=0 -> true; [b] s=0 -> (s'=1); [] s=1 -> true; endmodule
        rewards [a] true : 1; endrewards";
    let asked = "multi(Rmax=? [ C ], P>=0.5 [ F s=1 ])";
    let found = certified(text, asked, &mut Elimination(Iteration::new(0.0, 0.0)));
    assert!(matches!(found, Err(Failure::Unsupported(_))), "{found:?}");
}
