"""Models: parsed, built, checked, and compared without surprises."""

import importlib.util
import sys
import types
from fractions import Fraction

import pytest

import corroborate

np = pytest.importorskip("numpy")

ROBOT = """dtmc
const double p;
module robot
  s : [0..2] init 0;
  up : bool init true;
  [] s=0 -> p:(s'=1) + 0.01:(s'=2)&(up'=false) + 0.99-p:(s'=0);
endmodule
label "grasped" = s=1;
rewards "tries" s=0 : 1; endrewards
"""

MDP = """mdp
module robot
  s : [0..2] init 0;
  [slow] s=0 -> 0.9:(s'=1) + 0.1:(s'=2);
  [fast] s=0 -> 0.6:(s'=1) + 0.4:(s'=2);
endmodule
"""


def stormvogel_or_skip():
    """stormvogel's models. Its package does not import before Python 3.12, so its module is loaded alone."""
    found = importlib.util.find_spec("stormvogel")
    if found is None:
        pytest.skip("stormvogel is not installed: no model to convert")
    if "stormvogel" not in sys.modules:
        package = types.ModuleType("stormvogel")
        package.__path__ = list(found.submodule_search_locations)
        sys.modules["stormvogel"] = package
    return importlib.import_module("stormvogel.model")


@pytest.fixture
def robot():
    return corroborate.Model.parse(ROBOT)


def test_what_a_model_declares(robot):
    assert (robot.kind, robot.modules, robot.labels, robot.rewards) == ("dtmc", ["robot"], ["grasped"], ["tries"])
    assert robot.constants["p"].type == "double" and robot.constants["p"].value is None


def test_an_answer_has_bounds_that_hold_and_a_guarantee(robot):
    exact = robot.check('P=? [ F "grasped" ]', constants={"p": 0.9}, method="exact")
    assert exact.value == Fraction(90, 91) and exact.guarantee == "exact" and exact.lower == exact.upper
    sound = robot.check('P=? [ F "grasped" ]', constants={"p": 0.9})
    assert sound.guarantee == "bounded" and Fraction(sound.lower) <= exact.value <= Fraction(sound.upper)
    assert float(sound) == pytest.approx(90 / 91)


def test_answers_compare_by_what_is_known(robot):
    answer = robot.check('P=? [ F "grasped" ]', constants={"p": 0.9}, precision=0.5)
    assert answer >= 0.9 and answer > 0.9 and not answer < 0.9 and not answer <= 0.9 and answer <= 1 and 1.0 >= answer
    if answer.lower < answer.upper:
        between = (answer.lower + answer.upper) / 2
        for compare in (lambda: answer >= between, lambda: answer == between, lambda: between > answer):
            with pytest.raises(corroborate.Problem) as caught:
                compare()
            assert caught.value.code == "undecided-comparison" and caught.value.kind == "undecided"
    estimate = robot.check('P=? [ F "grasped" ]', constants={"p": 0.9}, method="prism-default")
    assert estimate.guarantee == "estimated" and estimate.lower is None
    with pytest.raises(corroborate.Problem):
        assert estimate > 0.5


def test_an_answer_whose_bounds_straddle_a_number_refuses_to_compare():
    from corroborate import Answer

    answer = Answer("P=? [ F x=1 ]", 0.5, 0.4, 0.6, "bounded", "0.5", "sound")
    assert answer > 0.3 and answer >= 0.4 and answer <= 0.6 and answer < 0.7 and not answer == 0.7 and answer != 0.39
    assert not answer > 0.6 and not answer < 0.4
    for compare in (lambda: answer > 0.4, lambda: answer > 0.5, lambda: answer < 0.6, lambda: answer == 0.5):
        with pytest.raises(corroborate.Problem, match="between 0.4 and 0.6"):
            compare()
    assert np.float64(0.3) < answer
    with pytest.raises(TypeError, match="numbers"):
        assert answer > "0.3"
    with pytest.raises(TypeError, match="compare it"):
        assert answer
    assert len({answer, answer}) == 1


def test_floats_are_decimal_numbers_as_they_print(robot):
    answer = robot.check('P=? [ F s=1 ]', constants={"p": 0.99}, method="exact")
    assert answer == 0.99 and answer == Fraction(99, 100) and answer >= 0.99 and not answer > 0.99


