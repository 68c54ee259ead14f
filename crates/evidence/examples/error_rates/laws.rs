//! Ways in which people differ that are no beta distribution, and on which no procedure was tuned: laws that are held out.

use super::support::Uniform;
use stats::Sample;

/// How people differ. Each has a rate of its own; the mean over people is given.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// 85 % of the people succeed in 98 % of their ten attempts, the others as seldom as the mean asks for.
    TwoKinds,
    /// The logits of the rates are normal with a standard deviation of 1.5; ten attempts each.
    LogitNormal,
    /// Beta with an intraclass correlation of 0.3; from 1 to 19 attempts, each as probable.
    Uneven,
}

/// The share of people of the better kind, and their rate.
const BETTER: (f64, f64) = (0.85, 0.98);
const DEVIATION: f64 = 1.5;

impl Law {
    pub const ALL: [Law; 3] = [Law::TwoKinds, Law::LogitNormal, Law::Uneven];

    pub fn name(self) -> &'static str {
        match self {
            Law::TwoKinds => "two kinds of people x 10",
            Law::LogitNormal => "people x 10, logits normal",
            Law::Uneven => "people x 1 to 19, correlation 0.3",
        }
    }

    /// One more person.
    pub fn person(self, uniform: &mut Uniform, mean: f64) -> Sample {
        match self {
            Law::TwoKinds => {
                let (share, better) = BETTER;
                let rate = match uniform.chance(share) {
                    true => better,
                    false => (mean - share * better) / (1.0 - share),
                };
                uniform.sample(10, rate)
            }
            Law::LogitNormal => {
                let rate = logistic(centre(mean) + DEVIATION * normal(uniform));
                uniform.sample(10, rate)
            }
            Law::Uneven => {
                let attempts = 1 + (uniform.draw() * 19.0) as u64;
                let rate = uniform.rate(mean, 0.3);
                uniform.sample(attempts, rate)
            }
        }
    }
}

fn logistic(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// By Box and Muller.
fn normal(uniform: &mut Uniform) -> f64 {
    let (radius, angle) = (uniform.draw(), uniform.draw());
    (-2.0 * (1.0 - radius).ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
}

/// The centre of the logits at which the rates have this mean.
fn centre(mean: f64) -> f64 {
    let (mut low, mut high) = (-20.0, 20.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        match mean_at(middle) < mean {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// The mean of the rates, by the trapezoidal rule over eight standard deviations.
fn mean_at(centre: f64) -> f64 {
    let points = (-160..=160).map(|it| f64::from(it) / 20.0);
    let (sum, weight) = points.fold((0.0, 0.0), |(sum, weight), z| {
        let density = (-z * z / 2.0).exp();
        (
            sum + density * logistic(centre + DEVIATION * z),
            weight + density,
        )
    });
    sum / weight
}
