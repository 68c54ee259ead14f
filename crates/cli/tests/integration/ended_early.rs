//! `check` that has to end before all is answered: by Ctrl-C, or by its limit of memory.
#![cfg(target_os = "linux")]

use crate::support;

use serde_json::Value;
use std::path::Path;
use std::process::{Child, Stdio};
use support::program::{Said, command, corroborate};
use support::schema::violations;
use support::{read, root};
use tempfile::TempDir;

/// A walk on a long line, where each step may be a lazy one: what is earned in the long run differs little between
/// neighbours, so that value iteration takes for ever; what can be reached is clear at once.
const WALK: &str = "mdp
const int N;
module walk
  x : [0..N];
  [] x<N -> 1/2:(x'=x+1) + 1/2:(x'=max(x-1,0));
  [] x<N -> 1/4:(x'=x+1) + 1/4:(x'=max(x-1,0)) + 1/2:true;
  [] x=N -> (x'=N-1);
endmodule
rewards \"far\" true : 1; x>=N/2 : 1; endrewards
";

const PROPERTIES: &str = "\"near\": Pmax=? [ F<=2 x=2 ];
\"long\": R{\"far\"}max=? [ S ];
\"after\": Pmin=? [ F x=1 ];
";

fn folder() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("walk.prism"), WALK).expect("written");
    std::fs::write(folder.path().join("walk.props"), PROPERTIES).expect("written");
    folder
}

fn begin(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Hundredths of a second that a process has computed.
fn computed(child: &Child) -> u64 {
    let stat = read(Path::new(&format!("/proc/{}/stat", child.id())));
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or("").split(' ').collect();
    let number = |place: usize| fields[place].parse::<u64>().expect("a number");
    number(11) + number(12)
}

/// Lets a process compute for some hundredths of a second more, and interrupts it.
fn interrupt_after(mut child: Child, more: u64) -> Said {
    let begun = computed(&child);
    while computed(&child) < begun + more {
        assert!(
            child.try_wait().expect("a state").is_none(),
            "it ended too early"
        );
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let signalled = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signalled.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    Said {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).expect("it prints text"),
        talk: String::from_utf8(output.stderr).expect("it says text"),
    }
}

fn report(said: &Said) -> Value {
    let schema = read(&root().join("schemas/check.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    let report =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    assert_eq!(violations(&schema, &report), Vec::<String>::new());
    report
}

#[test]
fn ctrl_c_gives_the_bounds_reached_so_far() {
    let folder = folder();
    // Once the model is written, what can be reached is answered in no time.
    let arguments = [
        "check",
        "walk.prism",
        "walk.props",
        "-const",
        "N=20000",
        "--export-model",
        "model.tra",
        "--format",
        "json",
    ];
    let child = begin(folder.path(), &arguments);
    while !folder.path().join("model.tra").exists() {
        std::thread::yield_now();
    }
    let said = interrupt_after(child, 20);
    assert_eq!(said.code, 130, "{said:?}");
    let report = report(&said);
    let [near, long, after] = &report["properties"].as_array().expect("a list")[..] else {
        panic!("{report}");
    };
    assert_eq!(
        (near["result"].as_str(), near["unfinished"].as_str()),
        (Some("0.25"), None)
    );
    assert_eq!(long["unfinished"], "stopped", "{long}");
    assert!(long["result"].is_null() && long["guarantee"] == "bounded");
    let (low, high) = (long["low"].as_f64(), long["high"].as_f64());
    let (Some(low), Some(high)) = (low, high) else {
        panic!("{long}");
    };
    // At least 1 is earned in each step and at most 2; the bounds allow for rounding.
    assert!(0.999 < low && low < high && high < 2.001, "{low} {high}");
    assert_eq!(after["unfinished"], "not begun");
    assert_eq!(report["interrupted"], "interrupted");
}

#[test]
fn ctrl_c_while_exploring_says_how_far_it_came() {
    let folder = folder();
    let arguments = [
        "check",
        "walk.prism",
        "walk.props",
        "-const",
        "N=2000000000",
    ];
    let said = interrupt_after(begin(folder.path(), &arguments), 20);
    assert_eq!(said.code, 130, "{said:?}");
    let found = said.out.split("explored (").nth(1);
    let found = found.and_then(|rest| rest.split(' ').next());
    let found: u64 = found
        .and_then(|n| n.parse().ok())
        .unwrap_or_else(|| panic!("{said:?}"));
    assert!(found > 0);
    assert_eq!(said.out.matches("not begun").count(), 3, "{}", said.out);
}

#[test]
fn a_limit_of_memory_or_time_ends_every_kind_of_work_with_a_message() {
    let folder = folder();
    let coin =
        "dtmc const double p; module coin s:[0..9]; [] s<9 -> p:(s'=s+1) + 1-p:(s'=0); endmodule";
    std::fs::write(folder.path().join("coin.prism"), coin).expect("written");
    for more in [
        &["-const", "p=0.5"][..],
        &["-const", "p=0.5", "--method", "exact"],
        &["-const", "p=0.5", "--certify"],
        &["--param", "p=0:1"],
    ] {
        for (limit, value) in [("--memory-limit", "0.000001"), ("--timeout", "0.000001")] {
            let mut arguments = vec!["check", "coin.prism", "P=? [ F<=20 s=9 ]"];
            arguments.extend([limit, value]);
            arguments.extend(more);
            let said = corroborate(folder.path(), &arguments);
            assert_eq!(said.code, 3, "{said:?}");
            let remedy = said.talk.split("= help: ").nth(1).unwrap_or_default();
            assert!(remedy.contains(limit), "{said:?}");
        }
    }
    // A limit of states is one for who asks for it.
    let arguments = ["check", "coin.prism", "P=? [ F s=9 ]", "-const", "p=0.5"];
    let said = corroborate(
        folder.path(),
        &[&arguments[..], &["--max-states", "9"]].concat(),
    );
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("--max-states"), "{said:?}");
}
