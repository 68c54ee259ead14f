"""What random_models.py holds the program's answers against: Storm in exact arithmetic, and where it has none, a few lines of
linear algebra on the states that it built.

An answer is a fraction, "Infinity", "true", "false", `Near`: a number that is known to an absolute error, or `Span`: the range
of a filter. None means that nobody was found to answer.
"""

from collections import namedtuple
from fractions import Fraction

import numpy
import scipy.linalg
import stormpy

INFINITE = "Infinity"
Near = namedtuple("Near", "value error")
Span = namedtuple("Span", "low high")

# Product states up to which equations are solved in fractions.
MOST_STATES = 60
# Storm's optima of several objectives are approximate by its own setting, 1e-4 of the value.
OPTIMUM_ERROR = Fraction(1, 2000)
# Of exponentials in double precision, whose rates times the time are below 1e4.
TIMED_ERROR = 1e-9


def number(value):
    # Storm's infinity is -1 in this domain.
    return INFINITE if str(value) in ("inf", "-1", INFINITE) else Fraction(str(value))


def meets(value, comparison, bound):
    """Whether a value meets a bound, as the program writes it."""
    if value == INFINITE:
        return str(">" in comparison).lower()
    bound = Fraction(bound)
    return str({"<": value < bound, "<=": value <= bound, ">": value > bound, ">=": value >= bound}[comparison]).lower()


