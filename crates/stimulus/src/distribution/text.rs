//! How distributions are written in TOML and JSON.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Distribution, Options};
use crate::error::StimulusError;

/// The names that say which distribution a table is.
pub(crate) const KINDS: [&str; 8] = [
    "constant",
    "uniform",
    "normal",
    "log_uniform",
    "triangular",
    "integer",
    "choice",
    "boolean",
];

/// The keys that may stand beside a kind.
pub(crate) const DETAILS: [&str; 3] = ["low", "high", "weights"];

/// The keys of a distribution, of which one names its kind.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DistributionTable")]
pub(crate) struct Table {
    /// This number.
    #[serde(skip_serializing_if = "Option::is_none")]
    constant: Option<f64>,
    /// Uniform between these two.
    #[serde(skip_serializing_if = "Option::is_none")]
    uniform: Option<[f64; 2]>,
    /// Normal with this mean and standard deviation; `low` and `high` cut it.
    #[serde(skip_serializing_if = "Option::is_none")]
    normal: Option<[f64; 2]>,
    /// Its logarithm is uniform between those of these two, which are above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    log_uniform: Option<[f64; 2]>,
    /// Triangular: least, most probable, greatest.
    #[serde(skip_serializing_if = "Option::is_none")]
    triangular: Option<[f64; 3]>,
    /// A whole number from the first to the last, each equally probable.
    #[serde(skip_serializing_if = "Option::is_none")]
    integer: Option<[i64; 2]>,
    /// One of these, by `weights` where they are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<Options>,
    /// True with this probability.
    #[serde(skip_serializing_if = "Option::is_none")]
    boolean: Option<f64>,
    /// Where a normal distribution is cut below.
    #[serde(skip_serializing_if = "Option::is_none")]
    low: Option<f64>,
    /// Where a normal distribution is cut above.
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<f64>,
    /// The weights of a choice, one for each of its options.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<f64>>,
}

impl Table {
    /// Every distribution that some key names.
    fn candidates(&self) -> Vec<Distribution> {
        let Self { low, high, .. } = self;
        let found = [
            self.constant.map(Distribution::Constant),
            self.uniform
                .map(|[low, high]| Distribution::Uniform { low, high }),
            self.normal.map(|[mean, sd]| Distribution::Normal {
                mean,
                sd,
                low: low.unwrap_or(f64::NEG_INFINITY),
                high: high.unwrap_or(f64::INFINITY),
            }),
            self.log_uniform
                .map(|[low, high]| Distribution::LogUniform { low, high }),
            self.triangular
                .map(|[low, mode, high]| Distribution::Triangular { low, mode, high }),
            self.integer
                .map(|[low, high]| Distribution::Integer { low, high }),
            self.choice.clone().map(|options| Distribution::Choice {
                weights: (self.weights.clone()).unwrap_or_else(|| vec![1.0; options.len()]),
                options,
            }),
            self.boolean
                .map(|probability| Distribution::Boolean { probability }),
        ];
        found.into_iter().flatten().collect()
    }

    /// The one distribution that the table means.
    pub(crate) fn distribution(&self) -> Result<Distribution, StimulusError> {
        let wrong = |what: String| Err(StimulusError::Distribution(what));
        let mut found = self.candidates();
        let Some(distribution) = found.pop() else {
            return wrong(format!("give one of {}", KINDS.join(", ")));
        };
        if !found.is_empty() {
            return wrong(format!("give only one of {}", KINDS.join(", ")));
        }
        let cut = self.low.is_some() || self.high.is_some();
        if cut && self.normal.is_none() {
            return wrong("low and high belong to normal only".to_owned());
        }
        if self.weights.is_some() && self.choice.is_none() {
            return wrong("weights belong to choice only".to_owned());
        }
        distribution.check()?;
        Ok(distribution)
    }
}

impl From<&Distribution> for Table {
    fn from(distribution: &Distribution) -> Self {
        let mut table = Self::default();
        match distribution {
            Distribution::Constant(value) => table.constant = Some(*value),
            Distribution::Uniform { low, high } => table.uniform = Some([*low, *high]),
            Distribution::Normal {
                mean,
                sd,
                low,
                high,
            } => {
                table.normal = Some([*mean, *sd]);
                table.low = low.is_finite().then_some(*low);
                table.high = high.is_finite().then_some(*high);
            }
            Distribution::LogUniform { low, high } => table.log_uniform = Some([*low, *high]),
            Distribution::Triangular { low, mode, high } => {
                table.triangular = Some([*low, *mode, *high]);
            }
            Distribution::Integer { low, high } => table.integer = Some([*low, *high]),
            Distribution::Choice { options, weights } => {
                table.choice = Some(options.clone());
                let even = weights.iter().all(|weight| *weight == 1.0);
                table.weights = (!even).then(|| weights.clone());
            }
            Distribution::Boolean { probability } => table.boolean = Some(*probability),
        }
        table
    }
}

impl Serialize for Distribution {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(value) => serializer.serialize_f64(*value),
            _ => Table::from(self).serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Distribution {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Distribution {
    fn schema_name() -> Cow<'static, str> {
        "Distribution".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<Table>();
        json_schema!({
            "description": "A number, or a distribution from which each episode draws one.",
            "anyOf": [{ "type": "number" }, table],
        })
    }
}

/// Reads a number or a table, with the error of what was meant.
struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Distribution;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a distribution such as { uniform = [0.0, 1.0] }")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        let constant = Distribution::Constant(value);
        constant.check().map_err(E::custom)?;
        Ok(constant)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        let table = Table::deserialize(MapAccessDeserializer::new(map))?;
        table.distribution().map_err(A::Error::custom)
    }
}
