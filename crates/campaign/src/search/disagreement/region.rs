//! Regions of contexts: boxes that together are all contexts, cut where a difference changes most.
//!
//! Definition. Each context `x` has an expected difference `g(x)`. A box is cut in two, across one
//! parameter, where that takes away most of the sum of squares of `g` about the boxes' means; boxes
//! are cut in the order of what that takes away, until there are enough of them, or no cut parts
//! two means by `gap`. Then two halves of a box are put together again where both are expected to
//! agree (means within `gap` of 0), or both to differ in the same direction: each region costs
//! episodes of its own.
//!
//! Source: L. Breiman, J. Friedman, R. Olshen and C. Stone, "Classification and Regression Trees"
//! (1984), chapter 8. Deviation: pruning is by what is asked, since what a box shows is found by
//! fresh episodes. Cost: O(boxes * parameters * n^2) for n contexts. Guarantee: the boxes are all
//! contexts, each once; where they are cut is estimated.

use serde::{Deserialize, Serialize};
use stimulus::{Parameter, Point, Space};

/// A box of contexts in the unit cube of the declared distributions: its size is its probability.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Region {
    low: Vec<f64>,
    high: Vec<f64>,
}

/// A context with its expected difference.
pub(super) struct Expected {
    pub unit: Vec<f64>,
    pub difference: f64,
}

/// A way to cut a box in two.
#[derive(Clone, Copy)]
struct Cut {
    /// What it takes away of the sum of squares.
    gain: f64,
    parameter: usize,
    at: f64,
}

/// Both sides of a cut hold at least this share of all contexts.
const LEAST_SHARE: f64 = 0.02;

impl Region {
    /// All contexts.
    #[must_use]
    pub fn whole(dimensions: usize) -> Self {
        Self {
            low: vec![0.0; dimensions],
            high: vec![1.0; dimensions],
        }
    }

    /// The probability of the region by the declared distributions, constraints aside.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.sides().map(|[low, high]| high - low).product()
    }

    /// From where to where it goes in each parameter, in the distribution function.
    pub fn sides(&self) -> impl Iterator<Item = [f64; 2]> {
        self.low.iter().zip(&self.high).map(|(l, h)| [*l, *h])
    }

    /// Whether coordinates lie in it.
    #[must_use]
    pub fn holds(&self, unit: &[f64]) -> bool {
        let mut sides = self.sides().zip(unit);
        sides.all(|([low, high], u)| *u >= low && (*u < high || high >= 1.0))
    }

    /// The place of the region at coordinates of the unit cube.
    #[must_use]
    pub fn at(&self, unit: &[f64]) -> Vec<f64> {
        let places = self.sides().zip(unit);
        places
            .map(|([low, high], u)| low + (high - low) * u)
            .collect()
    }

    /// The values of each parameter: the lowest and the highest.
    #[must_use]
    pub fn ranges(&self, space: &Space) -> Vec<[f64; 2]> {
        let sides = self.sides().zip(&space.parameters);
        let range = |([low, high], parameter): ([f64; 2], &Parameter)| {
            let distribution = &parameter.distribution;
            match distribution.cardinality() {
                None if low <= 0.0 && high >= 1.0 => distribution.support(),
                None => [distribution.quantile(low), distribution.quantile(high)],
                // A hair inside: an end of a side belongs to two values.
                Some(_) => [low + 1e-9, high - 1e-9].map(|u| distribution.quantile(u)),
            }
        };
        sides.map(range).collect()
    }

    /// Whether it holds all values of a parameter, by its place.
    #[must_use]
    pub fn is_whole_in(&self, parameter: usize) -> bool {
        self.sides().nth(parameter) == Some([0.0, 1.0])
    }

    fn halves(&self, cut: Cut) -> [Self; 2] {
        let (mut below, mut above) = (self.clone(), self.clone());
        below.high[cut.parameter] = cut.at;
        above.low[cut.parameter] = cut.at;
        [below, above]
    }
}

/// A box, and its halves by their places if it is cut.
struct Node {
    region: Region,
    halves: Option<[usize; 2]>,
    /// Where it can be cut best, as long as it is not.
    cut: Option<Cut>,
    /// Whether it is expected to agree (0), or in which direction it differs.
    side: i8,
}

