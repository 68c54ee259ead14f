//! Basic events, house events and the numbers in them.

use num_rational::BigRational;
use num_traits::One;
use roxmltree::Node;

use super::{Reader, content, tag};
use crate::data::EventData;
use crate::decimal::decimal;
use crate::draft::Body;

impl<'d> Reader<'_, 'd, '_> {
    pub(super) fn house(&mut self, definition: Node<'d, 'd>) -> Body {
        let mut values = content(definition);
        let Some(value) = values.next() else {
            return Body::House(false);
        };
        if !value.has_tag_name("constant") || values.next().is_some() {
            let message = "a house event has one `constant`";
            self.mistakes.add(
                tag(definition),
                message,
                "write `<constant value=\"true\"/>` in it",
            );
            return Body::Unknown;
        }
        self.constant(value).map_or(Body::Unknown, Body::House)
    }

    /// What is known of a basic event. `None` is a mistake that was reported, `Some(None)` an event without data.
    pub(super) fn basic(&mut self, definition: Node<'d, 'd>) -> Option<Option<EventData>> {
        if let Some(data) = self.by_attributes(definition) {
            return data.map(Some);
        }
        let mut expressions = content(definition);
        let Some(expression) = expressions.next() else {
            return Some(None);
        };
        if let Some(second) = expressions.next() {
            self.mistakes.add(
                tag(second),
                "a basic event has one expression",
                "keep one of them",
            );
            return None;
        }
        if expression.has_tag_name("exponential") {
            return self.exponential(expression).map(Some);
        }
        let value = self.number(expression)?;
        if value > BigRational::one() {
            let message = "the probability of a basic event must be between 0 and 1";
            self.mistakes
                .add(tag(expression), message, "correct the number");
            return None;
        }
        Some(Some(EventData::Probability(value)))
    }

    fn exponential(&mut self, expression: Node<'d, 'd>) -> Option<EventData> {
        let mut arguments = content(expression);
        let (Some(rate), Some(time), None) = (arguments.next(), arguments.next(), arguments.next())
        else {
            let message = "`exponential` has two numbers: the rate and the time";
            self.mistakes.add(
                tag(expression),
                message,
                "write for example `<float value=\"1e-3\"/><system-mission-time/>`",
            );
            return None;
        };
        let (rate, time) = (self.number(rate), self.number(time));
        Some(EventData::Rate {
            rate: rate?,
            time: time?,
        })
    }

    /// The value of an expression that is a number. Parameters lead from one to the next.
    fn number(&mut self, expression: Node<'d, 'd>) -> Option<BigRational> {
        let mut at = expression;
        for _ in 0..=self.parameters.len() {
            match at.tag_name().name() {
                "float" | "int" => return self.literal(at),
                "system-mission-time" => return self.mission_time(at),
                "parameter" => {
                    let (name, span) = self.name(at)?;
                    let Some(definition) = self.parameters.get(name).copied() else {
                        self.mistakes.undefined(span, name);
                        return None;
                    };
                    at = self.expression_of(definition)?;
                }
                other => {
                    let message = format!("the expression `{other}` is not read");
                    let remedy = "use float, int, parameter, system-mission-time or exponential";
                    self.mistakes.refuse(tag(at), message, remedy);
                    return None;
                }
            }
        }
        self.mistakes.add(
            tag(expression),
            "this parameter depends on itself",
            "give one of them a number",
        );
        None
    }

    fn expression_of(&mut self, definition: Node<'d, 'd>) -> Option<Node<'d, 'd>> {
        let mut expressions = content(definition);
        match (expressions.next(), expressions.next()) {
            (Some(expression), None) => Some(expression),
            _ => {
                self.mistakes.add(
                    tag(definition),
                    "a parameter has one expression",
                    "write for example `<float>`",
                );
                None
            }
        }
    }

    fn literal(&mut self, node: Node<'d, 'd>) -> Option<BigRational> {
        let text = node.attribute("value").unwrap_or_default().trim();
        let value = decimal(text);
        if value.is_none() {
            let message = format!("the value must be a number of at least 0 (got `{text}`)");
            self.mistakes.add(tag(node), message, "correct the number");
        }
        value
    }

    fn mission_time(&mut self, node: Node<'d, 'd>) -> Option<BigRational> {
        if self.settings.mission_time.is_none() {
            let message = "this needs the mission time, and none is given";
            self.mistakes
                .add(tag(node), message, "give the mission time");
        }
        self.settings.mission_time.clone()
    }

    /// Counts or an interval from the attributes; `None` if there are no such attributes, `Some(None)` if they are wrong.
    fn by_attributes(&mut self, definition: Node<'d, 'd>) -> Option<Option<EventData>> {
        let attributes = definition
            .children()
            .find(|it| it.has_tag_name("attributes"))?;
        let get = |wanted: &str| {
            let mut known = attributes
                .children()
                .filter(|it| it.has_tag_name("attribute"));
            known
                .find(|it| it.attribute("name") == Some(wanted))?
                .attribute("value")
        };
        let counts = (get("occurrences"), get("trials"));
        let ends = (get("probability-lower"), get("probability-upper"));
        let data = match (counts, ends) {
            ((None, None), (None, None)) => return None,
            ((Some(occurrences), Some(trials)), (None, None)) => {
                let whole = |text: &str| text.trim().parse().ok();
                let both = whole(occurrences).zip(whole(trials));
                both.and_then(|(occurrences, trials)| EventData::counts(occurrences, trials))
            }
            ((None, None), (Some(lower), Some(upper))) => {
                EventData::interval(lower.trim(), upper.trim())
            }
            _ => None,
        };
        if data.is_none() {
            let message = "these attributes must be `occurrences` and `trials` (whole numbers, occurrences at most trials), \
                           or `probability-lower` and `probability-upper` (between 0 and 1, in this order)";
            self.mistakes
                .add(tag(attributes), message, "correct them, or take them away");
        }
        Some(data)
    }
}
