//! Ready requirements for collaborative robots, as templates with parameters.
//!
//! Each template is a sentence whose numbers are parameters with units, defaults and allowed ranges.
//! It names the quantities and propositions that a study has to bind. The templates are written in
//! the sense of the standards that they name: they put into a testable sentence what a clause is
//! about. They do not replace the standard, nor the risk assessment that decides which requirements
//! apply and with which limits; the text and the edition that apply to a robot are to be consulted.
//!
//! ```
//! use requirement_lang::compile::monitor::monitor;
//! use requirement_lang::library;
//!
//! let template = library::template("reduced-speed-near-person").unwrap();
//! let requirement = template.instantiate(&[("near_distance", "10 cm")])?;
//! assert_eq!(
//!     monitor(&requirement.sentence)?.to_string(),
//!     "always (person_distance < near_distance => hand_speed <= reduced_speed)"
//! );
//! assert_eq!(requirement.parameters.get("near_distance").map(|near| near.si_value()), Some(0.1));
//!
//! let mistake = template.instantiate(&[("near_distance", "10 s")]).unwrap_err();
//! assert_eq!(
//!     mistake.to_string(),
//!     "the parameter near_distance is a length, but 10 s is a time; give it in a unit of length"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body_regions;
mod contact;
mod error;
mod mobile;
mod motion;
mod separation;
mod stop;

use trace::Parameters;
use trace::units::{QuantityValue, Unit};

pub use body_regions::{BODY_REGIONS, BodyRegion};
pub use error::TemplateError;
pub use separation::{SeparationTerms, protective_separation_distance_m};

use crate::parse::{Context, parse};
use crate::sentence::Sentence;

/// A requirement with parameters still open.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// Identifier, for example `reduced-speed-near-person`.
    pub id: &'static str,
    /// A short title.
    pub title: &'static str,
    /// The standard and clause in whose sense it is written.
    pub standard: &'static str,
    /// What it is for, and what to mind.
    pub notes: &'static str,
    /// The sentence.
    pub sentence: &'static str,
    /// Its parameters.
    pub parameters: &'static [Declaration],
    /// What a study has to bind in its vocabulary.
    pub needs: &'static [Need],
}

/// A parameter of a template.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// The name in the sentence.
    pub name: &'static str,
    /// The value if none is given; `None` if one has to be given.
    pub default: Option<&'static str>,
    /// The least value allowed, with its unit.
    pub least: &'static str,
    /// The greatest value allowed, with its unit.
    pub most: &'static str,
    /// What it is, and where the default comes from.
    pub meaning: &'static str,
}

/// A quantity or proposition that a template speaks of.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    /// The name in the sentence.
    pub name: &'static str,
    /// The unit of a quantity; `None` for a proposition.
    pub unit: Option<&'static str>,
    /// The frame in which it is to be measured, where that makes a difference.
    pub frame: Option<&'static str>,
    /// What it is.
    pub meaning: &'static str,
}

/// A template with all its parameters set.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The template's identifier.
    pub template: &'static str,
    /// The sentence's text.
    pub text: &'static str,
    /// The sentence.
    pub sentence: Sentence,
    /// The values of its parameters, for its predicates, too.
    pub parameters: Parameters,
}

impl Template {
    /// The template with these values, given as name and text with unit; the others have their
    /// defaults.
    ///
    /// # Errors
    /// [`TemplateError`] if a name is unknown, a value has the wrong dimension or is outside its
    /// range, or a value that has no default is not given.
    pub fn instantiate(&self, values: &[(&str, &str)]) -> Result<Instance, TemplateError> {
        self.check_names(values)?;
        let mut chosen = Vec::with_capacity(self.parameters.len());
        for declaration in self.parameters {
            let given = values.iter().find(|(name, _)| *name == declaration.name);
            let text = given.map(|(_, text)| *text).or(declaration.default);
            let text = text.ok_or(TemplateError::Missing {
                name: declaration.name,
                meaning: declaration.meaning,
            })?;
            declaration.check(text)?;
            chosen.push((declaration.name, text));
        }
        let parameters = Parameters::new(chosen).map_err(|errors| TemplateError::Parameters {
            errors: errors.iter().map(ToString::to_string).collect(),
        })?;
        let context = Context {
            parameters: Some(&parameters),
            vocabulary: None,
        };
        let sentence = parse(self.sentence, &context)
            .into_result()
            .map_err(|diagnostics| TemplateError::Sentence { diagnostics })?;
        Ok(Instance {
            template: self.id,
            text: self.sentence,
            sentence,
            parameters,
        })
    }

