//! Coverage: which situations, requirements, model states and lines of code a campaign has seen,
//! what it has not, and whether more episodes would still show anything new.
//!
//! | question | answered by |
//! |---|---|
//! | Which combinations of circumstances were seen? | [`CoverageModel`], [`Coverage`] |
//! | What is missing, in the fewest words? | [`Coverage::holes`] |
//! | What should be generated next? | [`Coverage::label_weights`] |
//! | Which states and transitions of a model were visited, and which does it not have? | [`SetCoverage`] |
//! | Which code of the controller ran? | [`Lcov`] |
//! | Do more episodes pay? | [`Saturation`] |

mod holes;
mod lcov;
mod model;
mod saturation;
mod sets;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

pub use holes::Hole;
pub use lcov::{FileCoverage, Lcov, Share};
pub use model::{CoverageModel, Cross, Situation, Variable};
pub use saturation::Saturation;
pub use sets::{SetCoverage, Visits};

use crate::error::CampaignError;
use model::Cell;

/// What a campaign has covered of its model.
///
/// ```
/// use campaign::{Coverage, CoverageModel};
/// let model = CoverageModel::from_toml(r#"
///     [[variable]]
///     name = "gaze"
///     labels = ["on the object", "away"]
///
///     [[variable]]
///     name = "pull"
///     unit = "N"
///     edges = [1, 5, 15]
///
///     [[cross]]
///     name = "situation"
///     of = ["gaze", "pull"]
///     "#)?;
/// let pull = model.variable("pull").and_then(|v| v.label_of(3.2)).unwrap_or_default();
/// let mut coverage = Coverage::new(model);
/// coverage.record(&[[("gaze".to_owned(), "on the object".to_owned()), ("pull".to_owned(), pull)].into()])?;
/// let holes: Vec<String> = coverage.holes("situation", 10)?.iter().map(ToString::to_string).collect();
/// assert_eq!(holes, ["gaze=away × pull=* (2)", "gaze=* × pull=5..15 N (2)"]);
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Kept")]
pub struct Coverage {
    model: CoverageModel,
    episodes: u64,
    /// For each cross of the model, in its order: covered cells, and in how many episodes.
    cells: Vec<Vec<(Cell, u64)>>,
    /// The places (from 0) of the episodes that showed something new.
    news: Vec<u64>,
}

/// Coverage as it was written down, not yet checked against its model.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    model: CoverageModel,
    episodes: u64,
    cells: Vec<Vec<(Cell, u64)>>,
    news: Vec<u64>,
}

impl TryFrom<Kept> for Coverage {
    type Error = CampaignError;

    fn try_from(kept: Kept) -> Result<Self, CampaignError> {
        kept.model.check()?;
        let mut coverage = Self::new(kept.model);
        let fits = |(cross, cells): (&Cross, &Vec<(Cell, u64)>)| {
            let ascending = cells.windows(2).all(|pair| pair[0].0 < pair[1].0);
            ascending
                && cells
                    .iter()
                    .all(|(cell, _)| coverage.model.has_cell(cross, cell))
        };
        let mut pairs = coverage.model.crosses.iter().zip(&kept.cells);
        if kept.cells.len() != coverage.cells.len() || !pairs.all(fits) {
            let problem = "the counts that were kept do not fit the model beside them";
            return Err(CampaignError::Text(problem.to_owned()));
        }
        coverage.episodes = kept.episodes;
        coverage.cells = kept.cells;
        coverage.news = kept.news;
        Ok(coverage)
    }
}

/// A bin that an episode was the first to cover.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct NewBin {
    /// The cross.
    pub cross: String,
    /// The cell's labels, in the order of the cross's variables.
    pub labels: Vec<String>,
}

impl Coverage {
    /// Nothing covered yet.
    #[must_use]
    pub fn new(model: CoverageModel) -> Self {
        Self {
            cells: vec![Vec::new(); model.crosses.len()],
            model,
            episodes: 0,
            news: Vec::new(),
        }
    }

    /// The bins that there are.
    #[must_use]
    pub fn model(&self) -> &CoverageModel {
        &self.model
    }

    /// How many episodes were recorded.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Records the situations of one episode and returns the bins that it was the first to
    /// cover. A situation counts for each cross all of whose variables it names.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a variable or a label that the model does not have; then
    /// nothing is recorded.
    pub fn record(&mut self, situations: &[Situation]) -> Result<Vec<NewBin>, CampaignError> {
        let mut hit: Vec<BTreeSet<Cell>> = vec![BTreeSet::new(); self.model.crosses.len()];
        for situation in situations {
            self.model.check_situation(situation)?;
            for (cross, hit) in self.model.crosses.iter().zip(&mut hit) {
                hit.extend(self.model.cell_of(cross, situation));
            }
        }
        let mut new = Vec::new();
        for (index, hit) in hit.into_iter().enumerate() {
            for cell in hit {
                if self.count(index, &cell) {
                    new.push(self.bin(index, &cell));
                }
            }
        }
        if !new.is_empty() {
            self.news.push(self.episodes);
        }
        self.episodes += 1;
        Ok(new)
    }

