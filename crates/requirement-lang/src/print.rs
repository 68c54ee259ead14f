//! Sentences as canonical text, which parses to the same sentence.

use std::fmt;

use crate::sentence::{
    ConditionKind, Duration, Probability, Scope, ScopeKind, Sentence, Stage, Timing,
};

/// The canonical sentence, for example
/// `While lifting, when near, the robot shall within 2 s satisfy slow`.
impl fmt::Display for Sentence {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = self.scope.to_string();
        if !text.is_empty() {
            text.push_str(", ");
        }
        if let Some(condition) = &self.condition {
            let keyword = match condition.kind {
                ConditionKind::Upon => "when",
                ConditionKind::Whenever => "whenever",
                ConditionKind::Unless => "unless",
            };
            text.push_str(&format!("{keyword} {}, ", condition.expression));
        }
        text.push_str(&format!("the {} shall", self.component));
        if let Some(probability) = &self.probability {
            text.push_str(&format!(" {probability}"));
        }
        let mut letters = text.chars();
        let first = letters.next().into_iter().flat_map(char::to_uppercase);
        write!(out, "{}{}", first.collect::<String>(), letters.as_str())?;
        for (index, stage) in self.stages.iter().enumerate() {
            write!(out, "{}{stage}", if index == 0 { " " } else { ", then " })?;
        }
        Ok(())
    }
}

/// The clause without a comma; nothing for [`ScopeKind::Global`].
impl fmt::Display for Scope {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = match self.kind {
            ScopeKind::Global => return Ok(()),
            ScopeKind::In => "while",
            ScopeKind::NotIn => "when not in",
            ScopeKind::Before => "before",
            ScopeKind::After => "after",
            ScopeKind::OnlyIn => "only in",
            ScopeKind::OnlyBefore => "only before",
            ScopeKind::OnlyAfter => "only after",
        };
        write!(out, "{words} {}", self.mode)
    }
}

impl fmt::Display for Probability {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "with probability {} {}",
            self.comparison.words(),
            self.decimal
        )
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} satisfy {}", self.timing, self.response)
    }
}

impl fmt::Display for Duration {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

impl fmt::Display for Timing {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Timing::Immediately => out.write_str("immediately"),
            Timing::Next => out.write_str("at the next step"),
            Timing::Eventually => out.write_str("eventually"),
            Timing::Always => out.write_str("always"),
            Timing::Never => out.write_str("never"),
            Timing::Within(duration) => write!(out, "within {duration}"),
            Timing::For(duration) => write!(out, "for {duration}"),
            Timing::After(duration) => write!(out, "after {duration}"),
            Timing::Until(stop) => write!(out, "until {stop}"),
            Timing::Before(stop) => write!(out, "before {stop}"),
        }
    }
}
