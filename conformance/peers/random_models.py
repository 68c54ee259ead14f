"""Random models and properties of every kind, answered by Storm in exact arithmetic and by the program in three ways.

    random_models.py [--models 40] [--seed 1] [--keep FOLDER]

Models of the types dtmc, ctmc and mdp: one to three modules, synchronised and other commands, overlapping guards, state and
transition rewards. Our exact answer must be Storm's, our bounds must contain it, what is certified must hold; functions of two
constants must have Storm's value at a random point. Models with a disagreement are kept in FOLDER.
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

import stormpy
from stormpy.developer import LogLevel, set_log_level

ROOT = Path(__file__).resolve().parents[2]
INFINITE = "Infinity"


class Model:
    """The text of a random model, with two constants p and q."""

    def __init__(self, draw, kind):
        self.draw, self.kind, self.used = draw, kind, set()
        self.ranges = [draw.randint(1, 3) for _ in range(draw.randint(1, 3))]
        self.actions = draw.sample(["a", "b"], draw.randint(0, 2))
        # In most models everything ends in some states, so that probabilities are not only 0 and 1.
        self.end = f"!({self.equality()} | {self.equality()})" if draw.random() < 0.7 else "true"
        modules = [self.module(number) for number in range(len(self.ranges))]
        self.text = f"{kind}\nconst double p;\nconst double q;\n" + "\n".join(modules) + self.rewards() + self.labels()

    def atom(self):
        number = self.draw.randrange(len(self.ranges))
        operator = self.draw.choice(["=", "!=", "<", ">="])
        return f"x{number}{operator}{self.draw.randint(0, self.ranges[number])}"

    def equality(self):
        number = self.draw.randrange(len(self.ranges))
        return f"x{number}={self.draw.randint(1, self.ranges[number])}"

    def formula(self):
        atoms = [self.atom() for _ in range(self.draw.randint(1, 2))]
        return f"({self.draw.choice([' & ', ' | ']).join(atoms)})"

    def value(self, number):
        top, shift = self.ranges[number], self.draw.randint(0, 2)
        if self.draw.random() < 0.5:
            return str(self.draw.randint(0, top))
        return f"mod(x{number}+{shift},{top + 1})"

    def weights(self):
        if self.kind == "ctmc":
            return [self.draw.choice(["1", "2.5", "1/3", "4*p", "1+q"]) for _ in range(self.draw.randint(1, 3))]
        return self.draw.choice([["1"], ["0.5", "0.5"], ["1/3", "2/3"], ["0.2", "0.3", "0.5"], ["p", "1-p"],
                                 ["q/2", "1-q/2"], ["p*q", "(1-p)*q", "1-q"], ["1e-6", "1-1e-6"]])

    def module(self, number):
        commands = []
        for _ in range(self.draw.randint(1, 4)):
            action = self.draw.choice(["", *self.actions]) if commands else ""
            self.used.update(action)
            updates = [f"{weight}:(x{number}'={self.value(number)})" for weight in self.weights()]
            guard = f"{self.formula()} & {self.end}" if commands else self.end
            commands.append(f"  [{action}] {guard} -> {' + '.join(updates)};")
        start = 0
        if number == 0 and self.end != "true":
            # Without deadlocks: Storm leaves out their state's rewards (conformance/models/deadlock_rewards.props).
            commands.append(f"  [] !({self.end}) -> 1:true;")
        body = "\n".join(commands)
        return f"module m{number}\n  x{number} : [0..{self.ranges[number]}] init {start};\n{body}\nendmodule\n"

    def rewards(self):
        items = [f"  {self.formula()} : {self.draw.choice(['1', '2', '0.5', '1/3'])};"]
        if self.draw.random() < 0.5:
            action = self.draw.choice(["", *sorted(self.used)])
            items.append(f"  [{action}] {self.formula()} : {self.draw.choice(['1', '3'])};")
        return '\nrewards "r"\n' + "\n".join(items) + "\nendrewards\n"

    def labels(self):
        one, two = self.equality(), self.draw.choice([self.equality(), self.formula()])
        return f'label "one" = {one};\nlabel "two" = {two};\n'


def properties(draw, kind):
    """Pairs: in the program's syntax, in Storm's."""
    optimum = draw.choice(["min", "max"]) if kind == "mdp" else ""
    steps = draw.randint(0, 6)
    paths = ['F "one"', '"one" U "two"', '!"two" U "one"', 'G "one"', 'X "two"', 'G F "one"', 'F G "two"',
             '(F "one") & (F "two")', '(G "one") | (F "two")', '"one" U (X "two")', 'F ("one" & (X "two"))']
    if kind != "ctmc":
        paths += [f'F<={steps} "one"', f'"one" U<={steps} "two"']
    chosen = [(f"P{optimum}=? [ {path} ]",) * 2 for path in draw.sample(paths, 3)]
    rewards = [('F "one"', 'F "one"')]
    if kind != "ctmc":
        rewards += [(f"C<={steps}",) * 2, (f"I={steps}",) * 2]
    if kind != "mdp":
        rewards.append(("S", "LRA"))
        chosen.append(('S=? [ "one" ]', 'LRA=? [ "one" ]'))
    ours, storms = draw.choice(rewards)
    chosen.append((f'R{{"r"}}{optimum}=? [ {ours} ]', f'R{{"r"}}{optimum}=? [ {storms} ]'))
    bound, comparison = draw.choice(["0", "1/3", "0.5", "1"]), draw.choice(["<", "<=", ">", ">="])
    worst = "" if kind != "mdp" else "max" if "<" in comparison else "min"
    chosen.append((f'P{comparison}{bound} [ F "one" ]', f'P{worst}=? [ F "one" ]'))
    return chosen


def truth(text, value):
    """Whether the value of the probability meets the bound of `P<0.5 [...]`; a value that is asked for as it is."""
    bounded = re.match(r"P(<=|>=|<|>)([\d./]+) ", text)
    if value is None or not bounded:
        return value
    comparison, bound = bounded[1], Fraction(bounded[2])
    holds = {"<": value < bound, "<=": value <= bound, ">": value > bound, ">=": value >= bound}[comparison]
    return str(holds).lower()


def storm(path, texts, constants):
    """Storm's exact values; None for those that it cannot give."""
    try:
        program = stormpy.parse_prism_program(str(path), prism_compatibility=True)
    except Exception:  # Storm's errors have no common class.
        return [None] * len(texts)
    found = []
    for text in texts:
        try:
            formula = stormpy.parse_property(text, program)
            given, formulas = stormpy.instantiate_constants(program, constants, [formula])
            built = stormpy.build_model[stormpy.Rational](given, formulas)
            result = stormpy.model_checking(built, formulas[0])
            found.append(number(result.get_value(built.initial_states[0])))
        except Exception:
            found.append(None)
    return found