    /// Counts one more episode for a cell; whether it is the first.
    fn count(&mut self, cross: usize, cell: &Cell) -> bool {
        let cells = &mut self.cells[cross];
        match cells.binary_search_by(|(known, _)| known.cmp(cell)) {
            Ok(place) => {
                cells[place].1 += 1;
                false
            }
            Err(place) => {
                cells.insert(place, (cell.clone(), 1));
                true
            }
        }
    }

    fn bin(&self, cross: usize, cell: &Cell) -> NewBin {
        let cross = &self.model.crosses[cross];
        NewBin {
            cross: cross.name.clone(),
            labels: self.model.labels_of(cross, cell),
        }
    }

    fn index_of(&self, cross: &str) -> Result<usize, CampaignError> {
        let found = self.model.crosses.iter().position(|c| c.name == cross);
        found.ok_or_else(|| CampaignError::Unknown {
            kind: "cross",
            name: cross.to_owned(),
        })
    }

    /// Covered cells with their labels and the number of episodes that covered them, in order.
    /// Cells that the model excludes are among them when they were seen all the same.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a cross that the model does not have.
    pub fn covered(&self, cross: &str) -> Result<Vec<(Vec<String>, u64)>, CampaignError> {
        let index = self.index_of(cross)?;
        let cross = &self.model.crosses[index];
        let cells = self.cells[index].iter();
        Ok(cells
            .map(|(cell, count)| (self.model.labels_of(cross, cell), *count))
            .collect())
    }

    /// How many of a cross's possible cells are covered, and how many there are.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a cross that the model does not have.
    pub fn share(&self, cross: &str) -> Result<Share, CampaignError> {
        let index = self.index_of(cross)?;
        let cross = &self.model.crosses[index];
        let possible = |(cell, _): &&(Cell, u64)| !self.model.is_excluded(cross, cell);
        Ok(Share {
            covered: self.cells[index].iter().filter(possible).count() as u64,
            total: self.model.possible_cells(cross),
        })
    }

    /// Cells that were seen although the model says that they cannot occur: the model of the
    /// situations is wrong there.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a cross that the model does not have.
    pub fn seen_though_excluded(&self, cross: &str) -> Result<Vec<Vec<String>>, CampaignError> {
        let index = self.index_of(cross)?;
        let cross = &self.model.crosses[index];
        let cells = self.cells[index].iter();
        let excluded = cells.filter(|(cell, _)| self.model.is_excluded(cross, cell));
        Ok(excluded
            .map(|(cell, _)| self.model.labels_of(cross, cell))
            .collect())
    }

    /// What was never seen, as the largest blocks of cells, at most `limit` of them: no block
    /// lies within another, and together they are all that is missing.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a cross that the model does not have.
    pub fn holes(&self, cross: &str, limit: usize) -> Result<Vec<Hole>, CampaignError> {
        let index = self.index_of(cross)?;
        let covered = self.cells[index].iter().map(|(cell, _)| cell);
        let cross = &self.model.crosses[index];
        let mut holes = holes::find(&self.model, cross, covered);
        holes.truncate(limit);
        Ok(holes)
    }

    /// For each variable of a cross, each label's weight for generation: half of it even, half in
    /// proportion to the missing cells that have the label. Weights of a variable add up to 1.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a cross that the model does not have.
    pub fn label_weights(
        &self,
        cross: &str,
    ) -> Result<BTreeMap<String, Vec<(String, f64)>>, CampaignError> {
        let index = self.index_of(cross)?;
        let cross = &self.model.crosses[index];
        let covered = self.cells[index].iter().map(|(cell, _)| cell).collect();
        let missing = self.model.missing_by_label(cross, &covered);
        let mut weights = BTreeMap::new();
        for (variable, counts) in self.model.variables_of(cross).zip(missing) {
            let total: f64 = counts.iter().sum();
            let even = 1.0 / counts.len() as f64;
            let weight = |count: f64| match total > 0.0 {
                true => 0.5 * even + 0.5 * count / total,
                false => even,
            };
            let labels = variable.labels.iter().cloned();
            let labels = labels.zip(counts.iter().map(|count| weight(*count)));
            weights.insert(variable.name.clone(), labels.collect());
        }
        Ok(weights)
    }

    /// What the counts of all bins say about bins that were not seen yet.
    #[must_use]
    pub fn saturation(&self) -> Saturation {
        let counts = self.cells.iter().flatten().map(|(_, count)| *count);
        Saturation::new(self.episodes, counts, &self.news)
    }
}

#[cfg(test)]
mod tests;
