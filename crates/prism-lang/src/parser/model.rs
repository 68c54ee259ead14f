//! Models: declarations, modules and commands.

use super::expression::Context;
use super::{Parse, Parser, Reported, suggest_keyword};
use crate::ast::{
    Constant, Formula, Label, Model, ModelType, Name, RewardItem, RewardKind, RewardStructure,
    Type, Variable, VariableRange,
};
use crate::diagnostic::{Diagnostic, Parsed, Span};
use crate::lexer::{Token, TokenKind};

/// Words at which a new part of a model starts.
pub(super) const PARTS: &[&str] = &[
    "dtmc",
    "probabilistic",
    "mdp",
    "nondeterministic",
    "ctmc",
    "stochastic",
    "pta",
    "pomdp",
    "popta",
    "const",
    "rate",
    "prob",
    "formula",
    "label",
    "global",
    "module",
    "rewards",
    "init",
    "system",
    "observables",
    "observable",
];

/// Kinds of models of other tools in the same style of language (PRISM-games, Storm, a PRISM with fixed delays), and those that
/// PRISM sees from intervals of probabilities: the word that says it, and what they are.
const OTHER_TYPES: &[(&str, &str)] = &[
    ("smg", "stochastic multi-player games"),
    ("csg", "concurrent stochastic games"),
    ("tsg", "turn-based stochastic games"),
    ("stpg", "stochastic two-player games"),
    ("tptg", "turn-based probabilistic timed games"),
    ("fdctmc", "continuous-time Markov chains with fixed delays"),
    ("gsmp", "generalised semi-Markov processes"),
    ("ma", "Markov automata"),
    ("ctmdp", "continuous-time Markov decision processes"),
    ("idtmc", "Markov chains with intervals of probabilities"),
    (
        "imdp",
        "Markov decision processes with intervals of probabilities",
    ),
    (
        "ipomdp",
        "partially observable models with intervals of probabilities",
    ),
];

/// What is said of them.
const SUPPORTED: &str = "Use a `dtmc`, `ctmc` or `mdp`.";

/// Reads a model. Never fails: the tree holds what was understood, the diagnostics all mistakes.
///
/// ```
/// let parsed = prism_lang::parse_model("dtmc module m x : [0..1]; [] x=0 -> (x'=1); endmodule");
/// assert!(parsed.diagnostics.is_empty());
/// assert_eq!(parsed.tree.modules[0].name.text, "m");
/// ```
pub fn parse_model(text: &str) -> Parsed<Model> {
    let mut parser = Parser::new(text);
    let mut tree = Model::default();
    parser.not_a_model();
    while !parser.at_end() {
        if parser.model_part(&mut tree).is_err() {
            parser.recover(PARTS);
        }
    }
    Parsed {
        tree,
        diagnostics: parser.finish(),
    }
}

