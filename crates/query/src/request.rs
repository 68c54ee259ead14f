//! What is asked of a model.

use diagnostic::Source;
use prism_lang::Experiment;
use prism_lang::ast::ModelType;
use std::path::PathBuf;
use std::time::Duration;
use study::Method;

/// One model, many properties, and how they are answered. [`CheckRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct CheckRequest {
    /// The model.
    pub model: ModelInput,
    /// Takes the model for one of this type.
    pub model_type: Option<ModelType>,
    /// Parts of the model in files of their own, as `FORM=FILE`: tra, sta, lab, srew, trew.
    pub imports: Vec<String>,
    /// The properties, in their order; none only builds the states.
    pub properties: Vec<PropertyInput>,
    /// Only the properties with these names or numbers (from 1), separated by commas; all if there are none.
    pub selected: Vec<String>,
    /// Values of constants; over ranges, each valuation is checked.
    pub constants: Experiment,
    /// Constants that stay open, with their ranges, as `p=0:1,q=0.2:0.4`: answers are rational functions of them.
    pub open: Option<String>,
    /// How answers are computed.
    pub method: Method,
    /// Relative width of the bounds, of methods that have bounds.
    pub precision: f64,
    /// When a method that has no bounds stops: change of the values.
    pub epsilon: f64,
    /// Which change that is.
    pub termination: checker::Termination,
    /// How many iterations a method that has no bounds may take.
    pub max_iterations: Option<u64>,
    /// How many states the model may have; by default as many as can be numbered.
    pub max_states: Option<u64>,
    /// Only fair schedulers: each choice of each state that is visited infinitely often is taken infinitely often.
    pub fair: bool,
    /// Takes probabilities of a command that miss the sum 1 by up to this much as rounded.
    pub sum_roundoff: Option<f64>,
    /// Checks each answer again with code that shares nothing with the solver.
    pub certify: bool,
    /// Finds the most probable path that shows why.
    pub witness: bool,
    /// Ends after so long with what was found. (A budget of memory is the host's.)
    pub timeout: Option<Duration>,
    /// Finds the share of time in each state in the long run.
    pub steady_state: bool,
    /// Finds the probability of each state at this time, or at those of a range: `2.5`, `0:0.5:5`.
    pub transient: Option<String>,
    /// A file with the distribution that `steady_state` and `transient` start from; by default all initial states are equally
    /// probable.
    pub initial_distribution: Option<PathBuf>,
    /// What is written to files.
    pub exports: Exports,
}

/// What is written to files; a file named `stdout` is what the caller gives to [`crate::check()`].
#[derive(Clone, Debug, Default)]
pub struct Exports {
    /// The model, as `FILE.FORM`, `FILE.FORM,FORM`, `FILE.all` or `FORM=FILE`: tra, sta, lab, srew, trew, dot, drn.
    pub model: Vec<String>,
    /// Its labels.
    pub labels: Option<PathBuf>,
    /// The scheduler that attains the answer; by its ending as decisions, as JSON or as the chain that it induces.
    pub strategy: Option<String>,
    /// The shares of the time in each state in the long run.
    pub steady_state: Option<PathBuf>,
    /// The probabilities of the states at the times asked for.
    pub transient: Option<PathBuf>,
}

/// Where a model comes from.
#[derive(Clone, Debug)]
pub enum ModelInput {
    /// A file in the PRISM language; or states and transitions: `FILE.tra`, `FILE.tra,sta,lab`, `FILE.all` or `FILE.drn`.
    File(PathBuf),
    /// A text in the PRISM language, with the name that messages call it by.
    Text(Source),
}

/// Where properties come from.
#[derive(Clone, Debug)]
pub enum PropertyInput {
    /// A file in the PRISM language.
    File(PathBuf),
    /// A text in the PRISM language: one property, or several with semicolons.
    Text(String),
}

impl CheckRequest {
    /// A model without properties, answered soundly to a relative width of 1e-6.
    pub fn new(model: ModelInput) -> Self {
        Self {
            model,
            model_type: None,
            imports: Vec::new(),
            properties: Vec::new(),
            selected: Vec::new(),
            constants: Experiment::default(),
            open: None,
            method: Method::Sound,
            precision: 1e-6,
            epsilon: 1e-6,
            termination: checker::Termination::Relative,
            max_iterations: None,
            max_states: None,
            fair: false,
            sum_roundoff: None,
            certify: false,
            witness: false,
            timeout: None,
            steady_state: false,
            transient: None,
            initial_distribution: None,
            exports: Exports::default(),
        }
    }

    /// With a further property, or several with semicolons.
    #[must_use]
    pub fn property(mut self, text: impl Into<String>) -> Self {
        self.properties.push(PropertyInput::Text(text.into()));
        self
    }
}

impl ModelInput {
    /// A text in the PRISM language.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        let (name, text) = (name.into(), text.into());
        Self::Text(Source { name, text })
    }

    /// What messages call it by.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Text(source) => source.name.clone(),
        }
    }
}
