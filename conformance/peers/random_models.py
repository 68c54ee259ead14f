"""Random models and properties of every kind, answered by Storm in exact arithmetic and by the program in four ways.

    random_models.py [--models 60] [--seed 1] [--keep FOLDER] [--log FILE]

Models of the types dtmc, ctmc and mdp (random_texts.py): one to four modules, synchronised and other commands, overlapping
guards, renamed modules, compositions by `system`, a global and a boolean variable, formulas, several starts, state and transition
rewards, negative ones too.
Our exact answer must be Storm's, our bounds must contain it, what is certified must hold; functions of two constants must have
Storm's value at a random point. What Storm has no exact answer to is held against linear algebra on its states
(random_oracles.py); its optima of several objectives are approximate, and compared as such. The counts at the end are kind by
kind. Models with a disagreement are kept in FOLDER. With FILE each seed's counts are a line of it, and seeds that have one are
not run again.
"""

import argparse
import collections
import json
import random
import re
import subprocess
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

from random_oracles import INFINITE, Near, Oracle, Span, number
from random_texts import OPEN, Model, Questions
from stormpy.developer import LogLevel, set_log_level

ROOT = Path(__file__).resolve().parents[2]
QUESTIONS = 6
# What takes longer is counted, and not waited for: functions of two constants can grow without end.
PATIENCE_SECS = 10
# States up to which models are asked about: exact long-run averages of some hundred take Storm minutes.
MOST_STATES = 128
# States up to which functions of the constants are asked for.
MOST_STATES_PARAMETRIC = 16
# Exact values of some models have thousands of digits.
sys.set_int_max_str_digits(0)


def ours(program, path, texts, *options):
    """The answers, or what the program says instead of them; None if it takes too long."""
    command = [str(program), "check", str(path), "--format", "json", *options]
    for text in texts:
        command += ["--pf", text]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_SECS)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode not in (0, 1, 3):
        return done.stderr.strip() or f"ended with {done.returncode}"
    return json.loads(done.stdout)["properties"]


class Comparison:
    """What agreed, what did not, and what could not be asked, of one model.

    Where several objectives cannot be met together, the optimum is no number to us, and Storm says that they cannot.
    """

    def __init__(self, path):
        self.path, self.counts, self.wrong = path, collections.Counter(), []

    def note(self, way, question, good, what):
        self.counts[f"{way}: {'agree' if good else 'DISAGREE'}"] += 1
        self.counts[f"of {question.kind}: {'agree' if good else 'DISAGREE'}"] += 1
        if not good:
            self.wrong.append(f"{way}: {question.ours}: {what}")

    def refused(self, way, answer):
        if answer["error"]:
            self.counts[f"{way}: refused"] += 1
            self.counts[f"  {answer['error'][:90]}"] += 1
        return answer["error"]

    def exact(self, question, answer, value):
        if self.refused("exact", answer):
            return
        result = answer["result"]
        if answer["result"] == "NaN":
            good = question.how == "optimum" and value == "false"
        elif isinstance(value, Span):
            good = [number(end) for end in result.strip("[]").split(",")] == list(value)
        elif isinstance(value, str):
            good = result == value
        elif result in (INFINITE, "true", "false"):
            good = False
        elif isinstance(value, Near):
            good = abs(Fraction(result) - Fraction(value.value)) <= value.error
        else:
            good = Fraction(result) == value
        self.note("exact", question, good, f"expected {value}, ours {result}")

    def sound(self, question, answer, value):
        if self.refused("sound", answer):
            return
        if answer["result"] == "NaN":
            good = question.how == "optimum" and value == "false"
        elif isinstance(value, Span):
            ends = zip(map(number, answer["result"].strip("[]").split(",")), value)
            good = all(own == end or INFINITE not in (own, end) and abs(own - end) <= 1e-6 * abs(end) for own, end in ends)
        elif isinstance(value, str):
            good = answer["result"] == value
        elif answer["result"] == INFINITE or answer["value"] is None:
            good = False
        else:
            low, high = (answer[end] if answer[end] is not None else answer["value"] for end in ("low", "high"))
            near, error = (value.value, value.error) if isinstance(value, Near) else (value, 0)
            good = Fraction(low) - Fraction(error) <= near <= Fraction(high) + Fraction(error)
            good = good or answer["exact"] and abs(Fraction(answer["value"]) - Fraction(near)) < 1e-15 * max(1, abs(near))
            self.counts["sound: wider than 1e-6"] += high - low > 1e-6 * max(abs(high), 1e-300)
        self.note("sound", question, good, f"expected {value}, ours {answer['result']} [{answer['low']}, {answer['high']}]")

    def certified(self, question, answer, value):
        certificate = answer["certificate"]
        if certificate is None:
            return
        if certificate["status"] != "certified":
            self.counts[f"certificate: {certificate['status']}"] += 1
            self.counts[f"  {certificate['why'][:90]}"] += 1
            return
        if isinstance(value, Fraction):
            good = Fraction(certificate["low"]) <= value <= Fraction(certificate["high"])
            self.note("certificate", question, good, f"expected {value}, certified {certificate}")
        else:
            self.counts["certificate: of a truth value or infinity"] += 1

    @staticmethod
    def at(function, point):
        if function in ("true", "false", "NaN") or INFINITE in function:
            return function
        python = re.sub(r"(?<![\w^])(\d+)", r"Fraction(\1)", function.replace("^", "**"))
        return Fraction(eval(python, {"Fraction": Fraction, **point}))

    def parametric(self, question, answer, value, point):
        if self.refused("parametric", answer) or isinstance(value, Near):
            return
        for part in answer["parametric"]["parts"]:
            ends = [(Fraction(r["low"]), Fraction(r["high"])) for r in part["region"]]
            if all(low < x < high for (low, high), x in zip(ends, point.values())):
                found = [self.at(each["function"], point) for each in part["values"]]
                order = lambda value: (value == INFINITE, 0 if value == INFINITE else value)
                if isinstance(value, Span):
                    good = min(found, key=order) == value.low and max(found, key=order) == value.high
                elif value in ("true", "false"):
                    # One truth value for each initial state.
                    good = str(set(found) == {"true"}).lower() == value
                else:
                    good = found[0] == value
                self.note("parametric", question, good, f"expected {value}, ours {part['values']} at {point}")
                return
        self.counts["parametric: undecided at the point"] += 1


