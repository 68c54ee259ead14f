//! PRISM's command line, understood by `check`.
//!
//! Flags that have the same meaning here are rewritten to ours. Those that choose a numerical method that is here, too,
//! choose it, unless another flag asks for exact or interval arithmetic. Flags that choose among PRISM's engines and data
//! structures change no answer: they are noted and have no effect. Flags that would change an answer and that we do not have
//! are errors, each with its reason (module `refused`), and so are words behind one dash that nobody knows, which are named
//! as a whole.

use super::refused;
use std::ffi::OsString;

/// Flags with the same meaning, and ours.
const SAME: [(&str, &[&str]); 44] = [
    ("-sumroundoff", &["--sum-roundoff"]),
    ("-const", &["--const"]),
    ("-param", &["--param"]),
    ("-pf", &["--pf"]),
    ("-pctl", &["--pf"]),
    ("-csl", &["--pf"]),
    ("-prop", &["--prop"]),
    ("-property", &["--prop"]),
    ("-epsilon", &["--epsilon"]),
    ("-e", &["--epsilon"]),
    ("-maxiters", &["--maxiters"]),
    ("-exact", &["--method", "exact"]),
    ("--exact", &["--method", "exact"]),
    ("-relative", &["--termination", "relative"]),
    ("-rel", &["--termination", "relative"]),
    ("-absolute", &["--termination", "absolute"]),
    ("-abs", &["--termination", "absolute"]),
    ("-fair", &["--fair"]),
    ("-dtmc", &["--type", "dtmc"]),
    ("-ctmc", &["--type", "ctmc"]),
    ("-mdp", &["--type", "mdp"]),
    ("-exportresults", &["--export-results"]),
    ("-exportmodel", &["--export-model"]),
    ("-exporttrans", &["--export-model"]),
    ("-exportstates", &["--export-model"]),
    ("-exportlabels", &["--export-labels"]),
    ("-exportstaterewards", &["--export-model"]),
    ("-exporttransrewards", &["--export-model"]),
    ("-exportdot", &["--export-model"]),
    ("-exporttransdot", &["--export-model"]),
    ("-exporttransdotstates", &["--export-model"]),
    ("-exportstrat", &["--export-strategy"]),
    ("-exportadv", &["--export-strategy"]),
    ("-exportadvmdp", &["--export-strategy"]),
    ("-steadystate", &["--steady-state"]),
    ("-ss", &["--steady-state"]),
    ("-transient", &["--transient"]),
    ("-tr", &["--transient"]),
    ("-exportsteadystate", &["--export-steady-state"]),
    ("-exportss", &["--export-steady-state"]),
    ("-exporttransient", &["--export-transient"]),
    ("-exporttr", &["--export-transient"]),
    ("-importinitdist", &["--import-initial"]),
    ("-timeout", &["--timeout"]),
];

/// Flags that choose a numerical method, and ours.
const METHODS: [(&str, &str); 10] = [
    ("-valiter", "value-iteration"),
    ("-power", "value-iteration"),
    ("-pow", "value-iteration"),
    ("-pwr", "value-iteration"),
    ("-gaussseidel", "gauss-seidel"),
    ("-gs", "gauss-seidel"),
    ("-jacobi", "jacobi"),
    ("-jac", "jacobi"),
    ("-politer", "policy-iteration"),
    ("-modpoliter", "modified-policy-iteration"),
];

/// Flags that ask for answers without estimates, whatever numerical method is chosen besides.
const WITH_GUARANTEE: [&str; 5] = ["-exact", "--exact", "-param", "-intervaliter", "-ii"];

/// Flags that read a part of a model, and its form.
const IMPORTS: [(&str, &str); 4] = [
    ("-importstates", "sta"),
    ("-importlabels", "lab"),
    ("-importstaterewards", "srew"),
    ("-importtransrewards", "trew"),
];

