"""Studies: opened, planned, run with a callback, shown as data frames."""

import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import textwrap

import pytest

import corroborate
from corroborate import Study

DOCKING = pathlib.Path(__file__).parents[2] / "corroborate/templates/docking"
HANDOVER = pathlib.Path(__file__).parents[3] / "case-studies/handover"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    copy = tmp_path_factory.mktemp("study") / "docking"
    shutil.copytree(DOCKING, copy)
    return copy


@pytest.fixture(scope="module")
def result(folder):
    return Study(folder).run()


def test_a_study_says_what_it_asks(folder):
    study = Study(folder)
    assert study.title and study.evidence == ["E1", "E2"]
    assert study.requirements["1"].threshold == 0.9 and study.requirements["1"].direction == "at-least"


def test_a_run_tells_how_it_goes_and_a_plan_what_is_left(folder, tmp_path):
    study = Study(folder, out=tmp_path / "results")
    assert {it.freshness for it in study.plan()} == {"not-produced"}
    events = []
    found = study.run(progress=events.append)
    assert events and {"started", "advanced", "finished"} >= {it["event"] for it in events if "stage" in it}
    assert {it.freshness for it in study.plan()} == {"fresh"}
    # Pairs are tuples here.
    assert json.loads(json.dumps(found.data)) == json.loads((tmp_path / "results/study.json").read_text())
    assert (tmp_path / "results/report.html").read_text() == found.html()
    assert study.result().data == found.data


def test_conclusions(result):
    assert result.conclusions["1"].verdict == "satisfied" and result.conclusions["1"].statement
    assert result.exit_code in (0, 1, 3) and "Requirement" in result.summary()
    assert "satisfied" in result._repr_html_()


def test_evidence_is_a_data_frame_without_a_copy(result):
    table = result.evidence
    rows = {(row["evidence"], row["subject"]): row for row in table.rows()}
    counted = rows["E2", "1"]
    assert (counted["count"], counted["trials"], counted["technique"], counted["guarantee"]) == (96, 100, "experiment", "statistical")
    computed = rows["E1", "1"]
    assert computed["trials"] is None and computed["guarantee"] == "bounded" and computed["low"] <= computed["estimate"] <= computed["high"]
    assert rows["E1", "2"]["estimate"] is None and rows["E1", "2"]["reason"]


def test_polars_takes_it_over(result):
    polars = pytest.importorskip("polars")
    frame = result.evidence.to_polars()
    assert frame.columns == result.evidence.columns and len(frame) == len(result.evidence)
    for name in frame.columns:
        assert frame[name].to_list() == result.evidence[name]
    assert result.comparisons.to_polars().schema["independent"] == polars.Boolean


def test_pyarrow_takes_it_over_and_lets_it_go(result):
    pyarrow = pytest.importorskip("pyarrow")
    for table in (result.evidence, result.comparisons):
        taken = pyarrow.table(table)
        taken.validate(full=True)
        assert taken.to_pylist() == table.rows()
        assert pyarrow.schema(table) == taken.schema
    # The memory outlives what it came from.
    taken = pyarrow.table(result.evidence)
    assert taken.column("evidence").to_pylist() == result.evidence["evidence"]
    for _ in range(2000):
        pyarrow.table(result.evidence)
        result.evidence.__arrow_c_stream__()
        result.evidence.__arrow_c_schema__()
    assert taken.to_pylist() == result.evidence.rows()


def test_pandas_has_it(result):
    pytest.importorskip("pandas")
    frame = result.evidence.to_pandas()
    assert frame.loc[frame.evidence == "E2", "trials"].iloc[0] == 100


def test_evidence_is_produced_by_itself(folder, tmp_path):
    (model,) = Study(folder, out=tmp_path / "some").produce("E1")
    assert model.id == "E1" and model.headline and model.data["technique"] == "model-checking"
    with pytest.raises(corroborate.Problem):
        Study(folder, out=tmp_path / "some").produce()
    with pytest.raises(corroborate.Problem) as caught:
        Study(folder, out=tmp_path / "some").result()
    assert caught.value.code == "not-run"


def test_comparisons(folder, result):
    rows = [row for row in result.comparisons.rows() if row["subject"] == "1"]
    assert [(row["left"], row["right"], row["outcome"]) for row in rows] == [("E1", "E2", "corroborates")]
    found = Study(folder).compare("E1")
    assert found[0]["outcome"] == "corroborates"
    with pytest.raises(corroborate.Problem) as caught:
        Study(folder).compare("E9")
    assert caught.value.code == "unknown-evidence"