    fn check_names(&self, values: &[(&str, &str)]) -> Result<(), TemplateError> {
        let names = || self.parameters.iter().map(|declaration| declaration.name);
        for (index, (name, _)) in values.iter().enumerate() {
            if !names().any(|known| known == *name) {
                return Err(TemplateError::Unknown {
                    name: (*name).to_owned(),
                    similar: trace::nearest(name, names()),
                });
            }
            if values[..index].iter().any(|(earlier, _)| earlier == name) {
                return Err(TemplateError::Twice {
                    name: (*name).to_owned(),
                });
            }
        }
        Ok(())
    }
}

impl Declaration {
    /// Checks a value's dimension and range.
    ///
    /// # Errors
    /// [`TemplateError`] if it is no quantity, of another dimension, or outside the range.
    pub fn check(&self, text: &str) -> Result<(), TemplateError> {
        let quantity = |text: &str| {
            text.parse::<QuantityValue>()
                .map_err(|error| TemplateError::Quantity {
                    name: self.name,
                    error,
                })
        };
        let (value, least, most) = (quantity(text)?, quantity(self.least)?, quantity(self.most)?);
        if value.dimension() != least.dimension() {
            return Err(TemplateError::Dimension {
                name: self.name,
                given: value.to_string(),
                given_dimension: value.dimension(),
                expected: least.dimension(),
            });
        }
        // In the unit of the range, so that a value that is written like a limit equals it exactly.
        let unit = least.unit().cloned().unwrap_or_else(Unit::one);
        let (value_in, least_in, most_in) = (
            value.value_in(&unit),
            least.value_in(&unit),
            most.value_in(&unit),
        );
        match (value_in, least_in, most_in) {
            (Some(value_in), Some(least), Some(most)) if (least..=most).contains(&value_in) => {
                Ok(())
            }
            _ => Err(TemplateError::Range {
                name: self.name,
                given: value.to_string(),
                least: self.least,
                most: self.most,
            }),
        }
    }
}

/// All templates, in the order in which they are best read.
pub fn templates() -> impl Iterator<Item = &'static Template> {
    [
        separation::TEMPLATES,
        motion::TEMPLATES,
        stop::TEMPLATES,
        contact::TEMPLATES,
        mobile::TEMPLATES,
    ]
    .into_iter()
    .flatten()
}

/// The template with this identifier.
#[must_use]
pub fn template(id: &str) -> Option<&'static Template> {
    templates().find(|template| template.id == id)
}

/// The proposition `name`.
const fn proposition(name: &'static str, meaning: &'static str) -> Need {
    Need {
        name,
        unit: None,
        frame: None,
        meaning,
    }
}

/// The quantity `name`, which does not depend on a frame.
const fn quantity(name: &'static str, unit: &'static str, meaning: &'static str) -> Need {
    Need {
        name,
        unit: Some(unit),
        frame: None,
        meaning,
    }
}

/// The quantity `name`, measured in `frame`.
const fn quantity_in(
    name: &'static str,
    unit: &'static str,
    frame: &'static str,
    meaning: &'static str,
) -> Need {
    Need {
        name,
        unit: Some(unit),
        frame: Some(frame),
        meaning,
    }
}

/// The parameter `name` with a default and a range.
const fn parameter(
    name: &'static str,
    default: &'static str,
    [least, most]: [&'static str; 2],
    meaning: &'static str,
) -> Declaration {
    Declaration {
        name,
        default: Some(default),
        least,
        most,
        meaning,
    }
}

/// The least distance between robot and person.
const PERSON_DISTANCE: Need = quantity(
    "person_distance",
    "m",
    "least distance between any part of the robot, with tool and load, and any part of a person; \
     between surfaces, not centres",
);

/// The speed of the hand.
const HAND_SPEED: Need = quantity_in(
    "hand_speed",
    "m/s",
    "the robot's base, or the world if the base moves",
    "speed of the tool centre point, magnitude",
);

/// The speed of the fastest part.
const ROBOT_SPEED: Need = quantity_in(
    "robot_speed",
    "m/s",
    "the robot's base, or the world if the base moves",
    "speed of the fastest part of the robot, magnitude",
);

/// What counts as standstill.
const STANDSTILL_SPEED: Declaration = parameter(
    "standstill_speed",
    "5 mm/s",
    ["0 mm/s", "50 mm/s"],
    "greatest speed that still counts as standstill; above the noise of the measurement",
);

/// The longest time to come to rest.
const STOPPING_TIME: Declaration = parameter(
    "stopping_time",
    "0.5 s",
    ["10 ms", "5 s"],
    "longest time from the request to standstill, reaction and braking together; from the stopping \
     data of the robot at its load and speed",
);
