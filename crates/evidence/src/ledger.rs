//! The ledger: evidence with its history, and the whole of a study.

use crate::{
    Asset, CalibrationReport, Comparison, Conclusion, CoverageGap, DescriptionGap, Diagnosis,
    DisagreementMap, EpisodeFailures, Exploration, FailureMode, Finding, FormDifference, Interval,
    Outcome, Relation, Requirement, Subject, Suspect, Synthesis, Technique, Tool,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number of this evidence's assets that was set to another evidence's
/// count: agreement on it is a fit, not corroboration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Calibration {
    /// The constant or parameter that was set.
    pub parameter: String,
    /// The evidence whose finding it was set to.
    pub from: String,
    /// The failure mode or requirement that supplied the number.
    pub subject: Subject,
    /// Whether no number was set: `parameter` says in words what was changed in a text of the study, which was chosen because then the
    /// evidence agrees.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub chosen: bool,
}

/// What producing the evidence took. Varies from run to run, so it is kept
/// apart from everything that must be reproducible.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cost {
    /// The evidence.
    pub evidence: String,
    /// Elapsed time in seconds; of a campaign that was interrupted and went on, of all its parts.
    pub wall_secs: f64,
    /// Seconds of simulated time, for simulations.
    pub simulated_secs: Option<f64>,
    /// Processor seconds spent simulating and judging, over all threads and the robots' programs
    /// that were started for it.
    pub cpu_secs: Option<f64>,
    /// Simulated seconds for each processor second, monitors, recording and
    /// robots' programs included: how many times faster than real time one
    /// core is.
    pub real_time_factor: Option<f64>,
    /// States of the model.
    pub states: Option<u64>,
    /// Transitions of the model.
    pub transitions: Option<u64>,
    /// What the source publication needed, in words.
    pub published: Option<String>,
}

/// A figure that the source publication prints, beside ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedFigure {
    /// The evidence to which it belongs.
    pub evidence: String,
    /// What it is, for example `states` or `success rate (prism-default)`.
    pub quantity: String,
    /// As printed.
    pub published: String,
    /// As computed here.
    pub ours: String,
    /// Whether they are the same to the tolerance, or statistically
    /// consistent.
    pub agrees: bool,
    /// How that was judged, for example `within 1e-12` or `Fisher p = 0.41`.
    pub judged: String,
}

/// Statistics of trials grouped by subject or session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClusterTests {
    /// Intraclass correlation of success within a group; what all columns have in common where success alone
    /// cannot tell it.
    pub intraclass_correlation: f64,
    /// What all trials are worth in independent ones, by the count of the first requirement: the number with which it is
    /// compared ([`crate::Measure::Counts`]).
    pub effective_trials: f64,
    /// Subjects or sessions with trials; 1 if all trials are of one, 0 where an older version did not count them.
    #[serde(default)]
    pub subjects: u64,
    /// Why the one subject stands for all, where all trials are of one and the study declares it.
    #[serde(default)]
    pub one_for_all: Option<String>,
    /// Tests in words with their figures, one a line.
    pub tests: Vec<String>,
    /// What counts were given that cannot tell themselves how alike their trials are; `None` if all can.
    #[serde(default)]
    pub common: Option<TakenCorrelation>,
}

impl ClusterTests {
    /// The same with the declaration that one subject stands for all, where there is one alone.
    #[must_use]
    pub fn with_one_for_all(self, because: Option<String>) -> Self {
        let one_for_all = because.filter(|_| self.subjects == 1);
        Self {
            one_for_all,
            ..self
        }
    }
}

/// The intraclass correlation that all columns of a cohort have in common, taken for counts that cannot tell their
/// own (`stats::common_correlation`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TakenCorrelation {
    /// The most likely one; `None` where no column tells, so that each subject counts as one trial.
    pub estimate: Option<f64>,
    /// Where it lies at the study's level, from 0 to 1.
    pub interval: Interval,
    /// The columns of the cohort that tell it.
    pub columns: Vec<String>,
    /// How many independent columns tell as much.
    pub effective_columns: f64,
    /// Whose counts it was taken for.
    pub taken_for: Vec<Subject>,
}

