//! A study drafted from a behaviour tree: its Markov chain, the root's success and each leaf's failure, and the counts of
//! recordings to which the chain's constants are set.

mod executions;
mod texts;

use super::draft::{comment, file_name, filled, quoted};
use super::{Content, Draft, NewFile};
use behaviour_tree::{
    Attributed, BehaviourTree, Constant, Draw, Group, Kind, Leaf, Options, PrismModel, Reading,
};
use diagnostic::{Problem, Source, counted};
use executions::Runs;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Ways to fail of which the model is asked beside counts, at most: each is solved for anew at every point at which the
/// uncertainty of the constants is looked at.
const MOST_ASKED: usize = 8;

/// Bytes of a file in which its outermost element is looked for.
const BEGINNING: usize = 1 << 20;

/// Whether a file is a behaviour tree in the XML of BehaviorTree.CPP: its outermost element is `root`, and it has trees or
/// the format's number.
pub(super) fn is_tree(file: &Path) -> bool {
    if file.extension().is_none_or(|ending| ending != "xml") {
        return false;
    }
    let Ok(text) = std::fs::read_to_string(file) else {
        return false;
    };
    let end = text.len().min(BEGINNING);
    let end = (0..=end).rev().find(|at| text.is_char_boundary(*at));
    let text = without_comments(&text[..end.unwrap_or(0)]);
    let Some(at) = text.find("<root") else {
        return false;
    };
    let before = text[..at].trim_start_matches('\u{feff}').trim();
    let is_outermost = before.is_empty() || (before.starts_with("<?") && before.ends_with("?>"));
    let behind = &text[at..];
    is_outermost
        && ["BTCPP_format", "main_tree_to_execute", "<BehaviorTree"]
            .iter()
            .any(|word| behind.contains(word))
}

fn without_comments(text: &str) -> String {
    let mut parts = text.split("<!--");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| {
        all + part.split_once("-->").map_or("", |(_, behind)| behind)
    })
}

/// A draft of a study about the behaviour tree in a file, with the executions that recordings show.
///
/// # Errors
/// Those of reading the tree; `bad-recording` and `no-executions` of the recordings.
pub(super) fn draft(file: &Path, recordings: Option<&Path>) -> Result<Draft, Problem> {
    let (reading, included) = read(file)?;
    let runs = recordings.map(executions::of).transpose()?;
    let drafted = Drafted::new(file, reading, runs)?;
    let mut files = drafted.files();
    files.push(NewFile::text(".gitignore", "results/\n"));
    for path in std::iter::once(file.to_owned()).chain(included) {
        let name = path.file_name().unwrap_or_default();
        let whole =
            std::fs::canonicalize(&path).map_err(|error| Problem::cannot_read(&path, &error))?;
        files.push(NewFile {
            path: Path::new("tree").join(name),
            content: Content::CopyOf(whole),
        });
    }
    Ok(Draft {
        is: format!("a draft about the behaviour tree {}", file_name(file)),
        files,
        notes: drafted.notes,
    })
}

/// The tree, and the files that it includes.
fn read(file: &Path) -> Result<(Reading, Vec<PathBuf>), Problem> {
    let text = |path: &Path| {
        std::fs::read_to_string(path).map_err(|error| Problem::cannot_read(path, &error))
    };
    let mut included = Vec::new();
    let mut include = |path: &str, from: &str| {
        let folder = Path::new(from).parent().unwrap_or(Path::new(""));
        let path = folder.join(path);
        let found = Source::new(path.display().to_string(), text(&path)?);
        if !included.contains(&path) {
            included.push(path);
        }
        Ok(found)
    };
    let source = Source::new(file.display().to_string(), text(file)?);
    let reading = behaviour_tree::read(&source, None, &mut include)?;
    Ok((reading, included))
}

/// A way to fail: of one leaf, of several that share their counts, or of a time that does not suffice.
struct Mode {
    /// What its words begin with: the leaf's label.
    word: String,
    id: String,
    leaves: Vec<behaviour_tree::NodeId>,
    group: Option<Group>,
}

struct Drafted {
    file: String,
    tree: BehaviourTree,
    model: PrismModel,
    modes: Vec<Mode>,
    runs: Option<Runs>,
    /// The root's executions by run, where the recordings tell them.
    root: Option<Vec<behaviour_tree::Counts>>,
    of_tree: Vec<String>,
    notes: Vec<String>,
}

