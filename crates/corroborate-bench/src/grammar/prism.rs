//! A machine as a model in the PRISM language, in one of many styles: names of constants and states, constants or
//! numbers, probabilities of failing or of passing, one module or several that are synchronised.

use super::machine::{Branch, Command, Factor, Guard, Machine, Time, Update};
use crate::random::Random;
use std::fmt::Write as _;

/// How the states are named in the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Names {
    /// By constants.
    Constants,
    /// By formulas.
    Formulas,
    /// Not at all.
    Numbers,
}

/// How a model is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// The variable of the location.
    pub variable: &'static str,
    /// How states are named.
    pub names: Names,
    /// For each constant, whether its number stands where it is used, without a name.
    pub inline: Vec<bool>,
    /// For each constant, whether the text has 1 minus it.
    pub complement: Vec<bool>,
    /// Whether counters stand in a module of their own where that can be.
    pub is_split: bool,
    /// Whether ends have a command each.
    pub ends_apart: bool,
    /// Constants that are given as this text, such as a quotient of counts.
    pub given: Vec<Option<String>>,
}

impl Style {
    /// Draws a style.
    pub fn draw(machine: &Machine, random: &mut Random) -> Self {
        let is_rate = |place: usize| machine.time == Time::Rates && is_rate(machine, place);
        let inline = random.chance(0.15);
        let count = machine.constants.len();
        Self {
            variable: random.one_of(&["s", "phase", "robot", "loc", "task"]),
            names: random.one_of(&[Names::Constants, Names::Formulas, Names::Numbers]),
            inline: (0..count).map(|_| inline && random.chance(0.5)).collect(),
            complement: (0..count)
                .map(|place| !is_rate(place) && random.chance(0.25))
                .collect(),
            is_split: random.chance(0.4),
            ends_apart: random.chance(0.5),
            given: vec![None; count],
        }
    }

    /// What says in a model that the machine is at a location.
    #[must_use]
    pub fn is_at(&self, machine: &Machine, location: usize) -> String {
        let (variable, name) = (self.variable, &machine.locations[location]);
        match self.names {
            Names::Constants => format!("{variable}=at_{name}"),
            Names::Formulas => format!("in_{name}"),
            Names::Numbers => format!("{variable}={location}"),
        }
    }

    /// The name of a constant in the text.
    #[must_use]
    pub fn constant(&self, machine: &Machine, place: usize) -> String {
        let name = &machine.constants[place].name;
        match self.complement[place] {
            true => format!("{name}_ok"),
            false => name.clone(),
        }
    }

    /// The number of a constant as the text has it.
    #[must_use]
    pub fn number(&self, machine: &Machine, place: usize) -> String {
        let value = machine.constants[place].value;
        match self.complement[place] {
            true => decimal(1.0 - value),
            false => decimal(value),
        }
    }

    /// The model's text.
    #[must_use]
    pub fn text(&self, machine: &Machine) -> String {
        let mut text = String::from(match machine.time {
            Time::Steps => "dtmc\n\n",
            Time::Choices => "mdp\n\n",
            Time::Rates => "ctmc\n\n",
        });
        for place in 0..machine.constants.len() {
            let named = !self.inline[place] || self.given[place].is_some();
            if named && is_used(machine, place) {
                let value = self.given[place]
                    .clone()
                    .unwrap_or_else(|| self.number(machine, place));
                let _ = writeln!(
                    text,
                    "const double {} = {value};",
                    self.constant(machine, place)
                );
            }
        }
        self.write_names(machine, &mut text);
        let split: Vec<bool> = (0..machine.counters.len())
            .map(|counter| self.stands_apart(machine, counter))
            .collect();
        let _ = writeln!(
            text,
            "\nmodule {}",
            if self.variable == "robot" {
                "unit"
            } else {
                "controller"
            }
        );
        let _ = writeln!(
            text,
            "  {} : [0..{}] init 0;",
            self.variable,
            machine.locations.len() - 1
        );
        for (place, counter) in machine
            .counters
            .iter()
            .enumerate()
            .filter(|(place, _)| !split[*place])
        {
            let _ = place;
            let _ = writeln!(
                text,
                "  {} : [0..{}] init {};",
                counter.name, counter.most, counter.first
            );
        }
        text.push('\n');
        for (number, command) in machine.commands.iter().enumerate() {
            self.write_command(machine, number, command, &split, &mut text);
        }
        self.write_ends(machine, &mut text);
        text.push_str("endmodule\n");
        for (counter, _) in split.iter().enumerate().filter(|(_, apart)| **apart) {
            write_counter(machine, counter, &mut text);
        }
        text
    }

