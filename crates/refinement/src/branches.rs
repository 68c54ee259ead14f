//! A branch of a command that should not be there: its probability belongs to another branch.
//!
//! # Definition
//! For each command with several updates and each ordered pair of them: the first is taken out, and what it had as its
//! probability is added to that of the second; the sum is written out where both are decimal numbers, and left out where
//! nothing else is left. In a continuous-time chain, whose rates make up nothing, an update is taken out alone. Each is solved and
//! tried on all evidence ([`crate::structure`]), where the model disagrees strongly with counts. Of those that explain as much the
//! ones come last that leave a constant of the model without any use: it was written to be used.
//!
//! # Assumes
//! One branch is wrong, and all else of the model is right. The strengths take trials as independent, or at their effective
//! size.
//!
//! # Guarantee
//! All else of the text stays as it is written. What is offered was solved. Numbers that explain as well are offered behind, since
//! they are free.
//!
//! # Cost
//! One solution for each pair: those with the first update of a command come first, and the others of it follow only if one of
//! these moves a value that is in disagreement. At most [`MOST_BRANCHES`] in all; of a large model fewer, so that states times
//! solutions stay below [`crate::model_offers::MOST_WORK`].

use crate::counts::anchors;
use crate::model_change::{
    AS_GOOD, Alternative, Changed, ModelChange, Read, Refusal, Solver, Values, digits, value_of,
};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use crate::structure::{Explaining, Tried};
use crate::trial::SAME_VALUE;
use crate::unreached::Place;
use crate::unused::is_used;
use evidence::{Evidence, Subject};
use prism_lang::Span;
use prism_lang::ast::{Command, ExprKind, Update};
use prism_lang::edit::{self, Edit};
use prism_lang::resolved::ModelType;

/// Solutions for the branches of one model, at most.
const MOST_BRANCHES: usize = 200;

/// Branches that are offered for one subject, at most.
const MOST_OFFERS: usize = 4;

/// Sums that differ by less are the same.
const SAME_SUM: f64 = 1e-12;

/// A branch of a command that is taken out, whatever the model's text is by then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Branch {
    /// The command, counted from 0 over all modules.
    pub command: usize,
    /// The update that is taken out, counted from 0.
    pub from: usize,
    /// The update that gets its probability; none for a rate, which goes away.
    pub to: Option<usize>,
}

impl Branch {
    /// The branch as it is written.
    #[must_use]
    pub fn written(&self, text: &str) -> Option<String> {
        let read = Read::new(text).ok()?;
        let all = commands(&read.tree);
        Some(plainly(
            text,
            all.get(self.command)?.updates.get(self.from)?.span,
        ))
    }

    /// The line of a model's text that holds it, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let place = Place {
            command: self.command,
            update: Some(self.from),
        };
        place.line(text)
    }

    /// What is done, in one clause.
    fn in_words(&self, read: &Read<'_>) -> Option<String> {
        let all = commands(&read.tree);
        let updates = &all.get(self.command)?.updates;
        let from = updates.get(self.from)?;
        let (line, _) = prism_lang::line_and_column(read.text, from.span.start);
        let from = plainly(read.text, from.span);
        Some(match self.to.and_then(|to| updates.get(to)) {
            Some(to) => format!(
                "`{from}` of line {line} taken out, its probability goes to `{}`",
                plainly(read.text, to.span)
            ),
            None => format!("`{from}` of line {line} taken out"),
        })
    }

    /// The model's text without the branch.
    pub(crate) fn make(&self, read: &Read<'_>) -> Result<String, Refusal> {
        let all = commands(&read.tree);
        let command = all
            .get(self.command)
            .ok_or("the model has no such command")?;
        let edits = self
            .edits(read.text, command)
            .ok_or("the command has no such branch")?;
        edit::apply(read.text, &edits).map_err(|e| e.to_string())
    }

    fn edits(&self, text: &str, command: &Command) -> Option<Vec<Edit>> {
        let updates = &command.updates;
        let from = updates.get(self.from)?;
        // With the sign that joins it to its neighbour.
        let out = match self.from {
            0 => Span::new(from.span.start, updates.get(1)?.span.start),
            place => Span::new(updates.get(place - 1)?.span.end, from.span.end),
        };
        let mut edits = vec![Edit::replace(out, "")];
        if let Some(to) = self.to {
            let to = updates.get(to).filter(|_| to != self.from)?;
            edits.push(match updates.len() {
                2 => Edit::replace(certain(text, to)?, ""),
                _ => Edit::replace(probability(text, to)?, sum(text, to, from)?),
            });
        }
        Some(edits)
    }
}