def test_truth_values_are_truth_values(robot):
    assert robot.check('P>=0.9 [ F "grasped" ]', constants={"p": 0.9})
    assert not robot.check('P>=0.99 [ F "grasped" ]', constants={"p": 0.9})
    with pytest.raises(TypeError):
        float(robot.check('P>=0.9 [ F "grasped" ]', constants={"p": 0.9}))


def test_several_properties_and_ranges_of_constants(robot):
    answers = robot.check(['P=? [ F "grasped" ]', 'R{"tries"}=? [ C<=3 ]'], constants={"p": 0.9})
    assert [answer.property for answer in answers] == ['P=? [ F "grasped" ]', 'R{"tries"}=? [ C<=3 ]']
    ranged = robot.check('P=? [ F "grasped" ]', constants={"p": (0.5, 0.1, 0.9)}, method="exact")
    assert [it.constants["p"] for it in ranged] == [Fraction(k, 10) for k in range(5, 10)]
    assert [it.value for it in ranged] == [Fraction(k, 10) / (Fraction(k, 10) + Fraction(1, 100)) for k in range(5, 10)]


def test_parametric_answers_are_functions(robot):
    answer = robot.check('P=? [ F "grasped" ]', open={"p": (0.5, 0.9)})
    for p in (0.5, 0.75, 0.9):
        assert answer.parametric(p=p) == robot.check('P=? [ F "grasped" ]', constants={"p": p}, method="exact").value
    with pytest.raises(corroborate.Problem):
        answer.parametric(p=0.95)
    with pytest.raises(corroborate.Problem):
        answer.parametric.parts[0].function(q=0.5)


def test_a_scheduler_says_what_is_done():
    model = corroborate.Model.parse(MDP)
    best = model.scheduler("Pmax=? [ F s=1 ]")
    assert [(it.state, it.action) for it in best.decisions if it.state["s"] == 0] == [({"s": 0}, "slow")]
    worst = model.scheduler("Pmin=? [ F s=1 ]")
    assert [it.action for it in worst.decisions if it.state["s"] == 0] == ["fast"]


def test_states_are_arrays(robot):
    space = robot.build(constants={"p": 0.9})
    assert len(space) == 3 and space.initial == [0]
    assert space.valuations["s"].dtype == np.int64 and space.valuations["up"].dtype == np.bool_
    order = space.valuations["s"]
    dense = np.zeros((3, 3))
    for row in range(3):
        for entry in range(space.matrix.indptr[row], space.matrix.indptr[row + 1]):
            dense[order[row], order[space.matrix.indices[entry]]] = space.matrix.data[entry]
    assert np.allclose(dense, [[0.09, 0.9, 0.01], [0, 1, 0], [0, 0, 1]])
    assert space.label("grasped").tolist() == (order == 1).tolist()
    assert space.rewards["tries"].state.tolist() == (order == 0).astype(float).tolist()
    assert space.matrix.data is space.matrix.data
    with pytest.raises(ValueError):
        space.matrix.data[0] = 2
    with pytest.raises(corroborate.Problem, match="no label"):
        space.label("grapsed")


def test_choices_have_actions():
    space = corroborate.Model.parse(MDP).build()
    assert space.kind == "mdp" and space.choice_start.tolist() == [0, 2, 3, 4]
    assert sorted(filter(None, space.actions)) == ["fast", "slow"]


def test_paths_are_the_same_for_the_same_seed_and_are_drawn_from_the_chain(robot):
    space = robot.build(constants={"p": 0.9})
    again = space.path(seed=7)
    assert space.path(seed=7).states.tolist() == again.states.tolist()
    ends = [space.valuations["s"][space.path(seed=seed).states[-1]] for seed in range(500)]
    assert 0.95 < np.mean(np.array(ends) == 1) <= 1
    with pytest.raises(corroborate.Problem, match="choices"):
        corroborate.Model.parse(MDP).build().path(seed=1)


def test_scipy_takes_the_matrix(robot):
    pytest.importorskip("scipy.sparse")
    matrix = robot.build(constants={"p": 0.9}).matrix
    assert np.allclose(matrix.to_scipy().sum(axis=1), 1)
    assert np.shares_memory(matrix.to_scipy().data, matrix.data)


