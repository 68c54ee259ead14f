//! PRISM's flags that `check` does not take, each with the reason, so that a script that has them is not left to guess.

/// A flag, how many values follow it, and why it is not taken.
type Refused = (&'static str, usize, &'static str);

const COMPONENTS: &str = "components are not written: write the model (--export-model FILE.drn) and take them from its graph";
const GRAPH: &str =
    "this form is not written: --export-model writes .tra, .sta, .lab, .srew, .trew, .dot and .drn";
const LANGUAGE: &str = "only the PRISM language and explicit files are read";
const DEADLOCKS: &str = "deadlocks always get a self-loop, which is noted: ask for `filter(forall, !\"deadlock\")` to check for them";

/// All of them.
pub const REFUSED: [Refused; 30] = [
    ("-exportsccs", 1, COMPONENTS),
    ("-exportbsccs", 1, COMPONENTS),
    ("-exportmecs", 1, COMPONENTS),
    ("-exportmatlab", 0, GRAPH),
    ("-exportmrmc", 0, GRAPH),
    ("-exportrows", 0, GRAPH),
    ("-exportmodeldotview", 0, GRAPH),
    (
        "-noexportheaders",
        0,
        "files of rewards are written with their headers",
    ),
    (
        "-exportprism",
        1,
        "`corroborate format` lays a model out anew, but modules are not expanded",
    ),
    (
        "-exportprismconst",
        1,
        "give constants by --const: they are not written into the model",
    ),
    ("-exportdigital", 1, "timed automata are not checked yet"),
    (
        "-exportpareto",
        1,
        "the corners of a curve are the answer: write it by -exportresults",
    ),
    ("-exportpropaut", 1, "automata of formulas are not written"),
    (
        "-exportprodvector",
        1,
        "products with automata are not written",
    ),
    (
        "-exportiterations",
        0,
        "iterations are not written: the bounds reached are in --format json",
    ),
    ("-importpepa", 0, LANGUAGE),
    (
        "-importprismpp",
        1,
        "the preprocessor is not read: expand its loops first",
    ),
    (
        "-importobs",
        1,
        "partially observable models are not checked yet",
    ),
    ("-importresults", 1, "answers are computed, not read"),
    (
        "-simpath",
        2,
        "`check` shows no random paths: --witness shows the most probable one",
    ),
    ("-nofixdl", 0, DEADLOCKS),
    ("-noreach", 0, "only what can be reached is explored"),
    (
        "-nobuild",
        0,
        "to parse and check the types only, use `corroborate format --check`",
    ),
    ("-mainlog", 1, "redirect the output instead: `> FILE`"),
    ("-settings", 1, "settings of PRISM are not read: give flags"),
    ("-dir", 1, "give paths, or change the folder before"),
    (
        "-keywords",
        0,
        "the words of the language are in PRISM's manual",
    ),
    ("-javaversion", 0, "there is no Java"),
    ("-version", 0, "use `corroborate --version`"),
    ("-help", 0, "use `corroborate check --help`"),
];

/// How many values follow a flag that is refused, if it is one.
pub fn values(flag: &str) -> Option<usize> {
    let known = REFUSED.iter().find(|(refused, ..)| *refused == flag);
    known.map(|(_, values, _)| *values)
}

/// Why a flag is not taken.
pub fn reason(flag: &str) -> &'static str {
    let known = REFUSED.iter().find(|(refused, ..)| *refused == flag);
    known.map_or(
        "neither PRISM nor this program has it; `corroborate check --help` lists those that there are",
        |(.., why)| *why,
    )
}