/// Cuts all contexts into at most `most` regions by what is expected at some of them.
pub(super) fn partition(
    space: &Space,
    expected: &[Expected],
    most: usize,
    gap: f64,
) -> Vec<Region> {
    let node = |region: Region| Node {
        cut: best_cut(&region, space, expected, gap),
        side: side(&region, expected, gap),
        region,
        halves: None,
    };
    let mut nodes = vec![node(Region::whole(space.dimensions()))];
    while nodes.len() < 2 * most.max(1) - 1 {
        let gains = nodes.iter().enumerate();
        let gains = gains.filter_map(|(place, node)| Some((place, node.cut?)));
        // The first of equals.
        let best = gains.rev().max_by(|a, b| a.1.gain.total_cmp(&b.1.gain));
        let Some((place, cut)) = best else { break };
        let [below, above] = nodes[place].region.halves(cut).map(node);
        nodes[place].cut = None;
        nodes[place].halves = Some([nodes.len(), nodes.len() + 1]);
        nodes.extend([below, above]);
    }
    leaves(nodes)
}

/// The boxes that are not cut, once halves that are expected to be alike are put together.
fn leaves(mut nodes: Vec<Node>) -> Vec<Region> {
    let mut regions = Vec::new();
    // Halves stand behind what they are halves of.
    for place in (0..nodes.len()).rev() {
        let Some(halves) = nodes[place].halves else {
            continue;
        };
        let [below, above] = halves.map(|half| (nodes[half].halves.is_none(), nodes[half].side));
        if below.0 && above.0 && below.1 == above.1 {
            nodes[place].halves = None;
            nodes[place].side = below.1;
        }
    }
    let mut open = vec![0];
    while let Some(place) = open.pop() {
        match nodes[place].halves {
            Some([below, above]) => open.extend([above, below]),
            None => regions.push(nodes[place].region.clone()),
        }
    }
    regions
}

/// Whether a region is expected to agree (0), or in which direction it differs.
fn side(region: &Region, expected: &[Expected], gap: f64) -> i8 {
    let inside = expected.iter().filter(|e| region.holds(&e.unit));
    let differences: Vec<f64> = inside.map(|e| e.difference).collect();
    let mean = differences.iter().sum::<f64>() / differences.len().max(1) as f64;
    match mean {
        mean if mean > gap => 1,
        mean if mean < -gap => -1,
        _ => 0,
    }
}

/// The cut of a region that takes away most, if any parts means by `gap`.
fn best_cut(region: &Region, space: &Space, expected: &[Expected], gap: f64) -> Option<Cut> {
    let inside: Vec<&Expected> = expected.iter().filter(|e| region.holds(&e.unit)).collect();
    let mut best: Option<Cut> = None;
    for (parameter, declared) in space.parameters.iter().enumerate() {
        for at in places(&inside, parameter, declared) {
            let gain = gain(&inside, parameter, at, gap);
            let cut = Cut {
                gain,
                parameter,
                at,
            };
            let shares = region.halves(cut).map(|half| half.share());
            let is_large = shares.iter().all(|share| *share >= LEAST_SHARE);
            if is_large && gain > best.map_or(0.0, |best| best.gain) {
                best = Some(cut);
            }
        }
    }
    best
}

/// Where a parameter can be cut: between neighbouring values.
fn places(inside: &[&Expected], parameter: usize, declared: &Parameter) -> Vec<f64> {
    let mut units: Vec<f64> = inside.iter().map(|e| e.unit[parameter]).collect();
    units.sort_by(f64::total_cmp);
    units.dedup();
    let distribution = &declared.distribution;
    let between = |pair: &[f64]| match distribution.cardinality() {
        Some(_) => distribution.cdf(distribution.quantile(pair[0])),
        None => f64::midpoint(pair[0], pair[1]),
    };
    units.windows(2).map(between).collect()
}