def test_files_are_read(tmp_path):
    path = tmp_path / "robot.prism"
    path.write_text(ROBOT)
    model = corroborate.Model.load(path)
    assert model.name == str(path) and model.check("P=? [ F s=1 ]", constants={"p": 0.5}) > 0.9
    (tmp_path / "robot.props").write_text('"one": P=? [ F s=1 ];\n"two": P=? [ F s=2 ];\n')
    answers = model.check(tmp_path / "robot.props", constants={"p": 0.5})
    assert [answer.name for answer in answers] == ["one", "two"]
    (tmp_path / "chain.tra").write_text("2 2\n0 1 1\n1 1 1\n")
    assert corroborate.Model.load(tmp_path / "chain.tra").check('P=? [ F "deadlock" ]') == 0


def test_a_limit_of_time_ends_the_work_with_what_there_is():
    sides = "".join(f"x{i}:[0..9]; " for i in range(8))
    steps = "".join(f"[] x{i}<9 -> (x{i}'=x{i}+1); " for i in range(8))
    large = corroborate.Model.parse(f"mdp module m {sides}{steps}endmodule")
    with pytest.raises(corroborate.Problem) as caught:
        large.check("Pmax=? [ F x0=9 ]", timeout=0.2)
    assert caught.value.code == "time-limit" and caught.value.kind == "undecided"
    with pytest.raises(corroborate.Problem) as caught:
        large.check("Pmax=? [ F x0=9 ]", max_states=1000)
    assert caught.value.remedy


def test_what_is_not_supported_says_so(robot):
    with pytest.raises(corroborate.Problem) as caught:
        corroborate.Model.parse("pta module m x:[0..1]; [] x=0 -> (x'=1); endmodule").check("P=? [ F x=1 ]")
    assert "pta" in str(caught.value)
    infinite = robot.check('R{"tries"}=? [ F s=2 ]', constants={"p": 0.9})
    assert infinite.value == float("inf") and infinite > 1e9


def test_unknown_settings_say_what_is_known(robot):
    with pytest.raises(corroborate.Problem, match="no method `guess`") as caught:
        robot.check("P=? [ F s=1 ]", constants={"p": 0.5}, method="guess")
    assert "sound" in caught.value.remedy
    with pytest.raises(corroborate.Problem):
        robot.check("P=? [ F s=1 ]", constants={"p": 0.5}, timeout=-1)
    with pytest.raises(corroborate.Problem):
        robot.check("P=? [ F s=1 ]", constants={"q": 0.5, "p": 0.5})
    with pytest.raises(corroborate.Problem):
        robot.check("P=? [ F s=1 ]", constants={"p": float("nan")})


def test_a_stormvogel_model_goes_in_and_out(robot):
    stormvogel = stormvogel_or_skip()
    die = stormvogel.new_dtmc("die")
    start = die.get_initial_state()
    start.add_valuation("rolled", 0)
    rolls = [die.new_state(labels=f"rolled{i}", valuations={"rolled": i}) for i in range(1, 7)]
    start.set_transitions([(Fraction(1, 6), roll) for roll in rolls])
    die.add_self_loops()
    ours = corroborate.Model.from_stormvogel(die)
    assert ours.check('P=? [ F "rolled3" ]', method="exact").value == Fraction(1, 6)
    assert ours.check("P=? [ F rolled>4 ]", method="exact").value == Fraction(1, 3)
    out = robot.to_stormvogel(constants={"p": 0.9})
    assert len(out.get_states()) == 3 and {"init", "grasped"} <= out.get_labels()
    again = corroborate.Model.from_stormvogel(out)
    assert float(again.check('P=? [ F "grasped" ]')) == pytest.approx(90 / 91)
    assert float(again.check('R{"tries"}=? [ C<=3 ]')) == pytest.approx(1 + 0.09 + 0.09**2)
    choices = corroborate.Model.from_stormvogel(corroborate.Model.parse(MDP).to_stormvogel())
    assert float(choices.check("Pmax=? [ F s=1 ]")) == pytest.approx(0.9)