/// A piece of evidence: what one technique found on one set of assets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evidence {
    /// Identifier in the ledger, for example `E4`.
    pub id: String,
    /// A short title.
    pub title: String,
    /// How it was obtained.
    pub technique: Technique,
    /// With which tool.
    pub tool: Tool,
    /// On which assets.
    pub assets: Vec<Asset>,
    /// Under which conditions it holds; evidence under other conditions is
    /// not comparable.
    pub conditions: String,
    /// What was changed since the evidence before it.
    pub changed: String,
    /// Whose counts its assets were set to.
    pub calibrated: Vec<Calibration>,
    /// `true` for a step on the way to later evidence: shown in the ledger,
    /// but not compared and not concluded from.
    pub intermediate: bool,
    /// `true` if the counts were published by others and only read here.
    pub published: bool,
    /// The evidence of ours that reproduces this published evidence.
    pub reproduced_by: Option<String>,
    /// What was found.
    pub findings: Vec<Finding>,
    /// Forms of one requirement that do not agree on the same runs, for
    /// techniques that judge traces.
    #[serde(default)]
    pub form_differences: Vec<FormDifference>,
    /// Episodes that were ended by the robot's program or by the simulator; empty if none was.
    #[serde(default)]
    pub failures: Vec<EpisodeFailures>,
    /// What of robots' and things' descriptions was not simulated as it is described.
    #[serde(default)]
    pub description_gaps: Vec<DescriptionGap>,
    /// Clustering of trials, for experiments by subject.
    pub clusters: Option<ClusterTests>,
    /// Rows of its tables that earlier evidence has, too, beyond chance.
    #[serde(default)]
    pub shared_rows: Vec<RepeatedRows>,
    /// What of its models stands in models of earlier evidence, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub common_texts: Vec<CommonText>,
    /// Earlier simulations whose seeds its runs have, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shared_seeds: Vec<SharedSeeds>,
    /// Why its runs without a verdict are as likely to be kept as those with one, where the study declares it; without it they
    /// count against and for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undecided_at_random: Option<String>,
    /// How alike its trials are in groups that nothing declares, where a technique that sees each trial looked for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alike_trials: Option<AlikeTrials>,
    /// What of its assets looks taken from other evidence though no lineage says so.
    #[serde(default)]
    pub lineage_questions: Vec<LineageQuestion>,
    /// Hash of everything that the findings depend on, in hexadecimal.
    pub inputs: String,
}

/// How alike the trials of a piece are in groups that nothing declares: the strongest of all tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AlikeTrials {
    /// What was counted.
    pub subject: Subject,
    /// What forms the groups, in words: `recordings of one folder`.
    pub groups: String,
    /// The probability of being as alike by chance, by itself, 0 to 1 (`stats::alike_by_label`, `alike_in_order`).
    pub p_value: f64,
    /// How many tests there were: subjects times groupings that tell anything.
    pub tests: u64,
}

/// Rows that the tables of two pieces of evidence have in common beyond chance: the same trials, or the same people's, told
/// twice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RepeatedRows {
    /// The earlier evidence.
    pub with: String,
    /// Its table, and the table of the piece itself, relative to the study's folder.
    pub tables: [String; 2],
    /// Rows that are the same.
    pub same: u64,
    /// Rows of which both tables have the key.
    pub common: u64,
    /// The probability of as many by chance, at most (`stats::shared_rows`).
    pub chance: f64,
}

/// Runs of two simulations that are drawn from the same seeds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SharedSeeds {
    /// The earlier evidence.
    pub with: String,
    /// The evidence whose seeds both have.
    pub of: String,
    /// Whether the same simulator runs the same in both: then they are the same runs, told twice. Otherwise they are paired,
    /// run by run, and draw the same random numbers.
    pub same_runs: bool,
}

/// Models of two pieces of evidence of which most was written once: a copy, or a revision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct CommonText {
    /// The earlier evidence.
    pub with: String,
    /// Its model, and the model of the piece itself, relative to the study's folder.
    pub files: [String; 2],
    /// Statements that stand in both.
    pub same: u64,
    /// Statements of the shorter of the two.
    pub statements: u64,
}

