#!/usr/bin/env python3
"""Run the program beside Storm (exact engine), and its statistics beside scipy; fail where they differ.

Usage: .ci/run peers        (installs the peers into .tools/peers, then calls this)
       compare.py [PROGRAM]  (asked some thousand times; ./corroborate, which sees to its being built each time, takes longer)

For every property of conformance/models that Storm can read, and for the handover's five models, `corroborate check` must
give bounds that contain Storm's exact value. What Storm cannot read is counted and listed, so that it stays visible.
"""

import json
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import scipy.stats
import stormpy

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "corroborate"
# Exact elimination of thirty thousand states takes Storm minutes; our own exact method checks it in the ordinary tests.
TOO_LARGE_FOR_STORM = {"long_chain"}

# Properties that Storm reads otherwise than their definition, with what it answers; the model's file settles them by hand
# (`a U[k,l] b` asks `a` of the states before step k too). A Storm that answers something else is compared again.
STORM_READS_OTHERWISE = {
    ("not_before", 'P=? [ "here" U[2,4] "goal" ]'): 1,
    ("not_before", 'P=? [ "here" U[1,4] "goal" ]'): 1,
}

# Exact values of long chains have thousands of digits.
sys.set_int_max_str_digits(0)

passed, failed, unread, otherwise = 0, 0, [], []


def report(ok, what, detail=""):
    """Counts a comparison and prints it if it failed."""
    global passed, failed
    if ok:
        passed += 1
    else:
        failed += 1
        print(f"DIFFERS {what}: {detail}")


def ours(model, text, constants="", method="sound"):
    """The program's answer to a property of a model, as parsed JSON."""
    command = [str(PROGRAM), "check", str(model), "--format", "json", "--method", method, "--pf", text]
    if constants:
        command += ["--const", constants]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        sys.exit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
    answer = json.loads(done.stdout)["properties"][0]
    if answer["error"] and method == "sound" and "exact method" in answer["error"]:
        return ours(model, text, constants, method="exact")
    return answer


def storms(model, text, constants=""):
    """Storm's exact value in the initial state, or None if it cannot read the model or the property."""
    # Storm has no `=>` within path formulas.
    text = re.sub(r'("\w+") => ', r"!\1 | ", text)
    try:
        program = stormpy.parse_prism_program(str(model), prism_compatibility=True)
        formula = stormpy.parse_property(text, program)
        program, formulas = stormpy.instantiate_constants(program, constants, [formula])
        built = stormpy.build_model[stormpy.Rational](program, formulas)
        result = stormpy.model_checking(built, formulas[0])
    except Exception:  # Storm's errors have no common class.
        return None
    if not hasattr(result, "get_value"):
        return None
    return [Fraction(str(result.get_value(state))) for state in built.initial_states]


def cases(path):
    """Each property of a .props file with the constants for which its results are stated."""
    constants = []
    for line in path.read_text().splitlines():
        noted = re.match(r"// RESULT(?: \(([A-Za-z]\w*=[^)]*)\))?: ", line)
        if noted:
            constants.append(noted.group(1) or "")
        elif line and not line.startswith("//"):
            yield line.rstrip(";"), constants
            constants = []


def compare(model, text, constants=""):
    """One property by both tools."""
    what = f"{model.name} ({constants}) {text}"
    exact = storms(model, text, constants)
    if exact is None:
        unread.append(what)
        return
    if exact == [STORM_READS_OTHERWISE.get((model.stem, text))]:
        otherwise.append(f"{what}: Storm {exact[0]}")
        return
    answer = ours(model, text, constants)
    if answer["error"]:
        report(False, what, answer["error"])
        return
    if answer["exact"] and len(exact) == 1:
        report(Fraction(answer["result"]) == exact[0], what, f"Storm {exact[0]}, ours {answer['result']}")
        return
    if answer["value"] is None:
        found = answer["result"]
        low, high = (float(end) for end in found.strip("[]").split(","))
        near = all(abs(float(a) - b) <= 1e-6 for a, b in ((min(exact), low), (max(exact), high)))
        report(near, what, f"Storm {min(exact)} to {max(exact)}, ours {found}")
        return
    low = answer["value"] if answer["low"] is None else answer["low"]
    high = answer["value"] if answer["high"] is None else answer["high"]
    contained = all(Fraction(low) <= value <= Fraction(high) for value in exact)
    report(contained, what, f"Storm {float(exact[0])!r}, ours {low!r} to {high!r}")


def compare_models():
    for path in sorted((ROOT / "conformance/models").glob("*.props")):
        if path.stem in TOO_LARGE_FOR_STORM:
            continue
        for text, all_constants in cases(path):
            for constants in all_constants:
                if text.startswith("P=?"):
                    compare(path.with_suffix(".prism"), text, constants)


def compare_handover():
    """The handover's models: the probability of success, as the study asks for it."""
    for model in sorted((ROOT / "case-studies/handover/models").glob("*.prism")):
        text = "P=? [ F robotState=handoverSuccessful ]"
        if storms(model, text) is None:
            sys.exit(f"Storm cannot read {model.name} with {text}: correct this script")
        compare(model, text)


def compare_statistics():
    """Intervals and tests of the handover's published counts, recomputed with scipy."""
    result = json.loads((ROOT / "target/ci/handover/study.json").read_text())
    for evidence in result["evidence"]:
        for finding in evidence["findings"]:
            measure = finding["measure"]
            if measure["kind"] != "counts" or measure["effective_trials"] is not None:
                continue
            count, trials = measure["count"], measure["trials"]
            if trials == 0:
                continue
            test = scipy.stats.binomtest(count, trials)
            wanted = test.proportion_ci(result["confidence"], method="wilson")
            found = measure["interval"]
            what = f"interval of {evidence['id']}, {finding['subject']}: {count} of {trials}"
            near = abs(found["low"] - wanted.low) < 1e-9 and abs(found["high"] - wanted.high) < 1e-9
            report(near, what, f"scipy {wanted}, ours {found}")


if __name__ == "__main__":
    compare_models()
    compare_handover()
    if (ROOT / "target/ci/handover/study.json").exists():
        compare_statistics()
    else:
        print("no target/ci/handover/study.json (run the step case_study first): intervals are not compared")
    print(f"{len(unread)} properties that Storm does not read are covered by conformance tests alone:")
    print("\n".join(f"  {what}" for what in unread))
    print(f"{len(otherwise)} properties that Storm reads otherwise than their definition, settled by hand:")
    print("\n".join(f"  {what}" for what in otherwise))
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)