    fn write_names(&self, machine: &Machine, text: &mut String) {
        text.push('\n');
        for (place, name) in machine.locations.iter().enumerate() {
            let _ = match self.names {
                Names::Constants => writeln!(text, "const int at_{name} = {place};"),
                Names::Formulas => writeln!(text, "formula in_{name} = {}={place};", self.variable),
                Names::Numbers => writeln!(text, "// {place}: {name}"),
            };
        }
    }

    /// Whether a counter can stand in a module of its own: each command changes it alike on all branches.
    fn stands_apart(&self, machine: &Machine, counter: usize) -> bool {
        self.is_split
            && machine.time != Time::Rates
            && machine.commands.iter().all(|command| {
                let first = of_counter(&command.branches[0], counter);
                command
                    .branches
                    .iter()
                    .all(|branch| of_counter(branch, counter) == first)
            })
    }

    fn write_command(
        &self,
        machine: &Machine,
        number: usize,
        command: &Command,
        split: &[bool],
        text: &mut String,
    ) {
        let apart = |update: &Update| split[counter_of(update)];
        let is_synchronised = command.branches[0].updates.iter().any(apart);
        let action = if is_synchronised {
            action(machine, number)
        } else {
            String::new()
        };
        let mut guard = self.is_at(machine, command.at);
        for it in &command.guards {
            let name = |place: &usize| &machine.counters[*place].name;
            let _ = match it {
                Guard::Below(place, value) => write!(guard, " & {}<{value}", name(place)),
                Guard::Is(place, value) => write!(guard, " & {}={value}", name(place)),
                Guard::Above(place, value) => write!(guard, " & {}>{value}", name(place)),
            };
        }
        let branches = command
            .branches
            .iter()
            .filter(|branch| machine.weight(branch) > 0.0 || !branch.weight.is_empty());
        let written: Vec<String> = branches
            .map(|branch| self.branch(machine, branch, split))
            .collect();
        let _ = writeln!(text, "  [{action}] {guard} -> {};", written.join(" + "));
    }

    fn branch(&self, machine: &Machine, branch: &Branch, split: &[bool]) -> String {
        let to = match self.names {
            Names::Constants => format!("at_{}", machine.locations[branch.to]),
            _ => branch.to.to_string(),
        };
        let mut text = format!("({}'={to})", self.variable);
        for update in branch
            .updates
            .iter()
            .filter(|update| !split[counter_of(update)])
        {
            let _ = write!(text, " & {}", assignment(machine, update));
        }
        let factors: Vec<String> = branch
            .weight
            .iter()
            .map(|it| self.factor(machine, *it))
            .collect();
        match factors.is_empty() {
            true => text,
            false => format!("{} : {text}", factors.join("*")),
        }
    }

    fn factor(&self, machine: &Machine, factor: Factor) -> String {
        let (place, is_not) = match factor {
            Factor::Of(place) => (place, false),
            Factor::Not(place) => (place, true),
        };
        let is_inline = self.inline[place] && self.given[place].is_none();
        if is_inline {
            let value = machine.constants[place].value;
            return decimal(if is_not { 1.0 - value } else { value });
        }
        let name = self.constant(machine, place);
        if is_not == self.complement[place] {
            name
        } else {
            format!("(1-{name})")
        }
    }

    fn write_ends(&self, machine: &Machine, text: &mut String) {
        let ends = (0..machine.locations.len()).filter(|place| machine.is_end(*place));
        let ends: Vec<String> = ends.map(|place| self.is_at(machine, place)).collect();
        if self.ends_apart {
            for end in &ends {
                let _ = writeln!(text, "  [] {end} -> true;");
            }
        } else {
            let _ = writeln!(text, "  [] {} -> true;", ends.join(" | "));
        }
    }
}

/// Whether a constant is a rate by its use: alone, where nothing is 1 minus it.
fn is_rate(machine: &Machine, place: usize) -> bool {
    let branches = machine
        .commands
        .iter()
        .flat_map(|command| &command.branches);
    !branches
        .flat_map(|branch| &branch.weight)
        .any(|factor| *factor == Factor::Not(place))
}

