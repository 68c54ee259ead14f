//! Which declared parameters a sentence uses, so that drift between its forms can be looked for.

use trace::Parameters;
use trace::units::{Dimension, QuantityValue};

use crate::expression::Expression;
use crate::sentence::Sentence;

/// A parameter that a sentence uses.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterUse {
    /// Its name.
    pub name: String,
    /// What it measures.
    pub dimension: Dimension,
    /// Its declared value.
    pub value: QuantityValue,
    /// Whether it stands for a duration of the sentence; otherwise only propositions speak of it.
    pub as_duration: bool,
}

impl Sentence {
    /// The parameters it uses, in alphabetical order, each once: as durations, and by name in the
    /// texts of its propositions. What the vocabulary's definitions use is not seen here.
    ///
    /// ```
    /// use requirement_lang::{Context, parse};
    /// let parameters = trace::Parameters::new([("near", "10 cm"), ("wait", "2 s"), ("far", "1 m")])
    ///     .map_err(|errors| errors[0].clone())?;
    /// let context = Context { parameters: Some(&parameters), vocabulary: None };
    /// let text = "When norm(/hand.near, /hand.y) < near, the robot shall within wait satisfy still";
    /// let sentence = parse(text, &context).into_result().map_err(|mistakes| mistakes[0].clone())?;
    /// let uses = sentence.parameters_used(&parameters);
    /// let shown: Vec<String> = uses.iter().map(|used| format!("{}: {}", used.name, used.dimension)).collect();
    /// assert_eq!(shown, ["near: length", "wait: time"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn parameters_used(&self, parameters: &Parameters) -> Vec<ParameterUse> {
        let durations: Vec<&str> = (self.stages.iter())
            .filter_map(|stage| stage.timing.duration())
            .map(|duration| duration.text.as_str())
            .collect();
        let atoms = self.expressions().into_iter().flat_map(Expression::atoms);
        let names: Vec<&str> = atoms.flat_map(|atom| names(&atom.text)).collect();
        let used = |(name, value): (&str, &QuantityValue)| {
            let as_duration = durations.contains(&name);
            (as_duration || names.contains(&name)).then(|| ParameterUse {
                name: name.to_owned(),
                dimension: value.dimension(),
                value: value.clone(),
                as_duration,
            })
        };
        parameters.iter().filter_map(used).collect()
    }
}

/// The plain names in the text of a proposition: not those in quotes, in signals (`/topic.field`),
/// of functions, or of units behind a number.
fn names(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    let mut rest = text;
    let mut place = Place::Free;
    while let Some(first) = rest.chars().next() {
        let signal = first == '/' && rest[1..].starts_with(is_letter) && place == Place::Free;
        let length = match first {
            '\'' | '"' | '`' => rest[1..].find(first).map_or(rest.len(), |end| end + 2),
            _ if signal => run(rest, |letter| {
                letter.is_alphanumeric() || "/._[]".contains(letter)
            }),
            _ if is_letter(first) => run(rest, |letter| letter.is_alphanumeric() || letter == '_'),
            _ if first.is_ascii_digit() => {
                run(rest, |letter| letter.is_ascii_digit() || letter == '.')
            }
            _ => first.len_utf8(),
        };
        let (token, following) = rest.split_at(length);
        let called = following.trim_start().starts_with('(');
        if is_letter(first) && !called && place == Place::Free {
            names.push(token);
        }
        place = place.after(first);
        rest = following;
    }
    names
}

/// Where a reader is with regard to numbers and their units.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// Where a name can stand.
    Free,
    /// Behind a number, perhaps with white space between.
    Number,
    /// Directly behind a unit.
    Unit,
    /// Directly behind a sign that joins units, as in `mm/s`.
    Joined,
}

impl Place {
    /// The place behind a token that begins with `first`.
    fn after(self, first: char) -> Self {
        match self {
            Place::Number if first.is_whitespace() => Place::Number,
            Place::Number | Place::Joined if is_letter(first) => Place::Unit,
            Place::Unit if "/*^".contains(first) => Place::Joined,
            Place::Joined if first.is_ascii_digit() => Place::Unit,
            _ if first.is_ascii_digit() => Place::Number,
            _ => Place::Free,
        }
    }
}

fn is_letter(letter: char) -> bool {
    letter.is_alphabetic() || letter == '_'
}

fn run(text: &str, inside: impl Fn(char) -> bool) -> usize {
    text.find(|letter| !inside(letter)).unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::names;

    #[test]
    fn names_are_told_from_signals_units_functions_and_quotes() {
        assert_eq!(names("/robot.near < near"), ["near"]);
        assert_eq!(names("norm(/a.x, reach) > 250 mm/s"), ["reach"]);
        assert_eq!(names("/robot.state = 'near'"), [""; 0]);
        assert_eq!(
            names("distance >= speed * (reaction + 0.3 s) + margin"),
            ["distance", "speed", "reaction", "margin"]
        );
        assert_eq!(names("speed / limit < 3"), ["speed", "limit"]);
        assert_eq!(names("2 * reach < 3 N/cm^2 + margin"), ["reach", "margin"]);
        assert_eq!(names("1e-3 < reach"), ["reach"]);
        assert_eq!(names("reach < 5 m and"), ["reach", "and"]);
    }
}
