//! The words of the language.

use crate::kind::Kind;
use std::ops::Range;

/// The word at a place.
pub fn at(text: &str, offset: usize) -> Option<(&str, Range<usize>)> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let before = text.get(..offset)?;
    let start = before.len() - before.chars().rev().take_while(|c| is_part(*c)).count();
    let length = text[start..].chars().take_while(|c| is_part(*c)).count();
    let line = &text[..start];
    let line = &line[line.rfind('\n').map_or(0, |at| at + 1)..];
    // Not in comments.
    (length > 0 && !line.contains("//"))
        .then(|| (&text[start..start + length], start..start + length))
}

/// What a word means in models.
const IN_MODELS: [(&str, &str); 19] = [
    (
        "dtmc",
        "discrete-time Markov chain: each step is drawn; commands that are enabled together are drawn uniformly",
    ),
    (
        "ctmc",
        "continuous-time Markov chain: numbers before `:` are rates",
    ),
    (
        "mdp",
        "Markov decision process: commands that are enabled together are choices of a scheduler",
    ),
    (
        "pta",
        "probabilistic timed automaton (not supported by the checker)",
    ),
    (
        "pomdp",
        "partially observable Markov decision process (not supported by the checker)",
    ),
    (
        "const",
        "`const TYPE NAME = VALUE;` without a value, one is given when the model is checked",
    ),
    (
        "formula",
        "`formula NAME = EXPRESSION;` stands for the expression wherever it is named",
    ),
    (
        "label",
        "`label \"NAME\" = CONDITION;` names the states in which the condition holds",
    ),
    (
        "module",
        "`module NAME VARIABLES COMMANDS endmodule`, or a renamed copy: `module NAME = OTHER [old=new, ...] endmodule`",
    ),
    ("endmodule", "ends a module"),
    (
        "global",
        "a variable that every module may change, in commands without an action",
    ),
    (
        "init",
        "behind a range, the initial value; at top level, `init CONDITION endinit`, all states that are initial",
    ),
    (
        "rewards",
        "`rewards \"NAME\" CONDITION : VALUE; [ACTION] CONDITION : VALUE; endrewards`: of states and of transitions",
    ),
    ("endrewards", "ends a reward structure"),
    (
        "system",
        "`system A || B |[a]| C endsystem`: how the modules are composed",
    ),
    ("true", "holds everywhere; as an update, changes nothing"),
    ("bool", "a truth value"),
    ("int", "an integer"),
    ("double", "a real number; constants alone can be real"),
];

/// What a word means in properties.
const IN_PROPERTIES: [(&str, &str); 19] = [
    (
        "P",
        "`P=? [ PATH ]` is the probability of the path formula; `P>=0.9 [ PATH ]` whether it meets the bound",
    ),
    (
        "Pmin",
        "`Pmin=? [ PATH ]`: the least probability over all schedulers",
    ),
    (
        "Pmax",
        "`Pmax=? [ PATH ]`: the greatest probability over all schedulers",
    ),
    (
        "R",
        "`R{\"NAME\"}=? [ F CONDITION ]`: the expected reward; also `C<=k` (accumulated), `I=k` (at an instant), `S` (in the long run), `C` (in total)",
    ),
    ("Rmin", "the least expected reward over all schedulers"),
    ("Rmax", "the greatest expected reward over all schedulers"),
    (
        "S",
        "`S=? [ CONDITION ]`: the share of time in the long run; within `R`, the reward per unit of time",
    ),
    ("A", "`A [ PATH ]`: on all paths"),
    ("E", "`E [ PATH ]`: on some path"),
    (
        "F",
        "`F a`: at some point `a` holds; `F<=k a`: within k steps, or units of time",
    ),
    ("G", "`G a`: `a` holds at all points"),
    ("X", "`X a`: `a` holds in the next step"),
    ("U", "`a U b`: `b` holds at some point, and `a` until then"),
    ("W", "`a W b`: `a` holds until `b` does, or for ever"),
    ("C", "the accumulated reward, within `R`"),
    ("I", "the reward at an instant, within `R`"),
    (
        "filter",
        "`filter(OPERATOR, WHAT, STATES)`: one value for several states: min, max, sum, avg, count, first, range, forall, exists, print, argmin, argmax, state",
    ),
    ("min", "the least of its arguments"),
    ("max", "the greatest of its arguments"),
];

/// What a word of the language means; `None` of all others.
pub fn of_language(word: &str, kind: Kind) -> Option<String> {
    let (first, second) = match kind {
        Kind::Properties => (&IN_PROPERTIES, &IN_MODELS),
        _ => (&IN_MODELS, &IN_PROPERTIES),
    };
    let all = first.iter().chain(second.iter());
    let mut found = all.filter(|(known, _)| *known == word);
    found
        .next()
        .map(|(word, meaning)| format!("`{word}`: {meaning}"))
}