/// Where the probability of an update stands, with all its parentheses.
fn probability(text: &str, update: &Update) -> Option<Span> {
    let inner = update.probability.as_ref()?.span;
    let colon = inner.end + text[inner.end..update.span.end].find(':')?;
    let written = text[update.span.start..colon].trim_end();
    Some(Span::new(
        update.span.start,
        update.span.start + written.len(),
    ))
}

/// The same with the colon and the blanks behind it.
fn certain(text: &str, update: &Update) -> Option<Span> {
    let before = probability(text, update)?;
    let behind = &text[before.end..update.span.end];
    let colon = before.end + behind.find(':')? + 1;
    let blanks = &text[colon..update.span.end];
    let start = colon + blanks.len() - blanks.trim_start().len();
    Some(Span::new(update.span.start, start))
}

/// The probabilities of two updates added up.
fn sum(text: &str, one: &Update, other: &Update) -> Option<String> {
    let literal = |update: &Update| match &update.probability.as_ref()?.kind {
        ExprKind::Double(digits) => digits.parse::<f64>().ok(),
        _ => None,
    };
    if let (Some(one), Some(two)) = (literal(one), literal(other)) {
        let sum = digits(one + two);
        // What six digits do not hold stays a sum.
        let is_whole = |it: f64| (it - one - two).abs() < SAME_SUM;
        if sum.parse::<f64>().is_ok_and(is_whole) {
            return Some(sum);
        }
    }
    let part = |update: &Update| {
        let span = probability(text, update)?;
        let written = &text[span.start..span.end];
        let is_choice = matches!(update.probability.as_ref()?.kind, ExprKind::IfThenElse(..));
        Some(match is_choice && !written.starts_with('(') {
            true => format!("({written})"),
            false => written.to_owned(),
        })
    };
    Some(format!("{}+{}", part(one)?, part(other)?))
}

/// Whether a constant of the model stands nowhere else in another text of it but where it is defined.
fn leaves_unused(read: &Read<'_>, new: &str) -> bool {
    let mut names = read.tree.constants.iter().map(|it| it.name.text.as_str());
    names.any(|name| is_used(read.text, name) && !is_used(new, name))
}

