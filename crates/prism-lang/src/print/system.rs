//! `system ... endsystem` and observables.

use std::fmt::{self, Display, Formatter};

use crate::ast::{Name, Observables, System, SystemExpr, SystemKind};

impl Display for System {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("system ")?;
        if let Some(name) = &self.name {
            write!(f, "\"{}\" ", name.text)?;
        }
        write!(f, "{} endsystem", self.body)
    }
}

impl Display for SystemExpr {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            SystemKind::Module(name) => f.write_str(&name.text),
            SystemKind::Reference(name) => write!(f, "\"{}\"", name.text),
            SystemKind::Full(operands) => write_operands(f, operands, " || "),
            SystemKind::Interleaved(operands) => write_operands(f, operands, " ||| "),
            SystemKind::On(left, actions, right) => {
                write_atom(f, left)?;
                f.write_str(" |[")?;
                write_names(f, actions)?;
                f.write_str("]| ")?;
                write_atom(f, right)
            }
            SystemKind::Hide(operand, actions) => {
                write_atom(f, operand)?;
                f.write_str(" / {")?;
                write_names(f, actions)?;
                f.write_str("}")
            }
            SystemKind::Rename(operand, renames) => {
                write_atom(f, operand)?;
                f.write_str(" {")?;
                for (i, (old, new)) in renames.iter().enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{}<-{}", old.text, new.text)?;
                }
                f.write_str("}")
            }
            SystemKind::Error => f.write_str("?"),
        }
    }
}

fn write_operands(f: &mut Formatter<'_>, operands: &[SystemExpr], bars: &str) -> fmt::Result {
    for (i, operand) in operands.iter().enumerate() {
        f.write_str(if i == 0 { "" } else { bars })?;
        write_atom(f, operand)?;
    }
    Ok(())
}

/// With parentheses around all but names.
fn write_atom(f: &mut Formatter<'_>, system: &SystemExpr) -> fmt::Result {
    match system.kind {
        SystemKind::Module(_) | SystemKind::Reference(_) => write!(f, "{system}"),
        _ => write!(f, "({system})"),
    }
}

fn write_names(f: &mut Formatter<'_>, names: &[Name]) -> fmt::Result {
    for (i, name) in names.iter().enumerate() {
        write!(f, "{}{}", if i == 0 { "" } else { ", " }, name.text)?;
    }
    Ok(())
}

impl Display for Observables {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Variables { names, .. } => {
                f.write_str("observables ")?;
                write_names(f, names)?;
                f.write_str(" endobservables")
            }
            Self::Defined { name, body, .. } => write!(f, "observable \"{}\" = {body};", name.text),
        }
    }
}
