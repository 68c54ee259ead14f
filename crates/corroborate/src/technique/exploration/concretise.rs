//! Concrete stimuli: values for the parameters of a test.

use super::situations::Situations;
use campaign::{Coverage, Design, Random, Sampler};
use diagnostic::Problem;
use stimulus::{AbstractTest, Space, Stimulus};

/// How many candidates are looked at for one that leads towards holes.
const CANDIDATES: usize = 4;

/// Chooses values.
pub struct Concretiser {
    space: Space,
    designs: Vec<(Design, Sampler)>,
    random: Random,
    next: usize,
}

impl Concretiser {
    /// Values of a space by these designs in turn.
    pub fn new(space: &Space, designs: &[Design], seed: u64) -> Self {
        let sampler = |design: &Design| (*design, Sampler::new(space.clone(), *design, seed));
        Self {
            space: space.clone(),
            designs: designs.iter().map(sampler).collect(),
            random: Random::new(seed, "concretise"),
            next: 0,
        }
    }

    /// A stimulus for a test, with the design that chose its values. Random
    /// values are chosen among a few, towards what was covered least.
    pub fn stimulus(
        &mut self,
        test: &AbstractTest,
        situations: &Situations,
        coverage: &Coverage,
    ) -> Result<(Stimulus, Design), Problem> {
        let place = self.next % self.designs.len().max(1);
        self.next += 1;
        let Some((design, sampler)) = self.designs.get_mut(place) else {
            return Ok((Stimulus::of(test.clone()), Design::Random));
        };
        let design = *design;
        let stimulus = match design {
            Design::Boundary => {
                // Limits of delays as well: they are part of the test.
                let space = self.space.with_delays_of(test);
                let seed = self.random.bits();
                let point = Sampler::new(space.clone(), design, seed).ask(1);
                of_points(&space, test, point)?
            }
            Design::Random => {
                let points = sampler.ask(CANDIDATES).map_err(bad)?;
                let mut best: Option<(f64, Stimulus)> = None;
                for point in points {
                    let stimulus = self.space.stimulus(test, &point).map_err(bad)?;
                    let worth = worth(&stimulus, situations, coverage)?;
                    if best.as_ref().is_none_or(|(most, _)| worth > *most) {
                        best = Some((worth, stimulus));
                    }
                }
                best.map_or_else(|| Stimulus::of(test.clone()), |(_, stimulus)| stimulus)
            }
            _ => {
                let point = sampler.ask(1);
                of_points(&self.space, test, point)?
            }
        };
        Ok((stimulus, design))
    }
}

fn of_points(
    space: &Space,
    test: &AbstractTest,
    points: Result<Vec<stimulus::Point>, campaign::CampaignError>,
) -> Result<Stimulus, Problem> {
    match points.map_err(bad)?.first() {
        Some(point) => space.stimulus(test, point).map_err(bad),
        None => Ok(Stimulus::of(test.clone())),
    }
}

fn bad(error: impl std::fmt::Display) -> Problem {
    Problem::new("bad-exploration", error.to_string())
        .remedy("correct the [[parameter]] tables of the exploration")
}

/// How much the holes of all crosses ask for the labels of a stimulus.
fn worth(
    stimulus: &Stimulus,
    situations: &Situations,
    coverage: &Coverage,
) -> Result<f64, Problem> {
    let mut worth = 0.0;
    for cross in &coverage.model().crosses {
        let weights = coverage.label_weights(&cross.name).map_err(bad)?;
        for (variable, labels) in weights {
            let label = situations.parameter_label(&variable, stimulus);
            let weight = labels.iter().find(|(name, _)| Some(name) == label.as_ref());
            worth += weight.map_or(0.0, |(_, weight)| *weight);
        }
    }
    Ok(worth)
}

/// What a design is called in results.
pub fn design_name(design: Design) -> &'static str {
    match design {
        Design::Random => "random values, towards holes",
        Design::LatinHypercube => "Latin hypercube",
        Design::LowDiscrepancy => "even values",
        Design::Boundary => "boundary values",
    }
}
