//! Trees as plain data, what they mean by enumeration of all truth assignments, and their texts.

use std::collections::BTreeSet;
use std::fmt::Write;

use diagnostic::{Cancel, Problem, Source};
use fault_tree::{
    Analysis, BigRational, Connective, FaultTree, Options, Reading, Settings, decimal,
    read_galileo, read_open_psa,
};

/// Events `e0`, `e1`, ..., gates `g0`, `g1`, ...; an argument below the number of events is an event, else a gate before.
#[derive(Clone, Debug)]
pub struct Sketch {
    /// Decimal texts.
    pub probabilities: Vec<String>,
    /// The last is the top event.
    pub gates: Vec<(Connective, Vec<usize>)>,
}

/// Exactly one half is left out: it would hide an exchange of a probability and its complement.
pub const PROBABILITIES: [&str; 8] = ["0.1", "0.25", "0.7", "0.03", "0.9", "1e-3", "0.6", "0.45"];

impl Sketch {
    pub fn events(&self) -> usize {
        self.probabilities.len()
    }

    fn name(&self, argument: usize) -> String {
        match argument.checked_sub(self.events()) {
            None => format!("e{argument}"),
            Some(gate) => format!("g{gate}"),
        }
    }

    pub fn top(&self) -> String {
        format!("g{}", self.gates.len() - 1)
    }

    pub fn galileo(&self) -> String {
        let mut text = format!("toplevel \"{}\";\n", self.top());
        for (index, (connective, arguments)) in self.gates.iter().enumerate() {
            let word = match connective {
                Connective::And => "and".to_owned(),
                Connective::Or => "or".to_owned(),
                Connective::Not => "not".to_owned(),
                Connective::Xor => "xor".to_owned(),
                Connective::Nand => "nand".to_owned(),
                Connective::Nor => "nor".to_owned(),
                Connective::AtLeast(k) => format!("{k}of{}", arguments.len()),
            };
            write!(text, "\"g{index}\" {word}").expect("a string");
            for argument in arguments {
                write!(text, " \"{}\"", self.name(*argument)).expect("a string");
            }
            text.push_str(";\n");
        }
        for (index, probability) in self.probabilities.iter().enumerate() {
            writeln!(text, "e{index} prob={probability};").expect("a string");
        }
        text
    }

    /// With every second gate written where it is used, so that formulas nest.
    pub fn open_psa(&self) -> String {
        let mut text =
            "<?xml version=\"1.0\"?>\n<opsa-mef>\n<define-fault-tree name=\"t\">\n".to_owned();
        for index in 0..self.gates.len() {
            writeln!(
                text,
                "<define-gate name=\"g{index}\">{}</define-gate>",
                self.formula(index)
            )
            .expect("a string");
        }
        text.push_str("</define-fault-tree>\n<model-data>\n");
        for (index, probability) in self.probabilities.iter().enumerate() {
            let event = format!(
                "<define-basic-event name=\"e{index}\"><float value=\"{probability}\"/></define-basic-event>"
            );
            writeln!(text, "{event}").expect("a string");
        }
        text + "</model-data>\n</opsa-mef>\n"
    }

    fn formula(&self, gate: usize) -> String {
        let (connective, arguments) = &self.gates[gate];
        let (word, attribute) = match connective {
            Connective::And => ("and", String::new()),
            Connective::Or => ("or", String::new()),
            Connective::Not => ("not", String::new()),
            Connective::Xor => ("xor", String::new()),
            Connective::Nand => ("nand", String::new()),
            Connective::Nor => ("nor", String::new()),
            Connective::AtLeast(k) => ("atleast", format!(" min=\"{k}\"")),
        };
        let argument = |it: &usize| match it.checked_sub(self.events()) {
            None => format!("<basic-event name=\"e{it}\"/>"),
            Some(gate) if gate % 2 == 0 => self.formula(gate),
            Some(gate) => format!("<gate name=\"g{gate}\"/>"),
        };
        let inner: String = arguments.iter().map(argument).collect();
        format!("<{word}{attribute}>{inner}</{word}>")
    }

