//! What a draft's texts say of a tree.

use super::{Comments, Drafted, MOST_ASKED, Mode, comment, counted, quoted};
use crate::init::NewFile;
use behaviour_tree::{Constant, Draw, Group, Node};
use std::fmt::Write as _;

impl Drafted {
    pub(super) fn values(&self) -> Vec<(&'static str, String)> {
        let has_counts = self.runs.is_some();
        let title = format!("A draft about the behaviour tree {}", self.file);
        vec![
            ("FILE", self.file.clone()),
            ("TITLE", quoted(&title)),
            ("VERDICTS", verdicts(has_counts)),
            ("EVIDENCE", evidence(has_counts)),
            ("FILES", files(has_counts)),
            ("RESTS", self.rests()),
            ("NOTES", self.simplifications()),
            ("NEXT", next(has_counts)),
            ("COUNTED", self.counted_entry()),
            ("CHANGED", quoted(self.changed())),
            ("CALIBRATED", self.calibrated()),
            ("ABOUT_MODES", self.about_modes()),
            ("MODES", self.each_mode(Self::mode)),
            ("COLUMN", self.column()),
            ("EXPERIMENT", self.experiment()),
            ("WORDS", self.each_mode(Self::words)),
        ]
    }

    fn each_mode(&self, one: fn(&Self, &Mode) -> String) -> String {
        let texts: Vec<String> = self.modes.iter().map(|mode| one(self, mode)).collect();
        texts.join("\n").trim_end().to_owned()
    }

    /// The leaf that gives a way to fail its name.
    fn leaf(&self, mode: &Mode) -> &Node {
        self.tree.node(mode.leaves[0])
    }

    fn mode(&self, mode: &Mode) -> String {
        let leaf = self.leaf(mode);
        let word = &mode.word;
        let (fails, how) = match leaf.is_leaf() {
            true => ("fails", "ends with FAILURE"),
            false => ("ends its child", "ends with FAILURE since its time is over"),
        };
        let name = quoted(&format!("{} {fails}", comment(&leaf.name)));
        let meaning = quoted(&format!(
            "{} {how}; counted by execution.",
            comment(&leaf.path)
        ));
        let asked = match self.is_asked() {
            true => format!(
                "occurs = 'P=? [ !\"{word}_ended\" U \"{word}_fails\" ]'\nopportunity = 'P=? [ F \"{word}_ended\" ]'\n"
            ),
            false => String::new(),
        };
        format!(
            "\n[[failure_mode]]\nid = \"{}\"\nname = {name}\nmeaning = {meaning}\nmargin = 0.05\n{asked}",
            mode.id
        )
    }

    /// Whether the model is asked for the leaves' ways to fail: not where there are many whose counts it was set to, of which
    /// it would show nothing but those counts.
    fn is_asked(&self) -> bool {
        self.runs.is_none() || self.modes.len() <= MOST_ASKED
    }

    fn about_modes(&self) -> String {
        let text = match self.is_asked() {
            true => {
                "# Each leaf's way to fail, counted by execution. In the model it is the failure of its first execution in a run, among the\n\
                 # runs that come to it: all executions of a leaf are alike there."
            }
            false => {
                "# Each leaf's way to fail, counted by execution. The model is not asked for it, since it has the counts themselves; with\n\
                 # `occurs` and `opportunity` it would be, for example P=? [ !\"X_ended\" U \"X_fails\" ] and P=? [ F \"X_ended\" ]."
            }
        };
        text.to_owned()
    }

    fn words(&self, mode: &Mode) -> String {
        let name = comment(&self.leaf(mode).name);
        let word = &mode.word;
        let [good, bad] = self.leaf(mode).ends();
        let labels = mode.leaves.iter().map(|it| &self.tree.node(*it).label);
        let failed: Vec<String> = labels
            .clone()
            .map(|it| format!("step={bad}_{it}"))
            .collect();
        let ended = labels.map(|it| format!("step={good}_{it}"));
        let ran: Vec<String> = ended.chain(failed.iter().cloned()).collect();
        let (ended, fails) = match self.leaf(mode).is_leaf() {
            true => (
                "has just ended, with SUCCESS or FAILURE",
                "has just ended with FAILURE",
            ),
            false => (
                "is executed, and its time suffices or not",
                "is executed, and its time does not suffice",
            ),
        };
        format!(
            "\n[{word}_ended]\nmeaning = {}\nmodel = \"{}\"\n\n[{word}_fails]\nmeaning = {}\nmodel = \"{}\"\n",
            quoted(&format!("{name} {ended}.")),
            ran.join(" | "),
            quoted(&format!("{name} {fails}.")),
            failed.join(" | "),
        )
    }

