//! Requirements and evidence made step by step: what is not said is empty, so that a piece of evidence takes a few lines
//! where a literal takes forty.

use crate::{
    Asset, AssetRole, Calibration, Denominator, Direction, Evidence, Finding, Guarantee, Measure,
    MethodAnswer, Requirement, Subject, Technique, Threshold, Tool,
};

impl Requirement {
    /// A requirement of every run, with the margin of agreement of declarations that have none
    /// ([`DEFAULT_MARGIN`](crate::DEFAULT_MARGIN)).
    ///
    /// ```
    /// let grasp = evidence::Requirement::new("1", "The robot shall grasp the object.").at_least(0.9);
    /// assert_eq!(grasp.threshold.map(|it| it.value), Some(0.9));
    /// ```
    #[must_use]
    pub fn new(id: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            text: text.into(),
            margin: crate::DEFAULT_MARGIN,
            ..Self::default()
        }
    }

    /// It has to hold in at least this share of the runs, 0 to 1.
    #[must_use]
    pub fn at_least(self, value: f64) -> Self {
        let direction = Direction::AtLeast;
        Self {
            threshold: Some(Threshold { direction, value }),
            ..self
        }
    }

    /// It may hold in at most this share of the runs, 0 to 1.
    #[must_use]
    pub fn at_most(self, value: f64) -> Self {
        let direction = Direction::AtMost;
        Self {
            threshold: Some(Threshold { direction, value }),
            ..self
        }
    }

    /// The largest difference of two rates that counts as agreement, 0 to 1.
    #[must_use]
    pub fn margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }
}

impl Measure {
    /// A probability that was computed without rounding.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self::computed("exact", value, Guarantee::Exact { rational: None })
    }

    /// A probability with bounds between which the true value lies.
    #[must_use]
    pub fn bounded(value: f64, low: f64, high: f64) -> Self {
        Self::computed("sound", value, Guarantee::Bounded { low, high })
    }

    fn computed(method: &str, value: f64, guarantee: Guarantee) -> Self {
        Self::Probability {
            answer: MethodAnswer {
                method: method.into(),
                value,
                complement: None,
                guarantee,
                iterations: None,
            },
            others: vec![],
            credible: None,
        }
    }
}

impl Finding {
    /// What was found of a subject, over all runs.
    #[must_use]
    pub fn new(subject: Subject, measure: Measure) -> Self {
        Self {
            subject,
            measure,
            denominator: Denominator::default(),
            trigger: None,
            undecided: 0,
            left_out: 0,
            completions: None,
            witnesses: vec![],
            readings: vec![],
        }
    }
}

impl Evidence {
    /// A piece of evidence that has found nothing yet, of no assets, under the conditions `typical`; its title is `id`.
    ///
    /// ```
    /// use evidence::{AssetRole, Evidence, Finding, Measure, Subject, Technique};
    /// use stats::{Confidence, Sample};
    ///
    /// let grasped = Measure::of_counts(Sample::new(88, 100)?, None, Confidence::P95)?;
    /// let trials = Evidence::new("E1", Technique::Experiment)
    ///     .titled("A hundred grasps")
    ///     .of_asset(AssetRole::Data, "grasps.csv", "0f3a...")
    ///     .found(Finding::new(Subject::Requirement("1".into()), grasped));
    /// assert_eq!(trials.finding(&Subject::Requirement("1".into())).map(|it| it.undecided), Some(0));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    #[must_use]
    pub fn new(id: impl Into<String>, technique: Technique) -> Self {
        let id = id.into();
        Self {
            title: id.clone(),
            id,
            technique,
            tool: Tool {
                name: String::new(),
                version: String::new(),
                settings: String::new(),
            },
            assets: vec![],
            conditions: "typical".into(),
            changed: String::new(),
            calibrated: vec![],
            intermediate: false,
            published: false,
            reproduced_by: None,
            findings: vec![],
            form_differences: vec![],
            description_gaps: vec![],
            failures: vec![],
            clusters: None,
            shared_rows: vec![],
            common_texts: Vec::new(),
            shared_seeds: Vec::new(),
            undecided_at_random: None,
            alike_trials: None,
            lineage_questions: vec![],
            inputs: String::new(),
        }
    }

    /// With a title.
    #[must_use]
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..self
        }
    }

    /// Under these conditions; evidence under other conditions is not comparable.
    #[must_use]
    pub fn under(self, conditions: impl Into<String>) -> Self {
        Self {
            conditions: conditions.into(),
            ..self
        }
    }

    /// By this tool, in the version that it states.
    #[must_use]
    pub fn by_tool(mut self, name: impl Into<String>, version: impl Into<String>) -> Self {
        self.tool.name = name.into();
        self.tool.version = version.into();
        self
    }

    /// Resting on one more file: its path relative to the study's folder, and the BLAKE3 hash of its content in
    /// hexadecimal.
    #[must_use]
    pub fn of_asset(
        mut self,
        role: AssetRole,
        path: impl Into<String>,
        hash: impl Into<String>,
    ) -> Self {
        self.assets.push(Asset {
            role,
            path: path.into(),
            hash: hash.into(),
        });
        self
    }

    /// With a number of its assets that was set to what the evidence `from` counted of a subject.
    #[must_use]
    pub fn set_to(
        mut self,
        parameter: impl Into<String>,
        from: impl Into<String>,
        subject: Subject,
    ) -> Self {
        self.calibrated.push(Calibration {
            parameter: parameter.into(),
            from: from.into(),
            subject,
            chosen: false,
        });
        self
    }

    /// With one more finding.
    #[must_use]
    pub fn found(mut self, finding: Finding) -> Self {
        self.findings.push(finding);
        self
    }
}