def number(value):
    # Storm's infinity is -1 in this domain.
    return INFINITE if str(value) in ("inf", "-1") else Fraction(str(value))


def ours(program, path, texts, *options):
    command = [str(program), "check", str(path), "--format", "json", *options]
    for text in texts:
        command += ["--pf", text]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        return done.stderr.strip()
    return json.loads(done.stdout)["properties"]


class Comparison:
    """What agreed, what did not, and what could not be asked."""

    def __init__(self, keep):
        self.keep, self.counts, self.wrong = keep, collections.Counter(), []

    def note(self, path, kind, good, what):
        self.counts[f"{kind}: {'agree' if good else 'DISAGREE'}"] += 1
        if not good:
            self.wrong.append(what)
            print(f"{path.name}: {what}", flush=True)
            if self.keep:
                self.keep.mkdir(parents=True, exist_ok=True)
                (self.keep / path.name).write_text(f"// {what}\n" + path.read_text())

    def exact(self, path, text, answer, value):
        if answer["error"]:
            self.counts["exact: refused"] += 1
            self.counts[f"  {answer['error'][:90]}"] += 1
            return
        result = answer["result"]
        good = result == value if isinstance(value, str) else result != INFINITE and Fraction(result) == value
        self.note(path, "exact", good, f"{text}: Storm {value}, ours {result}")

    def sound(self, path, text, answer, value):
        if answer["error"]:
            self.counts["sound: refused"] += 1
            self.counts[f"  {answer['error'][:90]}"] += 1
            return
        if isinstance(value, str):
            good = answer["result"] == value
        elif answer["result"] == INFINITE or answer["value"] is None:
            good = False
        else:
            low, high = (answer[end] if answer[end] is not None else answer["value"] for end in ("low", "high"))
            good = Fraction(low) <= value <= Fraction(high) or answer["exact"] and abs(Fraction(answer["value"]) - value) < 1e-15
            width = high - low
            self.counts["sound: wider than 1e-6"] += width > 1e-6 * max(abs(high), 1e-300)
        self.note(path, "sound", good, f"{text}: Storm {value}, ours {answer['result']} [{answer['low']}, {answer['high']}]")

    def certified(self, path, text, answer, value):
        certificate = answer["certificate"]
        if certificate is None:
            return
        if certificate["status"] != "certified":
            forms = "only probabilities of" in (certificate["why"] or "")
            self.counts["certificate: other form" if forms else f"certificate: {certificate['status']}"] += 1
            if not forms:
                self.counts[f"  {certificate['why'][:90]}"] += 1
            return
        if isinstance(value, Fraction):
            good = Fraction(certificate["low"]) <= value <= Fraction(certificate["high"])
            self.note(path, "certificate", good, f"{text}: Storm {value}, certified {certificate}")
        else:
            self.counts["certificate: of a truth value or infinity"] += 1

    def parametric(self, path, text, answer, value, point):
        if answer["error"]:
            self.counts["parametric: refused"] += 1
            self.counts[f"  {answer['error'][:90]}"] += 1
            return
        for part in answer["parametric"]["parts"]:
            ends = [(Fraction(r["low"]), Fraction(r["high"])) for r in part["region"]]
            if all(low < x < high for (low, high), x in zip(ends, point.values())):
                function = part["values"][0]["function"]
                if function in ("true", "false", INFINITE):
                    found = function
                else:
                    python = re.sub(r"(?<![\w^])(\d+)", r"Fraction(\1)", function.replace("^", "**"))
                    found = eval(python, {"Fraction": Fraction, **point})
                self.note(path, "parametric", found == value, f"{text}: Storm {value}, ours {function} at {point}")
                return
        self.counts["parametric: undecided at the point"] += 1


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--models", type=int, default=40)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--keep", type=Path)
    arguments.add_argument("--program", type=Path, default=ROOT / "corroborate")
    given = arguments.parse_args()
    set_log_level(LogLevel.OFF)
    comparison = Comparison(given.keep)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(given.seed, given.seed + given.models):
            one(comparison, given.program, Path(folder), seed)
    for name, count in sorted(comparison.counts.items()):
        if count:
            print(f"{count:8} {name}")
    agreed = sum(count for name, count in comparison.counts.items() if name.endswith(": agree"))
    print(f"{given.models} random models: {agreed} answers agree with Storm's exact ones, {len(comparison.wrong)} do not")
    sys.exit(1 if comparison.wrong or not agreed else 0)


