use super::*;
use crate::answer::{AnswerValue, Guarantee};
use crate::{check_space, explore::explore};
use prism_lang::{
    Constants, Path, StateFormula, TimeBound, Value, ast, parse_model, parse_properties,
    resolve_properties, resolve_with,
};

/// Numbers from 0 to 1: SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn reach(bound: TimeBound) -> Property {
    let label = StateFormula::Label("goal".to_owned());
    let path = Path::Finally {
        operand: Box::new(Path::State(Box::new(label))),
        bound,
    };
    Property::Probability { bound: None, path }
}

fn bounds(model: &IntervalModel, property: &Property) -> (f64, f64) {
    let answer = model.check(property, &Options::default()).unwrap();
    match answer.guarantee {
        Guarantee::Bounded { low, high } => (low, high),
        _ => match answer.value {
            AnswerValue::Number(value) => (value, value),
            _ => panic!("a number was asked for"),
        },
    }
}

/// The vertices of the rows that sum to 1 within ranges: all entries but one at an end.
fn vertices(row: &[(u32, Range)]) -> Vec<Vec<(u32, f64)>> {
    let mut found = Vec::new();
    for free in 0..row.len() {
        for ends in 0..1_u32 << row.len() {
            let mut point: Vec<(u32, f64)> = row
                .iter()
                .enumerate()
                .map(|(i, (target, range))| {
                    (
                        *target,
                        if ends >> i & 1 == 1 {
                            range.high
                        } else {
                            range.low
                        },
                    )
                })
                .collect();
            let others: f64 = (0..row.len())
                .filter(|i| *i != free)
                .map(|i| point[i].1)
                .sum();
            point[free].1 = 1.0 - others;
            let Range { low, high } = row[free].1;
            if (low - 1e-12..=high + 1e-12).contains(&point[free].1) {
                found.push(point);
            }
        }
    }
    found
}

/// Random rows of states 0, 1 and 2 to all five; 3 is the goal, 4 a trap.
fn random_rows(uniform: &mut Uniform) -> Vec<Vec<(u32, Range)>> {
    let mut rows: Vec<Vec<(u32, Range)>> = (0..3)
        .map(|_| {
            let targets: Vec<u32> = (0..5).filter(|_| uniform.next() < 0.6).collect();
            let targets = if targets.is_empty() { vec![3] } else { targets };
            let weights: Vec<f64> = targets.iter().map(|_| 0.05 + uniform.next()).collect();
            let sum: f64 = weights.iter().sum();
            let mut row = Vec::new();
            for (target, weight) in targets.into_iter().zip(weights) {
                let p = weight / sum;
                let (down, up) = (uniform.next(), uniform.next());
                let range = Range {
                    low: p * (1.0 - 0.5 * down),
                    high: (p * (1.0 + 0.5 * up)).min(1.0),
                };
                row.push((target, range));
            }
            row
        })
        .collect();
    let stay = |state| {
        vec![(
            state,
            Range {
                low: 1.0,
                high: 1.0,
            },
        )]
    };
    rows.push(stay(3));
    rows.push(stay(4));
    rows
}

/// Over all chains whose rows are vertices, the least and largest probability are the bounds.
#[test]
fn bounds_are_those_of_brute_force_over_vertices() {
    let mut uniform = Uniform(7);
    let goal = || vec![("goal".to_owned(), vec![false, false, false, true, false])];
    let property = reach(TimeBound::default());
    let mut wide = 0;
    for case in 0..60 {
        let rows = random_rows(&mut uniform);
        let model = IntervalModel::from_rows(rows.clone(), vec![0], goal()).unwrap();
        let (low, high) = bounds(&model, &property);
        let corners: Vec<_> = rows[..3].iter().map(|row| vertices(row)).collect();
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for a in &corners[0] {
            for b in &corners[1] {
                for c in &corners[2] {
                    let chain = vec![
                        a.clone(),
                        b.clone(),
                        c.clone(),
                        vec![(3, 1.0)],
                        vec![(4, 1.0)],
                    ];
                    let space = StateSpace::from_matrix(Csr::from_rows(chain), vec![0], goal());
                    let answer = check_space(&space, &property, &Options::default()).unwrap();
                    let AnswerValue::Number(value) = answer.value else {
                        panic!()
                    };
                    least = least.min(value);
                    most = most.max(value);
                }
            }
        }
        assert!(
            low <= least + 1e-12 && most <= high + 1e-12,
            "{case}: {low} {least} {most} {high}"
        );
        assert!(
            least - low < 1e-8 && high - most < 1e-8,
            "{case}: {low} {least} {most} {high}"
        );
        wide += usize::from(high - low > 0.01);
    }
    assert!(wide > 30, "the cases must tell something: {wide}");
}

