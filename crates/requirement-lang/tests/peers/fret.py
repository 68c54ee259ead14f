"""Compares our properties with the formulas that FRET publishes, on all short infinite words.

    cargo run -q -p corroborate-requirement-lang --example forms > forms.tsv
    python3 crates/requirement-lang/tests/peers/fret.py compare forms.tsv FRET/fret-electron/app/parser/semantics.json
    python3 crates/requirement-lang/tests/peers/fret.py record forms.tsv FRET/fret-electron/app/parser/semantics.json \
        > crates/requirement-lang/tests/peers/fret_answers.tsv
    python3 crates/requirement-lang/tests/peers/fret.py check forms.tsv crates/requirement-lang/tests/peers/fret_answers.tsv

`compare` needs FRET's file and says on which word a formula differs. `record` writes down what FRET's formulas answer on
all the words, as one hash for each formula; `check` holds ours against that record and needs nothing of FRET's.

FRET is at https://github.com/NASA-SW-VnV/fret; its formulas are read from its own file and are not
part of this repository. They are those for infinite traces, which FRET calls `ftInfAUExpanded`.
A word is a finite prefix and a cycle that repeats for ever. Our `after N` is compared with FRET's
`after N-1`, since FRET asks for the response one step later. Exits with 1 if any two differ.
"""

import hashlib
import itertools
import json
import re
import sys

TOKEN = re.compile(r'\s*(<=>|=>|->|<=\d+|\[[^\]]*\]|[A-Za-z_$][A-Za-z_0-9$]*|"[^"]*"|[()!&|])')


def tokens(text):
    found, at = [], 0
    while text[at:].strip():
        match = TOKEN.match(text, at)
        if not match:
            raise ValueError(f"cannot read {text[at:]!r}")
        found.append(match.group(1))
        at = match.end()
    return found


class Reader:
    """Both syntaxes; precedence from weak to strong: =>, |, &, U V W R, unary."""

    def __init__(self, text):
        self.tokens, self.next = tokens(text), 0

    def peek(self):
        return self.tokens[self.next] if self.next < len(self.tokens) else None

    def take(self):
        self.next += 1
        return self.tokens[self.next - 1]

    def whole(self):
        formula = self.implies()
        if self.peek() is not None:
            raise ValueError(f"unexpected {self.peek()}")
        return formula

    def implies(self):
        left = self.chain("|")
        if self.peek() in ("->", "=>"):
            self.take()
            return ("|", ("!", left), self.implies())
        return left

    def chain(self, sign):
        left = self.chain("&") if sign == "|" else self.until()
        while self.peek() == sign:
            self.take()
            left = (sign, left, self.chain("&") if sign == "|" else self.until())
        return left

    def bound(self):
        text = self.peek()
        if text is None or not (text.startswith("[") or text.startswith("<=")):
            return (0, None)
        text = self.take().strip("[]").replace(" ", "")
        if "," in text:
            low, high = text.split(",")
            return (int(low), int(high))
        sign, number = re.fullmatch(r"(<=|<|=)(.+)", text).groups()
        if not re.fullmatch(r"[\d+]+", number):
            raise ValueError(number)
        number = sum(int(part) for part in number.split("+"))
        return {"<=": (0, number), "<": (0, number - 1), "=": (number, number)}[sign]

    def until(self):
        left = self.unary()
        if self.peek() in ("U", "V", "W", "R"):
            operator = self.take()
            bound = self.bound()
            right = self.until()
            if operator == "U":
                return ("U", bound, left, right)
            if operator == "W":
                left, right = right, ("|", left, right)
            return ("!", ("U", bound, ("!", left), ("!", right)))
        return left

    def unary(self):
        token = self.take()
        if token == "!":
            return ("!", self.unary())
        if token == "X":
            return ("X", self.unary())
        if token in ("F", "G"):
            bound = self.bound()
            inner = self.unary()
            if token == "F":
                return ("U", bound, ("true",), inner)
            return ("!", ("U", bound, ("true",), ("!", inner)))
        if token == "(":
            inner = self.implies()
            if self.take() != ")":
                raise ValueError("no closing parenthesis")
            return inner
        if token in ("true", "TRUE"):
            return ("true",)
        if token in ("false", "FALSE", "LAST"):
            return ("!", ("true",))
        return ("atom", token.strip('"'))