    /// Whether the top event occurs if the events of these bits do.
    pub fn holds(&self, assignment: u32) -> bool {
        let mut values: Vec<bool> = (0..self.events())
            .map(|bit| assignment >> bit & 1 == 1)
            .collect();
        for (connective, arguments) in &self.gates {
            let count = arguments.iter().filter(|it| values[**it]).count();
            values.push(match connective {
                Connective::And => count == arguments.len(),
                Connective::Or => count > 0,
                Connective::Not | Connective::Nor => count == 0,
                Connective::Xor => count == 1,
                Connective::Nand => count < arguments.len(),
                Connective::AtLeast(k) => count >= *k,
            });
        }
        *values.last().expect("a gate")
    }

    pub fn exact(&self) -> Vec<BigRational> {
        let numbers = self.probabilities.iter();
        numbers.map(|it| decimal(it).expect("a number")).collect()
    }

    /// The sum over all assignments in which the top event occurs.
    pub fn probability(&self, events: &[BigRational]) -> BigRational {
        let one = decimal("1").expect("a number");
        let mut sum = decimal("0").expect("a number");
        for assignment in (0..1_u32 << self.events()).filter(|it| self.holds(*it)) {
            let factor = |(bit, p): (usize, &BigRational)| match assignment >> bit & 1 {
                1 => p.clone(),
                _ => &one - p,
            };
            sum += events
                .iter()
                .enumerate()
                .map(factor)
                .fold(one.clone(), |a, b| a * b);
        }
        sum
    }

    /// Whether no event can prevent the top event.
    pub fn is_monotone(&self) -> bool {
        let all = 0..1_u32 << self.events();
        all.clone()
            .all(|a| (0..self.events()).all(|bit| !self.holds(a) || self.holds(a | 1 << bit)))
    }

    /// The assignments in which the top event occurs and that contain no other such assignment.
    pub fn minimal_solutions(&self) -> BTreeSet<u32> {
        let solutions: Vec<u32> = (0..1_u32 << self.events())
            .filter(|it| self.holds(*it))
            .collect();
        let is_minimal = |it: &&u32| {
            solutions
                .iter()
                .all(|other| other == *it || other & **it != *other)
        };
        solutions.iter().filter(is_minimal).copied().collect()
    }
}

pub fn galileo(text: &str) -> Result<Reading, Problem> {
    read_galileo(&Source::new("tree.dft", text), &Settings::default())
}

pub fn open_psa(text: &str) -> Result<Reading, Problem> {
    read_open_psa(&Source::new("tree.xml", text), &Settings::default())
}

/// The analysis of the top event of a tree, with the usual options.
pub fn analysis(tree: &FaultTree) -> Analysis<'_> {
    let top = tree.top().expect("a top event");
    Analysis::new(tree, top, Options::default(), &Cancel::default()).expect("a small tree")
}

/// The cut sets of a sketch's tree as bits of its events.
pub fn cut_sets_as_bits(tree: &FaultTree, analysis: &Analysis<'_>) -> Vec<u32> {
    let found = analysis
        .cut_sets(usize::MAX, &Cancel::default())
        .expect("a small tree");
    assert!(found.is_complete());
    let bit = |name: &str| 1_u32 << name[1..].parse::<u32>().expect("e0, e1, ...");
    let bits = |set: &Vec<_>| set.iter().map(|id| bit(tree.name(*id))).sum();
    found.sets.iter().map(bits).collect()
}

/// Whether two doubles enclose a rational number.
pub fn encloses(lower: f64, upper: f64, value: &BigRational) -> bool {
    let is_above =
        upper == f64::INFINITY || BigRational::from_float(upper).expect("a number") >= *value;
    BigRational::from_float(lower).expect("a number") <= *value && is_above
}