def one(comparison, program, folder, seed):
    draw = random.Random(seed)
    kind = draw.choice(["dtmc", "ctmc", "mdp"])
    model = Model(draw, kind)
    path = folder / f"random-{seed}.prism"
    path.write_text(model.text)
    point = {name: Fraction(draw.randint(1, 96), 97) for name in ("p", "q")}
    constants = ",".join(f"{name}={value}" for name, value in point.items())
    pairs = properties(draw, kind)
    values = storm(path, [text for _, text in pairs], constants)
    kept = [(text, truth(text, value)) for (text, _), value in zip(pairs, values) if value is not None]
    comparison.counts["Storm gives no value"] += len(pairs) - len(kept)
    if not kept:
        return
    texts = [text for text, _ in kept]
    ways = [
        (comparison.exact, ["--method", "exact", "--const", constants]),
        (comparison.sound, ["--const", constants]),
        (comparison.certified, ["--certify", "--const", constants]),
        (lambda *a: comparison.parametric(*a, point), ["--param", "p,q"]),
    ]
    for judge, options in ways:
        answers = ours(program, path, texts, *options)
        if isinstance(answers, str):
            comparison.counts[f"refused: {answers.splitlines()[0][:100]}"] += 1
            continue
        for (text, value), answer in zip(kept, answers):
            judge(path, text, answer, value)


if __name__ == "__main__":
    main()
