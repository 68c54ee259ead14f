//! Candidates for symmetries: what must be exchanged if one module takes the place of another.
//!
//! *Method.* Commands of the two modules are matched one by one, in the order of the text, as they are where one was made from
//! the other by renaming; where a variable or action stands in one, that in the other is its image. An image in
//! a third module matches that module with another one, and so does an action that belongs to no other module that could be
//! meant. Chains are closed to cycles, what was not met stays. Whether the result is a symmetry is left to be verified.

use prism_lang::resolved::{ActionId, Command, Model};
use prism_lang::{Expr, ExprKind, VarIndex};
use rustc_hash::FxHashMap;

/// Images of variables, actions and modules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Permutation {
    pub variable: Vec<VarIndex>,
    pub action: Vec<ActionId>,
    pub module: Vec<usize>,
}

impl Permutation {
    pub fn identity(model: &Model) -> Self {
        Self {
            variable: (0..model.variables.len()).collect(),
            action: (0..model.actions.len()).collect(),
            module: (0..model.modules.len()).collect(),
        }
    }

    /// The variables that have another image, ascending.
    pub fn moved(&self) -> impl Iterator<Item = VarIndex> {
        (0..self.variable.len()).filter(|v| self.variable[*v] != *v)
    }
}

/// A one-to-one relation that grows.
struct Partial {
    image: Vec<Option<usize>>,
    origin: Vec<Option<usize>>,
}

impl Partial {
    fn new(size: usize) -> Self {
        Self {
            image: vec![None; size],
            origin: vec![None; size],
        }
    }

    /// Says that `b` is the image of `a`; whether that is new. Nothing if it contradicts what is known.
    fn bind(&mut self, a: usize, b: usize) -> Option<bool> {
        match (self.image[a], self.origin[b]) {
            (None, None) => {
                (self.image[a], self.origin[b]) = (Some(b), Some(a));
                Some(true)
            }
            (Some(image), _) if image == b => Some(false),
            _ => None,
        }
    }

    /// The last of a chain and its first, if there is a chain that is no cycle.
    fn open(&self) -> Option<(usize, usize)> {
        let is_last = |a: &usize| self.image[*a].is_none() && self.origin[*a].is_some();
        let last = (0..self.image.len()).find(is_last)?;
        let mut first = last;
        while let Some(origin) = self.origin[first] {
            first = origin;
        }
        Some((last, first))
    }

    fn complete(&self) -> Vec<usize> {
        let images = self.image.iter().enumerate();
        images.map(|(a, image)| image.unwrap_or(a)).collect()
    }
}

/// What modules have, looked up once for all candidates.
pub(super) struct Owned {
    /// The module of each variable.
    owner: Vec<Option<usize>>,
    /// The variables of each module.
    variables: Vec<Vec<VarIndex>>,
    /// The modules that have each action, ascending.
    with_action: Vec<Vec<usize>>,
}

impl Owned {
    pub fn of(model: &Model) -> Self {
        let modules = || model.modules.iter().enumerate();
        let mut numbers = FxHashMap::default();
        for (number, module) in modules() {
            numbers.entry(module.name.as_str()).or_insert(number);
        }
        let owner = |name: &Option<String>| numbers.get(name.as_ref()?.as_str()).copied();
        let owner: Vec<_> = model.variables.iter().map(|v| owner(&v.module)).collect();
        let mut variables = vec![Vec::new(); model.modules.len()];
        for (variable, owner) in owner.iter().enumerate() {
            if let Some(module) = owner {
                variables[*module].push(variable);
            }
        }
        let mut with_action = vec![Vec::new(); model.actions.len()];
        for (number, module) in modules() {
            for action in module.commands.iter().filter_map(|c| c.action) {
                if with_action[action].last() != Some(&number) {
                    with_action[action].push(number);
                }
            }
        }
        Self {
            owner,
            variables,
            with_action,
        }
    }
}

/// What is known so far.
pub(super) struct Guess<'m> {
    model: &'m Model,
    owned: &'m Owned,
    variable: Partial,
    action: Partial,
    module: Partial,
    /// Modules to be matched.
    open: Vec<(usize, usize)>,
}

impl<'m> Guess<'m> {
    /// The candidate in which the second module of each pair is the image of the first.
    pub fn from(
        model: &'m Model,
        owned: &'m Owned,
        pairs: &[(usize, usize)],
    ) -> Option<Permutation> {
        let mut guess = Self {
            model,
            owned,
            variable: Partial::new(model.variables.len()),
            action: Partial::new(model.actions.len()),
            module: Partial::new(model.modules.len()),
            open: Vec::new(),
        };
        for (a, b) in pairs {
            guess.bind_module(*a, *b)?;
        }
        guess.close()?;
        Some(Permutation {
            variable: guess.variable.complete(),
            action: guess.action.complete(),
            module: guess.module.complete(),
        })
    }

