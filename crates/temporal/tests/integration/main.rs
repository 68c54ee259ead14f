//! All integration tests of the crate in one program, since each program costs a link.

mod automata_against_semantics;
mod formula_dense;
mod formula_discrete;
mod formula_early_end;
mod formula_explanations;
mod formula_linear;
mod formula_losses;
mod formula_ltl;
mod formula_text;
mod formulas;
mod monitor_formulas;
mod monitor_reports;
mod monitor_robustness;
mod monitor_words;
