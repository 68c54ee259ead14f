"""The command that the package brings."""

import os
import subprocess
import sys


def command(*arguments, **environment):
    done = subprocess.run([sys.executable, "-m", "corroborate", *arguments], capture_output=True, text=True, env={**os.environ, **environment})
    return done.returncode, done.stdout, done.stderr


def test_it_is_the_program(tmp_path):
    model = tmp_path / "coin.prism"
    model.write_text("dtmc module m x:[0..2]; [] x=0 -> 0.5:(x'=1) + 0.5:(x'=2); endmodule")
    code, said, _ = command("check", str(model), "P=? [ F x=1 ]", "--format", "json")
    assert code == 0 and '"value": 0.5' in said


def test_exit_codes_and_messages_are_those_of_the_program(tmp_path):
    code, _, said = command("chek")
    assert code == 2 and "check" in said
    code, _, said = command("run", str(tmp_path))
    assert code == 2 and "error[no-study]" in said
    run = tmp_path / "run.csv"
    run.write_text("time_secs,/robot.speed [m/s]\n0.0,0.9\n")
    assert command("monitor", "--formula", "always (/robot.speed < 250 mm/s)", str(run))[0] == 1


def test_the_physics_library_of_an_installed_package_is_found(tmp_path):
    package = tmp_path / "mujoco"
    package.mkdir()
    (package / "__init__.py").write_text("raise ImportError('not to be imported')\n")
    (package / "libmujoco.so.3.17.0").write_bytes(b"")
    asked = "from corroborate._surroundings import physics_library; print(physics_library())"
    environment = {key: value for key, value in os.environ.items() if key != "CORROBORATE_MUJOCO"}
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))

    def found(**more):
        done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, env={**environment, "PYTHONPATH": path, **more})
        return done.stdout.strip()

    assert found() == str(package / "libmujoco.so.3.17.0")
    assert found(CORROBORATE_MUJOCO="/elsewhere.so") == "/elsewhere.so"
    assert found(CORROBORATE_MUJOCO="") == "None"
