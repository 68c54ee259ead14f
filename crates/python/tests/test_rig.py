"""A rig in Python is a rig like any other: a study runs it and judges what it leaves."""

import pathlib
import shutil
import subprocess
import sys

import pytest

import corroborate
from corroborate import Study, rig

TEMPLATE = pathlib.Path(__file__).parents[2] / "corroborate/templates/command"

CART = '''
from corroborate import rig


class Cart:
    """The template's cart, as a class."""

    signals = {"/cart.gap": "cm", "/cart.speed": "cm/s", "/cart.sees": ""}

    def reset(self, seed, stimulus):
        draws = stimulus.draws("cart")
        self.time, self.gap = 0.0, stimulus.number("cart.gap_cm")
        self.speed = stimulus.number("cart.speed_cm_per_s") * draws.uniform(0.8, 1.2)
        self.braking = stimulus.number("cart.braking_cm_per_s2") * (0.5 if draws.random() < 0.1 else 1.0)
        self.brakes = 1.0 + draws.uniform(0, 0.3)
        self.still = 0
        return self.sample()

    def sample(self):
        return self.time, (self.gap, self.speed, self.time >= 1.0)

    def step(self):
        if self.still > 50:
            return None
        self.time = round(self.time + 0.01, 2)
        if self.gap <= 0:
            self.speed = 0.0
        elif self.time >= self.brakes:
            self.speed = max(0.0, self.speed - self.braking * 0.01)
        self.still += self.speed == 0.0
        self.gap -= self.speed * 0.01
        return self.sample()


if __name__ == "__main__":
    rig.serve(Cart)
'''


def stimulus(seed, **settings):
    return rig.Stimulus(seed, "straight on", (), settings)


def test_a_study_runs_it(tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(TEMPLATE, folder)
    ledger = (folder / "ledger.toml").read_text()
    program = f'command = ["{sys.executable}", "cart.py"]\npersistent = true'
    ledger = ledger.replace('command = ["python3", "simulate.py", "{stimulus}", "{seed}", "{recording}"]', program)
    (folder / "ledger.toml").write_text(ledger.replace("episodes = 60", "episodes = 12"))
    (folder / "cart.py").write_text(CART)
    # The signals have the names of the study's: nothing has to be mapped.
    (folder / "topics.toml").unlink()
    with pytest.raises(corroborate.Problem) as caught:
        Study(folder).produce("S1")
    assert caught.value.code == "not-trusted"
    study = Study(folder, trust=True)
    (found,) = study.produce("S1")
    measure = {it["subject"]["id"]: it["measure"] for it in found.data["findings"]}["stopping"]
    assert measure["trials"] == 12 and measure["count"] > 0
    # Again from nothing: the same bytes.
    again = Study(folder, out=tmp_path / "again", trust=True).produce("S1")[0]
    assert again.data["findings"] == found.data["findings"]


def test_it_is_explored_shrunk_and_calibrated(tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(TEMPLATE, folder)
    program = f'command = ["{sys.executable}", "cart.py"]\npersistent = true'
    ledger = (folder / "ledger.toml").read_text()
    ledger = ledger.replace('command = ["python3", "simulate.py", "{stimulus}", "{seed}", "{recording}"]', program)
    (folder / "ledger.toml").write_text(ledger.replace("episodes = 60", "episodes = 12"))
    (folder / "cart.py").write_text(CART)
    (folder / "topics.toml").unlink()
    parameter = '[[parameter]]\nname = "braking"\nsets = ["cart.braking_cm_per_s2"]\nuniform = [20.0, 120.0]\n'
    (folder / "exploration.toml").write_text(f'evidence = "S1"\n[budget]\nepisodes = 20\nbatch = 10\n{parameter}')
    fit = 'simulator = "S1"\ntest = "straight on"\nevidence = "T1"\nfit = ["clear"]\nrounds = 2\nepisodes_per_round = 8\ncheck_episodes = 4\n'
    (folder / "calibration.toml").write_text(f'name = "fitted"\n{fit}{parameter}')

    def command(*arguments):
        done = subprocess.run([sys.executable, "-m", "corroborate", "--trust", *arguments], capture_output=True, text=True, cwd=folder)
        assert done.returncode in (0, 1, 3), done.stderr
        return done.stdout

    command("explore", ".", "exploration.toml")
    findings = folder / "results/exploration/findings"
    assert "requirement" in command("shrink", ".", str(findings / "violated-clear.toml"))
    command("calibrate", ".", "calibration.toml", "--to", "fitted.toml")
    assert "cart.py" in (folder / "fitted.toml").read_text()


def test_an_episode_is_its_seed(tmp_path):
    names = {"__name__": "cart"}
    exec(CART, names)
    settings = {"cart.gap_cm": 450, "cart.speed_cm_per_s": 150, "cart.braking_cm_per_s2": 60}
    one, same, other = (rig.episode(names["Cart"], stimulus(seed, **settings)).text() for seed in (1, 1, 2))
    assert one == same != other
    with pytest.raises(corroborate.Problem) as caught:
        rig.episode(names["Cart"], stimulus(1, **settings), most_steps=10)
    assert caught.value.code == "bad-rig"


def test_an_environment_of_gymnasium_works_as_it_is():
    gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed: no environment to serve")

    def leaning(observation):
        return int(observation[2] > 0)

    rigs = [rig.of_gymnasium(lambda: gymnasium.make("CartPole-v1"), policy, step_secs=0.02) for policy in (leaning, None)]
    for made in rigs:
        text = rig.episode(made, stimulus(5)).text()
        assert text == rig.episode(made, stimulus(5)).text() != rig.episode(made, stimulus(6)).text()
        header, first, *_, last = text.splitlines()
        assert header.startswith("time_secs,/observation.value_0") and first.endswith(",,,,") and ",true," in last
