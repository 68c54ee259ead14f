"""Makes a file of FRET's with one requirement for each form of its semantics.

    python3 crates/requirement-files/tests/peers/fret_forms.py FRET/fret-electron/app/parser/semantics.json > forms.json
    cargo run -p corroborate-requirement-files --example columns -- forms.json

FRET is at https://github.com/NASA-SW-VnV/fret; its formulas are read from its own file and are not part of this repository.
The second call translates each sentence and compares its meaning with FRET's formulas.
"""

import json
import sys

SCOPES = {
    "null": "",
    "in": "in mode m ",
    "notin": "when not in mode m ",
    "onlyIn": "only in mode m ",
    "before": "before m ",
    "after": "after m ",
    "onlyBefore": "only before m ",
    "onlyAfter": "only after m ",
}
CONDITIONS = {"null": "", "regular": "when c ", "holding": "whenever c ", "noTrigger": "whenever c "}
TIMINGS = {
    "null": "",
    "immediately": "immediately",
    "next": "at the next timepoint",
    "eventually": "eventually",
    "always": "always",
    "never": "never",
    "within": "within 3 ticks",
    "for": "for 3 ticks",
    "after": "after 3 ticks",
    "until": "until q",
    "before": "before q",
    "finally": "finally",
}
NAMES = {
    "$scope_mode$": "m",
    "$regular_condition$": "c",
    "$post_condition$": "r",
    "$stop_condition$": "q",
    "$duration$": "3",
}


def named(formula):
    for placeholder, name in NAMES.items():
        formula = formula.replace(placeholder, name)
    return formula


def main(path):
    requirements = []
    for key, forms in json.load(open(path)).items():
        scope, condition, timing, _ = key.split(",")
        formulas = {name: named(forms[name]) for name in ("ftExpanded", "ftInfAUExpanded", "ptExpanded") if forms.get(name)}
        text = f"{SCOPES[scope]}{CONDITIONS[condition]}the robot shall {TIMINGS[timing]} satisfy r"
        requirements.append({"reqid": key.replace(",", "-"), "fulltext": text, "semantics": formulas})
    json.dump(requirements, sys.stdout, indent=1)


if __name__ == "__main__":
    main(sys.argv[1])
