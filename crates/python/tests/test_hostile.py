"""Whatever an argument is, a public function either answers or raises `Problem`: nothing else, no panic, no endless work.

Every parameter of every public callable is given each of the values below in turn, the others being as they should. New
callables are found by themselves: one without a call in `CALLS` fails the last test.
"""

import fractions
import inspect
import pathlib
import pickle
import shutil

import numpy
import pytest

import corroborate
from corroborate import rig, stats

DOCKING = pathlib.Path(__file__).parents[2] / "corroborate/templates/docking"

VALUES = [
    None,
    True,
    1,
    -1,
    0.5,
    2**53 + 1,
    2**63,
    2**64 - 1,
    2**64,
    10**400,
    10**5000,
    float("nan"),
    float("inf"),
    -float("inf"),
    1e308,
    1j,
    "",
    "x",
    "a\0b",
    "\ud800",
    "1e999999999",
    b"bytes",
    [],
    (),
    {},
    [None],
    ["\ud800"],
    {1: 2},
    {"x": 1},
    {"\ud800": "\ud800"},
    {"x": "1e999999999"},
    {"x": [1, 2]},
    [[1, 2], [3]],
    [1, 2, 3],
    (1, 2**64),
    (10**400, 1),
    object(),
    object,
    len,
    fractions.Fraction(1, 3),
    pathlib.Path("no such file"),
    numpy.float64(0.5),
    numpy.int64(7),
    numpy.array(3),
    numpy.zeros((2, 2)),
    numpy.zeros(2, dtype=complex),
    numpy.array(["a", "b"]),
    numpy.array([None, object()]),
    numpy.array([10**400], dtype=object),
    numpy.array(["2020-01-01"], dtype="datetime64[s]"),
]

DTMC = "dtmc const double x; module m s:[0..2]; [] s=0 -> x:(s'=1) + 1-x:(s'=2); endmodule"
MDP = "mdp module m s:[0..2]; [] s=0 -> (s'=1); [] s=0 -> (s'=2); endmodule"


class Cart:
    signals = {"/cart.gap": "m"}

    def reset(self, seed, stimulus):
        self.time = 0.0

    def step(self):
        self.time += 1.0
        return (self.time, (1.0,)) if self.time < 3 else None


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """Something of each kind."""
    folder = tmp_path_factory.mktemp("hostile") / "docking"
    shutil.copytree(DOCKING, folder)
    recording = folder.parent / "run.csv"
    recording.write_text("time_secs,/robot.speed [m/s]\n0,0.5\n1,0.6\n")
    study = corroborate.Study(folder)
    model = corroborate.Model.parse(DTMC)
    formula = corroborate.Formula("always (speed < 1)")
    return {
        "folder": folder,
        "recording": recording,
        "study": study,
        "result": study.run(),
        "model": model,
        "choices": corroborate.Model.parse(MDP),
        "space": model.build(constants={"x": 0.5}),
        "answer": model.check("P=? [ F s=1 ]", constants={"x": 0.5}),
        "parametric": model.check("P=? [ F s=1 ]", open={"x": (0.1, 0.9)}).parametric,
        "formula": formula,
        "out": folder.parent / "out",
    }