/// A piece of text on one line.
fn plainly(text: &str, span: Span) -> String {
    let written = &text[span.start..span.end];
    written.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The branches of each command that could be taken out: those with its first update, then the others.
fn branches(read: &Read<'_>) -> Vec<[Vec<Branch>; 2]> {
    let is_rate = read.model.model_type == ModelType::Ctmc;
    let all = commands(&read.tree).into_iter().enumerate();
    let several = all.filter(|(_, command)| {
        let mut updates = command.updates.iter();
        command.updates.len() > 1 && updates.all(|it| it.probability.is_some())
    });
    let of_command = |(command, written): (usize, &Command)| {
        let places = 0..written.updates.len();
        let found: Vec<Branch> = match is_rate {
            true => places
                .map(|from| Branch {
                    command,
                    from,
                    to: None,
                })
                .collect(),
            false => places
                .clone()
                .flat_map(|from| places.clone().map(move |to| (from, to)))
                .filter(|(from, to)| from != to)
                .map(|(from, to)| Branch {
                    command,
                    from,
                    to: Some(to),
                })
                .collect(),
        };
        let is_first = |it: &Branch| is_rate || it.from == 0 || it.to == Some(0);
        let (first, others) = found.into_iter().partition(is_first);
        [first, others]
    };
    several.map(of_command).collect()
}

/// A branch that explains what disagrees, with the text without it.
type Explained = Explaining<(Branch, String)>;

impl Ground<'_> {
    /// Puts the branches that explain what disagrees among the other changes: before those of the same subject in which a number
    /// was solved for, unless one of these weighs more; none that explains less than they do.
    pub(crate) fn of_branches(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let subjects = self.in_conflict(own, before);
        let Ok(read) = Read::new(model.text).map_err(|_| ()) else {
            return;
        };
        if subjects.is_empty() {
            return;
        }
        let tried = solved(model, &read, (&subjects, before));
        let mut explaining = self.explaining(own, before, tried);
        explaining.sort_by_key(|it| leaves_unused(&read, &it.change.1));
        let most = self.heaviest(own, before, found.changes.iter().map(|it| &it.1));
        for subject in subjects {
            let of_subject = explaining
                .iter()
                .filter(|it| it.subjects.first() == Some(&subject) && it.weight >= most - AS_GOOD);
            let of_subject: Vec<&Explained> = of_subject.collect();
            let Some(best) = of_subject.iter().map(|it| it.weight).max_by(f64::total_cmp) else {
                continue;
            };
            let made = of_subject.iter().take(MOST_OFFERS);
            let made: Vec<(ModelChange, Changed)> = made
                .filter_map(|it| self.offered(&read, own, (&subject, it, &of_subject)))
                .collect();
            place(&mut found.changes, made, (&subject, best >= most));
            // That no number explains it is no matter any more.
            let refused = format!("requirement {} of {}: ", subject.id(), model.evidence);
            found.refused.retain(|it| !it.starts_with(&refused));
        }
    }

    fn offered(
        &self,
        read: &Read<'_>,
        own: &Evidence,
        (subject, it, all): (&Subject, &Explained, &[&Explained]),
    ) -> Option<(ModelChange, Changed)> {
        let (branch, text) = &it.change;
        let counts = anchors(self.evidence, own, subject).into_iter().next()?;
        let others = all.iter().map(|other| &other.change.0);
        let others = others.filter(|other| *other != branch);
        let alternatives: Vec<Alternative> = others
            .filter_map(|other| {
                Some(Alternative {
                    name: other.in_words(read)?,
                    line: other.line(read.text),
                })
            })
            .collect();
        let mut notes = vec![format!(
            "No number was fitted for it; {} other ways to take out a branch were tried that change what is answered.",
            it.tried.saturating_sub(1)
        )];
        notes.extend(alternatives.iter().map(|other| {
            format!(
                "The evidence does not tell it apart from this: {}.",
                other.name
            )
        }));
        let change = ModelChange::Branchless {
            subject: subject.clone(),
            branch: branch.clone(),
            counts,
            tried: it.tried,
        };
        let changed = Changed {
            text: text.clone(),
            what: branch.in_words(read)?,
            constant: None,
            values: it.values.clone(),
            notes,
            alternatives,
            settled: None,
        };
        Some((change, changed))
    }
}

/// Puts branches before the other changes of their subject, which then are not the only ones that explain it, or behind all.
fn place(
    all: &mut Vec<(ModelChange, Changed)>,
    mut branches: Vec<(ModelChange, Changed)>,
    (subject, is_first): (&Subject, bool),
) {
    let is_same = |(change, _): &(ModelChange, Changed)| change.subject() == *subject;
    let named = |(_, changed): &(ModelChange, Changed)| Alternative {
        name: changed.what.clone(),
        line: None,
    };
    let first = all.iter().position(is_same);
    if let (true, Some(at)) = (is_first, first) {
        let names: Vec<Alternative> = branches.iter().map(named).collect();
        let numbers: Vec<Alternative> = all.iter().filter(|it| is_same(it)).map(named).collect();
        for (_, changed) in all.iter_mut().filter(|it| is_same(it)) {
            changed.alternatives.extend(names.iter().cloned());
        }
        for (_, changed) in &mut branches {
            changed.alternatives.extend(numbers.iter().cloned());
        }
        all.splice(at..at, branches);
        return;
    }
    if let Some(at) = first {
        let name = named(&all[at]);
        for (_, changed) in &mut branches {
            changed.alternatives.push(name.clone());
        }
    }
    all.extend(branches);
}

/// What the model answers without each branch, as far as that may be tried.
fn solved(
    model: &Model<'_>,
    read: &Read<'_>,
    (subjects, before): (&[Subject], &Values),
) -> Vec<Tried<(Branch, String)>> {
    let mut left = model.affordable(MOST_BRANCHES, 1);
    let mut found = Vec::new();
    let is_moved = |values: &Values| {
        subjects.iter().any(|subject| {
            let both = (value_of(values, subject), value_of(before, subject));
            matches!(both, (Some(a), Some(b)) if (a - b).abs() > SAME_VALUE)
        })
    };
    for [first, others] in branches(read) {
        let mut bears = false;
        for (is_first, branch) in first
            .into_iter()
            .map(|it| (true, it))
            .chain(others.into_iter().map(|it| (false, it)))
        {
            if left == 0 || !(is_first || bears) {
                break;
            }
            left -= 1;
            let Ok(text) = branch.make(read) else {
                continue;
            };
            let Ok(values) = model.solver.values(&text) else {
                continue;
            };
            bears |= is_moved(&values);
            found.push(Tried {
                change: (branch, text),
                kind: 0,
                values,
            });
        }
    }
    found
}

