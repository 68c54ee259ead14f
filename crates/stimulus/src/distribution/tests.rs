//! Quantiles against distribution functions, and the written forms.

use proptest::prelude::*;

use super::*;

fn read(text: &str) -> Result<Distribution, String> {
    let table: Result<toml::Table, _> = toml::from_str(&format!("x = {text}"));
    let value = table.expect("TOML").remove("x").expect("x");
    Distribution::deserialize(value).map_err(|error| error.to_string())
}

fn any_distribution() -> impl Strategy<Value = Distribution> {
    let ordered = |a: f64, b: f64| (a.min(b), a.max(b));
    prop_oneof![
        (-5.0..5.0, -5.0..5.0).prop_map(move |(a, b)| {
            let (low, high) = ordered(a, b);
            Distribution::Uniform { low, high }
        }),
        (-5.0..5.0, 0.01..3.0, 0.1..4.0, 0.1..4.0).prop_map(|(mean, sd, below, above)| {
            Distribution::Normal {
                mean,
                sd,
                low: mean - below,
                high: mean + above,
            }
        }),
        (-5.0..5.0, 0.01..3.0).prop_map(|(mean, sd)| Distribution::Normal {
            mean,
            sd,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
        }),
        (0.001..5.0, 0.001..5.0).prop_map(move |(a, b)| {
            let (low, high) = ordered(a, b);
            Distribution::LogUniform { low, high }
        }),
        (-5.0..5.0, 0.1..3.0, 0.1..3.0).prop_map(|(mode, below, above)| {
            Distribution::Triangular {
                low: mode - below,
                mode,
                high: mode + above,
            }
        }),
        (-9_i64..9, 0_i64..20).prop_map(|(low, more)| Distribution::Integer {
            low,
            high: low + more
        }),
        prop::collection::vec(0.0..2.0, 1..6).prop_map(|mut weights| {
            weights[0] += 0.1;
            Distribution::Choice {
                options: Options::Numbers((0..weights.len()).map(|i| 10.0 - i as f64).collect()),
                weights,
            }
        }),
        (0.01..0.99).prop_map(|probability| Distribution::Boolean { probability }),
    ]
}

proptest! {
    #[test]
    fn a_value_comes_back_from_its_coordinate(d in any_distribution(), u in 0.0..1.0) {
        d.check().unwrap();
        let value = d.quantile(u);
        prop_assert!(d.contains(value), "{value} outside {:?}", d.support());
        let again = d.quantile(d.unit_of(value));
        let width = (d.quantile(1.0) - d.quantile(0.0)).abs();
        if d.cardinality().is_some() {
            prop_assert_eq!(again, value);
        } else {
            prop_assert!((again - value).abs() <= 1e-7 * (width + value.abs()), "{again} {value}");
        }
    }

    #[test]
    fn quantiles_invert_the_distribution_function(d in any_distribution(), u in 0.001..0.999) {
        // Choices are ordered by place, not by size: their quantile is no inverse of F.
        prop_assume!(!matches!(d, Distribution::Choice { .. }));
        let value = d.quantile(u);
        prop_assert!(d.cdf(value) >= u - 1e-9);
        let width = d.quantile(1.0) - d.quantile(0.0);
        let below = match d.cardinality() {
            Some(_) => value - 1.0,
            None => value - 1e-6 * (1.0 + width),
        };
        prop_assert!(d.cdf(below) <= u + 1e-9, "F({below}) = {} above {u}", d.cdf(below));
    }

    #[test]
    fn written_forms_are_read_back(d in any_distribution()) {
        let json = serde_json::to_string(&d).unwrap();
        prop_assert_eq!(&serde_json::from_str::<Distribution>(&json).unwrap(), &d);
        let toml = toml::Value::try_from(&d).unwrap().to_string();
        prop_assert_eq!(&read(&toml).unwrap(), &d);
    }
}

#[test]
fn shares_of_values_are_their_weights() {
    let choice = read(r#"{ choice = ["a", "b", "c"], weights = [1, 0, 3] }"#).unwrap();
    let count = 1000;
    let values = (0..count).map(|i| choice.quantile((f64::from(i) + 0.5) / f64::from(count)));
    let values: Vec<f64> = values.collect();
    let share = |wanted: f64| values.iter().filter(|v| **v == wanted).count();
    assert_eq!([share(0.0), share(1.0), share(2.0)], [250, 0, 750]);
    assert_eq!(choice.support(), [0.0, 2.0]);
    assert!(!choice.contains(1.0));
}

#[test]
fn certain_answers_are_certain() {
    let yes = Distribution::Boolean { probability: 1.0 };
    let no = Distribution::Boolean { probability: 0.0 };
    for u in [0.0, 0.3, 1.0] {
        assert_eq!((yes.quantile(u), no.quantile(u)), (1.0, 0.0));
    }
}

#[test]
fn moments_are_those_of_the_definitions() {
    let mean = |d: &Distribution| {
        let n = 20_000;
        let values = (0..n).map(|i| d.quantile((f64::from(i) + 0.5) / f64::from(n)));
        values.sum::<f64>() / f64::from(n)
    };
    let near = |d: &str, expected: f64| {
        let found = mean(&read(d).unwrap());
        assert!((found - expected).abs() < 1e-3, "{d}: {found}");
    };
    near("{ uniform = [1, 15] }", 8.0);
    near("{ triangular = [0.0, 1.0, 5.0] }", 2.0);
    near("{ integer = [1, 6] }", 3.5);
    // (high - low) / ln(high / low).
    near("{ log_uniform = [1.0, 2.0] }", 1.0 / 2.0_f64.ln());
    // Half normal: sqrt(2 / pi).
    near("{ normal = [0.0, 1.0], low = 0.0 }", 0.797_885);
}

#[test]
fn mistakes_are_named() {
    for (text, expected) in [
        ("{ uniform = [2.0, 1.0] }", "descend"),
        ("{ uniform = [2.0] }", "length 2"),
        ("{ normal = [0.0, 0.0] }", "standard deviation above 0"),
        (
            "{ normal = [0.0, 1.0], low = 2.0, high = 1.0 }",
            "below its highest",
        ),
        (
            "{ normal = [0.0, 1.0], low = 50.0 }",
            "30 standard deviations",
        ),
        ("{ log_uniform = [0.0, 1.0] }", "above 0"),
        ("{ triangular = [0.0, 3.0, 1.0] }", "descend"),
        ("{ integer = [3, 1] }", "above the highest"),
        ("{ integer = [0, 9223372036854775807] }", "2^53"),
        ("{ choice = [] }", "at least one"),
        ("{ choice = [1, 1] }", "twice"),
        ("{ choice = [1, 2], weights = [1] }", "as many weights"),
        ("{ choice = [1, 2], weights = [0, 0] }", "some weight"),
        ("{ boolean = 1.5 }", "between 0 and 1"),
        ("{ uniform = [0, 1], normal = [0, 1] }", "only one of"),
        ("{ low = 1 }", "give one of"),
        ("{ uniform = [0, 1], low = 1 }", "normal only"),
        ("{ unifrom = [0, 1] }", "unifrom"),
        ("inf", "finite"),
        ("\"x\"", "a number or a distribution"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
}