/// Flags without a value that change no answer.
const WITHOUT_EFFECT: [&str; 66] = [
    "-mtbdd",
    "-m",
    "-sparse",
    "-s",
    "-hybrid",
    "-h",
    "-explicit",
    "-ex",
    "-bgaussseidel",
    "-bgs",
    "-pgaussseidel",
    "-pgs",
    "-bpgaussseidel",
    "-bpgs",
    "-jor",
    "-sor",
    "-bsor",
    "-psor",
    "-bpsor",
    "-linprog",
    "-lp",
    "-intervaliter",
    "-ii",
    "-topological",
    "-nopre",
    "-noprob0",
    "-noprob1",
    "-nofair",
    "-fixdl",
    "-nossdetect",
    "-noprobchecks",
    "-nocompact",
    "-pathviaautomata",
    "-verbose",
    "-v",
    "-extraddinfo",
    "-extrareachinfo",
    "-test",
    "-testall",
    "-sim",
    "-bfs",
    "-frontier",
    "-bisim",
    "-nobscc",
    "-noprerel",
    "-nodasimplify",
    "-o1",
    "-o2",
    "-c1",
    "-c2",
    "-c3",
    "-dddebug",
    "-ddtraceall",
    "-ddtracefollowcopies",
    "-dddebugwarnfatal",
    "-dddebugwarnoff",
    "-ddsanity",
    "-explicitbuild",
    "-pmaxquotient",
    "-exportordered",
    "-ordered",
    "-zerorewardcheck",
    "-unordered",
    "-exportunordered",
    "-explicitbuildtest",
    "-ng",
];

/// Flags with a value that change no answer.
const VALUE_WITHOUT_EFFECT: [&str; 55] = [
    "-transientmethod",
    "-paretoepsilon",
    "-multimaxpoints",
    "-cuddepsilon",
    "-cuddmaxmem",
    "-javamaxmem",
    "-javastack",
    "-omega",
    "-sbmax",
    "-sbl",
    "-gsmax",
    "-gsl",
    "-partitions",
    "-heuristic",
    "-ltl2dasyntax",
    "-simmethod",
    "-simsamples",
    "-simconf",
    "-simwidth",
    "-simapprox",
    "-simpathlen",
    "-simmanual",
    "-exportmodelprecision",
    "-exportvector",
    "-exporttarget",
    "-exportproplabels",
    "-exportprodtrans",
    "-exportprodstates",
    "-sccmethod",
    "-bsccmethod",
    "-ddextraactionvars",
    "-ddextrastatevars",
    "-gridresolution",
    "-ltl2datool",
    "-javaparams",
    "-parambisim",
    "-paramelimorder",
    "-paramfunction",
    "-paramprecision",
    "-paramrandompoints",
    "-paramsplit",
    "-paramsubsumeregions",
    "-paramdagmaxerror",
    "-fauepsilon",
    "-faudelta",
    "-fauarraythreshold",
    "-fauintervals",
    "-fauinitival",
    "-aroptions",
    "-ptamethod",
    "-simvar",
    "-simmaxrwd",
    "-sorl",
    "-sormax",
    "-ddtrace",
];

/// Two numbers follow it; it changes no answer, states that stand for each other being found without it.
const SYMMETRY: &str = "-symm";