def test_a_study_is_packed_as_by_the_command(folder, result, tmp_path):
    (tmp_path / "sbom.json").write_text('{"bomFormat": "CycloneDX", "specVersion": "1.5", "components": []}')
    key, events = tmp_path / "key.pem", []
    subprocess.run([sys.executable, "-m", "corroborate", "pack", "--new-key", str(key)], check=True, capture_output=True)
    packed = Study(folder).pack(tmp_path / "a.zip", key=key, sboms=[tmp_path / "sbom.json"], progress=events.append)
    assert packed.file == tmp_path / "a.zip" and packed.bytes == packed.file.stat().st_size
    assert hashlib.sha256(packed.file.read_bytes()).hexdigest() == packed.sha256
    assert packed.parts > 10 and packed.signed_by and packed.not_shown and all(words for _, words in packed.not_shown)
    by_command = [str(folder), "--to", str(tmp_path / "b.zip"), "--key", str(key), "--sbom", str(tmp_path / "sbom.json")]
    subprocess.run([sys.executable, "-m", "corroborate", "pack", *by_command], check=True, capture_output=True)
    assert (tmp_path / "b.zip").read_bytes() == packed.file.read_bytes()
    verify = [sys.executable, "-m", "corroborate", "verify", str(packed.file), "--key", str(tmp_path / "key.pub.pem")]
    assert subprocess.run(verify, capture_output=True).returncode == 0
    # By default beside the results, and unsigned.
    unsigned = Study(folder).pack()
    assert unsigned.file == folder / "results/evidence-pack.zip" and unsigned.signed_by is None
    for wrong, code in [({"to": tmp_path / "sbom.json"}, "pack-over-file"), ({"key": 3}, "wrong-argument"), ({"sboms": "a"}, "wrong-argument")]:
        with pytest.raises(corroborate.Problem) as caught:
            Study(folder).pack(**wrong)
        assert caught.value.code == code and caught.value.remedy
    with pytest.raises(corroborate.Problem) as caught:
        Study(folder, out=tmp_path / "none").pack()
    assert caught.value.code == "not-run"


def test_a_forest_plot_is_one_call(result):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = result.forest_plot()
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert "1: E2 96/100" in labels and len(labels) == 3
    one = result.forest_plot(subject="1")
    assert len(one.get_yticklabels()) == 2
    with pytest.raises(corroborate.Problem):
        result.forest_plot(subject="none")


def test_mistakes_of_a_study_are_placed(folder, tmp_path):
    copy = tmp_path / "wrong"
    shutil.copytree(DOCKING, copy)
    text = (copy / "ledger.toml").read_text().splitlines()
    (copy / "ledger.toml").write_text("\n".join(["techniqe = 1", *text]) + "\n")
    with pytest.raises(corroborate.Problem) as caught:
        Study(copy)
    assert caught.value.path.endswith("ledger.toml") and caught.value.line == 1
    with pytest.raises(corroborate.Problem) as caught:
        Study(tmp_path / "nowhere")
    assert caught.value.code == "no-study"
    with pytest.raises(corroborate.Problem) as caught:
        Study(folder, out=tmp_path / "none").result()
    assert caught.value.code == "not-run"


def test_what_a_callback_raises_ends_the_run(folder, tmp_path):
    def stop(event):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        Study(folder, out=tmp_path / "stopped").run(progress=stop)
    assert Study(folder, out=tmp_path / "stopped").run().conclusions["1"].verdict == "satisfied"


INTERRUPTED = """
    import corroborate, os, pathlib, signal, sys
    study = corroborate.Study(sys.argv[1], out=sys.argv[2])
    begun = []
    def progress(event):
        if event["event"] == "advanced" and not begun:
            begun.append(event)
            os.kill(os.getpid(), signal.SIGINT)
    try:
        study.produce("E2", progress=progress)
        print("finished")
    except KeyboardInterrupt:
        print("interrupted", len(begun))
"""


def test_ctrl_c_ends_a_simulation_and_what_is_finished_is_kept(tmp_path):
    from corroborate._surroundings import physics_library

    if physics_library() is None:
        pytest.skip("no physics library: nothing can be simulated")
    out = tmp_path / "results"
    command = [sys.executable, "-c", textwrap.dedent(INTERRUPTED), str(HANDOVER), str(out)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout.strip() == "interrupted 1", done.stderr


def test_shards_merge_to_what_one_machine_gives(tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(pathlib.Path(__file__).parents[3] / "conformance/command", folder)
    whole = Study(folder, trust=True).run()
    study = Study(folder, out=tmp_path / "merged", trust=True)
    for part in (1, 2):
        report = study.shard(part, 2, tmp_path / f"part-{part}")
        assert [it["episodes"] for it in report["campaigns"]] == [20]
    assert list(study.merge(tmp_path / "part-2")["campaigns"][0]["missing"]) == [1, 20]
    merged = study.merge(tmp_path / "part-2", tmp_path / "part-1")
    assert merged["campaigns"][0]["missing"] is None and merged["campaigns"][0]["taken"] == 40
    assert study.run().data["evidence"] == whole.data["evidence"]
    for shard, of in ((3, 2), (0, 2), (-1, 2), (1, 2**70)):
        with pytest.raises(corroborate.Problem) as raised:
            study.shard(shard, of, tmp_path / "other")
        assert raised.value.code in ("bad-shard", "wrong-argument") and raised.value.remedy
def test_programs_of_a_study_run_only_if_they_are_allowed(tmp_path, monkeypatch):
    monkeypatch.setenv("CORROBORATE_TRUST", "")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    copy = tmp_path / "study"
    shutil.copytree(DOCKING.parent / "command", copy)
    ledger = copy / "ledger.toml"
    ledger.write_text(ledger.read_text().replace("episodes = 60", "episodes = 2"))
    assert Study(copy).produce("M1")
    with pytest.raises(corroborate.Problem) as refused:
        Study(copy).run()
    assert refused.value.code == "not-trusted" and "ledger.toml" in str(refused.value)
    assert not (copy / "results/evidence/S1.json").exists()
    with pytest.raises(corroborate.Problem, match="trust"):
        Study(copy, trust="yes")
    assert Study(copy, trust=True).produce("S1")
    # What is fresh needs no program.
    assert Study(copy).produce("S1")
    ledger.write_text(ledger.read_text().replace("episodes = 2", "episodes = 3"))
    monkeypatch.setenv("CORROBORATE_TRUST", str(tmp_path))
    assert Study(copy).produce("S1")
