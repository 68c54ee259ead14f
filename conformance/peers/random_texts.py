"""What random_models.py draws: models, and questions to them in the program's syntax with what an oracle is asked instead.

A question says of which kind it is, so that what no oracle can answer stays visible kind by kind.
"""

import itertools
import re
from dataclasses import dataclass
from fractions import Fraction

LABELS = ['"one"', '"two"', '"three"']
# Constants that stay open, so that answers are functions of them.
OPEN = ("p", "q")


class Model:
    """The text of a random model, with two constants p and q."""

    def __init__(self, draw, kind):
        self.draw, self.kind, self.used = draw, kind, set()
        # Of each module, its variables' lines and its commands.
        self.variables, self.commands = {}, {}
        self.ranges = [draw.randint(1, 3) for _ in range(draw.randint(1, 3))]
        # Least values; all begin at 0.
        self.lows = [draw.choice([0, 0, 0, -1, -2]) for _ in self.ranges]
        self.actions = draw.sample(["a", "b"], draw.randint(0, 2))
        self.has_copy = draw.random() < 0.2
        self.has_switch = draw.random() < 0.3
        self.has_global = draw.random() < 0.2
        # Where several states begin, only filters have one answer.
        self.several = draw.random() < 0.1
        # In most models everything ends in some states, so that probabilities are not only 0 and 1.
        self.end = f"!({self.equality()} | {self.equality()})" if draw.random() < 0.7 else "true"
        self.busy = self.formula() if draw.random() < 0.3 else ""
        self.formulas = f"formula busy = {self.busy};\n" if self.busy else ""
        modules = [self.module(number) for number in range(len(self.ranges))]
        if self.has_copy:
            modules.append(self.copy())
        head = f"{kind}\nconst double p;\nconst double q;\nconst int N = 2;\n{self.formulas}"
        if self.has_global:
            head += "global g : [0..N]" + ("" if self.several else " init 1") + ";\n"
        self.loses = draw.random() < 0.15
        rest = self.initial() + self.rewards() + self.labels()
        self.text = self.plain = head + "\n".join(modules) + rest
        if len(modules) > 1 and draw.random() < 0.2:
            system, commands = self.system()
            self.text += f"system {system} endsystem\n"
            variables = [line for module in self.variables.values() for line in module]
            # The same without `system`, which Storm does not build.
            self.plain = head + "module all\n" + "".join(variables) + "".join(map(written, commands)) + "endmodule\n" + rest
        # Nor has it equivalence.
        self.plain = self.plain.replace(") <=> (", ") = (")

    def names(self):
        return [(f"x{number}", top) for number, top in enumerate(self.ranges)] + [("g", 2)] * self.has_global

    def atom(self):
        name, top = self.draw.choice(self.names())
        if self.draw.random() < 0.2:
            other = self.draw.choice(self.names())[0]
            return self.draw.choice([f"{name}/2>0.4", f"pow({name},2)<={top}", f"{name}+{other}>={top}", f"{name}*{other}!=1",
                                     f"({name}=0 ? {other}>0 : {other}<=1)", f"max({name},{other})={top}", f"ceil({name}/2)={top - 1}"])
        return f"{name}{self.draw.choice(['=', '!=', '<', '>='])}{self.draw.randint(0, top)}"

    def equality(self):
        number = self.draw.randrange(len(self.ranges))
        return f"x{number}={self.draw.randint(1, self.ranges[number])}"

    def formula(self):
        atoms = [self.atom() for _ in range(self.draw.randint(1, 2))]
        if len(atoms) == 2 and self.draw.random() < 0.2:
            return f"(({atoms[0]}) <=> ({atoms[1]}))"
        return f"({self.draw.choice([' & ', ' | ', ' => ']).join(atoms)})"

    def guard(self):
        choices = [self.formula()]
        if self.formulas:
            choices.append("busy")
        if self.has_switch:
            choices.append(self.draw.choice(["on", "!on"]))
        return self.draw.choice(choices)

    def value(self, number):
        top, shift, low = self.ranges[number], self.draw.randint(0, 2), self.lows[number]
        return self.draw.choice([
            str(self.draw.randint(low, top)), str(self.draw.randint(0, top)), f"max(x{number}-{shift},{low})",
            f"mod(max(x{number},0)+{shift},{top + 1})", f"min(x{number}+{shift},{top})", f"max(x{number}-1,0)",
            f"(x{number}=0 ? {top} : {self.draw.randint(0, top)})", f"floor(x{number}/2)",
        ])

    def weights(self):
        if self.kind == "ctmc":
            return [self.draw.choice(["1", "2.5", "1/3", "4*p", "1+q", "0.01", "20"]) for _ in range(self.draw.randint(1, 3))]
        return self.draw.choice([["1"], ["0.5", "0.5"], ["1/3", "2/3"], ["0.2", "0.3", "0.5"], ["p", "1-p"],
                                 ["q/2", "1-q/2"], ["p*q", "(1-p)*q", "1-q"], ["1e-6", "1-1e-6"], ["pow(p,2)", "1-pow(p,2)"]])

    def module(self, number):
        commands = []
        for _ in range(self.draw.randint(1, 4)):
            action = self.draw.choice(["", *self.actions]) if commands else ""
            self.used.update(action)
            updates = [(weight, self.update(number, action)) for weight in self.weights()]
            guard = f"{self.guard()} & {self.end}" if commands else self.end
            commands.append((action, guard, updates))
        if number == 0 and self.end != "true":
            # Without deadlocks: Storm leaves out their state's rewards (conformance/models/deadlock_rewards.props).
            commands.append(("", f"!({self.end})", [("1", "true")]))
        start = "" if self.several else " init 0"
        variables = f"  x{number} : [{self.lows[number]}..{self.ranges[number]}]{start};\n"
        if number == 0 and self.has_switch:
            variables += "  on : bool" + ("" if self.several else " init false") + ";\n"
        self.variables[f"m{number}"], self.commands[f"m{number}"] = [variables], commands
        return f"module m{number}\n{variables}" + "".join(map(written, commands)) + "endmodule\n"

    def update(self, number, action):
        parts = [f"(x{number}'={self.value(number)})"]
        if number == 0 and self.has_switch and self.draw.random() < 0.5:
            parts.append(self.draw.choice(["(on'=!on)", "(on'=true)", f"(on'=x0>{self.draw.randint(0, 1)})"]))
        if self.has_global and not action and self.draw.random() < 0.5:
            parts.append(self.draw.choice(["(g'=mod(g+1,N+1))", "(g'=0)", "(g'=N)"]))
        return "&".join(parts)

    def copy(self):
        """Another process like the first, by renaming."""
        exchange = {"a": "b", "b": "a"} if self.draw.random() < 0.5 and len(self.actions) == 2 else {}
        pairs = [("x0", "y0")] + [("on", "ony")] * self.has_switch + list(exchange.items())
        names = dict(pairs)
        # Renaming reaches into formulas.
        renamed = lambda text: re.sub(r"\w+", lambda word: names.get(word[0], word[0]), re.sub(r"\bbusy\b", self.busy or "busy", text))
        self.variables["copy"] = [renamed(line) for line in self.variables["m0"]]
        self.commands["copy"] = [(names.get(action, action), renamed(guard), [(renamed(p), renamed(update)) for p, update in updates])
                                 for action, guard, updates in self.commands["m0"]]
        return f"module copy = m0 [ {', '.join(f'{old}={new}' for old, new in pairs)} ] endmodule\n"

    def initial(self):
        return "\ninit x0<=1 endinit\n" if self.several else ""

    def system(self):
        """How the modules are composed, with names hidden or changed; and the commands of one module that does the same."""
        names = list(self.commands)
        self.draw.shuffle(names)
        actions = lambda name: {command[0] for command in self.commands[name]} - {""}
        whole, commands, known = names[0], self.commands[names[0]], actions(names[0])
        for name in names[1:]:
            # An action that modules have is theirs even where they never take it together (conformance/models/blocked.prism).
            own = actions(name)
            join = self.draw.choice(["||", "|||"] + [f"|[{action}]|" for action in sorted(self.used)] * 2)
            over = {"||": known & own, "|||": set()}.get(join) if join[1] == "|" else {join[2]}
            whole, commands = f"({whole} {join} {name})", together(commands, self.commands[name], over)
            known = known | own
            if self.used and self.draw.random() < 0.4:
                old = self.draw.choice(sorted(self.used))
                how, new = self.draw.choice([(f"/{{{old}}}", ""), (f"{{{old}<-c}}", "c")])
                whole = f"({whole}{how})"
                commands = [(new if action == old else action, *rest) for action, *rest in commands]
                known = {new if action == old else action for action in known} - {""}
        return whole, commands

    def rewards(self):
        values = ['1', '2', '0.5', '1/3', 'x0+p'] if min(self.lows) == 0 else ['1', '2', '0.5', '1/3', 'max(x0,0)+p']
        values = ['-1', '-x0/2', '1', '3-2*x0'] if self.loses else values
        items = [f"  {self.formula()} : {self.draw.choice(values)};"]
        if self.draw.random() < 0.5:
            action = self.draw.choice(["", *sorted(self.used)])
            items.append(f"  [{action}] {self.formula()} : {self.draw.choice(['1', '3', '2*q'])};")
        whole = '\nrewards "r"\n' + "\n".join(items) + "\nendrewards\n"
        return whole + 'rewards "time"\n  true : 1;\nendrewards\nrewards "in"\n  ' + self.formula() + " : 1;\nendrewards\n"

    def labels(self):
        texts = [self.equality(), self.draw.choice([self.equality(), self.formula()]), self.formula()]
        return "".join(f"label {name} = {text};\n" for name, text in zip(LABELS, texts))