/// Within steps, rows may change from visit to visit; every fixed chain lies within the bounds.
#[test]
fn bounds_within_steps_hold_for_every_chain() {
    let mut uniform = Uniform(11);
    let goal = || vec![("goal".to_owned(), vec![false, false, false, true, false])];
    let within = |last| {
        reach(TimeBound {
            upper: Some((last, false)),
            ..TimeBound::default()
        })
    };
    for _ in 0..30 {
        let rows = random_rows(&mut uniform);
        let model = IntervalModel::from_rows(rows.clone(), vec![0], goal()).unwrap();
        for steps in [1, 3, 10] {
            let (low, high) = bounds(&model, &within(steps));
            for a in vertices(&rows[0]) {
                for b in vertices(&rows[1]) {
                    let c = vertices(&rows[2]).swap_remove(0);
                    let chain = vec![a.clone(), b, c, vec![(3, 1.0)], vec![(4, 1.0)]];
                    let space = StateSpace::from_matrix(Csr::from_rows(chain), vec![0], goal());
                    let answer = check_space(&space, &within(steps), &Options::default()).unwrap();
                    let AnswerValue::Number(value) = answer.value else {
                        panic!()
                    };
                    assert!(
                        (low - 1e-12..=high + 1e-12).contains(&value),
                        "{low} {value} {high}"
                    );
                }
            }
        }
    }
}