impl Drafted {
    fn new(file: &Path, reading: Reading, runs: Option<Runs>) -> Result<Self, Problem> {
        let tree = reading.tree;
        let mut notes = Vec::new();
        let attributed = match &runs {
            Some(runs) => attributed(&tree, runs, &mut notes)?,
            None => Attributed::default(),
        };
        let open = behaviour_tree::to_prism(&tree, &Options::default());
        let mut modes = modes(&tree, &open, &attributed);
        modes.extend(late_modes(&tree, &open, &attributed));
        if runs.is_some() {
            modes.retain(|mode| mode.group.is_some());
        }
        let values = open.constants.iter().map(|it| {
            let mode = modes.iter().find(|mode| mode.leaves.contains(&it.node));
            (it.name.clone(), value(&tree, it, mode))
        });
        let options = Options {
            values: values.collect(),
            ..Options::default()
        };
        let model = behaviour_tree::to_prism(&tree, &options);
        let of_tree: Vec<String> = reading.notes.iter().map(said).collect();
        if !of_tree.is_empty() {
            let many = counted(of_tree.len(), "simplification");
            notes.push(format!(
                "README.md lists {many} of the tree, each with its line"
            ));
        }
        let mut drafted = Self {
            file: file_name(file),
            root: attributed.root,
            tree,
            model,
            modes,
            runs,
            of_tree,
            notes,
        };
        drafted.note_guesses();
        Ok(drafted)
    }

    fn note_guesses(&mut self) {
        let guessed = self.guessed().len();
        if guessed > 0 {
            let all = self.model.constants.len();
            self.notes.push(format!(
                "{guessed} of {} in model.prism are guesses, marked DRAFT there",
                counted(all, "constant")
            ));
        }
    }

    /// The constants that no counts were found for.
    fn guessed(&self) -> Vec<&Constant> {
        let constants = self.model.constants.iter();
        constants.filter(|it| !self.is_counted(it)).collect()
    }

    fn mode_of(&self, constant: &Constant) -> Option<&Mode> {
        let mut modes = self.modes.iter();
        let is_counted = matches!(constant.draw, Draw::Leaf | Draw::Deadline);
        modes.find(|mode| is_counted && mode.leaves.contains(&constant.node))
    }

    fn is_counted(&self, constant: &Constant) -> bool {
        self.mode_of(constant)
            .is_some_and(|mode| mode.group.is_some())
    }

    fn files(&self) -> Vec<NewFile> {
        let values = self.values();
        let values: Vec<(&str, &str)> = values
            .iter()
            .map(|(name, value)| (*name, value.as_str()))
            .collect();
        let mut files: Vec<NewFile> = TEXTS
            .iter()
            .map(|(path, text)| NewFile::text(*path, filled(text, &values)))
            .collect();
        files.push(NewFile::text("model.prism", self.model_text()));
        files.extend(self.tables());
        files
    }
}

/// The texts of `templates/from-tree`.
const TEXTS: [(&str, &str); 5] = [
    (
        "README.md",
        include_str!("../../templates/from-tree/README.md"),
    ),
    (
        "study.toml",
        include_str!("../../templates/from-tree/study.toml"),
    ),
    (
        "vocabulary.toml",
        include_str!("../../templates/from-tree/vocabulary.toml"),
    ),
    (
        "requirements.toml",
        include_str!("../../templates/from-tree/requirements.toml"),
    ),
    (
        "ledger.toml",
        include_str!("../../templates/from-tree/ledger.toml"),
    ),
];

/// Whose executions the recordings show; what cannot be given to one leaf is noted.
fn attributed(
    tree: &BehaviourTree,
    runs: &Runs,
    notes: &mut Vec<String>,
) -> Result<Attributed, Problem> {
    let found = tree.attributed(&runs.executions);
    if found.leaves.is_empty() {
        let names: Vec<&str> = found.unknown.iter().take(5).map(String::as_str).collect();
        let message = match names.is_empty() {
            true => "the recordings show no execution of a leaf of the tree".to_owned(),
            false => format!(
                "the recordings show no execution of a leaf of the tree; they name {}",
                comment(&names.join(", "))
            ),
        };
        return Err(Problem::new("no-executions", message)
            .remedy("name recordings of this tree, or a CSV with the columns node and status"));
    }
    for shared in &found.shared {
        let name = comment(&shared.name);
        let many = shared.nodes.len();
        notes.push(match shared.is_mixed {
            true => format!(
                "{many} nodes are logged as {name}, and not all of them are leaves: their executions are not counted"
            ),
            false => format!("{many} leaves are logged as {name}: they share their counts"),
        });
    }
    if !found.unknown.is_empty() {
        let names: Vec<&str> = found.unknown.iter().take(5).map(String::as_str).collect();
        let more = match found.unknown.len() > names.len() {
            true => ", ...",
            false => "",
        };
        notes.push(format!(
            "the recordings name nodes that the tree does not have: {}{more}",
            comment(&names.join(", "))
        ));
    }
    notes.extend(runs.notes.iter().cloned());
    Ok(found)
}