def written(command):
    action, guard, updates = command
    return f"  [{action}] {guard} -> {' + '.join(f'{p}:{update}' for p, update in updates)};\n"


def together(left, right, over):
    """The commands of two sides that take the actions of a set together."""
    found = [command for command in left + right if command[0] not in over]
    for one, other in itertools.product(left, right):
        if one[0] in over and one[0] == other[0]:
            updates = [(f"({p})*({q})", "&".join(part for part in (a, b) if part != "true") or "true")
                       for (p, a), (q, b) in itertools.product(one[2], other[2])]
            found.append((one[0], f"({one[1]}) & ({other[1]})", updates))
    return found


@dataclass
class Question:
    """What is asked of the program, and of an oracle.

    `how` says how the oracle's answer is read:
    value: the value or truth value at the initial state, of `oracle`;
    worst: whether the value of `oracle` meets `bound`;
    quotient: of the values of two texts;
    filter: a function of all states' values;
    starts: the least and the greatest value in the initial states;
    paths: of all or some paths, by fixpoints on the oracle's graph;
    sum: a combination of the values of texts;
    optimum: an approximate value of Storm's;
    timed: exponentials of matrices, with `oracle` the parts of the question.
    """

    kind: str
    ours: str
    oracle: object
    how: str = "value"
    bound: tuple = ()


