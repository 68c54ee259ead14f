//! In which power the uncertain constants occur in a model's probabilities, by the text of the model.

use prism_lang::ast::{BinaryOp, Command, Expr, ExprKind, Model, ModuleBody, UnaryOp};
use std::collections::{BTreeMap, BTreeSet};

/// How deep definitions may be nested.
const MOST_DEPTH: usize = 400;

/// The highest power of each uncertain constant that occurs.
type Degrees<'a> = BTreeMap<&'a str, u32>;

type Renaming<'a> = BTreeMap<&'a str, &'a str>;

/// Why a transition probability is no polynomial without squares; `None` if each is one.
pub(super) fn obstacle(model: &Model, uncertain: &[&str]) -> Option<String> {
    let mut reader = Reader {
        model,
        uncertain,
        constants: BTreeMap::new(),
    };
    reader.model().err()
}

struct Reader<'a> {
    model: &'a Model,
    uncertain: &'a [&'a str],
    /// Of constants that were looked at.
    constants: BTreeMap<&'a str, Degrees<'a>>,
}

impl<'a> Reader<'a> {
    fn model(&mut self) -> Result<(), String> {
        let model = self.model;
        let plain = Renaming::new();
        for label in &model.labels {
            self.free(&label.body, &plain, "a label")?;
        }
        if let Some(init) = &model.init {
            self.free(init, &plain, "the initial states")?;
        }
        // Which constants the probabilities of an action's commands hold, module by module.
        let mut by_action: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
        for (commands, renaming) in self.instances() {
            let mut of_module: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
            for command in commands {
                let found = self.command(command, &renaming)?;
                if let Some(action) = &command.action {
                    let name = renamed(&renaming, &action.text);
                    of_module.entry(name).or_default().extend(found);
                }
            }
            for (action, constants) in of_module {
                for constant in constants {
                    let modules = by_action.entry(action).or_default();
                    *modules.entry(constant).or_default() += 1;
                }
            }
        }
        for (action, modules) in by_action {
            if let Some((constant, _)) = modules.into_iter().find(|(_, count)| *count > 1) {
                return Err(format!(
                    "`{constant}` occurs in several modules that take `{action}` together"
                ));
            }
        }
        self.ranges()
    }

    /// Ranges and initial values of variables hold no uncertain constant.
    fn ranges(&mut self) -> Result<(), String> {
        let model = self.model;
        let plain = Renaming::new();
        let written = model
            .modules
            .iter()
            .filter_map(|module| match &module.body {
                ModuleBody::Written { variables, .. } => Some(variables),
                ModuleBody::Renamed { .. } => None,
            });
        let variables = model.globals.iter().chain(written.flatten());
        for variable in variables {
            if let prism_lang::ast::VariableRange::Int { low, high } = &variable.range {
                self.free(low, &plain, "a variable's range")?;
                self.free(high, &plain, "a variable's range")?;
            }
            if let Some(init) = &variable.init {
                self.free(init, &plain, "an initial value")?;
            }
        }
        Ok(())
    }

