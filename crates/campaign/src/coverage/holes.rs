//! Coverage holes: what was never seen, as the largest blocks of cells.
//!
//! ```text
//! a pattern gives each variable a label or *; it is a hole if no covered cell matches it and
//! some possible cell does; it is listed if no pattern with one more * is a hole
//! ```
//!
//! Source: O. Lachish, E. Marcus, S. Ur and A. Ziv, "Hole analysis for functional coverage data"
//! (2002), projected holes. Deviation: all maximal holes are found, by marking each
//! generalisation of each covered cell, not only those with one or two labels. Cost: O(c 2^k + p k)
//! for c covered and possible cells of k variables and p patterns (at most two million).
//! Guarantee: exact; the listed holes together are all missing possible cells.

use std::cmp::Reverse;
use std::fmt;

use super::model::{Cell, CoverageModel, Cross, Situation};

/// A block of cells that were never seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hole {
    /// For each variable of the cross its name and a label, or `None` for any label.
    pub pattern: Vec<(String, Option<String>)>,
    /// How many possible cells it holds.
    pub cells: u64,
}

impl Hole {
    /// Whether a situation lies in the hole; one that names not all fixed variables does not.
    #[must_use]
    pub fn holds(&self, situation: &Situation) -> bool {
        self.pattern.iter().all(|(variable, label)| match label {
            Some(label) => situation.get(variable) == Some(label),
            None => true,
        })
    }
}

impl fmt::Display for Hole {
    /// `gaze=away × pull=* (4)`: the pattern, and how many cells it holds.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (variable, label)) in self.pattern.iter().enumerate() {
            let separator = if index == 0 { "" } else { " × " };
            let label = label.as_deref().unwrap_or("*");
            write!(f, "{separator}{variable}={label}")?;
        }
        write!(f, " ({})", self.cells)
    }
}

/// Patterns as numbers in mixed radix: digit 0 is `*`, digit i the label at place i - 1.
struct Patterns {
    /// What a step of each variable's digit is worth.
    strides: Vec<usize>,
    radices: Vec<usize>,
    total: usize,
}

impl Patterns {
    fn new(model: &CoverageModel, cross: &Cross) -> Self {
        let radices: Vec<usize> = model
            .variables_of(cross)
            .map(|v| v.labels.len() + 1)
            .collect();
        let mut strides = vec![1; radices.len()];
        let mut total = 1;
        for (stride, radix) in strides.iter_mut().zip(&radices).rev() {
            *stride = total;
            total *= radix;
        }
        Self {
            strides,
            radices,
            total,
        }
    }

    fn digit(&self, pattern: usize, variable: usize) -> usize {
        pattern / self.strides[variable] % self.radices[variable]
    }

    /// All patterns that match a cell: each label, or `*` in its stead.
    fn matching(&self, cell: &Cell) -> Vec<usize> {
        let mut found = vec![0];
        for (place, stride) in cell.iter().zip(&self.strides) {
            let fixed = stride * (usize::from(*place) + 1);
            let more: Vec<usize> = found.iter().map(|pattern| pattern + fixed).collect();
            found.extend(more);
        }
        found
    }
}

/// All maximal holes, the largest first, then those with fewer labels, then in order of the labels.
pub(super) fn find<'c>(
    model: &CoverageModel,
    cross: &Cross,
    covered: impl Iterator<Item = &'c Cell>,
) -> Vec<Hole> {
    let patterns = Patterns::new(model, cross);
    let mut seen = vec![false; patterns.total];
    for cell in covered.filter(|cell| !model.is_excluded(cross, cell)) {
        patterns
            .matching(cell)
            .into_iter()
            .for_each(|p| seen[p] = true);
    }
    let mut possible = vec![0_u64; patterns.total];
    for cell in model.possible(cross) {
        patterns
            .matching(&cell)
            .into_iter()
            .for_each(|p| possible[p] += 1);
    }
    let is_hole = |pattern: usize| !seen[pattern] && possible[pattern] > 0;
    let is_maximal = |pattern: usize| {
        (0..cross.of.len()).all(|variable| {
            let digit = patterns.digit(pattern, variable);
            digit == 0 || !is_hole(pattern - digit * patterns.strides[variable])
        })
    };
    let holes = (0..patterns.total).filter(|p| is_hole(*p) && is_maximal(*p));
    let mut holes: Vec<(u64, usize)> = holes.map(|p| (possible[p], p)).collect();
    let labels = |p: usize| {
        (0..cross.of.len())
            .filter(|v| patterns.digit(p, *v) > 0)
            .count()
    };
    let order = |p: usize| -> Vec<usize> {
        let digits = (0..cross.of.len()).map(|v| patterns.digit(p, v));
        digits.map(star_last).collect()
    };
    holes.sort_by_cached_key(|(cells, p)| (Reverse(*cells), labels(*p), order(*p)));
    let named = holes.into_iter().map(|(cells, pattern)| Hole {
        pattern: named(model, cross, &patterns, pattern),
        cells,
    });
    named.collect()
}

/// Orders `*` behind all labels, so that holes of the first variable come first.
fn star_last(digit: usize) -> usize {
    digit.wrapping_sub(1)
}

fn named(
    model: &CoverageModel,
    cross: &Cross,
    patterns: &Patterns,
    pattern: usize,
) -> Vec<(String, Option<String>)> {
    let variables = model.variables_of(cross).enumerate();
    let named = variables.map(|(index, variable)| {
        let place = patterns.digit(pattern, index).checked_sub(1);
        (
            variable.name.clone(),
            place.map(|p| variable.labels[p].clone()),
        )
    });
    named.collect()
}