def same(kind, text):
    return Question(kind, text, text)


def negated(text):
    return f"!({text})"


def ltl(draw, depth, bounded):
    """A pair: in the program's syntax, in Storm's, which has neither W nor R nor implications."""
    if depth == 0:
        text = draw.choice(LABELS)
        text = text if draw.random() < 0.75 else f"!{text}"
        return text, text
    one, other = ltl(draw, depth - 1, bounded), ltl(draw, draw.randint(0, depth - 1), bounded)
    operator = draw.choice(["X", "F", "G", "!", "U", "W", "R", "&", "|", "=>", "<=>"] + ["F<=", "G<=", "U<="] * bounded)
    (a, storms_a), (b, storms_b) = one, other
    if operator.endswith("<="):
        steps = draw.randint(0, 4)
        a, b = draw.choice(LABELS), draw.choice(LABELS)
        if operator == "F<=":
            return f"(F<={steps} {a})", f"(F<={steps} {a})"
        if operator == "G<=":
            return f"(G<={steps} {a})", f"!(F<={steps} !{a})"
        return f"({a} U<={steps} {b})", f"({a} U<={steps} {b})"
    if operator in "XFG":
        return f"({operator} {a})", f"({operator} {storms_a})"
    if operator == "!":
        return f"!({a})", negated(storms_a)
    storms = {
        "U": f"({storms_a} U {storms_b})",
        "W": f"((G {storms_a}) | ({storms_a} U {storms_b}))",
        "R": f"!({negated(storms_a)} U {negated(storms_b)})",
        "&": f"({storms_a} & {storms_b})",
        "|": f"({storms_a} | {storms_b})",
        "=>": f"({negated(storms_a)} | {storms_b})",
        "<=>": f"(({storms_a} & {storms_b}) | ({negated(storms_a)} & {negated(storms_b)}))",
    }[operator]
    return f"({a} {operator} {b})", storms