/// Rewrites the flags of a `check`; other commands are left as they are.
pub fn with_peers_spelling(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let all: Vec<OsString> = arguments.collect();
    let command = (1..all.len()).find(|at| !is_flag(&all[*at]));
    let Some(start) = command.filter(|at| all[*at] == "check") else {
        return all;
    };
    let guaranteed = |argument: &OsString| WITH_GUARANTEE.iter().any(|flag| argument == flag);
    let may_estimate = !all[start + 1..].iter().any(guaranteed);
    let mut given = all[start + 1..].iter();
    let mut rewritten = all[..=start].to_vec();
    let mut has_model = false;
    while let Some(argument) = given.next() {
        let text = argument.to_str().unwrap_or_default();
        let import = IMPORTS.iter().find(|(theirs, _)| *theirs == text);
        let is_model = matches!(text, "-importmodel" | "-importtrans");
        if is_model || import.is_some() {
            let Some(file) = given.next() else {
                rewritten.push(argument.clone());
                continue;
            };
            let part = |form: &str| format!("--import={form}={}", file.to_string_lossy());
            if is_model {
                // The model is the first argument that is no flag, wherever the flag stands.
                rewritten.insert(start + 1, file.clone());
                has_model = true;
            }
            if text == "-importtrans" {
                rewritten.push(OsString::from(part("tra")));
            }
            rewritten.extend(import.map(|(_, form)| OsString::from(part(form))));
            continue;
        }
        if let Some((_, ours)) = SAME.iter().find(|(theirs, _)| *theirs == text) {
            rewritten.extend(ours.iter().map(OsString::from));
            if let [flag] = ours
                && !["--fair", "--steady-state"].contains(flag)
                && let Some(value) = given.next()
            {
                rewritten.push(value.clone());
                let is_export = flag.starts_with("--export-") && text != "-exportmodel";
                if is_export && let Some(kind) = kind_of_export(text) {
                    let last = rewritten.len() - 1;
                    rewritten[last] = OsString::from(format!("{kind}={}", value.to_string_lossy()));
                }
            }
            continue;
        }
        if text == "-exportrewards" {
            for form in ["srew", "trew"] {
                let file = given.next().map(|file| file.to_string_lossy());
                rewritten.push(OsString::from("--export-model"));
                rewritten.extend(file.map(|file| OsString::from(format!("{form}={file}"))));
            }
            continue;
        }
        let method = METHODS.iter().find(|(theirs, _)| *theirs == text);
        if let Some((_, ours)) = method.filter(|_| may_estimate) {
            rewritten.push(OsString::from(format!("--method={ours}")));
            continue;
        }
        // `check -h` alone asks for help.
        let without =
            method.is_some() || WITHOUT_EFFECT.contains(&text) && (text != "-h" || has_model);
        if without || VALUE_WITHOUT_EFFECT.contains(&text) || text == SYMMETRY {
            rewritten.push(OsString::from(format!("--without-effect={text}")));
            let values = match text {
                _ if without => 0,
                SYMMETRY => 2,
                _ => 1,
            };
            given.by_ref().take(values).for_each(|_| {});
            continue;
        }
        let values = refused::values(text).or_else(|| is_word_of_peers(text).then_some(0));
        if let Some(values) = values {
            rewritten.push(OsString::from(format!("--refused={text}")));
            given.by_ref().take(values).for_each(|_| {});
            continue;
        }
        has_model |= !is_flag(argument);
        rewritten.push(argument.clone());
    }
    rewritten
}

/// The form that a flag for one form asks for, whatever the file's name.
fn kind_of_export(flag: &str) -> Option<&'static str> {
    match flag {
        "-exporttrans" => Some("tra"),
        "-exportstates" => Some("sta"),
        "-exportstaterewards" => Some("srew"),
        "-exporttransrewards" => Some("trew"),
        "-exportdot" | "-exporttransdotstates" => Some("dot"),
        "-exporttransdot" => Some("dot-plain"),
        _ => None,
    }
}

/// Whether it is a word behind one dash, and so no row of flags of one letter; `-cN=3` gives a constant.
fn is_word_of_peers(text: &str) -> bool {
    let word = text.strip_prefix('-').filter(|word| word.len() > 2);
    word.is_some_and(|word| !word.starts_with('c') && word.chars().all(char::is_alphabetic))
}

