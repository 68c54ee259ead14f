//! Expressions with the formulas that they name written out.

use prism_lang::ast::{Expr, ExprKind, Formula};

/// How many nodes an expression may have when it is shown.
const MOST_NODES: usize = 400;
/// How deep formulas may name each other.
const DEEPEST: usize = 50;

/// The expression with all formulas written out; `None` if it names none, or becomes too large to be read.
#[must_use]
pub fn expanded(expr: &Expr, formulas: &[Formula]) -> Option<Expr> {
    let mut left = MOST_NODES;
    let mut found = false;
    let expanded = one(expr, formulas, DEEPEST, &mut left, &mut found)?;
    found.then_some(expanded)
}

fn one(
    expr: &Expr,
    formulas: &[Formula],
    depth: usize,
    left: &mut usize,
    found: &mut bool,
) -> Option<Expr> {
    *left = left.checked_sub(1)?;
    let mut again = |it: &Expr| one(it, formulas, depth, left, found).map(Box::new);
    let kind = match &expr.kind {
        ExprKind::Name(name) => match formulas.iter().find(|it| it.name.text == *name) {
            Some(formula) => {
                *found = true;
                let depth = depth.checked_sub(1)?;
                return one(&formula.body, formulas, depth, left, found);
            }
            None => expr.kind.clone(),
        },
        ExprKind::Unary(operator, a) => ExprKind::Unary(*operator, again(a)?),
        ExprKind::Binary(operator, a, b) => ExprKind::Binary(*operator, again(a)?, again(b)?),
        ExprKind::IfThenElse(a, b, c) => ExprKind::IfThenElse(again(a)?, again(b)?, again(c)?),
        ExprKind::Call(name, arguments) => {
            let arguments = arguments.iter().map(|it| again(it).map(|it| *it));
            ExprKind::Call(name.clone(), arguments.collect::<Option<_>>()?)
        }
        other => other.clone(),
    };
    Some(Expr {
        kind,
        span: expr.span,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_written_out_and_cycles_are_not() {
        let text = "dtmc formula a = x>0 | y; formula b = a & !a; formula c = c; formula d = 1;";
        let tree = prism_lang::parse_model(text).tree;
        let of =
            |at: usize| expanded(&tree.formulas[at].body, &tree.formulas).map(|it| it.to_string());
        assert_eq!(of(1).as_deref(), Some("(x>0 | y) & !(x>0 | y)"));
        assert_eq!((of(0), of(2), of(3)), (None, None, None));
    }
}