HALF = {"x": 0.5}
# How each is called: what makes it, its arguments by position, and by name.
CALLS = {
    "Model.parse": lambda it: (corroborate.Model.parse, [DTMC], {}),
    "Model.load": lambda it: (corroborate.Model.load, [it["folder"] / "none.prism"], {}),
    "Model.from_stormvogel": lambda it: (corroborate.Model.from_stormvogel, [None], {}),
    "Model.to_stormvogel": lambda it: (it["model"].to_stormvogel, [], {"constants": HALF}),
    "Model.check": lambda it: (it["model"].check, ["P=? [ F s=1 ]"], {"constants": HALF}),
    "Model.scheduler": lambda it: (it["choices"].scheduler, ["Pmax=? [ F s=1 ]"], {}),
    "Model.build": lambda it: (it["model"].build, [], {"constants": HALF}),
    "StateSpace": lambda it: (corroborate.StateSpace, [it["space"]._space], {}),
    "StateSpace.label": lambda it: (it["space"].label, ["init"], {}),
    "StateSpace.describe": lambda it: (it["space"].describe, [0], {}),
    "StateSpace.path": lambda it: (it["space"].path, [], {"seed": 1}),
    "StateSpace.to_stormvogel": lambda it: (it["space"].to_stormvogel, [], {}),
    "Formula": lambda it: (corroborate.Formula, ["always (speed < 1)"], {}),
    "Formula.judge": lambda it: (it["formula"].judge, [[0.0, 1.0]], {"speed": [0.5, 0.6]}),
    "Formula.start": lambda it: (it["formula"].start, [["speed"]], {}),
    "Formula.judge_recordings": lambda it: (
        corroborate.Formula("always (/robot.speed < 1)").judge_recordings,
        [it["recording"]],
        {},
    ),
    "Monitor": lambda it: (corroborate.Monitor, [it["formula"], ["speed"]], {}),
    "Monitor.step": lambda it: (it["formula"].start(["speed"]).step, [0.0], {"speed": 0.5}),
    "Monitor.finish": lambda it: (it["formula"].start(["speed"]).finish, [], {}),
    "monitor": lambda it: (corroborate.monitor, [it["recording"]], {"formulas": ["always (/robot.speed < 1)"]}),
    "Study": lambda it: (corroborate.Study, [it["folder"]], {}),
    "Study.plan": lambda it: (it["study"].plan, [], {}),
    "Study.run": lambda it: (it["study"].run, [], {}),
    "Study.produce": lambda it: (it["study"].produce, ["E1"], {}),
    "Study.shard": lambda it: (it["study"].shard, [1, 2, it["out"]], {}),
    "Study.merge": lambda it: (it["study"].merge, [it["out"]], {}),
    "Study.result": lambda it: (it["study"].result, [], {}),
    "Study.compare": lambda it: (it["study"].compare, ["E1", "E2"], {}),
    "Study.replay": lambda it: (it["study"].replay, ["E2:1"], {}),
    "Study.pack": lambda it: (it["study"].pack, [], {"pdf": it["folder"] / "none.pdf"}),
    "StudyResult": lambda it: (corroborate.StudyResult, [it["result"]._outcome, it["folder"]], {}),
    "StudyResult.episodes": lambda it: (it["result"].episodes, ["E2"], {}),
    "StudyResult.summary": lambda it: (it["result"].summary, [], {}),
    "StudyResult.html": lambda it: (it["result"].html, [], {}),
    "StudyResult.forest_plot": lambda it: (it["result"].forest_plot, [], {}),
    "Table": lambda it: (corroborate.Table, [it["result"].evidence._table], {}),
    "Table.__getitem__": lambda it: (it["result"].evidence.__getitem__, ["evidence"], {}),
    "Table.rows": lambda it: (it["result"].evidence.rows, [], {}),
    "Table.to_pandas": lambda it: (it["result"].evidence.to_pandas, [], {}),
    "Table.to_polars": lambda it: (it["result"].evidence.to_polars, [], {}),
    "Table.to_pyarrow": lambda it: (it["result"].evidence.to_pyarrow, [], {}),
    "Answer.__ge__": lambda it: (it["answer"].__ge__, [0.1], {}),
    "Answer.__lt__": lambda it: (it["answer"].__lt__, [0.1], {}),
    "Answer.__eq__": lambda it: (it["answer"].__eq__, [0.1], {}),
    "Parametric": lambda it: (it["parametric"], [], HALF),
    "RationalFunction": lambda it: (it["parametric"].parts[0].function, [], HALF),
    "requirement": lambda it: (corroborate.requirement, ["REQ-1"], {}),
    "rig.episode": lambda it: (rig.episode, [Cart, rig.Stimulus(1, "drive")], {}),
    "rig.of_gymnasium": lambda it: (rig.of_gymnasium, [lambda: None], {"step_secs": 0.1}),
    "stats.rate": lambda it: (stats.rate, [88, 100], {}),
    "stats.test_rate": lambda it: (stats.test_rate, [88, 100], {"threshold": 0.9}),
    "stats.difference": lambda it: (stats.difference, [(80, 100), (88, 100)], {}),
    "stats.equivalence": lambda it: (stats.equivalence, [(80, 100), (88, 100)], {"margin": 0.1}),
    "stats.Equivalence.shown": lambda it: (stats.equivalence((8, 10), (8, 10), margin=0.1).shown, [], {}),
    "stats.clusters_of": lambda it: (stats.clusters_of, [[True, False], ["a", "b"]], {}),
    "stats.clustered_rate": lambda it: (stats.clustered_rate, [[(9, 10), (2, 10)]], {}),
    "stats.clustering": lambda it: (stats.clustering, [[(9, 10), (2, 10)]], {}),
    "stats.confidence_sequence": lambda it: (stats.confidence_sequence, [88, 100], {}),
    "stats.RunningRate": lambda it: (stats.RunningRate, [], {}),
    "stats.RunningRate.observe": lambda it: (stats.RunningRate().observe, [True], {}),
    "stats.decide": lambda it: (stats.decide, [88, 100], {"threshold": 0.9}),
    "stats.continued_rate": lambda it: (stats.continued_rate, [[(9, 10), (19, 20)]], {}),
    "stats.trials_per_arm": lambda it: (stats.trials_per_arm, [(0.9, 0.8)], {}),
    "stats.power": lambda it: (stats.power, [(0.9, 0.8), (100, 100)], {}),
    "stats.paired": lambda it: (stats.paired, [[True, False], [True, True]], {}),
    "stats.holm": lambda it: (stats.holm, [[0.01, 0.04]], {}),
    "stats.heterogeneity": lambda it: (stats.heterogeneity, [[(9, 10), (2, 10)]], {}),
}


