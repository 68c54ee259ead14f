//! How often a few people show a mean rate of 0.9 to be higher than 0.9, at 5 %, by the model of people alone and if people of a kind
//! that nobody met are allowed for; and how often they show a higher rate.
//!
//! `cargo run -p corroborate-stats --release --example unmet_kind` (about a minute)

use stats::{
    BetaBinomial, Confidence, Interval, Sample, clustered_rate, clustered_test_above, wilson,
    with_unmet_kind,
};

const THRESHOLD: f64 = 0.9;
const LEVEL: f64 = 0.05;
const GROUPS: u64 = 300;

/// How people differ.
#[derive(Clone, Copy)]
enum Law {
    /// 85 % succeed in 98 % of their ten attempts, the others in 44.7 %: 0.9 on average.
    TwoKinds,
    /// Logits of rates are normal around 3 with a deviation of 1.5: 0.9 on average.
    LogitNormal,
    /// Nine in ten always succeed, the others never.
    AllOrNothing,
    /// All at 0.97.
    Higher,
}

/// The generator of Marsaglia (2003).
struct Uniform(u64);

impl Uniform {
    fn draw(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn person(&mut self, law: Law) -> Sample {
        let rate = match law {
            Law::TwoKinds if self.draw() < 0.85 => 0.98,
            Law::TwoKinds => 0.067 / 0.15,
            Law::LogitNormal => {
                let (radius, angle) = (self.draw(), self.draw());
                let normal =
                    (-2.0 * (1.0 - radius).ln()).sqrt() * (std::f64::consts::TAU * angle).cos();
                1.0 / (1.0 + (-(3.0 + 1.5 * normal)).exp())
            }
            Law::AllOrNothing => f64::from(u8::from(self.draw() < 0.9)),
            Law::Higher => 0.97,
        };
        Sample {
            successes: (0..10).filter(|_| self.draw() < rate).count() as u64,
            trials: 10,
        }
    }
}

/// Whether people show it, by the model alone and allowing for a kind of people that was not met.
fn shown(people: &[Sample]) -> Result<[bool; 2], stats::StatsError> {
    let worth = clustered_rate(people, Confidence::P95)?.worth;
    let fit = BetaBinomial::fit(people).ok();
    let test = |mean: f64| {
        let by_people = fit.as_ref().map_or(0.0, |fit| fit.threshold_tests(mean).0);
        (clustered_test_above(worth, mean).max(by_people), 1.0)
    };
    let allowing = with_unmet_kind(people.len() as f64, THRESHOLD, test).0;
    Ok([test(THRESHOLD).0 <= LEVEL, allowing <= LEVEL])
}

fn main() -> Result<(), stats::StatsError> {
    println!("| people x 10 | law | by the model | allowing for others |\n|---|---|---|---|");
    let laws = [
        (Law::TwoKinds, "two kinds, 0.9"),
        (Law::LogitNormal, "logits normal, 0.9"),
        (Law::AllOrNothing, "all or nothing, 0.9"),
        (Law::Higher, "alike, 0.97"),
    ];
    for (law, name) in laws {
        for people in [10, 20, 40, 80] {
            let mut uniform = Uniform(88_172_645_463_325_252);
            let mut found = [0_u64; 2];
            for _ in 0..GROUPS {
                let group: Vec<Sample> = (0..people).map(|_| uniform.person(law)).collect();
                for (count, is_shown) in found.iter_mut().zip(shown(&group)?) {
                    *count += u64::from(is_shown);
                }
            }
            let percent = |successes: u64| {
                let sample = Sample {
                    successes,
                    trials: GROUPS,
                };
                let Interval { low, high } = wilson(sample, Confidence::P95);
                let share = 100.0 * successes as f64 / GROUPS as f64;
                format!("{share:.1} [{:.1}, {:.1}]", 100.0 * low, 100.0 * high)
            };
            println!(
                "| {people} | {name} | {} | {} |",
                percent(found[0]),
                percent(found[1])
            );
        }
    }
    Ok(())
}
