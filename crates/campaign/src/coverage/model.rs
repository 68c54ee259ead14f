//! Coverage models: variables with labels, and cross products of them, as data.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::CampaignError;

/// A label for each variable of interest, by the variables' names.
pub type Situation = BTreeMap<String, String>;

/// A cell of a cross: for each of its variables the place of a label.
pub(super) type Cell = Vec<u16>;

/// The largest number of cells (with wildcards) that a cross may have.
const LARGEST_CROSS: u64 = 2_000_000;

/// What there is to cover. Written as `[[variable]]` and `[[cross]]` tables in TOML.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoverageModel {
    /// What situations differ in.
    #[serde(rename = "variable", default)]
    pub variables: Vec<Variable>,
    /// Which variables are crossed; a cross of one variable counts its labels.
    #[serde(rename = "cross", default)]
    pub crosses: Vec<Cross>,
}

/// A variable with few labels, or a number cut into intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "VariableText", into = "VariableText")]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its labels, in order.
    pub labels: Vec<String>,
    /// For a number: ascending edges, one more than there are labels. An interval holds its
    /// lower edge; the last one its upper edge, too.
    pub edges: Vec<f64>,
    /// The number's unit.
    pub unit: Option<String>,
}

/// A cross product of variables.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    /// Its name.
    pub name: String,
    /// Its variables.
    pub of: Vec<String>,
    /// Blocks of cells that cannot occur: a label for some of the variables, for each block.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<Situation>,
}

/// A variable as it is written: labels, or edges with a unit.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct VariableText {
    name: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    labels: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    edges: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
}

impl TryFrom<VariableText> for Variable {
    type Error = String;

    fn try_from(text: VariableText) -> Result<Self, String> {
        let VariableText {
            name,
            mut labels,
            edges,
            unit,
        } = text;
        let ascending = edges.windows(2).all(|pair| pair[0] < pair[1]);
        if labels.is_empty() == edges.is_empty() {
            return Err(format!("variable `{name}` needs either labels or edges"));
        }
        if !edges.is_empty() && (edges.len() < 2 || !ascending) {
            return Err(format!(
                "variable `{name}`: edges must be two or more, ascending"
            ));
        }
        if labels.is_empty() {
            let suffix = unit
                .as_ref()
                .map(|unit| format!(" {unit}"))
                .unwrap_or_default();
            let pairs = edges.windows(2);
            labels = pairs
                .map(|e| format!("{}..{}{suffix}", e[0], e[1]))
                .collect();
        }
        let distinct: BTreeSet<&String> = labels.iter().collect();
        if distinct.len() != labels.len() || labels.len() > usize::from(u16::MAX) {
            return Err(format!(
                "variable `{name}`: each label may stand there once"
            ));
        }
        Ok(Self {
            name,
            labels,
            edges,
            unit,
        })
    }
}

impl From<Variable> for VariableText {
    fn from(variable: Variable) -> Self {
        let numeric = !variable.edges.is_empty();
        Self {
            name: variable.name,
            labels: if numeric { Vec::new() } else { variable.labels },
            edges: variable.edges,
            unit: variable.unit,
        }
    }
}

impl Variable {
    /// A variable with these labels.
    #[must_use]
    pub fn new(name: &str, labels: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            labels: labels.iter().map(|label| (*label).to_owned()).collect(),
            edges: Vec::new(),
            unit: None,
        }
    }

    /// The label of the interval that holds a number; `None` outside, or without edges.
    #[must_use]
    pub fn label_of(&self, value: f64) -> Option<String> {
        let (first, last) = self.edges.first().zip(self.edges.last())?;
        if !(*first..=*last).contains(&value) {
            return None;
        }
        let above = self.edges.partition_point(|edge| *edge <= value);
        self.labels.get(above.min(self.labels.len()) - 1).cloned()
    }

    fn place(&self, label: &str) -> Option<u16> {
        let place = self.labels.iter().position(|known| known == label)?;
        u16::try_from(place).ok()
    }
}

impl CoverageModel {
    /// Reads `[[variable]]` and `[[cross]]` tables.
    ///
    /// # Errors
    /// [`CampaignError::Text`] with line and column, or what [`check`](Self::check) finds.
    pub fn from_toml(text: &str) -> Result<Self, CampaignError> {
        let model: Self =
            toml::from_str(text).map_err(|error| CampaignError::Text(error.to_string()))?;
        model.check()?;
        Ok(model)
    }

    /// Checks that names are unique, that crosses name variables that there are, and that no
    /// cross has more than two million cells.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`], or [`CampaignError::Setting`] naming the variable or cross.
    pub fn check(&self) -> Result<(), CampaignError> {
        let mut names = BTreeSet::new();
        for variable in &self.variables {
            if !names.insert(&variable.name) {
                let problem = "the name is given to two variables";
                return Err(CampaignError::setting(&variable.name, problem));
            }
        }
        let mut crosses = BTreeSet::new();
        for cross in &self.crosses {
            if !crosses.insert(&cross.name) {
                let problem = "the name is given to two crosses";
                return Err(CampaignError::setting(&cross.name, problem));
            }
            self.check_cross(cross)?;
        }
        Ok(())
    }

