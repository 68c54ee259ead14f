//! A model in outline: what properties need to know of a state space that was read from files.

use prism_lang::ast::Type;
use prism_lang::resolved::{Init, Model, RewardStructure};
use prism_lang::{Expr, ExprKind, Span};

use crate::state_space::StateSpace;

impl<N> StateSpace<N> {
    /// The model's kind, variables, labels and reward structures by name: properties are resolved over it as over a
    /// model in the PRISM language. It has no modules; what its labels mean, only the state space knows.
    pub fn outline(&self) -> Model {
        let nowhere = || Expr {
            kind: ExprKind::Bool(false),
            ty: Type::Bool,
            span: Span::default(),
        };
        let labels = self.labels.iter();
        let rewards = self.rewards.iter();
        Model {
            model_type: self.kind,
            constants: Vec::new(),
            parameters: Vec::new(),
            variables: self.variables.clone(),
            modules: Vec::new(),
            actions: self.actions.clone(),
            composition: None,
            labels: labels.map(|(name, _)| (name.clone(), nowhere())).collect(),
            formulas: Vec::new(),
            rewards: rewards
                .map(|(name, _)| RewardStructure {
                    name: name.clone(),
                    items: Vec::new(),
                })
                .collect(),
            init: Init::Predicate(nowhere()),
            warnings: Vec::new(),
            rounded: Vec::new(),
        }
    }
}