    fn column(&self) -> String {
        match self.has_root() {
            true => "column = \"succeeded\"\n".to_owned(),
            false => String::new(),
        }
    }

    fn experiment(&self) -> String {
        match self.has_root() {
            true => "experiment = \"tree_succeeded\"\n".to_owned(),
            false => String::new(),
        }
    }

    /// Whether the recordings have runs of the root that ended.
    fn has_root(&self) -> bool {
        let root = self.root.iter().flatten();
        root.into_iter().any(|it| it.ended() > 0)
    }

    fn changed(&self) -> &'static str {
        match self.runs {
            Some(_) => {
                "Drafted from the behaviour tree; its constants are set to the counts of E1."
            }
            None => "Drafted from the behaviour tree; its constants are guesses.",
        }
    }

    fn counted_entry(&self) -> String {
        let Some(runs) = &self.runs else {
            return String::new();
        };
        let many = counted(runs.names.len(), "run");
        let cohort = match self.has_root() {
            true => "tables.cohort = \"counts/runs.csv\"\n",
            false => "",
        };
        format!(
            "\n# DRAFT: the recordings are taken for trials of the robot. Of a simulated one, write `technique = \"simulation\"`.\n\
             [[evidence]]\nid = \"E1\"\ntitle = \"Executions in the recordings\"\ntechnique = \"experiment\"\n\
             conditions = \"usual\"\n{cohort}tables.failure_modes = \"counts/failure_modes.csv\"\n\
             changed = {}\n",
            quoted(&format!("{many} of the tree, from {}.", comment(&runs.of)))
        )
    }

    fn calibrated(&self) -> String {
        let mut entries = String::new();
        for constant in &self.model.constants {
            if let Some(mode) = self.mode_of(constant).filter(|it| it.group.is_some()) {
                let _ = writeln!(
                    entries,
                    "    {{ constant = \"{}\", from = \"E1\", failure_mode = \"{}\", complement = true }},",
                    constant.name, mode.id
                );
            }
        }
        match entries.is_empty() {
            true => String::new(),
            false => format!("calibrated = [\n{entries}]\n"),
        }
    }

    /// The model, with where each value comes from.
    pub(super) fn model_text(&self) -> String {
        let comments: Comments = self
            .model
            .constants
            .iter()
            .map(|it| self.origin(it))
            .collect();
        let mut text = String::with_capacity(self.model.text.len());
        for line in self.model.text.lines() {
            text.push_str(line);
            let name = line.strip_prefix("const double ");
            let name = name.and_then(|it| it.split_whitespace().next());
            if let Some(origin) = name.and_then(|it| comments.get(it)) {
                let _ = write!(text, " // {origin}");
            }
            text.push('\n');
        }
        text
    }

    fn origin(&self, constant: &Constant) -> (String, String) {
        let group = self.mode_of(constant).and_then(|mode| mode.group.as_ref());
        let origin = match group.map(Group::total) {
            Some(total) => {
                let halted = match total.halted {
                    0 => String::new(),
                    halted => format!(", and {halted} halted"),
                };
                let how = match constant.draw {
                    Draw::Deadline => "ended in time",
                    _ => "succeeded",
                };
                format!(
                    "{} of {} {how}{halted}",
                    total.succeeded,
                    counted(total.ended(), "execution")
                )
            }
            None => "DRAFT: a guess".to_owned(),
        };
        (constant.name.clone(), origin)
    }

    /// The tables of counts.
    pub(super) fn tables(&self) -> Vec<NewFile> {
        let Some(runs) = &self.runs else {
            return Vec::new();
        };
        let from = format!("# Counted by `corroborate init --from {}`.\n", self.file);
        let mut modes = from.clone() + "mode,occurrences,opportunities\n";
        let mut by_run = from.clone() + "run,leaf,succeeded,failed,halted\n";
        for mode in &self.modes {
            let Some(group) = &mode.group else { continue };
            let total = group.total();
            let _ = writeln!(modes, "{},{},{}", mode.id, total.failed, total.ended());
            for (run, counts) in runs.names.iter().zip(&group.by_run) {
                let (succeeded, failed, halted) = (counts.succeeded, counts.failed, counts.halted);
                let leaf = self.leaf(mode);
                let label = match leaf.is_leaf() {
                    true => leaf.label.clone(),
                    false => leaf.draw_name(Draw::Deadline),
                };
                let _ = writeln!(
                    by_run,
                    "{},{label},{succeeded},{failed},{halted}",
                    cell(run)
                );
            }
        }
        let mut files = vec![
            NewFile::text("counts/failure_modes.csv", modes),
            NewFile::text("counts/by_run.csv", by_run),
        ];
        if self.has_root() {
            let mut cohort = from + "run,attempts,succeeded\n";
            for (run, counts) in runs.names.iter().zip(self.root.iter().flatten()) {
                if counts.ended() > 0 {
                    let (ended, succeeded) = (counts.ended(), counts.succeeded);
                    let _ = writeln!(cohort, "{},{ended},{succeeded}", cell(run));
                }
            }
            files.push(NewFile::text("counts/runs.csv", cohort));
        }
        files
    }

    fn rests(&self) -> String {
        let guessed = self.guessed();
        let all = self.model.constants.len();
        let mut text = match &self.runs {
            None => format!(
                "No recordings were given: all {} of the model are guesses. What the model says follows from them alone.",
                counted(all, "constant")
            ),
            Some(runs) => format!(
                "{} of {} of the model are set to counts of {} in {}. Their uncertainty is carried on to the model's answers \
                 (Jeffreys' posteriors). That the model agrees with the same counts is a fit: it shows that the numbers were \
                 carried over, not that the model is right. Whether it is, the root's own results show, as far as there are \
                 enough runs; recordings that were not counted would show it independently.",
                all - guessed.len(),
                counted(all, "constant"),
                counted(runs.names.len(), "run"),
                comment(&runs.of),
            ),
        };
        if self.runs.is_some() && !self.has_root() {
            text.push_str(" The recordings do not tell how the root ended.");
        }
        if self.runs.is_some() && !guessed.is_empty() {
            let names: Vec<String> = guessed.iter().map(|it| format!("`{}`", it.name)).collect();
            let _ = write!(text, " Guesses are: {}.", names.join(", "));
        }
        if self.runs.is_some() {
            text.push_str(
                " A log has changes of status alone: an execution that ends like the one before, without a reset between them, is not in it. \
                 Executions that were halted count neither as success nor as failure.",
            );
        }
        text
    }

    fn simplifications(&self) -> String {
        if self.of_tree.is_empty() {
            return "* nothing was found.\n".to_owned();
        }
        self.of_tree.iter().map(|it| format!("* {it}\n")).collect()
    }
}

fn verdicts(has_counts: bool) -> String {
    match has_counts {
        true => String::new(),
        false => "\n# A model alone: verdicts of the model are what is asked for here. Without this, requirements need trials of the\n\
                  # real robot (`corroborate explain steps`).\n[verdicts]\nneeds = \"model\"\n"
            .to_owned(),
    }
}

fn evidence(has_counts: bool) -> String {
    match has_counts {
        true => ": the counts E1, and the model M1 that is set to them".to_owned(),
        false => ": the model M1".to_owned(),
    }
}

fn files(has_counts: bool) -> String {
    match has_counts {
        true => "| `counts/` | executions by leaf and by run, as the recordings have them |\n"
            .to_owned(),
        false => String::new(),
    }
}

fn next(has_counts: bool) -> String {
    match has_counts {
        true => "`technique` of E1 in `ledger.toml`, if the recordings are of a simulated robot.".to_owned(),
        false => "The constants in `model.prism`, or draft again with `--recordings FOLDER`: then they are counted.".to_owned(),
    }
}

/// A cell of a table: without what would end it.
fn cell(text: &str) -> String {
    comment(text).replace([',', '"', ';'], "_")
}
