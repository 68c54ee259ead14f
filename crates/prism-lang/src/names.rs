//! Where a text names what: declarations and uses of constants, formulas, variables, actions, modules, labels and the rest.
//!
//! # Definition
//! An [`Occurrence`] is a place at which an identifier stands for something of a [`Space`]. Names of one space are one name: the
//! language has no scopes within a space, so all occurrences of a name in a model and in its property files speak of the same
//! thing. Names of different spaces may be spelled alike. A renamed copy (`module b = a [x=y] endmodule`) names what `a` has of
//! that name: a variable, constant or formula, an action, or both at one place.
//!
//! # Guarantee
//! Of a text without syntax errors all occurrences are found (tested: every name of every model at hand renamed and back). Of
//! what could not be read there is nothing.

mod copies;
mod walk;

use crate::ast::{Model, PropertyFile};
use crate::diagnostic::Span;
use crate::lexer::KEYWORDS;

/// In which space a name lives: names of one space are unique, those of different spaces may be the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Space {
    /// Constants, formulas and variables.
    Value,
    /// Actions of commands.
    Action,
    /// Modules.
    Module,
    /// Labels, and properties that have a name: both in quotes.
    Label,
    /// Reward structures.
    Reward,
    /// Named compositions (`system "name"`).
    System,
    /// Observables of partially observable models.
    Observable,
}

impl Space {
    /// Whether its names stand in double quotes.
    #[must_use]
    pub fn is_quoted(self) -> bool {
        match self {
            Self::Value | Self::Action | Self::Module => false,
            Self::Label | Self::Reward | Self::System | Self::Observable => true,
        }
    }

    /// Whether a text can be a name of this space.
    ///
    /// ```
    /// use prism_lang::names::Space;
    /// assert!(Space::Value.can_name("x_1") && !Space::Value.can_name("module") && !Space::Value.can_name("1x"));
    /// // In quotes, words of the language are names like others; what PRISM defines itself is taken.
    /// assert!(Space::Label.can_name("module") && !Space::Label.can_name("deadlock"));
    /// ```
    #[must_use]
    pub fn can_name(self, text: &str) -> bool {
        let is_identifier = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        let is_taken = match self {
            Self::Label => matches!(text, "init" | "deadlock"),
            _ => !self.is_quoted() && KEYWORDS.contains(&text),
        };
        is_identifier && !is_taken
    }
}

/// What an occurrence does with its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Declares it.
    Definition,
    /// Speaks of what is declared elsewhere.
    Use,
    /// Gives it a new value: the target of an assignment.
    Assignment,
    /// The old name in a renamed copy.
    Replaced,
}

/// A place at which a name stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Occurrence {
    /// The name, without quotes or prime.
    pub name: String,
    /// What kind of thing it names.
    pub space: Space,
    /// What is done with it here.
    pub role: Role,
    /// The identifier alone: no quotes, no prime.
    pub span: Span,
}

/// The names of a text, in the order of their places.
#[derive(Clone, Debug, Default)]
pub struct Names {
    all: Vec<Occurrence>,
}

impl Names {
    /// Those of a model.
    ///
    /// ```
    /// use prism_lang::names::{Names, Role, Space};
    /// let text = "dtmc module m x : [0..1]; [go] x=0 -> (x'=1); endmodule label \"up\" = x=1;";
    /// let names = Names::of_model(&prism_lang::parse_model(text).tree, text);
    /// let of_x: Vec<_> = names.of(Space::Value, "x").map(|it| (it.role, it.span.of(text))).collect();
    /// assert_eq!(of_x.len(), 4);
    /// assert_eq!(of_x[2], (Role::Assignment, "x"));
    /// assert_eq!(names.at(text.find("up").unwrap()).next().unwrap().space, Space::Label);
    /// ```
    #[must_use]
    pub fn of_model(tree: &Model, text: &str) -> Self {
        let mut walk = walk::Walk::new(text);
        walk.model(tree);
        copies::add(tree, &mut walk);
        Self::sorted(walk.found)
    }

    /// Those of a properties file, or of a single property.
    #[must_use]
    pub fn of_properties(tree: &PropertyFile, text: &str) -> Self {
        let mut walk = walk::Walk::new(text);
        walk.properties(tree);
        Self::sorted(walk.found)
    }

    fn sorted(mut all: Vec<Occurrence>) -> Self {
        all.sort_by_key(|it| (it.span, it.space));
        all.dedup();
        Self { all }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Occurrence> {
        self.all.iter()
    }

    /// Those of one name.
    pub fn of<'n>(&'n self, space: Space, name: &'n str) -> impl Iterator<Item = &'n Occurrence> {
        self.all
            .iter()
            .filter(move |it| it.space == space && it.name == name)
    }

    /// Those whose identifier has this offset inside or at its end: one, or several in a renamed copy.
    pub fn at(&self, offset: usize) -> impl Iterator<Item = &Occurrence> {
        self.all
            .iter()
            .filter(move |it| it.span.start <= offset && offset <= it.span.end)
    }

    /// Where a name is declared.
    #[must_use]
    pub fn definition(&self, space: Space, name: &str) -> Option<&Occurrence> {
        let mut all = self.all.iter();
        all.find(|it| it.space == space && it.name == name && it.role == Role::Definition)
    }

    /// Whether a renamed copy has this name on either side, in whatever space.
    #[must_use]
    pub fn is_in_a_copy(&self, tree: &Model, name: &str) -> bool {
        tree.modules.iter().any(|module| match &module.body {
            crate::ast::ModuleBody::Renamed { renames, .. } => {
                let sides = renames.iter().flat_map(|(old, new)| [old, new]);
                sides.into_iter().any(|side| side.text == name)
            }
            crate::ast::ModuleBody::Written { .. } => false,
        })
    }
}

#[cfg(test)]
mod tests;