/// What a cut takes away of the sum of squares; 0 if it does not part the means by `least`.
fn gain(inside: &[&Expected], parameter: usize, at: f64, least: f64) -> f64 {
    let (mut below, mut above) = ((0.0, 0.0), (0.0, 0.0));
    for it in inside {
        let side = match it.unit[parameter] < at {
            true => &mut below,
            false => &mut above,
        };
        side.0 += 1.0;
        side.1 += it.difference;
    }
    if below.0 == 0.0 || above.0 == 0.0 {
        return 0.0;
    }
    let gap: f64 = below.1 / below.0 - above.1 / above.0;
    match gap.abs() >= least {
        true => below.0 * above.0 / (below.0 + above.0) * gap * gap,
        false => 0.0,
    }
}

/// The context of a region at coordinates of the unit cube.
pub(super) fn context_at(region: &Region, space: &Space, unit: &[f64]) -> Point {
    space.at(&region.at(unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACE: &str = r#"
        [[parameter]]
        name = "pull"
        sets = ["pull"]
        uniform = [0.0, 10.0]

        [[parameter]]
        name = "glitches"
        sets = ["glitches"]
        choice = [0.0, 0.1, 0.5]
        weights = [1.0, 2.0, 1.0]
    "#;

    fn expected_at(space: &Space, difference: impl Fn(&Point) -> f64) -> Vec<Expected> {
        let rows = stats::design(400, 2, 1);
        let one = |row: Vec<f64>| {
            let point = space.at(&row);
            let difference = difference(&point);
            Expected {
                unit: space.unit_of(&point),
                difference,
            }
        };
        rows.into_iter().map(one).collect()
    }

    #[test]
    fn boxes_are_cut_where_the_difference_changes_and_are_all_contexts() {
        let space = Space::from_toml(SPACE).unwrap();
        let step = |p: &Point| f64::from(u8::from(p.0[0] < 3.0 && p.0[1] > 0.05));
        let expected = expected_at(&space, step);
        let regions = partition(&space, &expected, 6, 0.05);
        assert_eq!(regions.len(), 3, "{regions:?}");
        let total: f64 = regions.iter().map(Region::share).sum();
        assert!((total - 1.0).abs() < 1e-12);
        for e in &expected {
            let holding = regions.iter().filter(|r| r.holds(&e.unit));
            assert_eq!(holding.count(), 1, "{:?}", e.unit);
        }
        let planted = regions
            .iter()
            .find(|r| r.holds(&space.unit_of(&Point(vec![1.0, 0.5]))));
        let ranges = planted.unwrap().ranges(&space);
        assert!((ranges[0][1] - 3.0).abs() < 0.1, "{ranges:?}");
        assert_eq!(ranges[1], [0.1, 0.5]);
    }

    #[test]
    fn values_of_a_choice_are_never_cut_apart() {
        let space = Space::from_toml(SPACE).unwrap();
        let waves = |p: &Point| (p.0[1] * 10.0).sin() + (p.0[0] * 2.0).sin();
        let expected = expected_at(&space, waves);
        assert!(partition(&space, &expected, 12, 0.0).len() > 3);
        for region in partition(&space, &expected, 12, 0.0) {
            for row in stats::design(50, 2, 7) {
                let context = context_at(&region, &space, &row);
                assert!(
                    region.holds(&space.unit_of(&context)),
                    "{region:?} {context:?}"
                );
            }
        }
    }

    #[test]
    fn halves_that_are_expected_to_be_alike_are_put_together_again() {
        let space = Space::from_toml(SPACE).unwrap();
        // Three steps down: two of them are beyond what matters.
        let stairs = |p: &Point| -0.3 * (p.0[0] / 10.0 * 3.0).floor();
        let expected = expected_at(&space, stairs);
        let regions = partition(&space, &expected, 6, 0.1);
        assert_eq!(regions.len(), 2, "{regions:?}");
        let edge = regions[0].ranges(&space)[0][1];
        assert!((edge - 10.0 / 3.0).abs() < 0.1, "{edge}");
    }

    #[test]
    fn where_nothing_differs_nothing_is_cut() {
        let space = Space::from_toml(SPACE).unwrap();
        let expected = expected_at(&space, |p| p.0[0] * 0.001);
        let regions = partition(&space, &expected, 8, 0.05);
        assert_eq!(regions, [Region::whole(2)]);
    }
}