/// The ways to fail, in the order of the tree: leaves that are reached, those that share counts together.
fn modes(tree: &BehaviourTree, model: &PrismModel, attributed: &Attributed) -> Vec<Mode> {
    let reached = model.constants.iter().filter(|it| it.draw == Draw::Leaf);
    let reached: BTreeSet<_> = reached.map(|it| it.node).collect();
    let mut taken = BTreeSet::new();
    let mut found = Vec::new();
    for node in &reached {
        if taken.contains(node) {
            continue;
        }
        let group = attributed.leaves.iter().find(|it| it.nodes.contains(node));
        let group = group.filter(|it| it.total().ended() > 0);
        let members = group.map_or(vec![*node], |it| it.nodes.clone());
        let leaves: Vec<_> = members
            .into_iter()
            .filter(|it| reached.contains(it))
            .collect();
        taken.extend(leaves.iter().copied());
        // The model has labels of its own for single leaves.
        let label = &tree.node(*node).label;
        let word = match leaves.len() {
            1 => label.clone(),
            _ => format!("{label}_any"),
        };
        found.push(Mode {
            id: format!("{word}_failed"),
            word,
            leaves,
            group: group.cloned(),
        });
    }
    found
}

/// The times of which the recordings show whether they sufficed.
fn late_modes(tree: &BehaviourTree, model: &PrismModel, attributed: &Attributed) -> Vec<Mode> {
    let drawn = |group: &&Group| {
        let mut constants = model.constants.iter();
        constants.any(|it| it.draw == Draw::Deadline && it.node == group.nodes[0])
    };
    let shown = |group: &&Group| group.total().ended() > 0;
    let groups = attributed.deadlines.iter().filter(drawn).filter(shown);
    let mode = |group: &Group| {
        let word = tree.node(group.nodes[0]).label.clone();
        Mode {
            id: format!("{word}_late"),
            word,
            leaves: group.nodes.clone(),
            group: Some(group.clone()),
        }
    };
    groups.map(mode).collect()
}

/// The value of a constant: the share of successes among the executions, or a guess.
fn value(tree: &BehaviourTree, constant: &Constant, mode: Option<&Mode>) -> f64 {
    let node = tree.node(constant.node);
    let counts = mode.and_then(|mode| mode.group.as_ref()).map(Group::total);
    match (constant.draw, counts) {
        (Draw::Leaf | Draw::Deadline, Some(counts)) => {
            let rate = counts.succeeded as f64 / counts.ended() as f64;
            (rate * 1e6).round() / 1e6
        }
        (Draw::Leaf, None) if node.kind != Kind::Leaf(Leaf::Condition) => 0.9,
        (Draw::Deadline, _) => 0.95,
        _ => 0.5,
    }
}

/// A note of the tree as one line.
fn said(note: &Problem) -> String {
    let line = note.place().map_or(0, |place| place.line);
    let file = note.place().map_or("", |place| place.name.as_str());
    let remedy = note.what_to_do().unwrap_or_default();
    format!(
        "{}, line {line}: {}; {remedy}",
        file_name(Path::new(file)),
        comment(note.message())
    )
}

/// Counts by the constant that they belong to, for a comment.
type Comments = BTreeMap<String, String>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_are_told_from_other_xml() {
        let folder = tempfile::tempdir().expect("a folder");
        let is = |text: &str| {
            let path = folder.path().join("a.xml");
            std::fs::write(&path, text).expect("written");
            is_tree(&path)
        };
        assert!(is(
            "<?xml version=\"1.0\"?>\n<!-- <a> -->\n<root BTCPP_format=\"4\"/>"
        ));
        assert!(is("<root><BehaviorTree/></root>"));
        assert!(!is("<mujoco><root BTCPP_format=\"4\"/></mujoco>"));
        assert!(!is("<root/>"));
        assert!(!is_tree(&folder.path().join("none.xml")));
    }
}