def paths(draw):
    a, b = draw.choice(LABELS), draw.choice(LABELS)
    return draw.choice([
        f"F {a}", f"{a} U {b}", f"!{b} U {a}", f"G {a}", f"X {b}", f"G F {a}", f"F G {b}", f"(F {a}) & (F {b})",
        f"(G {a}) | (F {b})", f"{a} U (X {b})", f"F ({a} & (X {b}))",
    ])


class Questions:
    """Draws questions to a model of this type."""

    def __init__(self, draw, kind):
        self.draw, self.kind = draw, kind

    def optimum(self):
        return self.draw.choice(["min", "max"]) if self.kind == "mdp" else ""

    def probability(self):
        return same("P of a path", f"P{self.optimum()}=? [ {paths(self.draw)} ]")

    def of_ltl(self):
        bounded = self.kind != "ctmc"
        ours, storms = ltl(self.draw, self.draw.randint(1, 3), bounded)
        optimum = self.optimum()
        kind = "P of LTL with step bounds" if "<=" in ours.replace("<=>", "") else "P of LTL"
        return Question(kind, f"P{optimum}=? [ {ours} ]", f"P{optimum}=? [ {storms} ]")

    def bounded_steps(self):
        a, b, optimum = self.draw.choice(LABELS), self.draw.choice(LABELS), self.optimum()
        low, width = self.draw.randint(0, 4), self.draw.randint(0, 4)
        high = low + width
        # With a lower bound, something follows that many steps. Storm's own `a U[2,4] b` asks `a` of none of the states before
        # the lower bound (conformance/models/not_before.props).
        later = "X (" * low + f"F {a}" + ")" * low
        through = f"({a} & X " * low + f"({a} U<={width} {b})" + ")" * low
        ours, storms = self.draw.choice([
            (f"F<={high} {a}",) * 2, (f"{a} U<={high} {b}",) * 2, (f"F[{low},{high}] {a}",) * 2,
            (f"{a} U[{low},{high}] {b}", through), (f"F={low} {a}", f"F[{low},{low}] {a}"),
            (f"F<{high + 1} {a}", f"F<={high} {a}"), (f"F>={low} {a}", later),
            (f"G<={high} {a}", f"!(F<={high} !{a})"),
        ])
        return Question("P in steps", f"P{optimum}=? [ {ours} ]", f"P{optimum}=? [ {storms} ]")

    def bounded_time(self):
        a, b = self.draw.choice(LABELS), self.draw.choice(LABELS)
        low, width = self.draw.choice(["0.1", "1", "7/2"]), self.draw.choice(["0.3", "2", "40"])
        high = Fraction(low) + Fraction(width)
        ours, parts = self.draw.choice([
            (f"F<={width} {a}", ("until", None, a, 0, width)),
            (f"{a} U<={width} {b}", ("until", a, b, 0, width)),
            (f"G<={width} {a}", ("always", None, a, 0, width)),
            (f"F[{low},{high}] {a}", ("until", None, a, low, high)),
            (f"{a} U[{low},{high}] {b}", ("until", a, b, low, high)),
            (f"F>={low} {a}", ("until", None, a, low, None)),
            (f"{a} U>={low} {b}", ("until", a, b, low, None)),
        ])
        return Question("P in time", f"P=? [ {ours} ]", parts, "timed")

    def rewards_in_time(self):
        time, name = self.draw.choice(["0.1", "1", "7/2", "30"]), self.draw.choice(["r", "in"])
        ours, parts = self.draw.choice([(f"C<={time}", "cumulative"), (f"I={time}", "instantaneous")])
        return Question(f"R {parts} in time", f'R{{"{name}"}}=? [ {ours} ]', (parts, name, time), "timed")

    def rewards(self):
        draw, optimum = self.draw, self.optimum()
        steps, a, b = draw.randint(0, 6), draw.choice(LABELS), draw.choice(LABELS)
        kinds = [("R of reachability", f"F {a}", f"F {a}"), ("R total", "C", "C"), ("R steady", "S", "LRA")]
        if self.kind != "ctmc":
            kinds += [("R cumulative", f"C<={steps}", f"C<={steps}"), ("R instantaneous", f"I={steps}", f"I={steps}")]
        kind, ours, storms = draw.choice(kinds)
        name = draw.choice(["r", "r", "time", "in"])
        return Question(kind, f'R{{"{name}"}}{optimum}=? [ {ours} ]', f'R{{"{name}"}}{optimum}=? [ {storms} ]')

    def sequence_rewards(self):
        """Co-safe LTL: a sequence of two labels, in a chain, whose product with it an oracle can build."""
        a, b = self.draw.choice(LABELS), self.draw.choice(LABELS)
        name = self.draw.choice(["r", "time", "in"])
        ours, order = self.draw.choice([
            (f"F ({a} & (F {b}))", "then"), (f"(F {a}) & (F {b})", "both"), (f"F ({a} & (X {b}))", "next")])
        return Question("R of co-safe LTL", f'R{{"{name}"}}=? [ {ours} ]', (order, a, b, name), "cosafe")

    def steady(self):
        a = self.draw.choice(LABELS)
        if self.kind == "mdp":
            return self.rewards()
        return Question("S", f"S=? [ {a} ]", f"LRA=? [ {a} ]")

    def bound(self):
        bound, comparison = self.draw.choice(["0", "1/3", "0.5", "1"]), self.draw.choice(["<", "<=", ">", ">="])
        worst = "" if self.kind != "mdp" else "max" if "<" in comparison else "min"
        a, b = self.draw.choice(LABELS), self.draw.choice(LABELS)
        choices = [("P", f"F {a}", f"F {a}"), ("P", f"{a} U {b}", f"{a} U {b}"), ('R{"r"}', f"F {a}", f"F {a}"),
                   ('R{"time"}', "C", "C")]
        if self.kind != "mdp":
            choices.append(("S", a, a))
        operator, ours, storms = self.draw.choice(choices)
        if operator[0] == "R":
            bound = self.draw.choice(["0", "1/3", "1", "2", "5"])
        storms_operator = "LRA" if operator == "S" else operator
        return Question(f"{operator[0]} with a bound", f"{operator}{comparison}{bound} [ {ours} ]",
                        f"{storms_operator}{worst}=? [ {storms} ]", "worst", (comparison, bound))

    def inner(self):
        """A state formula, in which a probability, a reward or a steady state is compared with a bound."""
        bound, comparison = self.draw.choice(["0", "0.21", "0.5", "0.79", "1"]), self.draw.choice(["<", "<=", ">", ">="])
        a, b = self.draw.choice(LABELS), self.draw.choice(LABELS)
        choices = [(f"P{comparison}{bound} [ F {a} ]",) * 2, (f"P{comparison}{bound} [ X {a} ]",) * 2,
                   (f"P{comparison}{bound} [ {a} U {b} ]",) * 2, (f'R{{"r"}}{comparison}{self.draw.randint(1, 4)} [ F {a} ]',) * 2]
        if self.kind != "mdp":
            choices.append((f"S{comparison}{bound} [ {a} ]", f"LRA{comparison}{bound} [ {a} ]"))
        return self.draw.choice(choices)

    def nested(self):
        (one, storms_one), (other, storms_other) = self.inner(), self.inner()
        a, optimum = self.draw.choice(LABELS), self.optimum()
        shape = self.draw.choice(["F ({0} & {1})", "{2} U {0}", "G {0}", "X ({0} | {2})", "F ({0} & !({1}))"])
        return Question("nested", f"P{optimum}=? [ {shape.format(one, other, a)} ]",
                        f"P{optimum}=? [ {shape.format(storms_one, storms_other, a)} ]")

    def conditional(self):
        draw = self.draw
        if self.kind == "mdp":
            optimum, a, b = self.optimum(), draw.choice(LABELS), draw.choice(LABELS)
            return same("conditional", f"P{optimum}=? [ F {a} || F {b} ]")
        one, given = paths(draw), paths(draw)
        return Question("conditional", f"P=? [ {one} || {given} ]", (f"P=? [ ({one}) & ({given}) ]", f"P=? [ {given} ]"), "quotient")

    def filter(self):
        draw = self.draw
        over = draw.choice(['"init"', *LABELS, "true"])
        if draw.random() < 0.4:
            name = draw.choice(["forall", "exists", "count"])
            ours, storms = self.inner()
        else:
            name = draw.choice(["min", "max", "avg", "sum", "range", "first", "argmin", "argmax"])
            a, b, optimum = draw.choice(LABELS), draw.choice(LABELS), self.optimum()
            ours = storms = draw.choice([f"P{optimum}=? [ F {a} ]", f"P{optimum}=? [ {a} U {b} ]", f"P{optimum}=? [ X {a} ]",
                                         f'R{{"time"}}{optimum}=? [ F {a} ]', f'R{{"r"}}{optimum}=? [ F {a} ]'])
        return Question(f"filter {name}", f"filter({name}, {ours}, {over})", (name, storms, over), "filter")

    def starts(self):
        """A number in all initial states."""
        a, b, optimum = self.draw.choice(LABELS), self.draw.choice(LABELS), self.optimum()
        text = self.draw.choice([f"P{optimum}=? [ F {a} ]", f"P{optimum}=? [ {a} U {b} ]", f"P{optimum}=? [ X {a} ]",
                                 f"P{optimum}=? [ G F {a} ]", f'R{{"time"}}{optimum}=? [ F {a} ]'])
        return Question("several starts", text, text, "starts")

    def of_paths(self):
        """Computation tree logic."""
        a, b, steps = self.draw.choice(LABELS), self.draw.choice(LABELS), self.draw.randint(0, 3)
        quantifier = self.draw.choice("AE")
        text, parts = self.draw.choice([
            (f"F {a}", ("until", "true", a)), (f"G {a}", ("release", "false", a)), (f"{a} U {b}", ("until", a, b)),
            (f"{a} R {b}", ("release", a, b)), (f"X {a}", ("next", a, a)), (f"{a} W {b}", ("wait", a, b)),
        ])
        return Question("A and E", f"{quantifier} [ {text} ]", (quantifier, *parts), "paths")

    def arithmetic(self):
        a, b, optimum = self.draw.choice(LABELS), self.draw.choice(LABELS), self.optimum()
        one, other = f"P{optimum}=? [ F {a} ]", f"P{optimum}=? [ X {b} ]"
        ours, join = self.draw.choice([
            (f"2*{one} - {other}/3", lambda x, y: 2 * x - y / 3), (f"1-{one}*{other}", lambda x, y: 1 - x * y),
            (f"max({one}, {other})", max), (f"min({one}, 1/2)+{other}", lambda x, y: min(x, Fraction(1, 2)) + y),
            (f"1 + -{one}", lambda x, _: 1 - x), (f"pow({one}, 2)+{other}", lambda x, y: x * x + y),
        ])
        return Question("arithmetic", ours, ((one, other), join), "sum")

    def ratio(self):
        """A reward for each unit of another one."""
        return Question("R ratio", 'R{"r"}/{"time"}=? [ S ]', ('R{"r"}=? [ LRA ]', 'R{"time"}=? [ LRA ]'), "quotient")

    def multi(self):
        draw = self.draw
        a, b, c = (draw.choice(LABELS) for _ in range(3))
        bound, steps = draw.choice(["0.1", "0.3", "0.55", "0.9"]), draw.randint(1, 6)
        first = draw.choice([f"P{self.optimum()}=? [ F {a} ]", f"P{self.optimum()}=? [ {a} U {b} ]",
                             f'R{{"r"}}{self.optimum()}=? [ C<={steps} ]', f"P>=0.2 [ F {a} ]"])
        second = draw.choice([f"P>={bound} [ F {b} ]", f"P<={bound} [ F {b} ]", f'R{{"r"}}<={draw.randint(1, 4)} [ C<={steps} ]'])
        parts = [first, second] + [f"P>={draw.choice(['0.05', '0.4'])} [ F {c} ]"] * (draw.random() < 0.3)
        return Question("multi", f"multi({', '.join(parts)})", f"multi({', '.join(parts)})", "optimum")

    def several(self, count, one_start):
        """So many questions, of kinds that fit."""
        if not one_start:
            return [self.draw.choice([self.filter, self.starts])() for _ in range(count)]
        kinds = [self.probability, self.of_ltl, self.of_ltl, self.rewards, self.rewards, self.steady, self.bound, self.nested,
                 self.conditional, self.filter, self.of_paths, self.arithmetic]
        kinds += {"dtmc": [self.bounded_steps, self.sequence_rewards], "mdp": [self.bounded_steps, self.multi],
                  "ctmc": [self.bounded_time, self.rewards_in_time]}[self.kind]
        if self.kind != "mdp":
            kinds.append(self.ratio)
        return [self.draw.choice(kinds)() for _ in range(count)]