/// What looks taken from other evidence though no lineage says so, or looks dependent within one piece: a question that a
/// line of the ledger settles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LineageQuestion {
    /// The other evidence.
    pub with: String,
    /// What looks copied.
    pub kind: CopyKind,
    /// The requirements and failure modes on which it bears; all if empty.
    pub subjects: Vec<Subject>,
    /// What was found, with its figures, in one sentence.
    pub finding: String,
    /// Where: files with their lines, the copy first.
    pub places: Vec<String>,
    /// The probability of such a coincidence anywhere in the study if nothing was copied, at most.
    pub chance: f64,
    /// Whether the pair is not called independent until this is settled; a coincidence that chance explains is only noted.
    pub blocks: bool,
    /// The ledger's reason why it is no copy, where it gives one.
    pub settled: Option<String>,
    /// The line of the ledger that settles it.
    pub remedy: String,
}

impl LineageQuestion {
    /// Whether it keeps a pair from being called independent.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.blocks && self.settled.is_none()
    }
}

/// What looks copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CopyKind {
    /// A number in an asset that is a rate of the other evidence's counts.
    Constant,
    /// Counts that are the other evidence's.
    Counts,
    /// A table of totals that is the other evidence's to the byte, under another name.
    File,
    /// Rows of a table.
    Rows,
    /// A number in an asset that is a product of two rates of the other evidence's counts.
    Product,
    /// What a model computes that is, to the last digit, what the other evidence's model computes.
    Answer,
    /// Trials of the piece itself that are alike where the table does not say that they belong together; the other
    /// evidence is the piece.
    Trials,
    /// Episodes with the same seeds as the other evidence's.
    Seeds,
    /// Recordings of the piece itself that have the same messages; the other evidence is the piece.
    Recordings,
}

impl Evidence {
    /// Whether that a table of this piece has the content of one of the other's may be chance, or is settled: the question about it
    /// ([`CopyKind::File`]) decides, and the content says nothing.
    pub(crate) fn may_equal_by_chance(&self, other: &Self) -> bool {
        let asked = |one: &Self, other: &Self| {
            let mut all = one.lineage_questions.iter();
            all.any(|it| it.kind == CopyKind::File && it.with == other.id)
        };
        asked(self, other) || asked(other, self)
    }

    /// The finding about a subject.
    pub fn finding(&self, subject: &Subject) -> Option<&Finding> {
        self.findings.iter().find(|f| &f.subject == subject)
    }

    /// Whether all its trials are of one person, session or other cluster, which the study does not declare to stand for all: its figures are
    /// of this one alone, whatever their number, and say nothing of how others differ.
    #[must_use]
    pub fn is_of_one_subject(&self) -> bool {
        let clusters = self.clusters.as_ref();
        clusters.is_some_and(|it| it.subjects == 1 && it.one_for_all.is_none())
    }

    /// The same of its trials of one subject: of a triggered requirement, or of the opportunities of a failure mode, those of one may be all.
    #[must_use]
    pub fn is_of_one_subject_on(&self, subject: &Subject) -> bool {
        let clusters = self.clusters.as_ref();
        let is_declared = clusters.is_some_and(|it| it.one_for_all.is_some());
        let finding = self.finding(subject);
        self.is_of_one_subject()
            || !is_declared && finding.is_some_and(|it| it.measure.is_of_one_subject())
    }

    /// The same of trials that are not of the system itself.
    pub(crate) fn is_simulated_of_one(&self) -> bool {
        self.is_of_one_subject() && !self.technique.is_of_system()
    }

    /// The one whose all its trials are, in words: of the system a person or session, of a simulation whatever makes runs alike.
    pub(crate) fn one_subject(&self) -> &'static str {
        match self.technique.is_of_system() {
            true => "one person or session",
            false => "one cluster",
        }
    }
}