# What these raise is raised as it is.
CALLBACKS = ("progress", "rig", "make", "policy")


def variants(call, positional, named):
    """The calls in which one argument is one of the values."""
    for parameter in inspect.signature(call).parameters.values():
        place = list(inspect.signature(call).parameters).index(parameter.name)
        for value in VALUES:
            if parameter.name in CALLBACKS and callable(value):
                continue
            if parameter.kind is parameter.VAR_POSITIONAL:
                yield parameter.name, value, [value, *positional[1:]], named
            elif parameter.kind is parameter.VAR_KEYWORD:
                for name in named or ["speed"]:
                    yield name, value, positional, {**named, name: value}
            elif parameter.kind is parameter.KEYWORD_ONLY:
                yield parameter.name, value, positional, {**named, parameter.name: value}
            else:
                given = [*positional, *([None] * (place + 1 - len(positional)))]
                given[place] = value
                yield parameter.name, value, given, named


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_every_argument_gives_an_answer_or_a_problem(name, known):
    call, positional, named = CALLS[name](known)
    wrong = []
    for parameter, value, arguments, names in variants(call, positional, named):
        # A stream or a running rate is another thing after each call.
        fresh = CALLS[name](known)[0]
        try:
            fresh(*arguments, **names)
        except corroborate.Problem as problem:
            str(problem)
            assert problem.code and problem.message
            if problem.code == "wrong-argument" and not problem.remedy:
                wrong.append(f"{parameter}={value!r:.40}: no remedy: {problem.message}")
            pickle.loads(pickle.dumps(problem))
        except BaseException as error:
            wrong.append(f"{parameter}={ascii(value) if isinstance(value, str) else type(value)}: {type(error).__name__}: {ascii(error)[:150]}")
    assert not wrong, "\n".join(wrong)


# Results and types, which nobody but the package makes, and a program's main function.
MADE_BY_THE_PACKAGE = {
    "Answer", "InternalError", "Problem", "Scheduler", "UnknownColumn", "Verdict", "WrongArgument", "rig", "stats", "rig.Rig", "rig.Sample",
    "rig.Stimulus", "rig.serve", "stats.ClusteredRate", "stats.Clustering", "stats.Counts", "stats.Difference", "stats.Equivalence",
    "stats.Heterogeneity", "stats.Paired", "stats.Rate", "stats.RateTest",
}  # fmt: skip


def public():
    for module, prefix in [(corroborate, ""), (rig, "rig."), (stats, "stats.")]:
        for name in module.__all__:
            yield prefix + name, getattr(module, name)


def test_every_public_callable_is_called_here():
    missing = []
    for name, it in public():
        if name in MADE_BY_THE_PACKAGE:
            continue
        if not inspect.isclass(it):
            missing += [name] if name not in CALLS else []
            continue
        if name != "Model":
            missing += [name] if name not in CALLS else []
        methods = [key for key, value in vars(it).items() if not key.startswith("_") and (callable(value) or isinstance(value, classmethod))]
        missing += [f"{name}.{key}" for key in methods if f"{name}.{key}" not in CALLS]
    assert not missing, missing
