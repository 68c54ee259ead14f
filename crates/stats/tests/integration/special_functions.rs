//! Special functions against reference values of 40 digits (mpmath 1.3: loggamma, gammainc,
//! betainc, erfc; numerical integration of the density for the huge parameters), rounded to f64.

use stats::special::*;

fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    let error = if expected == 0.0 {
        found.abs()
    } else {
        (found / expected - 1.0).abs()
    };
    assert!(
        error <= relative,
        "{what}: found {found:e}, expected {expected:e}, error {error:e}"
    );
}

#[test]
fn ln_gamma_keeps_its_digits_through_its_zeros() {
    let cases = [
        (1e-8, 18.42068073818021),
        (0.1, 2.252712651734206),
        (0.5, 0.5723649429247001),
        (0.9, 0.06637623973474295),
        (1.0001, -5.771334222047127e-05),
        (1.2, -0.08537409000331583),
        (1.3, -0.10817480950786047),
        (1.999, -0.0004224618006921073),
        (2.1, 0.04543773854448518),
        (3.0, std::f64::consts::LN_2),
        (11.5, 16.292000476567242),
        (12.5, 18.734347511936445),
        (1e3, 5905.220423209181),
        (1e8, 1742068066.1038346),
        (1e15, 3.3538776394910668e+16),
    ];
    for (x, expected) in cases {
        assert_close(ln_gamma(x), expected, 2e-14, &format!("ln_gamma({x})"));
    }
    assert_eq!(ln_gamma(1.0), 0.0);
    assert_eq!(ln_gamma(2.0), 0.0);
    assert!(ln_gamma(-1.0).is_nan());
}

#[test]
fn both_tails_of_the_gamma_distribution() {
    let cases = [
        (0.5, 1e-06, 0.0011283787909692363, 0.9988716212090307),
        (0.5, 0.5, 0.6826894921370859, 0.3173105078629141),
        (0.5, 1.9, 0.9487474171426304, 0.05125258285736951),
        (0.5, 50.0, 1.0, 1.523970604832105e-23),
        (1.0, 0.1, 0.09516258196404043, 0.9048374180359595),
        (2.5, 0.3, 0.011996757205906266, 0.9880032427940937),
        (2.5, 9.0, 0.9970535954121197, 0.0029464045878802906),
        (50.0, 40.0, 0.07033506665939496, 0.9296649333406051),
        (50.0, 80.0, 0.9998692160234086, 0.00013078397659141034),
        (10000.0, 9800.0, 0.022207543813969693, 0.9777924561860303),
        (10000.0, 10500.0, 0.9999995724127545, 4.2758724550596475e-07),
        (
            1000000.0,
            1001000.0,
            0.8413447863683403,
            0.15865521363165971,
        ),
    ];
    for (a, x, lower, upper) in cases {
        assert_close(gamma_p(a, x), lower, 1e-12, &format!("gamma_p({a}, {x})"));
        assert_close(gamma_q(a, x), upper, 1e-12, &format!("gamma_q({a}, {x})"));
    }
}

#[test]
fn normal_tails_and_quantiles() {
    let tails = [
        (-8.0, 0.9999999999999993),
        (-1.5, 0.9331927987311419),
        (-0.001, 0.500398942213911),
        (0.0, 0.5),
        (1e-05, 0.49999601057719606),
        (0.3, 0.3820885778110474),
        (1.0, 0.15865525393145705),
        (1.644853626951473, 0.04999999999999996),
        (2.5, 0.006209665325776135),
        (6.0, 9.86587645037698e-10),
        (10.0, 7.619853024160525e-24),
        (20.0, 2.7536241186062337e-89),
        (37.0, 5.725571222524577e-300),
    ];
    for (z, expected) in tails {
        assert_close(normal_sf(z), expected, 2e-13, &format!("normal_sf({z})"));
        assert_close(
            normal_cdf(-z),
            expected,
            2e-13,
            &format!("normal_cdf({})", -z),
        );
    }
    let quantiles = [
        (1e-300, -37.0470962993612),
        (1e-20, -9.262340089798407),
        (1e-06, -4.753424308822899),
        (0.025, -1.9599639845400543),
        (0.05, -1.6448536269514726),
        (0.3, -0.5244005127080408),
        (0.4999, -0.00025066283008800747),
        (0.5, 0.0),
        (0.8, 0.8416212335729144),
        (0.95, 1.6448536269514722),
        (0.975, 1.9599639845400538),
        (0.999999, 4.753424308817087),
    ];
    for (p, expected) in quantiles {
        assert_close(
            normal_quantile(p),
            expected,
            1e-12,
            &format!("normal_quantile({p})"),
        );
    }
    assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
    assert_eq!(normal_quantile(1.0), f64::INFINITY);
    assert!(normal_quantile(1.1).is_nan());
}

