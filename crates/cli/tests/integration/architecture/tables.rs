//! What the architecture allows, as data.

/// Every crate, its floor, and which of our crates it may use.
pub const CRATES: [(&str, u8, &[&str]); 32] = [
    ("diagnostic", 0, &[]),
    ("prism-lang", 0, &[]),
    ("temporal", 0, &[]),
    ("stats", 0, &[]),
    ("trace", 0, &[]),
    ("robot-model", 0, &[]),
    ("stimulus", 0, &[]),
    ("checker", 1, &["prism-lang", "temporal", "stats"]),
    ("certifier", 1, &["prism-lang"]),
    ("fault-tree", 1, &["diagnostic", "stats"]),
    ("behaviour-tree", 1, &["diagnostic"]),
    ("recording", 1, &["trace"]),
    ("requirement-lang", 1, &["temporal", "trace"]),
    (
        "testbench",
        1,
        &["diagnostic", "trace", "robot-model", "stimulus"],
    ),
    ("campaign", 1, &["stats", "stimulus"]),
    ("pack", 1, &["diagnostic"]),
    ("evidence", 2, &["stats"]),
    ("requirement-files", 2, &["diagnostic", "requirement-lang"]),
    ("refinement", 2, &["prism-lang", "stats", "evidence"]),
    ("live", 2, &["trace", "recording"]),
    ("report", 2, &["diagnostic", "evidence"]),
    ("host", 2, &["diagnostic"]),
    (
        "study",
        2,
        &[
            "diagnostic",
            "host",
            "prism-lang",
            "requirement-lang",
            "temporal",
            "stats",
            "stimulus",
            "trace",
            "checker",
            "evidence",
        ],
    ),
    (
        "language-server",
        2,
        &[
            "diagnostic",
            "host",
            "prism-lang",
            "requirement-lang",
            "study",
        ],
    ),
    (
        "judging",
        2,
        &[
            "diagnostic",
            "host",
            "study",
            "prism-lang",
            "requirement-lang",
            "temporal",
            "trace",
            "recording",
            "evidence",
        ],
    ),
    (
        "query",
        2,
        &[
            "diagnostic",
            "host",
            "study",
            "prism-lang",
            "checker",
            "certifier",
        ],
    ),
    ("handover", 2, &["stimulus", "trace", "testbench"]),
    (
        "rig",
        2,
        &[
            "diagnostic",
            "host",
            "study",
            "judging",
            "trace",
            "stimulus",
            "testbench",
            "handover",
            "live",
            "recording",
            "evidence",
        ],
    ),
    (
        "corroborate-bench",
        3,
        &[
            "prism-lang",
            "temporal",
            "stats",
            "trace",
            "checker",
            "requirement-lang",
            "campaign",
            "evidence",
            "refinement",
        ],
    ),
    (
        "corroborate",
        3,
        &[
            "diagnostic",
            "host",
            "study",
            "judging",
            "query",
            "rig",
            "handover",
            "prism-lang",
            "temporal",
            "stats",
            "trace",
            "stimulus",
            "checker",
            "recording",
            "robot-model",
            "pack",
            "live",
            "requirement-lang",
            "requirement-files",
            "testbench",
            "campaign",
            "fault-tree",
            "behaviour-tree",
            "evidence",
            "refinement",
        ],
    ),
    (
        "cli",
        4,
        &[
            "corroborate",
            "diagnostic",
            "host",
            "study",
            "judging",
            "language-server",
            "query",
            "rig",
            "pack",
            "prism-lang",
            "temporal",
            "stats",
            "trace",
            "stimulus",
            "checker",
            "recording",
            "requirement-lang",
            "testbench",
            "campaign",
            "evidence",
            "refinement",
            "robot-model",
            "report",
        ],
    ),
    (
        "python",
        4,
        &[
            "corroborate",
            "diagnostic",
            "host",
            "study",
            "judging",
            "query",
            "prism-lang",
            "temporal",
            "stats",
            "trace",
            "checker",
            "evidence",
            "report",
            "cli",
        ],
    ),
];

/// Things of the outside world, each with the one crate that may name it.
pub const OUTSIDE: [(&str, &str); 22] = [
    ("lsp-server", "language-server"),
    ("ls-types", "language-server"),
    ("ed25519-dalek", "pack"),
    ("base64", "pack"),
    ("getrandom", "cli"),
    ("libloading", "testbench"),
    ("rapier3d-f64", "testbench"),
    ("mcap", "recording"),
    ("zip", "requirement-files"),
    ("rustdds", "live"),
    ("tungstenite", "live"),
    ("clap", "cli"),
    ("clap_complete", "cli"),
    ("clap_mangen", "cli"),
    ("annotate-snippets", "cli"),
    ("indicatif", "cli"),
    ("ctrlc", "cli"),
    ("maud", "report"),
    ("unicode-width", "report"),
    ("pyo3", "python"),
    ("numpy", "python"),
    ("pythonize", "python"),
];

/// What the product code of floors 0 and 1 does without: printing, clocks, the environment, global state.
pub const ABSENT_BELOW_FLOOR_2: [&str; 14] = [
    "println!",
    "print!",
    "eprintln!",
    "eprint!",
    "dbg!",
    "std::env",
    "std::process",
    "SystemTime",
    "Instant",
    "static mut",
    // Cells that only one thread may use cannot be in a `static`.
    "OnceLock",
    "LazyLock",
    "thread_local!",
    "std::net",
];