    fn check_cross(&self, cross: &Cross) -> Result<(), CampaignError> {
        let distinct: BTreeSet<&String> = cross.of.iter().collect();
        if cross.of.is_empty() || distinct.len() != cross.of.len() {
            let problem = "a cross names one or more variables, each once";
            return Err(CampaignError::setting(&cross.name, problem));
        }
        let mut patterns = 1_u64;
        for name in &cross.of {
            let variable = self
                .variable(name)
                .ok_or_else(|| unknown("variable", name))?;
            patterns = patterns.saturating_mul(variable.labels.len() as u64 + 1);
        }
        if patterns > LARGEST_CROSS {
            let problem = format!(
                "it has too many cells: the product of labels + 1 is {patterns}, at most \
                 {LARGEST_CROSS} is possible; cross fewer variables, or use fewer labels"
            );
            return Err(CampaignError::setting(&cross.name, problem));
        }
        for block in &cross.exclude {
            self.check_situation(block)?;
            if let Some(name) = block.keys().find(|name| !cross.of.contains(name)) {
                return Err(unknown("variable of the cross", name));
            }
        }
        Ok(())
    }

    /// The variable with this name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// Checks that every variable and label of a situation is in the model.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] naming it.
    pub fn check_situation(&self, situation: &Situation) -> Result<(), CampaignError> {
        for (name, label) in situation {
            let variable = self
                .variable(name)
                .ok_or_else(|| unknown("variable", name))?;
            if variable.place(label).is_none() {
                return Err(unknown("label", &format!("{name}={label}")));
            }
        }
        Ok(())
    }

    pub(super) fn variables_of<'m>(
        &'m self,
        cross: &'m Cross,
    ) -> impl Iterator<Item = &'m Variable> {
        cross.of.iter().filter_map(|name| self.variable(name))
    }

    /// The cell of a situation that names all variables of the cross.
    pub(super) fn cell_of(&self, cross: &Cross, situation: &Situation) -> Option<Cell> {
        let place = |variable: &Variable| variable.place(situation.get(&variable.name)?);
        self.variables_of(cross).map(place).collect()
    }

    /// Whether each place of a cell is one of its variable's labels.
    pub(super) fn has_cell(&self, cross: &Cross, cell: &Cell) -> bool {
        let mut pairs = self.variables_of(cross).zip(cell);
        cell.len() == cross.of.len()
            && pairs.all(|(variable, place)| usize::from(*place) < variable.labels.len())
    }

    pub(super) fn labels_of(&self, cross: &Cross, cell: &Cell) -> Vec<String> {
        let pairs = self.variables_of(cross).zip(cell);
        pairs
            .map(|(variable, place)| variable.labels[usize::from(*place)].clone())
            .collect()
    }

    pub(super) fn is_excluded(&self, cross: &Cross, cell: &Cell) -> bool {
        cross.exclude.iter().any(|block| {
            let mut pairs = self.variables_of(cross).zip(cell);
            pairs.all(|(variable, place)| {
                let label = block.get(&variable.name);
                label.is_none_or(|label| variable.labels[usize::from(*place)] == *label)
            })
        })
    }

    /// All cells of a cross that can occur, in order.
    pub(super) fn possible<'m>(&'m self, cross: &'m Cross) -> impl Iterator<Item = Cell> {
        let sizes: Vec<u16> = self
            .variables_of(cross)
            .map(|v| v.labels.len() as u16)
            .collect();
        let total: u64 = sizes.iter().map(|size| u64::from(*size)).product();
        let cell = move |mut number: u64| {
            let mut cell = vec![0; sizes.len()];
            for (place, size) in cell.iter_mut().zip(&sizes).rev() {
                *place = (number % u64::from(*size)) as u16;
                number /= u64::from(*size);
            }
            cell
        };
        (0..total)
            .map(cell)
            .filter(|cell| !self.is_excluded(cross, cell))
    }

    pub(super) fn possible_cells(&self, cross: &Cross) -> u64 {
        if cross.exclude.is_empty() {
            let sizes = self.variables_of(cross).map(|v| v.labels.len() as u64);
            return sizes.product();
        }
        self.possible(cross).count() as u64
    }

    /// For each variable of the cross and each of its labels: how many possible cells with it
    /// are missing.
    pub(super) fn missing_by_label(
        &self,
        cross: &Cross,
        covered: &BTreeSet<&Cell>,
    ) -> Vec<Vec<f64>> {
        let mut counts: Vec<Vec<f64>> = self
            .variables_of(cross)
            .map(|v| vec![0.0; v.labels.len()])
            .collect();
        for cell in self.possible(cross).filter(|cell| !covered.contains(cell)) {
            for (counts, place) in counts.iter_mut().zip(&cell) {
                counts[usize::from(*place)] += 1.0;
            }
        }
        counts
    }
}

fn unknown(kind: &'static str, name: &str) -> CampaignError {
    CampaignError::Unknown {
        kind,
        name: name.to_owned(),
    }
}