fn is_flag(argument: &OsString) -> bool {
    argument.to_str().is_some_and(|text| text.starts_with('-'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rewritten(words: &[&str]) -> Vec<String> {
        let words = ["corroborate"].iter().chain(words).map(OsString::from);
        let found = with_peers_spelling(words);
        found[1..]
            .iter()
            .map(|w| w.to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn flags_with_the_same_meaning_are_ours() {
        let found = rewritten(&[
            "check",
            "m.pm",
            "-pf",
            "P=? [ F x=1 ]",
            "-const",
            "N=3",
            "-exact",
        ]);
        let ours = [
            "check",
            "m.pm",
            "--pf",
            "P=? [ F x=1 ]",
            "--const",
            "N=3",
            "--method",
            "exact",
        ];
        assert_eq!(found, ours);
        let found = rewritten(&["check", "m.pm", "-exporttrans", "a.txt"]);
        assert_eq!(found, ["check", "m.pm", "--export-model", "tra=a.txt"]);
        let found = rewritten(&["check", "m.pm", "-exportrewards", "s", "t", "p.props"]);
        let (own, each) = ("--export-model", ["srew=s", "trew=t"]);
        assert_eq!(
            found,
            ["check", "m.pm", own, each[0], own, each[1], "p.props"]
        );
        let found = rewritten(&["check", "m.pm", "-ss", "-tr", "0:5", "-exporttr", "stdout"]);
        let ours = [
            "--steady-state",
            "--transient",
            "0:5",
            "--export-transient",
            "stdout",
        ];
        assert_eq!(found[2..], ours);
        let found = rewritten(&["check", "m.pm", "-sumroundoff", "1e-5"]);
        assert_eq!(found[2..], ["--sum-roundoff", "1e-5"]);
        let found = rewritten(&["check", "m.pm", "-exportstaterewards", "s"]);
        assert_eq!(found, ["check", "m.pm", "--export-model", "srew=s"]);
    }

    #[test]
    fn numerical_methods_are_chosen_unless_a_guarantee_is_asked_for() {
        let found = rewritten(&["check", "m.pm", "-gs", "-politer", "-absolute"]);
        let ours = [
            "check",
            "m.pm",
            "--method=gauss-seidel",
            "--method=policy-iteration",
            "--termination",
            "absolute",
        ];
        assert_eq!(found, ours);
        let found = rewritten(&["check", "m.pm", "-jac", "-ii"]);
        let ours = [
            "check",
            "m.pm",
            "--without-effect=-jac",
            "--without-effect=-ii",
        ];
        assert_eq!(found, ours);
    }

    #[test]
    fn the_files_of_a_model_are_the_model() {
        let found = rewritten(&["check", "p.props", "-importmodel", "m.all"]);
        assert_eq!(found, ["check", "m.all", "p.props"]);
        let found = rewritten(&[
            "check",
            "-importtrans",
            "m.txt",
            "-importlabels",
            "l",
            "-mdp",
        ]);
        let ours = [
            "check",
            "m.txt",
            "--import=tra=m.txt",
            "--import=lab=l",
            "--type",
            "mdp",
        ];
        assert_eq!(found, ours);
    }

    #[test]
    fn flags_without_effect_are_noted_with_their_values() {
        let found = rewritten(&["check", "m.pm", "-h", "-transientmethod", "fau", "p.props"]);
        let ours = [
            "check",
            "m.pm",
            "--without-effect=-h",
            "--without-effect=-transientmethod",
            "p.props",
        ];
        assert_eq!(found, ours);
        assert_eq!(rewritten(&["check", "-h"]), ["check", "-h"]);
        assert_eq!(rewritten(&["run", "s", "-h"]), ["run", "s", "-h"]);
        let found = rewritten(&["check", "m.pm", "-symm", "1", "2", "p.props"]);
        assert_eq!(found[2..], ["--without-effect=-symm", "p.props"]);
        // What would change an answer is not swallowed, and a word is not taken for letters.
        let found = rewritten(&["check", "m.pm", "-nofixdl", "-simpath", "9", "stdout"]);
        assert_eq!(found[2..], ["--refused=-nofixdl", "--refused=-simpath"]);
        let found = rewritten(&["check", "m.pm", "-vesion", "-cN=3", "-c", "p=1"]);
        assert_eq!(found[2..], ["--refused=-vesion", "-cN=3", "-c", "p=1"]);
    }
}
