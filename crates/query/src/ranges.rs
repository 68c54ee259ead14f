//! The valuations of constants that run over ranges, in PRISM's order, and which property depends on which.
//!
//! The model's constants come first, in the order of their declaration, then the properties'; the last one runs
//! fastest. A property that does not mention a constant (nor do the formulas, labels and properties that it
//! refers to) is checked once for all of its values.

use crate::properties::Text;
use prism_lang::{Constants, Experiment};
use std::collections::{BTreeMap, BTreeSet};

/// All valuations and what was checked of them.
pub(crate) struct Ranges {
    experiment: Experiment,
    /// For each property, the constants running over ranges that it depends on.
    uses: Vec<Vec<String>>,
    /// The properties that were checked, with the values that they depend on.
    checked: BTreeSet<(usize, Option<String>)>,
}

impl Ranges {
    pub fn new(model: &prism_lang::ast::Model, texts: &[Text], experiment: Experiment) -> Self {
        let of_model: Vec<&str> = model
            .constants
            .iter()
            .map(|c| c.name.text.as_str())
            .collect();
        let others = texts.iter().flat_map(|text| &text.tree.constants);
        let mut order = of_model.clone();
        order.extend(others.map(|c| c.name.text.as_str()));
        let experiment = experiment.ordered(&order);
        let ranges = experiment.ranges();
        let of_text = |text: &Text| {
            let definitions = definitions(text);
            let uses = |(_, property): &(_, String)| {
                let mentioned = mentioned(property, &definitions);
                let depends = |name: &&&str| of_model.contains(*name) || mentioned.contains(**name);
                ranges
                    .iter()
                    .filter(depends)
                    .map(|n| (*n).to_owned())
                    .collect()
            };
            text.all().iter().map(uses).collect::<Vec<Vec<String>>>()
        };
        let uses = texts.iter().flat_map(of_text).collect();
        Self {
            experiment,
            uses,
            checked: BTreeSet::new(),
        }
    }

    pub fn valuations(&self) -> Vec<Constants> {
        self.experiment.valuations().collect()
    }

    /// The values of the constants that run over ranges (of those that a property depends on), if any does.
    pub fn values(&self, given: &Constants, property: Option<usize>) -> Option<String> {
        let all = self.experiment.ranges();
        let own = property.and_then(|place| self.uses.get(place - 1));
        let names: Vec<&str> = match own {
            Some(own) => own.iter().map(String::as_str).collect(),
            None => all,
        };
        let value = |name: &&str| given.get(name).map(|value| format!("{name}={value}"));
        let values: Vec<String> = names.iter().filter_map(value).collect();
        (!values.is_empty()).then(|| values.join(","))
    }

    /// Whether a property was not yet checked for the values that it depends on.
    pub fn is_new(&mut self, property: usize, given: &Constants) -> bool {
        let values = self.values(given, Some(property));
        self.checked.insert((property, values))
    }
}

/// What the names of a text stand for; labels and properties with their quotes.
fn definitions(text: &Text) -> BTreeMap<String, &str> {
    let tree = &text.tree;
    let at = |span: &prism_lang::Span| {
        text.source
            .text
            .get(span.start..span.end)
            .unwrap_or_default()
    };
    let mut found = BTreeMap::new();
    for constant in &tree.constants {
        found.insert(constant.name.text.clone(), at(&constant.span));
    }
    for formula in &tree.formulas {
        found.insert(formula.name.text.clone(), at(&formula.span));
    }
    for label in &tree.labels {
        found.insert(format!("\"{}\"", label.name.text), at(&label.span));
    }
    for property in &tree.properties {
        if let Some(name) = &property.name {
            found.insert(format!("\"{}\"", name.text), property.text.as_str());
        }
    }
    found
}

/// All names in a text, and in what they stand for.
fn mentioned(text: &str, definitions: &BTreeMap<String, &str>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![text];
    while let Some(text) = open.pop() {
        for word in words(text) {
            if found.insert(word.clone())
                && let Some(definition) = definitions.get(&word)
            {
                open.push(definition);
            }
        }
    }
    found
}

/// The names in a text; those in quotes with their quotes.
fn words(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (place, part) in text.split('"').enumerate() {
        if place % 2 == 1 {
            found.push(format!("\"{part}\""));
            continue;
        }
        let names = part.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        found.extend(names.filter(|name| !name.is_empty()).map(str::to_owned));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnostic::Source;

    fn text(text: &str) -> Text {
        let (name, text) = ("p".into(), text.into());
        Text::new(Source { name, text }).expect("properties")
    }

    #[test]
    fn a_property_is_checked_once_for_what_it_depends_on() {
        let model =
            prism_lang::parse_model("dtmc const int N; module m x : [0..N]; endmodule").tree;
        let texts = [text(
            "const int k; const int j = k; label \"l\" = x=j; \"a\": P=? [ F \"l\" ]; P=? [ F x=1 ]; \"a\" > 0",
        )];
        let experiment = Experiment::parse("k=1:3,N=1:2").unwrap();
        let mut ranges = Ranges::new(&model, &texts, experiment);
        let all = ranges.valuations();
        let values: Vec<_> = all
            .iter()
            .map(|v| ranges.values(v, None).unwrap())
            .collect();
        assert_eq!(values[..2], ["N=1,k=1", "N=1,k=2"]);
        let mut count = |property| {
            let new = all.iter().filter(|v| ranges.is_new(property, v));
            new.count()
        };
        assert_eq!((count(1), count(2), count(3)), (6, 2, 6));
        assert_eq!(ranges.values(&all[0], Some(2)).as_deref(), Some("N=1"));
    }
}