def one(program, folder, seed):
    """The comparison of the model with this seed."""
    draw = random.Random(seed)
    kind = draw.choice(["dtmc", "ctmc", "mdp"])
    model = Model(draw, kind)
    path = folder / f"random-{seed}.prism"
    path.write_text(model.text)
    plain = folder / f"random-{seed}-plain.prism"
    plain.write_text(model.plain)
    comparison = Comparison(path)
    point = {name: Fraction(draw.randint(1, 96), 97) for name in OPEN}
    constants = ",".join(f"{name}={value}" for name, value in point.items())
    questions = Questions(draw, kind).several(QUESTIONS, not model.several)
    try:
        oracle = Oracle(plain, constants, model.loses)
    except Exception:  # Storm's errors have no common class.
        comparison.counts["models that Storm does not read"] += 1
        return comparison
    if oracle.model.nr_states > MOST_STATES:
        comparison.counts[f"models of more than {MOST_STATES} states, not asked"] += 1
        return comparison
    asked = []
    for question in questions:
        value = oracle.answer(question)
        if value is None:
            comparison.counts[f"of {question.kind}: no oracle"] += 1
        else:
            asked.append((question, value))
    if not asked:
        return comparison
    comparison.counts[f"{kind}s"] += 1
    ways = [
        (comparison.exact, ["--method", "exact", "--const", constants]),
        (comparison.sound, ["--const", constants]),
        (comparison.certified, ["--certify", "--const", constants]),
        (lambda *a: comparison.parametric(*a, point), ["--param", ",".join(OPEN)]),
    ]
    if oracle.model.nr_states > MOST_STATES_PARAMETRIC:
        ways.pop()
    for judge, options in ways:
        answers = ours(program, path, [question.ours for question, _ in asked], *options)
        if answers is None:
            comparison.counts[f"{options[0]}: more than {PATIENCE_SECS} s"] += 1
            continue
        if isinstance(answers, str):
            # A text that is refused as a whole is looked into: the other answers would be lost with it.
            comparison.wrong.append(f"{' '.join(options)}: {answers.splitlines()[0]}")
            continue
        for (question, value), answer in zip(asked, answers):
            judge(question, answer, value)
    return comparison


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--models", type=int, default=60)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--keep", type=Path)
    arguments.add_argument("--log", type=Path)
    arguments.add_argument("--program", type=Path, default=ROOT / "corroborate")
    given = arguments.parse_args()
    set_log_level(LogLevel.OFF)
    known = {}
    if given.log and given.log.exists():
        for line in given.log.read_text().splitlines():
            kept = json.loads(line)
            known[kept["seed"]] = kept
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(given.seed, given.seed + given.models):
            if seed in known:
                continue
            found = one(given.program, Path(folder), seed)
            known[seed] = {"seed": seed, "counts": dict(found.counts), "wrong": found.wrong}
            for what in found.wrong:
                print(f"{found.path.name}: {what}", flush=True)
            if given.keep and found.wrong:
                given.keep.mkdir(parents=True, exist_ok=True)
                text = "".join(f"// {what}\n" for what in found.wrong)
                (given.keep / found.path.name).write_text(text + found.path.read_text())
            if given.log:
                with given.log.open("a") as log:
                    log.write(json.dumps(known[seed]) + "\n")
    counts = collections.Counter()
    for seed in range(given.seed, given.seed + given.models):
        counts.update(known[seed]["counts"])
    wrong = sum(len(known[seed]["wrong"]) for seed in range(given.seed, given.seed + given.models))
    for name, count in sorted(counts.items()):
        if count:
            print(f"{count:8} {name}")
    ways = ("exact", "sound", "certificate", "parametric")
    agreed = sum(counts[f"{way}: agree"] for way in ways)
    print(f"{given.models} random models: {agreed} answers agree with the oracles' ones, {wrong} do not")
    sys.exit(1 if wrong or not agreed else 0)


if __name__ == "__main__":
    main()