    /// The commands of each module, with the names under which they are read.
    fn instances(&self) -> Vec<(&'a [Command], Renaming<'a>)> {
        let modules = &self.model.modules;
        let written = |name: &str| {
            let found = modules.iter().find(|module| module.name.text == name)?;
            match &found.body {
                ModuleBody::Written { commands, .. } => Some(commands.as_slice()),
                ModuleBody::Renamed { .. } => None,
            }
        };
        let instance = |module: &'a prism_lang::ast::Module| match &module.body {
            ModuleBody::Written { commands, .. } => Some((commands.as_slice(), Renaming::new())),
            ModuleBody::Renamed { base, renames } => {
                let pairs = renames.iter();
                let names = pairs.map(|(old, new)| (old.text.as_str(), new.text.as_str()));
                Some((written(&base.text)?, names.collect()))
            }
        };
        modules.iter().filter_map(instance).collect()
    }

    /// The uncertain constants in a command's probabilities.
    fn command(
        &mut self,
        command: &'a Command,
        renaming: &Renaming<'a>,
    ) -> Result<BTreeSet<&'a str>, String> {
        self.free(&command.guard, renaming, "a guard")?;
        let mut found = BTreeSet::new();
        for update in &command.updates {
            for assignment in &update.assignments {
                self.free(&assignment.value, renaming, "an assignment")?;
            }
            let Some(probability) = &update.probability else {
                continue;
            };
            for (constant, degree) in self.degrees(probability, renaming, 0)? {
                if degree > 1 {
                    return Err(format!("`{constant}` occurs squared in a probability"));
                }
                found.insert(constant);
            }
        }
        Ok(found)
    }

    /// Refuses an expression that holds an uncertain constant.
    fn free(&mut self, expr: &'a Expr, renaming: &Renaming<'a>, place: &str) -> Result<(), String> {
        match self.degrees(expr, renaming, 0)?.keys().next() {
            Some(constant) => Err(format!("`{constant}` occurs in {place}")),
            None => Ok(()),
        }
    }

    fn degrees(
        &mut self,
        expr: &'a Expr,
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Result<Degrees<'a>, String> {
        if depth > MOST_DEPTH {
            return Err("definitions are nested too deeply".to_owned());
        }
        let depth = depth + 1;
        match &expr.kind {
            ExprKind::Bool(_) | ExprKind::Int(_) | ExprKind::Double(_) => Ok(Degrees::new()),
            ExprKind::Name(name) => self.name(renamed(renaming, name), renaming, depth),
            ExprKind::Unary(UnaryOp::Minus, operand) => self.degrees(operand, renaming, depth),
            ExprKind::Unary(UnaryOp::Not, operand) => self.none_of(&[operand], renaming, depth),
            ExprKind::Binary(operator, left, right) => {
                self.binary(*operator, (left, right), renaming, depth)
            }
            ExprKind::IfThenElse(condition, then, otherwise) => {
                self.none_of(&[condition], renaming, depth)?;
                let then = self.degrees(then, renaming, depth)?;
                Ok(largest(then, self.degrees(otherwise, renaming, depth)?))
            }
            ExprKind::Call(_, arguments) => {
                let arguments: Vec<&Expr> = arguments.iter().collect();
                self.none_of(&arguments, renaming, depth)
            }
            _ => Ok(Degrees::new()),
        }
    }

    fn binary(
        &mut self,
        operator: BinaryOp,
        (left, right): (&'a Expr, &'a Expr),
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Result<Degrees<'a>, String> {
        match operator {
            BinaryOp::Plus | BinaryOp::Minus => {
                let left = self.degrees(left, renaming, depth)?;
                Ok(largest(left, self.degrees(right, renaming, depth)?))
            }
            BinaryOp::Times => {
                let mut sum = self.degrees(left, renaming, depth)?;
                for (constant, degree) in self.degrees(right, renaming, depth)? {
                    let known = sum.entry(constant).or_default();
                    *known = degree.saturating_add(*known);
                }
                Ok(sum)
            }
            BinaryOp::Divide => {
                self.none_of(&[right], renaming, depth)?;
                self.degrees(left, renaming, depth)
            }
            _ => self.none_of(&[left, right], renaming, depth),
        }
    }

    /// Operands of what is no polynomial must hold no uncertain constant.
    fn none_of(
        &mut self,
        operands: &[&'a Expr],
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Result<Degrees<'a>, String> {
        for operand in operands {
            if let Some(constant) = self.degrees(operand, renaming, depth)?.keys().next() {
                return Err(format!(
                    "`{constant}` occurs in a comparison, a divisor or a function"
                ));
            }
        }
        Ok(Degrees::new())
    }

    fn name(
        &mut self,
        name: &'a str,
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Result<Degrees<'a>, String> {
        if self.uncertain.contains(&name) {
            return Ok(Degrees::from([(name, 1)]));
        }
        if let Some(known) = self.constants.get(name) {
            return Ok(known.clone());
        }
        let model = self.model;
        let constant = model.constants.iter().find(|c| c.name.text == name);
        if let Some(constant) = constant {
            let found = match &constant.value {
                Some(value) => self.degrees(value, &Renaming::new(), depth)?,
                None => Degrees::new(),
            };
            self.constants.insert(&constant.name.text, found.clone());
            return Ok(found);
        }
        match model.formulas.iter().find(|f| f.name.text == name) {
            Some(formula) => self.degrees(&formula.body, renaming, depth),
            None => Ok(Degrees::new()),
        }
    }
}

/// A name under a renaming.
fn renamed<'a>(renaming: &Renaming<'a>, name: &'a str) -> &'a str {
    renaming.get(name).copied().unwrap_or(name)
}

/// The larger power of each constant.
fn largest<'a>(mut one: Degrees<'a>, other: Degrees<'a>) -> Degrees<'a> {
    for (constant, degree) in other {
        let known = one.entry(constant).or_default();
        *known = degree.max(*known);
    }
    one
}