fn tree(text: &str) -> ast::Model {
    let parsed = parse_model(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    parsed.tree
}

fn property_of(
    tree: &ast::Model,
    given: &[(&str, f64)],
    text: &str,
) -> (prism_lang::resolved::Model, Property) {
    let mut overrides = Constants::new();
    for (name, value) in given {
        let exact = prism_lang::Rational::from_float(*value).unwrap();
        overrides.set(
            *name,
            Value::Double(prism_lang::Number::from_rational(exact)),
        );
    }
    let model = resolve_with(tree, &Constants::new(), &overrides).unwrap();
    let properties = parse_properties(text).tree;
    let mut properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
    (model, properties.pop().unwrap().property)
}

const RETRIES: &str = "dtmc
    const double p = 0.1; const double ok = 1 - p; const double q = 0.3;
    module robot
      s : [0..3]; tries : [0..2];
      [] s=0 & tries<2 -> p*q:(s'=1) + p*(1-q):(tries'=tries+1) + ok:(s'=2);
      [] s=0 & tries=2 -> p:(s'=1) + ok:(s'=2);
      [] s=2 -> 0.5:(s'=0)&(tries'=0) + 0.5:(s'=3);
    endmodule
    module copy = robot [s=t, tries=more, p=q, q=p, ok=okq] endmodule
    const double okq = 1 - q;";

fn ranges() -> Vec<ConstantRange> {
    let range = |name: &str, low, high| ConstantRange {
        name: name.into(),
        low,
        high,
    };
    vec![range("p", 0.05, 0.2), range("q", 0.1, 0.4)]
}

/// On a grid over the box, every answer lies within the bounds, for a loop, `G` and nested operators.
#[test]
fn a_box_of_constants_lies_within_its_interval_model() {
    let tree = tree(RETRIES);
    let model = IntervalModel::new(&tree, &ranges(), 10_000, &|| false).unwrap();
    for text in [
        "P=? [ F s=3 ]",
        "P=? [ G s!=1 ]",
        "P=? [ (F s=1) & (F t=3) ]",
        "P=? [ s!=1 U<=5 s=3 ]",
    ] {
        let (_, property) = property_of(&tree, &[], text);
        let (low, high) = bounds(&model, &property);
        let (mut least, mut most) = (1.0_f64, 0.0_f64);
        for i in 0..=6 {
            for j in 0..=6 {
                let given = [
                    ("p", 0.05 + 0.025 * f64::from(i)),
                    ("q", 0.1 + 0.05 * f64::from(j)),
                ];
                let (resolved, property) = property_of(&tree, &given, text);
                let space = explore::<f64>(&resolved).unwrap();
                let answer = check_space(&space, &property, &Options::default()).unwrap();
                let AnswerValue::Number(value) = answer.value else {
                    panic!()
                };
                least = least.min(value);
                most = most.max(value);
            }
        }
        assert!(
            low <= least + 1e-9 && most <= high + 1e-9,
            "{text}: {low} {least} {most} {high}"
        );
        assert!(high - low < 1.0 && low > 0.0, "{text}: {low} {high}");
    }
}

#[test]
fn what_is_no_polynomial_without_squares_is_refused() {
    let refused = |command: &str, more: &str| {
        let text =
            format!("dtmc const double p = 0.1; {more} module m s : [0..2]; {command} endmodule");
        let range = ConstantRange {
            name: "p".into(),
            low: 0.05,
            high: 0.2,
        };
        match IntervalModel::new(&tree(&text), &[range], 100, &|| false) {
            Err(IntervalModelError::Form(reason)) => reason,
            other => panic!("{other:?}"),
        }
    };
    let squared = refused("[] s=0 -> p*p:(s'=1) + 1-p*p:(s'=2);", "");
    assert_eq!(squared, "`p` occurs squared in a probability");
    let hidden = refused(
        "[] s=0 -> p*b:(s'=1) + 1-p*b:(s'=2);",
        "const double b = 1 - p;",
    );
    assert_eq!(hidden, squared);
    let divided = refused("[] s=0 -> 0.01/p:(s'=1) + 1-0.01/p:(s'=2);", "");
    assert!(divided.contains("a divisor"), "{divided}");
    let guard = refused("[] s=0 & p<0.15 -> 0.5:(s'=1) + 0.5:(s'=2);", "");
    assert!(guard.contains("a comparison"), "{guard}");
    let both = refused(
        "[a] s=0 -> p:(s'=1) + 1-p:(s'=2);",
        "module other t : [0..2]; [a] t=0 -> p:(t'=1) + 1-p:(t'=2); endmodule",
    );
    assert!(both.contains("take `a` together"), "{both}");
}

/// 0 of n leaves an interval from 0, n of n one to 1: what the model says there is within the bounds, and they are as near as
/// elsewhere.
#[test]
fn intervals_begin_at_0_and_end_at_1() {
    let tree = tree(
        "dtmc const double p = 0.1; const double q = 0.9;
        module m s : [0..3];
          [] s=0 -> p:(s'=1) + 1-p:(s'=2);
          [] s=1 -> q:(s'=2) + 1-q:(s'=3);
        endmodule",
    );
    let range = |name: &str, low, high| ConstantRange {
        name: name.into(),
        low,
        high,
    };
    let ranges = [range("p", 0.0, 0.2), range("q", 0.7, 1.0)];
    let model = IntervalModel::new(&tree, &ranges, 100, &|| false).unwrap();
    for (text, least, most) in [
        ("P=? [ F s=2 ]", 0.94, 1.0),
        ("P=? [ F s=1 ]", 0.0, 0.2),
        ("P=? [ F s=3 ]", 0.0, 0.06),
    ] {
        let (_, property) = property_of(&tree, &[], text);
        let (low, high) = bounds(&model, &property);
        assert!(low <= least && most <= high, "{text}: {low} {high}");
        assert!(
            least - low < 1e-13 && high - most < 1e-13,
            "{text}: {low} {high}"
        );
        for given in [[("p", 0.0), ("q", 1.0)], [("p", 0.2), ("q", 1.0)]] {
            let (resolved, property) = property_of(&tree, &given, text);
            let space = explore::<f64>(&resolved).unwrap();
            let answer = check_space(&space, &property, &Options::default()).unwrap();
            let AnswerValue::Number(value) = answer.value else {
                panic!()
            };
            assert!(
                low <= value && value <= high,
                "{text}: {low} {value} {high}"
            );
        }
    }
}

#[test]
fn rows_without_probabilities_are_refused() {
    let row = |low, high| vec![vec![(0, Range { low, high })]];
    assert!(IntervalModel::from_rows(row(0.2, 0.9), vec![0], vec![]).is_err());
    assert!(IntervalModel::from_rows(row(0.0, 1.0), vec![0], vec![]).is_err());
    assert!(IntervalModel::from_rows(row(0.5, 1.0), vec![0], vec![]).is_ok());
    let many = vec![
        ConstantRange {
            name: "p".into(),
            low: 0.1,
            high: 0.2
        };
        11
    ];
    let found = IntervalModel::new(&tree("dtmc"), &many, 10, &|| false);
    assert!(matches!(found, Err(IntervalModelError::Box(_))));
}