/// The model without a branch, solved.
pub(crate) fn without(
    text: &str,
    solver: &dyn Solver,
    branch: &Branch,
) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let new = branch.make(&read)?;
    Changed::rewritten(new, branch.in_words(&read).unwrap_or_default(), solver)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str = "dtmc
const double p = 0.25;
module m
  s : [0..9] init 0;
  [] s=0 -> 0.8 : (s'=1) + 0.12 : (s'=2) + 0.08 : (s'=3);
  [] s=1 -> p : (s'=4) + (s=1 ? 0.5 : 0.1) : (s'=5) + (1-p)*(1-0.5)-0.125 : (s'=6);
  [] s=2 -> p : (s'=7) + 1-p :
    (s'=8);
  [] s>2 -> true;
endmodule
";

    fn lines_of(model: &str) -> Vec<String> {
        let read = Read::new(model).expect("a model");
        let all = branches(&read).into_iter().flatten().flatten();
        let changed = all.map(|branch| {
            let text = branch.make(&read).expect("a text");
            Read::new(&text).expect("a model");
            let old: Vec<&str> = model.lines().collect();
            let new = text.lines().filter(|line| !old.contains(line));
            new.map(str::trim).collect::<Vec<_>>().join(" ")
        });
        changed.collect()
    }

    #[test]
    fn each_branch_goes_to_each_other_one_of_its_command() {
        let expected = [
            "[] s=0 -> 0.92 : (s'=2) + 0.08 : (s'=3);",
            "[] s=0 -> 0.12 : (s'=2) + 0.88 : (s'=3);",
            "[] s=0 -> 0.92 : (s'=1) + 0.08 : (s'=3);",
            "[] s=0 -> 0.88 : (s'=1) + 0.12 : (s'=2);",
            "[] s=0 -> 0.8 : (s'=1) + 0.2 : (s'=3);",
            "[] s=0 -> 0.8 : (s'=1) + 0.2 : (s'=2);",
        ];
        let found = lines_of(MODEL);
        assert_eq!(found[..6], expected);
        assert!(
            found.contains(
                &"[] s=1 -> p+(1-p)*(1-0.5)-0.125 : (s'=4) + (s=1 ? 0.5 : 0.1) : (s'=5);"
                    .to_owned()
            ),
            "{found:#?}"
        );
        // Of two nothing but certainty is left.
        assert_eq!(found[12..], ["[] s=2 -> (s'=8);", "[] s=2 -> (s'=7);"]);
    }

    #[test]
    fn a_constant_that_only_a_branch_uses_is_left_without_use() {
        let read = Read::new(MODEL).expect("a model");
        let unused = |text: &str| leaves_unused(&read, text);
        assert!(!unused(MODEL));
        let without = MODEL.replace("p : (s'=7) + 1-p :\n    (s'=8)", "(s'=8)");
        assert!(!unused(&without));
        let without = without.replace("p : (s'=4) + ", "");
        assert!(unused(&without.replace("(1-p)*(1-0.5)-0.125", "0.1")));
    }

    #[test]
    fn a_rate_goes_away_alone() {
        let text = "ctmc\nmodule m\n  s : [0..2] init 0;\n  [] s=0 -> 0.2 : (s'=1) + 0.05 : (s'=2);\nendmodule\n";
        assert_eq!(
            lines_of(text),
            ["[] s=0 -> 0.05 : (s'=2);", "[] s=0 -> 0.2 : (s'=1);"]
        );
    }

    #[test]
    fn a_branch_has_its_own_line_and_words() {
        let branch = Branch {
            command: 2,
            from: 1,
            to: Some(0),
        };
        assert_eq!(branch.line(MODEL), Some(7));
        assert_eq!(branch.written(MODEL).as_deref(), Some("1-p : (s'=8)"));
    }
}