impl Parser<'_> {
    fn model_part(&mut self, model: &mut Model) -> Parse<()> {
        let token = self.peek();
        if let Some(model_type) = model_type_of(&token) {
            self.advance();
            self.model_type(model, model_type, token.span);
            return Ok(());
        }
        let keyword = if token.kind == TokenKind::Keyword {
            token.text
        } else {
            ""
        };
        match keyword {
            "const" | "rate" | "prob" => model.constants.push(self.constant()?),
            "formula" => model.formulas.push(self.formula()?),
            "label" => model.labels.push(self.label()?),
            "global" => {
                self.advance();
                model.globals.push(self.variable()?);
            }
            "module" => {
                let module = self.module()?;
                model.modules.push(module);
            }
            "rewards" => model.rewards.push(self.reward_structure()?),
            "init" => self.init(model)?,
            "system" => model.systems.push(self.system()?),
            "observables" => model.observables.push(self.observable_variables()?),
            "observable" => model.observables.push(self.observable()?),
            _ => return self.unknown_part(&token),
        }
        Ok(())
    }

    fn unknown_part(&mut self, token: &Token<'_>) -> Parse<()> {
        let is_name = token.kind == TokenKind::Name;
        let other = OTHER_TYPES.iter().find(|(word, _)| *word == token.text);
        if let Some((word, what)) = other.filter(|_| is_name) {
            self.foreign(token.span, &format!("{what} (`{word}`)"), SUPPORTED);
            return Ok(());
        }
        if is_name && token.text == "evolve" {
            let what = "models with `evolve`, from which designs are to be chosen,";
            let remedy = "Write a constant in place of what evolves, and give it a value.";
            self.foreign(token.span, what, remedy);
            return Ok(());
        }
        let stray = match token.text {
            ";" => Some("this `;` closes nothing."),
            "endmodule" => Some("this `endmodule` closes no module."),
            _ => None,
        };
        self.advance();
        if let Some(message) = stray {
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy("Remove it."));
            return Ok(());
        }
        let message = format!(
            "{} does not start a part of a model.",
            super::describe(token)
        );
        let error = Diagnostic::error("syntax", token.span, message);
        let meant = suggest_keyword(token.text, PARTS);
        let remedy = match meant {
            _ if token.text == "lts" => "Leave it out: a model without a type and without probabilities is a labelled transition system.".to_owned(),
            Some(word) => format!("Did you mean `{word}`?"),
            None => "A model consists of `dtmc`, `const`, `formula`, `label`, `global`, `module`, `system`, `rewards` and `init`.".to_owned(),
        };
        self.report(error.remedy(remedy));
        match meant {
            // Its lines would be reported one by one.
            _ if token.text == "lts" => Ok(()),
            Some("module") => {
                self.skip_past("endmodule");
                Ok(())
            }
            _ => Err(Reported),
        }
    }

    /// Reports a text in JSON: such as a JANI model, which is written so.
    fn not_a_model(&mut self) {
        let first = self.peek();
        if !self.is_symbol("{") {
            return;
        }
        let supported = "Read are models in the PRISM language, and explicit files of states and transitions (`.tra`, `.drn`).";
        match self.text.contains("\"jani-version\"") {
            true => self.foreign(first.span, "models in the JANI format", supported),
            false => self.foreign(first.span, "models in JSON", supported),
        }
    }

    /// Reports that all of the text is of a kind that is not supported. What follows is not read: it would be reported word by
    /// word.
    fn foreign(&mut self, span: Span, what: &str, remedy: &str) {
        self.diagnostics.retain(|d| d.span.start < span.start);
        let message = format!("{what} are not supported.");
        let error = Diagnostic::error("unsupported", span, message);
        self.report(error.remedy(remedy));
        self.at = self.tokens.len() - 1;
    }

    fn model_type(&mut self, model: &mut Model, model_type: ModelType, span: Span) {
        if let Some((_, first)) = model.model_type {
            let error =
                Diagnostic::error("two-model-types", span, "the model type is given twice.");
            self.report(error.related(first, "first given here").remedy("Keep one."));
        } else {
            model.model_type = Some((model_type, span));
        }
    }

    /// Reads `const double p = 0.5;`.
    pub(super) fn constant(&mut self) -> Parse<Constant> {
        let start = self.advance();
        let declared = ["int", "double", "bool"]
            .into_iter()
            .find(|t| self.is_keyword(t));
        if declared.is_some() {
            self.advance();
        }
        let ty = match declared {
            Some("bool") => Type::Bool,
            Some("double") => Type::Double,
            None if start.text != "const" => Type::Double,
            _ => Type::Int,
        };
        let name = self.expect_name("the name of a constant")?;
        let value = if self.accept("=") {
            Some(self.expression(Context::Model)?)
        } else {
            None
        };
        let end = self.expect(";")?;
        let span = start.span.to(end);
        Ok(Constant {
            name,
            ty,
            value,
            span,
        })
    }

    /// Reads `formula f = ...;`.
    pub(super) fn formula(&mut self) -> Parse<Formula> {
        let start = self.advance();
        let name = self.expect_name("the name of a formula")?;
        self.expect("=")?;
        let body = self.expression(Context::Model)?;
        let span = start.span.to(self.expect(";")?);
        Ok(Formula { name, body, span })
    }

    /// Reads `label "l" = ...;`.
    pub(super) fn label(&mut self) -> Parse<Label> {
        let start = self.advance();
        let token = self.peek();
        if token.kind == TokenKind::Name {
            let message = format!(
                "the name of label `{}` must stand in double quotes.",
                token.text
            );
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy(format!("Write `label \"{}\" = ...;`.", token.text)));
        } else if token.kind != TokenKind::Quoted {
            return Err(self.expected("the name of a label in double quotes"));
        }
        let name = super::name_of(&self.advance());
        self.expect("=")?;
        let body = self.expression(Context::Model)?;
        let span = start.span.to(self.expect(";")?);
        Ok(Label { name, body, span })
    }

    /// Reads `x : [0..3] init 0;`.
    pub(super) fn variable(&mut self) -> Parse<Variable> {
        let name = self.expect_name("the name of a variable")?;
        self.expect(":")?;
        let range = self.variable_range()?;
        let init = if self.accept_keyword("init") {
            Some(self.expression(Context::Model)?)
        } else {
            None
        };
        let span = name.span.to(self.expect(";")?);
        Ok(Variable {
            name,
            range,
            init,
            span,
        })
    }

    fn variable_range(&mut self) -> Parse<VariableRange> {
        if self.accept("[") {
            let low = Box::new(self.expression(Context::Model)?);
            self.expect("..")?;
            let high = Box::new(self.expression(Context::Model)?);
            self.expect("]")?;
            return Ok(VariableRange::Int { low, high });
        }
        for (keyword, range) in [
            ("bool", VariableRange::Bool),
            ("int", VariableRange::Unbounded),
            ("clock", VariableRange::Clock),
        ] {
            if self.accept_keyword(keyword) {
                return Ok(range);
            }
        }
        if self.is_keyword("double") {
            let error =
                Diagnostic::error("type", self.peek().span, "a variable cannot be a double.");
            self.report(error.remedy("Scale it to an integer range such as `[0..1000]`."));
            return Err(Reported);
        }
        Err(self.expected("a range such as `[0..3]`, or `bool`"))
    }

    /// Reads `rewards "name" ... endrewards`.
    fn reward_structure(&mut self) -> Parse<RewardStructure> {
        let start = self.advance();
        let name = if self.peek().kind == TokenKind::Quoted {
            Some(super::name_of(&self.advance()))
        } else {
            None
        };
        let mut items = Vec::new();
        while !self.accept_keyword("endrewards") {
            if self.starts_part() {
                let place = name.clone().unwrap_or(Name {
                    text: String::new(),
                    span: start.span,
                });
                self.unclosed(&place, "reward structure", "endrewards");
                break;
            }
            match self.reward_item() {
                Ok(item) => items.push(item),
                Err(Reported) => {
                    self.recover(&["endrewards", "module", "label", "formula", "const"])
                }
            }
        }
        let span = start.span.to(self.previous_span());
        Ok(RewardStructure { name, items, span })
    }

    fn reward_item(&mut self) -> Parse<RewardItem> {
        let start = self.peek().span;
        let kind = if self.accept("[") {
            let action = if self.is_symbol("]") {
                None
            } else {
                Some(self.expect_name("the name of an action")?)
            };
            self.expect("]")?;
            RewardKind::Transition(action)
        } else {
            RewardKind::State
        };
        let guard = self.expression(Context::Model)?;
        self.expect(":")?;
        let value = self.expression(Context::Model)?;
        let span = start.to(self.expect(";")?);
        Ok(RewardItem {
            kind,
            guard,
            value,
            span,
        })
    }

    fn init(&mut self, model: &mut Model) -> Parse<()> {
        let start = self.advance();
        let predicate = self.expression(Context::Model)?;
        self.expect_keyword("endinit")?;
        if model.init.is_some() {
            let error = Diagnostic::error(
                "two-inits",
                start.span,
                "`init ... endinit` is given twice.",
            );
            self.report(error.remedy("Join the two predicates with `|`."));
        } else {
            model.init = Some(predicate);
        }
        Ok(())
    }
}

fn model_type_of(token: &Token<'_>) -> Option<ModelType> {
    if token.kind != TokenKind::Keyword {
        return None;
    }
    Some(match token.text {
        "dtmc" | "probabilistic" => ModelType::Dtmc,
        "mdp" | "nondeterministic" => ModelType::Mdp,
        "ctmc" | "stochastic" => ModelType::Ctmc,
        "pta" => ModelType::Pta,
        "pomdp" => ModelType::Pomdp,
        "popta" => ModelType::Popta,
        _ => return None,
    })
}