/// Everything a study found: what the report shows and the JSON holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudyResult {
    /// Version of this form; a reader refuses another major number.
    pub format: String,
    /// The study's title.
    pub title: String,
    /// What the study is about, one paragraph for a reader new to it.
    pub summary: String,
    /// Level of all intervals, for example 0.95.
    pub confidence: f64,
    /// What was required.
    pub requirements: Vec<Requirement>,
    /// What can go wrong.
    pub failure_modes: Vec<FailureMode>,
    /// The ledger, oldest first.
    pub evidence: Vec<Evidence>,
    /// Every pair on every subject.
    pub comparisons: Vec<Comparison>,
    /// One for each requirement.
    pub conclusions: Vec<Conclusion>,
    /// What all evidence amounts to together, and what would decide the undecided.
    #[serde(default)]
    pub synthesis: Synthesis,
    /// Who is suspected by the evidence alone, the strongest first; see [`StudyResult::suspected`].
    pub suspects: Vec<Suspect>,
    /// What changing one asset at a time shows; `corroborate diagnose` finds it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosis>,
    /// Contexts in which model and simulation part; `corroborate explore --disagreement` finds them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disagreement: Option<DisagreementMap>,
    /// What was found by looking for what nobody has thought of; `corroborate explore` finds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exploration: Option<Exploration>,
    /// What of a simulator was fitted to counts; `corroborate calibrate` does it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationReport>,
    /// What nothing or too little covers.
    pub gaps: Vec<CoverageGap>,
    /// Figures of the source publication beside ours.
    pub published: Vec<PublishedFigure>,
    /// What it took.
    pub costs: Vec<Cost>,
    /// The program and version that produced this.
    pub produced_by: String,
}

impl StudyResult {
    /// The JSON schema of a serialised study result.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(StudyResult).into()
    }

    /// The suspects by their ranks: those of the diagnosis where one was made, which looked further, else those of the
    /// evidence alone.
    #[must_use]
    pub fn suspected(&self) -> &[Suspect] {
        match &self.diagnosis {
            Some(diagnosis) => &diagnosis.suspects,
            None => &self.suspects,
        }
    }

    /// Conflicts between current evidence, of requirements and failure modes: what exit codes, test cases and packs call a conflict. Of a
    /// requirement a piece is current that its conclusion rests on; of a failure mode one that some conclusion rests on, or
    /// that none lays aside, since a piece may speak of failure modes alone; so of a requirement that one side excludes.
    #[must_use]
    pub fn open_conflicts(&self) -> Vec<&Comparison> {
        let conflicts = self.comparisons.iter();
        let conflicts = conflicts.filter(|it| it.outcome == Outcome::Conflicts);
        conflicts.filter(|it| self.is_between_current(it)).collect()
    }

    /// Differences between current evidence that are shown and no conflicts, because they are said of one person, session or other cluster
    /// alone: nothing is decided by them, and a study that has one does not hold as a whole.
    #[must_use]
    pub fn differences_of_one(&self) -> Vec<&Comparison> {
        let pairs = self.comparisons.iter().filter(|it| {
            it.relation == Some(Relation::Different)
                && it.outcome == Outcome::Inconclusive
                && (it.independent || it.paired)
        });
        pairs.filter(|it| self.is_between_current(it)).collect()
    }

    fn is_between_current(&self, pair: &Comparison) -> bool {
        let sides = [&pair.left, &pair.right];
        // No conclusion rests on a model that excludes what the requirement is about.
        sides.iter().all(|id| match pair.is_with_the_impossible() {
            true => self.speaks_anywhere(id),
            false => self.is_current(id, &pair.subject),
        })
    }

    fn is_current(&self, id: &String, subject: &Subject) -> bool {
        let rests = |it: &Conclusion| it.rests_on.contains(id);
        let mut conclusions = self.conclusions.iter();
        match subject {
            Subject::Requirement(own) => conclusions.any(|it| it.requirement == *own && rests(it)),
            Subject::FailureMode(_) => self.speaks_anywhere(id),
        }
    }

    /// Whether some conclusion rests on a piece, or none lays it aside.
    fn speaks_anywhere(&self, id: &String) -> bool {
        let mut excluded = self.conclusions.iter().flat_map(|it| &it.excluded);
        self.conclusions.iter().any(|it| it.rests_on.contains(id))
            || !excluded.any(|it| it.evidence == *id && it.reason.lays_aside())
    }
}
