//! Bounds in time.

use super::oracle::{Iteration, certified, holds};

#[test]
fn time_passes_in_intervals() {
    let text = "ctmc module m s : [0..2]; [] s=0 -> 2:(s'=1); [] s=1 -> 3:(s'=2); endmodule
        rewards s=0 : 5; endrewards";
    let e = |x: f64| (-x).exp();
    holds(text, "P=? [ F<=0.5 s>0 ]", 1.0 - e(1.0));
    holds(text, "P=? [ G<=1000 s=0 ]", 0.0);
    holds(text, "P=? [ F<=1 s=2 ]", 1.0 - 3.0 * e(2.0) + 2.0 * e(3.0));
    holds(
        text,
        "P=? [ s<2 U[0.5,1] s=1 ]",
        3.0 * e(1.0) - 2.0 * e(1.5) - e(2.0),
    );
    holds(text, "P=? [ F>=1 s=0 ]", e(2.0));
    holds(text, "R=? [ I=0.5 ]", 5.0 * e(1.0));
    holds(text, "R=? [ C<=0.5 ]", 2.5 * (1.0 - e(1.0)));
    holds(text, "R=? [ F s=2 ]", 2.5);
    // What cannot happen has exactly no probability.
    for asked in ["P=? [ G<=40 s=1 ]", "P=? [ s=2 U[0.1,2] s=1 ]"] {
        let found = certified(text, asked, &mut Iteration::new(0.0, 0.0)).unwrap();
        assert_eq!((found.low, found.high), (0.0, 0.0), "{asked}");
    }
}

#[test]
fn bounds_in_time_are_combined() {
    let ends = "ctmc module a a : [0..1]; [] a=0 -> 2:(a'=1); endmodule
        module b b : [0..1]; [] b=0 -> 3:(b'=1); endmodule";
    let e = |x: f64| (-x).exp();
    for (asked, expected) in [
        ("(F<=1 a=1) & (F<=2 b=1)", (1.0 - e(2.0)) * (1.0 - e(6.0))),
        ("(G<=1 a=0) & (F[1,2] a=1)", e(2.0) * (1.0 - e(2.0))),
        ("(G<=1 a=0) & (F<=1 a=1)", 0.0),
        ("(G<=1 a=0) | (F<=1 a=1)", 1.0),
        (
            "(a=0 U[0.5,1.5] a=1) & (b=0 U[1,2] b=1)",
            (e(1.0) - e(3.0)) * (e(3.0) - e(6.0)),
        ),
        // An end of its own for the one and none for the other, which is after it.
        ("(F<=1 a=1) & (b=0 U>=1 b=1)", (1.0 - e(2.0)) * e(3.0)),
        // Which comes first, and when: machines read jumps.
        ("(F<=1 a=1) & (b=0 U a=1)", 0.4 * (1.0 - e(5.0))),
        ("(F<=1 a=1) & (X a=1)", 0.4 * (1.0 - e(5.0))),
        (
            "!((F<=1 a=1) & (X a=1)) & (F G b=1)",
            1.0 - 0.4 * (1.0 - e(5.0)),
        ),
        ("(G F b=1) => (b=1 W<=1 a=1)", 0.0),
        (
            "(F<=1 a=1) <=> (F<=1 b=1)",
            (1.0 - e(2.0)) * (1.0 - e(3.0)) + e(5.0),
        ),
    ] {
        holds(ends, &format!("P=? [ {asked} ]"), expected);
    }
    // At four times, each after the other.
    let switch =
        "ctmc module m on : bool; [] on -> 3:(on'=false); [] !on -> 2:(on'=true); endmodule";
    let on_after = |time: f64| 0.4 * (1.0 - e(5.0 * time));
    let off_after_on = |time: f64| 0.6 * (1.0 - e(5.0 * time));
    holds(
        switch,
        "P=? [ (F[1,1] on) & (F[2,2] !on) & (F[4,4] on) & (G F on) ]",
        on_after(1.0) * off_after_on(1.0) * on_after(2.0),
    );
}