/// Worlds that stand on an engine, so on floor 2, and do without the same, since the same seed gives the same bits there, too.
pub const AS_PURE_AS_ENGINES: [&str; 2] = ["handover", "requirement-files"];

/// The crates that may name the file system.
pub const MAY_USE_FILES: [&str; 9] = [
    "trace",
    "recording",
    "host",
    "study",
    "language-server",
    "judging",
    "rig",
    "corroborate",
    "cli",
];

/// What no library does: end the process, read its environment, change its pool of threads, its signals or its allocator, ask
/// what runs.
pub const ABSENT_IN_LIBRARIES: [&str; 8] = [
    "process::exit",
    "std::env",
    "build_global",
    "current_exe",
    "set_handler",
    "mallopt",
    "temp_dir",
    "println!",
];

/// What only some systems have.
pub const SYSTEMS: [&str; 7] = [
    "os::unix",
    "os::linux",
    "os::windows",
    "rustix::",
    "libc::",
    "windows::Win32",
    "process_wrap::",
];

/// The files that may name it, each of which says what is done on the other systems.
pub const MAY_NAME_A_SYSTEM: [&str; 8] = [
    "crates/cli/src/command/pack/pdf.rs",
    "crates/cli/src/memory/allocator.rs",
    "crates/host/src/system.rs",
    "crates/live/src/foxglove/socket.rs",
    "crates/rig/src/consent/owner.rs",
    "crates/rig/src/group/unix.rs",
    "crates/rig/src/group/windows.rs",
    "crates/rig/src/processor.rs",
];

/// The programs: everything else is a library.
pub const PROGRAMS: [&str; 2] = ["cli", "corroborate-bench"];

/// The modules in which `unsafe` may stand, with everything below them.
pub const MAY_BE_UNSAFE: [&str; 3] = [
    "crates/testbench/src/mujoco",
    "crates/cli/src/memory/allocator.rs",
    "crates/python/src/table/arrow.rs",
];

/// Where programs are started: those that a study names, or the user, in one place, which asks for consent; the others name
/// theirs themselves.
pub const START_PROGRAMS: [&str; 4] = [
    "crates/rig/src/start.rs",
    "crates/rig/src/surroundings.rs",
    "crates/cli/src/command/pack/pdf.rs",
    "crates/corroborate-bench/src/grammar/judge.rs",
];

/// Who takes for the user's what no study names: tests that are typed.
pub const TAKE_AS_TYPED: [&str; 1] = ["crates/rig/src/trial.rs"];

/// Where files are opened by paths that a study, or what was kept of it, may name: what is read in these crates goes through
/// `host::files`, which opens no pipe or device, but for these places, which read what the engine itself has written into a
/// folder that [`host::Reach::check_written`] has looked through, or what the system or the user names.
pub const OPEN_BY_THEMSELVES: [&str; 28] = [
    "crates/corroborate/src/init/",
    "crates/corroborate/src/inspect/description.rs",
    "crates/corroborate/src/kept.rs",
    "crates/corroborate/src/pack.rs",
    "crates/corroborate/src/pack/verification.rs",
    "crates/corroborate/src/plan.rs",
    "crates/corroborate/src/refine/command.rs",
    "crates/corroborate/src/replay/episode.rs",
    "crates/corroborate/src/simulate/mod.rs",
    "crates/corroborate/src/technique/campaign/",
    "crates/corroborate/src/technique/experiment/placed.rs",
    "crates/corroborate/src/technique/exploration/episode.rs",
    "crates/corroborate/src/technique/exploration/journal.rs",
    "crates/corroborate/src/technique/matrix/",
    "crates/corroborate/src/technique/model_checking/worst_case.rs",
    "crates/corroborate/src/technique/operation.rs",
    "crates/corroborate/src/verify",
    "crates/corroborate/src/watch/keeper.rs",
    "crates/corroborate/src/technique/copies/constants.rs",
    "crates/corroborate/src/decide/",
    "crates/host/src/files.rs",
    "crates/host/src/store.rs",
    "crates/judging/src/recording.rs",
    "crates/rig/src/command/once.rs",
    "crates/rig/src/processor.rs",
    "crates/study/src/looks.rs",
    "crates/corroborate/src/technique/same_messages.rs",
    "crates/corroborate/src/ros2_table.rs",
];

/// What has to be matched in full: who adds a variant is told by the compiler where it matters.
pub const MATCHED_IN_FULL: [&str; 8] = [
    "Technique",
    "Work",
    "Simulated",
    "Guarantee",
    "WitnessOf",
    "AskedBy",
    "Rerun",
    "Mark",
];

/// Where kinds of work are told apart: where they are read, what they have, and which technique does them.
pub const TELL_WORK_APART: [&str; 2] = [
    "crates/study/src/ledger",
    "crates/corroborate/src/technique/kinds.rs",
];

/// Where techniques are told apart or named: their table, the ledger that names them, the synthetic studies that have
/// evidence of each, and the legend of a plot, which shows one mark hollow.
pub const TELL_TECHNIQUES_APART: [&str; 5] = [
    "crates/evidence/src/technique.rs",
    "crates/study/src/ledger",
    "crates/corroborate-bench/src/matrix.rs",
    "crates/corroborate-bench/src/study.rs",
    "crates/report/src/section/forest.rs",
];
