//! How often a study errs that adds trials and judges again: with tests of all trials as if it was the only look, and
//! with those of `stats::continuation`; and what the latter cost.
//!
//! A study looks up to five times. After each look that shows nothing it adds trials: as many as there are (*double*), a
//! tenth of them at up to 40 looks (*often*), or, with the size chosen by what was seen, few when it is near to showing
//! something and many when not (*by what is seen*). Two samples grow on both sides or on the one that is behind.
//! Everything is drawn with fixed seeds.

use stats::{
    Confidence, Sample, ScoredLook, binomial_test_above, boschloo_exact, continued_above,
    continued_p,
};

const STUDIES: u32 = 4000;
const LEVEL: f64 = 0.05;

/// Uniform numbers: SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn more(&mut self, now: Sample, trials: u64, rate: f64) -> Sample {
        let successes = (0..trials).filter(|_| self.next() < rate).count() as u64;
        Sample {
            successes: now.successes + successes,
            trials: now.trials + trials,
        }
    }
}

#[derive(Clone, Copy)]
enum Going {
    Double,
    Often,
    BySeen,
}

impl Going {
    const ALL: [(Going, &'static str, usize); 3] = [
        (Going::Double, "double", 5),
        (Going::Often, "often", 40),
        (Going::BySeen, "by what is seen", 6),
    ];

    fn further(self, trials: u64, p: f64) -> u64 {
        match self {
            Going::Double => trials,
            Going::Often => trials.div_ceil(10),
            Going::BySeen if p < 0.1 => trials.div_ceil(5),
            Going::BySeen => 2 * trials,
        }
    }
}

const NONE: Sample = Sample {
    successes: 0,
    trials: 0,
};

/// Shares of studies that show the rate to be above the threshold: at the first look and at any, by each kind of test.
fn threshold(rate: f64, threshold: f64, first: u64, going: Going, looks: usize) -> [f64; 4] {
    let mut shown = [0_u32; 4];
    let mut uniform = Uniform(1);
    for _ in 0..STUDIES {
        let mut seen = vec![uniform.more(NONE, first, rate)];
        let (mut once, mut continued) = (false, false);
        for look in 0..looks {
            let now = seen[seen.len() - 1];
            let p = binomial_test_above(now, threshold);
            once |= p <= LEVEL;
            continued = continued || continued_above(&seen, threshold) <= LEVEL;
            if look == 0 {
                shown[0] += u32::from(once);
                shown[2] += u32::from(continued);
            }
            if once && continued || now.trials > 20 * first {
                break;
            }
            seen.push(uniform.more(now, going.further(now.trials, p), rate));
        }
        shown[1] += u32::from(once);
        shown[3] += u32::from(continued);
    }
    shown.map(|count| f64::from(count) / f64::from(STUDIES))
}

/// The two-sided p-value of a difference over all looks, from those of each look.
fn difference_over(looks: &[(Sample, Sample, f64)]) -> f64 {
    let side = |sign: f64| {
        let scored = looks.iter().map(|(a, b, p)| {
            let rate = |sample: &Sample| sample.successes as f64 / sample.trials as f64;
            let is_there = (rate(b) - rate(a)) * sign > 0.0;
            ScoredLook {
                p: if is_there { 0.5 * p } else { 1.0 - 0.5 * p },
                information: 1.0 / (1.0 / a.trials as f64 + 1.0 / b.trials as f64),
            }
        });
        continued_p(&scored.collect::<Vec<_>>())
    };
    (2.0 * side(1.0).min(side(-1.0))).min(1.0)
}

/// Two one-sided tests, the larger p-value.
fn equivalence(a: Sample, b: Sample, margin: f64) -> f64 {
    let tost = stats::tost(a, b, margin, stats::DifferenceVariance::AgrestiCaffo);
    let score = stats::score_equivalence(a, b, margin).unwrap_or(0.0);
    tost.map_or(1.0, |tost| tost.p_value().max(score))
}

/// Shares of studies of two samples that show a difference, and agreement, as above.
fn pair(
    rates: [f64; 2],
    margin: f64,
    one_sided: bool,
    going: Going,
    looks: usize,
) -> [[f64; 4]; 2] {
    let mut shown = [[0_u32; 4]; 2];
    let mut uniform = Uniform(2);
    let studies = STUDIES / 4;
    for _ in 0..studies {
        let mut now = rates.map(|rate| uniform.more(NONE, 60, rate));
        let mut seen: [Vec<(Sample, Sample, f64)>; 2] = [Vec::new(), Vec::new()];
        let mut found = [[false; 2]; 2];
        for look in 0..looks {
            let [a, b] = now;
            let once = [boschloo_exact(a, b), equivalence(a, b, margin)];
            seen[0].push((a, b, once[0]));
            seen[1].push((a, b, once[1]));
            let scored: Vec<ScoredLook> = seen[1]
                .iter()
                .map(|(a, b, p)| ScoredLook {
                    p: *p,
                    information: 1.0 / (1.0 / a.trials as f64 + 1.0 / b.trials as f64),
                })
                .collect();
            let over = [difference_over(&seen[0]), continued_p(&scored)];
            for kind in 0..2 {
                found[kind][0] |= once[kind] <= LEVEL;
                found[kind][1] |= over[kind] <= LEVEL;
                if look == 0 {
                    shown[kind][0] += u32::from(found[kind][0]);
                    shown[kind][2] += u32::from(found[kind][1]);
                }
            }
            if a.trials + b.trials > 1200 {
                break;
            }
            let p = once[0].min(once[1]);
            for (side, rate) in rates.into_iter().enumerate() {
                if one_sided && side == look % 2 {
                    continue;
                }
                now[side] = uniform.more(now[side], going.further(now[side].trials, p), rate);
            }
        }
        for kind in 0..2 {
            shown[kind][1] += u32::from(found[kind][0]);
            shown[kind][3] += u32::from(found[kind][1]);
        }
    }
    shown.map(|kind| kind.map(|count| f64::from(count) / f64::from(studies)))
}

fn row(what: &str, [first, any, first_continued, any_continued]: [f64; 4]) {
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    println!(
        "| {what} | {} | {} | {} | {} |",
        percent(first),
        percent(any),
        percent(first_continued),
        percent(any_continued)
    );
}

fn main() {
    assert!((Confidence::P95.alpha() - LEVEL).abs() < 1e-12);
    println!(
        "| studies | first look, single | any look, single | first look, continued | any look, continued |"
    );
    println!("|---|---|---|---|---|");
    for (going, name, looks) in Going::ALL {
        row(
            &format!("false: rate 0.9, threshold 0.9, {name}"),
            threshold(0.9, 0.9, 60, going, looks),
        );
        row(
            &format!("true: rate 0.95, threshold 0.9, {name}"),
            threshold(0.95, 0.9, 60, going, looks),
        );
    }
    for (going, name, looks) in [Going::ALL[0], Going::ALL[2]] {
        for (one_sided, sides) in [(false, "both sides"), (true, "one side")] {
            let equal = pair([0.88, 0.88], 0.1, one_sided, going, looks);
            let apart = pair([0.85, 0.95], 0.1, one_sided, going, looks);
            row(
                &format!("false difference: 0.88, 0.88, {name}, {sides}"),
                equal[0],
            );
            row(
                &format!("true agreement: 0.88, 0.88, margin 0.1, {name}, {sides}"),
                equal[1],
            );
            row(
                &format!("false agreement: 0.85, 0.95, margin 0.1, {name}, {sides}"),
                apart[1],
            );
            row(
                &format!("true difference: 0.85, 0.95, {name}, {sides}"),
                apart[0],
            );
        }
    }
}