    fn close(&mut self) -> Option<()> {
        loop {
            if let Some((a, b)) = self.open.pop() {
                self.match_modules(a, b)?;
            } else if let Some((a, b)) = self.module.open().or_else(|| self.meant_by_action()) {
                self.bind_module(a, b)?;
            } else if let Some((a, b)) = self.variable.open() {
                self.bind_variable(a, b)?;
            } else if let Some((a, b)) = self.action.open() {
                self.action.bind(a, b)?;
            } else {
                return Some(());
            }
        }
    }

    /// A module that has an action with another image, and the only one that can take its place there.
    fn meant_by_action(&self) -> Option<(usize, usize)> {
        let with = &self.owned.with_action;
        let moved = self.action.image.iter().enumerate();
        let moved = moved.filter_map(|(a, image)| image.filter(|b| *b != a).map(|b| (a, b)));
        for (a, b) in moved {
            let lacks = |m: &usize, action: ActionId| with[action].binary_search(m).is_err();
            let is_open = |m: &usize| self.module.image[*m].is_none() && lacks(m, b);
            let is_free = |m: &usize| self.module.origin[*m].is_none() && lacks(m, a);
            let mut open = with[a].iter().copied().filter(is_open);
            let mut free = with[b].iter().copied().filter(is_free);
            if let (Some(from), None, Some(to), None) =
                (open.next(), open.next(), free.next(), free.next())
            {
                return Some((from, to));
            }
        }
        None
    }

    fn bind_module(&mut self, a: usize, b: usize) -> Option<()> {
        if self.module.bind(a, b)? && a != b {
            self.open.push((a, b));
        }
        Some(())
    }

    fn bind_variable(&mut self, a: VarIndex, b: VarIndex) -> Option<()> {
        if self.model.variables[a].kind != self.model.variables[b].kind {
            return None;
        }
        if self.variable.bind(a, b)? {
            match (self.owned.owner[a], self.owned.owner[b]) {
                (None, None) => {}
                (Some(from), Some(to)) => self.bind_module(from, to)?,
                _ => return None,
            }
        }
        Some(())
    }

    fn match_modules(&mut self, a: usize, b: usize) -> Option<()> {
        let (from, to) = (&self.owned.variables[a], &self.owned.variables[b]);
        let modules = &self.model.modules;
        let (before, after) = (&modules[a].commands, &modules[b].commands);
        if before.len() != after.len() || from.len() != to.len() {
            return None;
        }
        for (a, b) in from.iter().zip(to) {
            self.bind_variable(*a, *b)?;
        }
        let mut commands = before.iter().zip(after);
        commands.try_for_each(|(a, b)| self.match_commands(a, b))
    }

    fn match_commands(&mut self, a: &Command, b: &Command) -> Option<()> {
        match (a.action, b.action) {
            (None, None) => {}
            (Some(a), Some(b)) => {
                self.action.bind(a, b)?;
            }
            _ => return None,
        }
        self.match_exprs(&a.guard, &b.guard)?;
        if a.updates.len() != b.updates.len() {
            return None;
        }
        for (a, b) in a.updates.iter().zip(&b.updates) {
            self.match_exprs(&a.probability, &b.probability)?;
            if a.assignments.len() != b.assignments.len() {
                return None;
            }
            for ((a, value), (b, image)) in a.assignments.iter().zip(&b.assignments) {
                self.bind_variable(*a, *b)?;
                self.match_exprs(value, image)?;
            }
        }
        Some(())
    }

    fn match_exprs(&mut self, a: &Expr, b: &Expr) -> Option<()> {
        let is_same = match (&a.kind, &b.kind) {
            (ExprKind::Variable(a), ExprKind::Variable(b)) => return self.bind_variable(*a, *b),
            (ExprKind::Unary(a, _), ExprKind::Unary(b, _)) => a == b,
            (ExprKind::Binary(a, ..), ExprKind::Binary(b, ..)) => a == b,
            (ExprKind::IfThenElse(..), ExprKind::IfThenElse(..)) => true,
            (ExprKind::Call(a, _), ExprKind::Call(b, _)) => a == b,
            (a, b) => return (a == b).then_some(()),
        };
        let (from, to) = (a.operands(), b.operands());
        if !is_same || from.len() != to.len() {
            return None;
        }
        let mut pairs = from.into_iter().zip(to);
        pairs.try_for_each(|(a, b)| self.match_exprs(a, b))
    }
}
