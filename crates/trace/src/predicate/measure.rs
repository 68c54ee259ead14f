//! What kind of quantity a comparison limits: a distance, or coordinates one by one, which makes a
//! box where a ball may have been meant.

use std::collections::BTreeMap;

use super::Source;
use super::comparison::Comparison;
use super::parser::{Function, Node, NodeKind, Operator};

/// What kind of quantity is compared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Measure {
    /// A signal by itself.
    Signal(String),
    /// The distance between two points: `distance(/a, /b)`, or the `norm` of the differences of
    /// two or more of their coordinates.
    Distance {
        /// The topic or prefix of the first point, `/a`.
        first: String,
        /// That of the second.
        second: String,
        /// The axes, for example x, y and z.
        axes: Vec<String>,
    },
    /// The difference of one coordinate of two points: `/a.x - /b.x`, perhaps within `abs`.
    AxisDifference {
        /// The topic or prefix of the first point, `/a`.
        first: String,
        /// That of the second.
        second: String,
        /// The axis, for example x.
        axis: String,
        /// Whether the sign does not matter.
        absolute: bool,
    },
    /// The greatest difference of coordinates, `max(abs(/a.x - /b.x), abs(/a.y - /b.y))`.
    GreatestAxisDifference {
        /// The topic or prefix of the first point, `/a`.
        first: String,
        /// That of the second.
        second: String,
        /// The axes.
        axes: Vec<String>,
    },
    /// Anything else.
    Other,
}

/// Limits on several coordinates of the same two points, which together make a box where a
/// distance would make a ball.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisBox<'c> {
    /// The topic or prefix of the first point.
    pub first: String,
    /// That of the second.
    pub second: String,
    /// The comparisons for each axis, by its name.
    pub axes: BTreeMap<String, Vec<&'c Comparison>>,
}

/// Which of `comparisons`, those of one predicate, limit at least two coordinates of the same two
/// points, as in `abs(/a.x - /b.x) < 5 cm & abs(/a.y - /b.y) < 5 cm`.
#[must_use]
pub fn axis_boxes(comparisons: &[Comparison]) -> Vec<AxisBox<'_>> {
    let mut boxes: Vec<AxisBox<'_>> = Vec::new();
    for comparison in comparisons {
        let Measure::AxisDifference {
            first,
            second,
            axis,
            ..
        } = &comparison.measure
        else {
            continue;
        };
        // a - b and b - a are of the same two points.
        let (first, second) = (first.min(second), first.max(second));
        let same = |found: &AxisBox<'_>| found.first == *first && found.second == *second;
        let index = boxes.iter().position(same).unwrap_or_else(|| {
            boxes.push(AxisBox {
                first: first.clone(),
                second: second.clone(),
                axes: BTreeMap::new(),
            });
            boxes.len() - 1
        });
        boxes[index]
            .axes
            .entry(axis.clone())
            .or_default()
            .push(comparison);
    }
    boxes.retain(|found| found.axes.len() > 1);
    boxes
}

impl Source {
    /// What kind of quantity `node` is.
    pub(super) fn measure(&self, node: &Node) -> Measure {
        let node = self.resolved(node);
        match &node.kind {
            NodeKind::Signal(name) => Measure::Signal(name.clone()),
            NodeKind::Call(Function::Distance, arguments) => match &arguments[..] {
                [from, to] => match (&from.kind, &to.kind) {
                    (NodeKind::Signal(first), NodeKind::Signal(second)) => Measure::Distance {
                        first: first.clone(),
                        second: second.clone(),
                        axes: ["x", "y", "z"].map(str::to_owned).to_vec(),
                    },
                    _ => Measure::Other,
                },
                _ => Measure::Other,
            },
            NodeKind::Call(Function::Norm, arguments) => match self.axes(arguments, false) {
                Some((first, second, axes)) => Measure::Distance {
                    first,
                    second,
                    axes,
                },
                None => Measure::Other,
            },
            NodeKind::Call(Function::Max, arguments) => match self.axes(arguments, true) {
                Some((first, second, axes)) => Measure::GreatestAxisDifference {
                    first,
                    second,
                    axes,
                },
                None => Measure::Other,
            },
            _ => self.axis_difference(node),
        }
    }

    /// `/a.x - /b.x` or `abs(/a.x - /b.x)`.
    fn axis_difference(&self, node: &Node) -> Measure {
        let node = self.resolved(node);
        let (node, absolute) = match &node.kind {
            NodeKind::Call(Function::Abs, arguments) => match &arguments[..] {
                [inner] => (self.resolved(inner), true),
                _ => return Measure::Other,
            },
            _ => (node, false),
        };
        let NodeKind::Binary(Operator::Subtract, left, right) = &node.kind else {
            return Measure::Other;
        };
        let (left, right) = (self.resolved(left), self.resolved(right));
        let (NodeKind::Signal(left), NodeKind::Signal(right)) = (&left.kind, &right.kind) else {
            return Measure::Other;
        };
        match (left.rsplit_once('.'), right.rsplit_once('.')) {
            (Some((first, axis)), Some((second, other))) if axis == other && first != second => {
                Measure::AxisDifference {
                    first: first.to_owned(),
                    second: second.to_owned(),
                    axis: axis.to_owned(),
                    absolute,
                }
            }
            _ => Measure::Other,
        }
    }

    /// The two points and the axes, if each of `nodes` is the difference of another coordinate of
    /// the same two points.
    fn axes(&self, nodes: &[Node], absolute: bool) -> Option<(String, String, Vec<String>)> {
        let mut points: Option<(String, String)> = None;
        let mut axes = Vec::new();
        for node in nodes {
            let Measure::AxisDifference {
                first,
                second,
                axis,
                absolute: found,
            } = self.axis_difference(node)
            else {
                return None;
            };
            let same = points
                .as_ref()
                .is_none_or(|it| *it == (first.clone(), second.clone()));
            if !same || (absolute && !found) || axes.contains(&axis) {
                return None;
            }
            points = Some((first, second));
            axes.push(axis);
        }
        let (first, second) = points?;
        (axes.len() > 1).then_some((first, second, axes))
    }
}