fn is_used(machine: &Machine, place: usize) -> bool {
    let branches = machine
        .commands
        .iter()
        .flat_map(|command| &command.branches);
    let mut factors = branches.flat_map(|branch| &branch.weight);
    factors.any(|factor| [Factor::Of(place), Factor::Not(place)].contains(factor))
}

fn decimal(value: f64) -> String {
    // At least two digits behind the point, or those of a small constant.
    let rounded = (value * 1e6).round() / 1e6;
    rounded.to_string()
}

fn counter_of(update: &Update) -> usize {
    match update {
        Update::Set(place, _) | Update::Add(place, _) => *place,
    }
}

fn of_counter(branch: &Branch, counter: usize) -> Option<Update> {
    branch
        .updates
        .iter()
        .copied()
        .find(|update| counter_of(update) == counter)
}

fn action(machine: &Machine, number: usize) -> String {
    format!(
        "do_{}_{number}",
        machine.locations[machine.commands[number].at]
    )
}

fn assignment(machine: &Machine, update: &Update) -> String {
    let name = &machine.counters[counter_of(update)].name;
    match update {
        Update::Set(_, value) => format!("({name}'={value})"),
        Update::Add(_, value) if *value < 0 => format!("({name}'={name}{value})"),
        Update::Add(_, value) => format!("({name}'={name}+{value})"),
    }
}

/// A counter as a module of its own, which changes it whenever the controller does what changes it.
fn write_counter(machine: &Machine, counter: usize, text: &mut String) {
    let it = &machine.counters[counter];
    let _ = writeln!(text, "\nmodule count_of_{}", it.name);
    let _ = writeln!(text, "  {} : [0..{}] init {};", it.name, it.most, it.first);
    for (number, command) in machine.commands.iter().enumerate() {
        if let Some(update) = of_counter(&command.branches[0], counter) {
            let guard = match update {
                Update::Add(_, by) if by > 0 => format!("{}<{}", it.name, it.most),
                Update::Add(..) => format!("{}>0", it.name),
                Update::Set(..) => "true".to_owned(),
            };
            let _ = writeln!(
                text,
                "  [{}] {guard} -> {};",
                action(machine, number),
                assignment(machine, &update)
            );
        }
    }
    text.push_str("endmodule\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grammar::family::Kind;
    use checker::explore::explore;
    use checker::{AnswerValue, Options, check_space};
    use prism_lang::Constants;

    /// What the model checker says of coming to a location by a text.
    fn value(text: &str, question: &str) -> f64 {
        let tree = prism_lang::parse_model(text).into_result();
        let tree = tree.unwrap_or_else(|found| panic!("{found:?}\n{text}"));
        let model = prism_lang::resolve(&tree, &Constants::new());
        let model = model.unwrap_or_else(|found| panic!("{found:?}\n{text}"));
        let space = explore::<f64>(&model).expect("it can be explored");
        let tree = prism_lang::parse_properties(question)
            .into_result()
            .expect("a property");
        let found = prism_lang::resolve_properties(&tree, &model, &Constants::new());
        let property = found.expect("it fits").pop().expect("one").property;
        let answer = check_space(&space, &property, &Options::default()).expect("an answer");
        match answer.value {
            AnswerValue::Number(value) => value,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_style_of_text_means_the_machine() {
        for kind in Kind::ALL {
            for number in 0..12 {
                let mut random = Random::new(3, ((kind as u64) << 8) + number);
                let machine = kind.draw(&mut random);
                let style = Style::draw(&machine, &mut random);
                let text = style.text(&machine);
                // Success does not depend on the order of parts; which part jams first does.
                let optimum = if machine.time == Time::Choices {
                    "Pmax"
                } else {
                    "P"
                };
                let done = style.is_at(&machine, machine.done);
                let solved = value(&text, &format!("{optimum}=? [ F {done} ]"));
                let known = machine.reaches(machine.done);
                assert!(
                    (solved - known).abs() < 1e-5,
                    "{kind:?} {number}: {solved} {known}\n{text}"
                );
                for mode in machine
                    .modes
                    .iter()
                    .filter(|_| machine.time != Time::Choices)
                {
                    let lost = style.is_at(&machine, mode.failed);
                    let solved = value(&text, &format!("P=? [ F {lost} ]"));
                    let known = machine.reaches(mode.failed);
                    assert!(
                        (solved - known).abs() < 1e-5,
                        "{kind:?} {number} {}: {solved} {known}",
                        mode.name
                    );
                }
            }
        }
    }
}