class Oracle:
    """One model, built once, in exact arithmetic."""

    def __init__(self, path, constants, loses=False):
        # With negative rewards Storm's infinity may be the number -1, and infinite losses are infinite gains.
        self.loses = loses
        program = stormpy.parse_prism_program(str(path), prism_compatibility=True)
        anything = stormpy.parse_property('P=? [ F "one" ]' if "mdp" not in str(program.model_type).lower() else 'Pmax=? [ F "one" ]', program)
        self.program, _ = stormpy.instantiate_constants(program, constants, [anything])
        options = stormpy.BuilderOptions(build_full=True)
        options.set_build_all_labels()
        options.set_build_all_reward_models()
        options.set_build_state_valuations()
        self.model = stormpy.build_model[stormpy.Rational](self.program, options=options)
        self.initial = self.model.initial_states

    def answer(self, question):
        """The answer to a question of random_texts.py; Storm's errors have no common class."""
        try:
            return getattr(self, "of_" + question.how)(question)
        except Exception:
            return None

    def check(self, text, only_initial=True):
        return stormpy.model_checking(self.model, stormpy.parse_property(text, self.program), only_initial_states=only_initial)

    def values(self, text):
        """Of all states: fractions, infinity, or truth values."""
        result = self.check(text, only_initial=False)
        if hasattr(result, "get_truth_values_vector"):
            holds = set(result.get_truth_values_vector())
            return [state in holds for state in range(self.model.nr_states)]
        return [self.unambiguous(number(value)) for value in result.get_value_vector()]

    def unambiguous(self, value):
        if self.loses and value == INFINITE:
            raise ValueError("infinite, or -1")
        return value

    def states(self, label):
        if label == "true":
            return list(range(self.model.nr_states))
        return list(self.model.labeling.get_states(label.strip('"')))

    def of_value(self, question):
        result = self.check(question.oracle)
        if hasattr(result, "get_truth_values_vector"):
            return str(self.initial[0] in set(result.get_truth_values_vector())).lower()
        return self.unambiguous(number(result.get_value(self.initial[0])))

    def of_worst(self, question):
        return meets(self.of_value(question), *question.bound)

    def of_quotient(self, question):
        both, given = (number(self.check(text).get_value(self.initial[0])) for text in question.oracle)
        # Given what never happens there is no probability.
        return both / given if given else None

    def of_filter(self, question):
        name, text, over = question.oracle
        states = self.states(over)
        if not states:
            return None
        values = [value for state, value in enumerate(self.values(text)) if state in set(states)]
        if name in ("forall", "exists", "count"):
            return {"forall": str(all(values)).lower(), "exists": str(any(values)).lower(), "count": Fraction(sum(values))}[name]
        finite = [value for value in values if value != INFINITE]
        if name == "range":
            most = max(finite) if len(finite) == len(values) else INFINITE
            return Span(min(finite) if finite else INFINITE, most)
        if name in ("first", "argmin", "argmax"):
            return self.of_places(name, states)(values)
        if name == "min":
            return min(finite) if finite else INFINITE
        if len(finite) < len(values):
            return INFINITE
        return {"max": max, "sum": sum, "avg": lambda all: sum(all) / len(all)}[name](finite)

    def of_places(self, name, states):
        """Of values in states: that of the first state, as the variables' values are compared; whether the initial state has the
        least or the greatest."""
        if name == "first":
            key = lambda state: tuple(int(value) for value in self.valuations()[state])
            return lambda values: values[min(range(len(states)), key=lambda place: key(states[place]))]
        best = min if name == "argmin" else max
        order = lambda value: (value == INFINITE, 0 if value == INFINITE else value)

        def holds(values):
            extreme = order(best(values, key=order))
            attained = {state for state, value in zip(states, values) if order(value) == extreme}
            return str(attained.issuperset(self.initial)).lower()
        return holds

    def valuations(self):
        """The values of the variables in the order of the text, in each state."""
        program, values = self.program, self.model.state_valuations
        numbers, truths = list(program.global_integer_variables), list(program.global_boolean_variables)
        for module in program.modules:
            numbers += module.integer_variables
            truths += module.boolean_variables
        read = [(v.name, v.expression_variable, values.get_int64_value) for v in numbers]
        read += [(v.name, v.expression_variable, values.get_boolean_value) for v in truths]
        # Globals come first, then the modules' variables: x0, on, x1 and so on, and those of the copy.
        place = {"g": 0, "x0": 1, "on": 2, "x1": 3, "x2": 4, "y0": 5, "ony": 6}
        read.sort(key=lambda item: place[item[0]])
        return [[int(of(state, variable)) for _, variable, of in read] for state in range(self.model.nr_states)]

    def of_starts(self, question):
        values = self.values(question.oracle)
        values = [values[state] for state in self.initial]
        order = lambda value: (value == INFINITE, 0 if value == INFINITE else value)
        return Span(min(values, key=order), max(values, key=order))

    def of_paths(self, question):
        """By the fixpoints of computation tree logic; `A` is the contrary of `E` of the contrary."""
        quantifier, shape, first, last = question.oracle
        count = self.model.nr_states
        everywhere = set(range(count))
        after = [{entry.column for action in state.actions for entry in action.transitions} for state in self.model.states]
        of = lambda name: {"true": everywhere, "false": set()}.get(name) if name in ("true", "false") else set(self.states(name))
        left, right = of(first), of(last)
        if shape == "wait":
            # `a W b` is `b R (a | b)`.
            shape, left, right = "release", right, left | right
        if quantifier == "A":
            shape = {"until": "release", "release": "until", "next": "next"}[shape]
            left, right = everywhere - left, everywhere - right
        before = lambda states: {state for state in everywhere if after[state] & states}
        if shape == "next":
            found = before(right)
        else:
            found = set() if shape == "until" else everywhere
            while True:
                more = right | (left & before(found)) if shape == "until" else right & (left | before(found))
                if more == found:
                    break
                found = more
        return str((self.initial[0] in found) != (quantifier == "A")).lower()

    def of_sum(self, question):
        texts, join = question.oracle
        return join(*(number(self.check(text).get_value(self.initial[0])) for text in texts))

    def of_optimum(self, question):
        value = self.of_value(question)
        if isinstance(value, Fraction):
            return Near(value, OPTIMUM_ERROR * max(1, abs(value)))
        return value

    def matrix(self):
        """Each state's row: probabilities of a chain, rates in continuous time."""
        return [[(entry.column, Fraction(str(entry.value))) for entry in state.actions[0].transitions] for state in self.model.states]

    def reward_of_visits(self, name):
        """State rewards and, apart, those of transitions in the mean."""
        model, count = self.model.reward_models[name], self.model.nr_states
        of = lambda has, rewards: [Fraction(str(value)) for value in rewards()] if has else [Fraction(0)] * count
        return (of(model.has_state_rewards, lambda: model.state_rewards),
                of(model.has_state_action_rewards, lambda: model.state_action_rewards))

    def of_timed(self, question):
        parts = question.oracle
        if parts[0] in ("cumulative", "instantaneous"):
            return Near(self.reward_in_time(*parts), TIMED_ERROR)
        shape, first, last, low, high = parts
        everywhere = set(range(self.model.nr_states))
        through = everywhere if first is None else set(self.states(first))
        goal = set(self.states(last))
        if shape == "always":
            return Near(1 - self.until(everywhere, everywhere - goal, low, high, None), TIMED_ERROR)
        after = None if high else [float(value) for value in self.values(f"P=? [ {first or 'true'} U {last} ]")]
        return Near(self.until(through, goal, low, high, after), TIMED_ERROR)

    def generator(self, frozen):
        """The generator of the chain whose `frozen` states are never left."""
        size = self.model.nr_states
        rates = numpy.zeros((size, size))
        for state, row in enumerate(self.matrix()):
            if state not in frozen:
                for column, rate in row:
                    rates[state, column] += float(rate)
        return rates - numpy.diag(rates.sum(axis=1))

    def until(self, through, goal, low, high, after):
        """`through U[low,high] goal` from the initial state; `after` are the values without an upper bound."""
        size = self.model.nr_states
        everywhere = set(range(size))
        if after is None:
            rest = float(Fraction(high) - Fraction(low))
            after = scipy.linalg.expm(self.generator((everywhere - through) | goal) * rest) @ [float(s in goal) for s in everywhere]
        if not low:
            return after[self.initial[0]]
        kept = [after[state] if state in through else 0.0 for state in everywhere]
        return (scipy.linalg.expm(self.generator(everywhere - through) * float(Fraction(low))) @ kept)[self.initial[0]]

    def reward_in_time(self, shape, name, time):
        of_states, of_transitions = self.reward_of_visits(name)
        time, size = float(Fraction(time)), self.model.nr_states
        if shape == "instantaneous":
            return (scipy.linalg.expm(self.generator(set()) * time) @ [float(r) for r in of_states])[self.initial[0]]
        exits = [sum(rate for _, rate in row) for row in self.matrix()]
        rewards = [float(r + leave * more) for r, leave, more in zip(of_states, exits, of_transitions)]
        # The integral stands in the last column of the exponential.
        whole = numpy.zeros((size + 1, size + 1))
        whole[:size, :size], whole[:size, size] = self.generator(set()), rewards
        return scipy.linalg.expm(whole * time)[self.initial[0], size]

    def of_cosafe(self, question):
        """The product with an automaton of three states, which has seen nothing, half or all of the sequence."""
        order, first, second, name = question.oracle
        seen = [set(self.states(first)), set(self.states(second))]

        def read(done, state):
            a, b = (state in states for states in seen)
            if order == "both":
                return done | frozenset({0} if a else ()) | frozenset({1} if b else ())
            if order == "then":
                done = done | frozenset({0} if a else ())
                return done | frozenset({1} if b and 0 in done else ())
            return frozenset({0, 1} if 0 in done and b else {0} if a else ())

        rows, start = self.matrix(), (self.initial[0], read(frozenset(), self.initial[0]))
        is_done = lambda node: len(node[1]) == 2
        edges, todo = {}, [start]
        while todo:
            node = todo.pop()
            if node not in edges:
                edges[node] = [] if is_done(node) else [((to, read(node[1], to)), p) for to, p in rows[node[0]]]
                todo += [to for to, _ in edges[node]]
        ends = {node for node in edges if is_done(node)}
        grows = True
        while grows:
            more = {node for node in edges if node not in ends and any(to in ends for to, _ in edges[node])}
            ends, grows = ends | more, bool(more)
        if len(ends) < len(edges):
            return INFINITE
        nodes = [node for node in edges if not is_done(node)]
        if len(nodes) > MOST_STATES:
            return None
        of_states, of_transitions = self.reward_of_visits(name)
        place = {node: i for i, node in enumerate(nodes)}
        equations = []
        for node in nodes:
            row = [Fraction(0)] * len(nodes) + [of_states[node[0]] + of_transitions[node[0]]]
            row[place[node]] += 1
            for to, p in edges[node]:
                if to in place:
                    row[place[to]] -= p
            equations.append(row)
        return solved(equations)[place[start]] if start in place else Fraction(0)


def solved(rows):
    """The solution of equations whose right side is the last column, by elimination."""
    for i in range(len(rows)):
        pivot = next(j for j in range(i, len(rows)) if rows[j][i])
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for j, row in enumerate(rows):
            if j != i and row[i]:
                rows[j] = [x - row[i] * y for x, y in zip(row, rows[i])]
    return [row[-1] for row in rows]