#[test]
fn student_and_f_tails() {
    let student = [
        (0.0, 3.0, 0.5),
        (1e-06, 5.0, 0.4999996203933102),
        (0.5, 1.0, 0.35241638234956674),
        (2.0, 1.0, 0.14758361765043326),
        (2.0, 8.0, 0.04025811897863134),
        (-1.3, 4.0, 0.868274201764388),
        (5.0, 30.0, 1.1648342733503898e-05),
        (1.96, 1000000.0, 0.024998033792634895),
        (40.0, 3.0, 1.7190340394579263e-05),
        (8.0, 200.0, 4.9396004546653196e-14),
    ];
    for (t, degrees, expected) in student {
        let what = format!("student_t_sf({t}, {degrees})");
        assert_close(student_t_sf(t, degrees), expected, 1e-12, &what);
        assert_close(-student_t_quantile(expected, degrees), t, 1e-10, &what);
    }
    let fisher = [
        (1.9, 9.0, 90.0, 0.06184404713258926),
        (0.3, 2.0, 5.0, 0.7532774095368846),
        (12.0, 3.0, 40.0, 9.654458319372918e-06),
        (1.0, 100.0, 1000.0, 0.4838563644616672),
    ];
    for (f, first, second, expected) in fisher {
        assert_close(
            f_sf(f, first, second),
            expected,
            1e-12,
            &format!("f_sf({f})"),
        );
    }
}

/// `(a, b, x, lower tail, upper tail)`.
const BETA_TAILS: [(f64, f64, f64, f64, f64); 17] = [
    (0.5, 5.5, 0.01, 0.254850092009452, 0.7451499079905479),
    (0.5, 0.5, 0.3, 0.36901011956554536, 0.6309898804344546),
    (5.5, 0.5, 0.999, 0.9183176370668991, 0.08168236293310092),
    (1.0, 1.0, 0.25, 0.25, 0.75),
    (88.0, 13.0, 0.95, 0.9985356519919655, 0.0014643480080344681),
    (89.0, 12.0, 0.87, 0.3388552003492243, 0.6611447996507758),
    (0.001, 2.0, 1e-05, 0.9895416378660649, 0.010458362133935167),
    (
        3.0,
        10000.0,
        0.001,
        0.9972442000286702,
        0.0027557999713298522,
    ),
    (
        0.5,
        100000000.5,
        1e-08,
        0.842700794506368,
        0.15729920549363202,
    ),
    (
        100000000.5,
        0.5,
        0.99999999,
        0.1572992044507244,
        0.8427007955492756,
    ),
    (
        1000000.0,
        1000000.0,
        0.4995,
        0.07864957758090163,
        0.9213504224190984,
    ),
    (1000000.0, 1000000.0, 0.5, 0.5, 0.5),
    (
        88000000.5,
        12000000.5,
        0.88003,
        0.822072372646515,
        0.17792762735348494,
    ),
    (
        88000000.5,
        12000000.5,
        0.8799,
        0.0010471947822140336,
        0.998952805217786,
    ),
    (88000000.5, 12000000.5, 0.8797, 1.415305385188682e-20, 1.0),
    (
        100000.0,
        30000000.0,
        0.0034,
        0.9999999999999054,
        9.457253821083199e-14,
    ),
    (439.5, 61.5, 0.95, 0.9999999998693978, 1.306021928610654e-10),
];

#[test]
fn beta_tails_from_half_a_count_to_a_hundred_million() {
    for (a, b, x, lower, upper) in BETA_TAILS {
        let what = format!("Beta({a}, {b}) at {x}");
        assert_close(beta_cdf(a, b, x), lower, 3e-13, &what);
        assert_close(beta_sf(a, b, x), upper, 3e-13, &what);
    }
}

#[test]
fn beta_quantiles_invert_both_tails() {
    for (a, b, x, lower, upper) in BETA_TAILS {
        let what = format!("quantile of Beta({a}, {b})");
        // A tail of 1 - e does not determine x: only the smaller one is asked to.
        if lower <= upper {
            assert_close(beta_quantile(a, b, lower), x, 1e-11, &what);
        } else {
            assert_close(beta_quantile_upper(a, b, upper), x, 1e-11, &what);
        }
    }
}

#[test]
fn beta_quantiles_end_for_extreme_shapes_and_tails() {
    let shapes = [1e-3, 0.5, 1.0, 3.0, 1e3, 1e6, 1e8];
    let tails = [1e-300, 1e-20, 1e-6, 0.025, 0.5, 0.975, 1.0 - 1e-12];
    for a in shapes {
        for b in shapes {
            let mut last = 0.0;
            for p in tails {
                let x = beta_quantile(a, b, p);
                assert!(
                    (0.0..=1.0).contains(&x) && x >= last,
                    "Beta({a}, {b}) at {p}: {x}"
                );
                last = x;
            }
        }
    }
    assert_eq!(beta_quantile(2.0, 3.0, 0.0), 0.0);
    assert_eq!(beta_quantile(2.0, 3.0, 1.0), 1.0);
    assert!(beta_quantile(2.0, 3.0, 1.5).is_nan());
    assert!(beta_quantile(-2.0, 3.0, 0.5).is_nan());
}

#[test]
fn small_count_densities_sum_to_one() {
    for trials in [1_u64, 2, 7, 30] {
        for p in [0.0, 1e-9, 0.3, 0.95, 1.0] {
            let sum: f64 = (0..=trials).map(|k| binomial_pmf(k, trials, p)).sum();
            assert_close(sum, 1.0, 1e-13, &format!("binomial {trials} {p}"));
        }
    }
    let sum: f64 = (0..=10).map(|k| hypergeometric_pmf(k, 12, 10, 40)).sum();
    assert_close(sum, 1.0, 1e-13, "hypergeometric");
    // C(12,3) C(28,7) / C(40,10) as a ratio of whole numbers.
    let exact = 220.0 * 1_184_040.0 / 847_660_528.0;
    assert_close(
        hypergeometric_pmf(3, 12, 10, 40),
        exact,
        1e-13,
        "hypergeometric at 3",
    );
}