def truth(formula, word, start):
    """The truth at each position of `word`, whose last position is followed by position `start`."""
    size = len(word)
    follows = [*range(1, size), start]
    kind = formula[0]
    if kind == "true":
        return [True] * size
    if kind == "atom":
        return [formula[1] in letter for letter in word]
    if kind == "!":
        return [not value for value in truth(formula[1], word, start)]
    if kind in "&|":
        left, right = truth(formula[1], word, start), truth(formula[2], word, start)
        if kind == "&":
            return [a and b for a, b in zip(left, right)]
        return [a or b for a, b in zip(left, right)]
    if kind == "X":
        inner = truth(formula[1], word, start)
        return [inner[follows[i]] for i in range(size)]
    (low, high), left, right = formula[1], truth(formula[2], word, start), truth(formula[3], word, start)
    values = []
    for position in range(size):
        value = False
        for step in range((low + size if high is None else high) + 1):
            if step >= low and right[position]:
                value = True
                break
            if not left[position]:
                break
            position = follows[position]
        values.append(value)
    return values


def words(atoms):
    letters = [frozenset(a for a, on in zip(atoms, bits) if on) for bits in itertools.product((0, 1), repeat=len(atoms))]
    shapes = [(0, 1), (0, 2), (1, 1)] + ([(1, 2)] if len(atoms) < 4 else [])
    for prefix, cycle in shapes:
        for word in itertools.product(letters, repeat=prefix + cycle):
            yield word, prefix


NAMES = {"$scope_mode$": "m", "$regular_condition$": "c", "$post_condition$": "r", "$stop_condition$": "q"}


def ours(forms):
    """Of each of our formulas: its key, its number of steps, the formula and its atoms."""
    for line in open(forms):
        key, steps, path = line.rstrip("\n").split("\t")
        scope, condition, timing = key.split(",")
        atoms = ["r"] + ["m"] * (scope != "null") + ["c"] * (condition != "null") + ["q"] * (timing in ("until", "before"))
        yield key, int(steps), Reader(path).whole(), atoms


def theirs(published, key, steps):
    """FRET's formula of that key, in our names."""
    formula = published[f"{key},satisfaction"]["ftInfAUExpanded"]
    formula = formula.replace("$duration$", str(steps - key.endswith(",after")))
    for name, atom in NAMES.items():
        formula = formula.replace(name, atom)
    return Reader(formula).whole()


def answers(formula, atoms):
    """A hash of the formula's truth at the beginning of each word."""
    truths = bytes(truth(formula, word, start)[0] for word, start in words(atoms))
    return hashlib.sha256(truths).hexdigest()


def compare(forms, semantics):
    published = json.load(open(semantics))
    compared, judged, different = 0, 0, []
    for key, steps, formula, atoms in ours(forms):
        published_formula = theirs(published, key, steps)
        compared += 1
        for word, start in words(atoms):
            judged += 1
            if truth(formula, word, start)[0] != truth(published_formula, word, start)[0]:
                shown = [sorted(letter) for letter in word]
                different.append(f"{key} {steps}: {shown[:start]} then for ever {shown[start:]}")
                break
    print(f"{compared} formulas compared in {judged} judgements, {len(different)} differ")
    return different


def record(forms, semantics):
    published = json.load(open(semantics))
    for key, steps, _, atoms in ours(forms):
        print(key, steps, answers(theirs(published, key, steps), atoms), sep="\t")
    return []


def check(forms, recorded):
    expected = {}
    for line in open(recorded):
        key, steps, answer = line.rstrip("\n").split("\t")
        expected[key, int(steps)] = answer
    different, compared = [], 0
    for key, steps, formula, atoms in ours(forms):
        answer = expected.pop((key, steps), None)
        compared += answer is not None
        if answer != answers(formula, atoms):
            reason = "is not recorded" if answer is None else "answers otherwise than FRET's"
            different.append(f"{key} {steps}: {reason}")
    different += [f"{key} {steps}: recorded, but we have no such formula" for key, steps in expected]
    print(f"{compared} formulas held against FRET's recorded answers, {len(different)} differ")
    return different


def main(what, forms, other):
    different = {"compare": compare, "record": record, "check": check}[what](forms, other)
    for line in different:
        print(line)
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
