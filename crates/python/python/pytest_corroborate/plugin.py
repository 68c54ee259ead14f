"""The plugin: repeats marked tests, and reports each as one."""

import hashlib
import os
import re
import shutil
import tempfile
import time

import pytest
from _pytest.reports import TestReport
from _pytest.runner import runtestprotocol

from .judge import Judge, JudgeError, program
from .mistakes import mistake
from .shared import Trials

MARK = "corroborate_requirement"
SHARE = "corroborate_share"
# How often a share that has nothing to run looks whether the others are done.
LOOK_SECS = 0.05
# So many trials of which none ran: then none will.
SKIPPED_ALWAYS = 20


class TestError(Exception):
    """The test cannot be judged, since something is wrong with itself."""

    __test__ = False


class AlwaysSkipped(Exception):
    """No trial of the test runs."""


def pytest_addoption(parser):
    group = parser.getgroup("corroborate", "deciding flaky tests")
    group.addoption(
        "--corroborate-seed",
        type=int,
        metavar="SEED",
        help="run marked tests once, with this seed",
    )
    group.addoption(
        "--corroborate-out",
        metavar="FOLDER",
        help="keep for each marked test what `corroborate decide --out` keeps; requirements.csv has the counts of all",
    )
    group.addoption(
        "--corroborate-program", metavar="PATH", help="the program, if it is not on the PATH"
    )
    group.addoption(
        "--corroborate-undecided",
        choices=("fail", "skip"),
        default="fail",
        help="what an undecided test counts as (default: fail)",
    )


def pytest_configure(config):
    config.addinivalue_line(
        "markers",
        MARK + "(name, at_least, confidence, margin, max_trials, ...): repeat this test until its rate is decided",
    )
    config._corroborate_run = None
    if not hasattr(config, "workerinput"):
        config._corroborate_run = tempfile.mkdtemp(prefix="pytest-corroborate-")


def pytest_unconfigure(config):
    if getattr(config, "_corroborate_run", None):
        shutil.rmtree(config._corroborate_run, ignore_errors=True)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """The workers of xdist share a folder of the process that started them."""
    node.workerinput["corroborate_run"] = node.config._corroborate_run


@pytest.fixture
def corroborate_seed(request):
    """The seed of this trial, for fixtures that are called `seed` themselves; None in a test that is not of a requirement."""
    return getattr(request.node, "_corroborate_seed", None)


@pytest.fixture
def seed(corroborate_seed, request):
    """The seed of this trial."""
    if corroborate_seed is None:
        pytest.fail(
            "{}: `seed` is the seed of a trial, and this test is not repeated: mark it with "
            "@corroborate.requirement(\"REQ-7\"), or give it a fixture `seed` of your own".format(_place(request.node)),
            pytrace=False,
        )
    return corroborate_seed


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """Keeps what a trial raised, which a report has as a text alone."""
    outcome = yield
    if call.excinfo is not None and _mark(item) is not None:
        outcome.get_result().corroborate_raised = call.excinfo


def _place(item):
    """Where a test stands, as file:line, seen from where pytest was started."""
    path = os.path.relpath(str(item.path), str(item.config.invocation_params.dir))
    return "{}:{}".format(path, (item.location[1] or 0) + 1)


def _mark(item):
    return item.get_closest_marker(MARK)


def pytest_generate_tests(metafunc):
    """With xdist a marked test is several shares, so that several workers run its trials."""
    workers = int(getattr(metafunc.config, "workerinput", {}).get("workercount", 1))
    marks = list(metafunc.definition.iter_markers(MARK))
    if not marks or workers < 2 or metafunc.config.getoption("corroborate_seed") is not None:
        return
    metafunc.fixturenames.append(SHARE)
    # A worker is given two at a time.
    shares = list(range(2 * workers))
    metafunc.parametrize(SHARE, shares, ids=["shared"] + ["share{}".format(share) for share in shares[1:]])


def _nodeid(item):
    """The name without that of the share: `test_grasp` of `test_grasp[shared]`, under which a worker's report has to stand."""
    name = re.sub(r"(\[|-)share(?:d|\d+)(?=[\]-])", lambda found: found.group(1), item.nodeid)
    return name.replace("[-", "[").replace("--", "-").replace("-]", "]").replace("[]", "")


def _share(item):
    callspec = getattr(item, "callspec", None)
    return callspec.params.get(SHARE, 0) if callspec else 0


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    if _mark(item) is None:
        return None
    replayed = item.config.getoption("corroborate_seed")
    if replayed is not None:
        item._corroborate_seed = replayed
        return None
    _Repeated(item, nextitem).run()
    return True


class _Sibling:
    """What comes next, as far as a trial's end asks: fixtures of the test itself end, those around it stay."""

    def __init__(self, item):
        self._chain = item.listchain()[:-1]
        self.nodeid = item.nodeid

    def listchain(self):
        return self._chain


class _Repeated:
    """One test, or a worker's share of it."""

    def __init__(self, item, nextitem):
        self.item = item
        self.nextitem = nextitem
        self.nodeid = _nodeid(item)
        self.mark = _mark(item)
        self.settings = dict(self.mark.kwargs)
        self.name = str(self.mark.args[0])
        self.share = _share(item)

    def run(self):
        hook = self.item.ihook
        is_shown = self.share == 0
        if is_shown:
            hook.pytest_runtest_logstart(nodeid=self.item.nodeid, location=self.item.location)
        began = time.time()
        place = _place(self.item)
        try:
            report = self._decided()
        except JudgeError as error:
            outcome, text, properties = "error", "{}: {}".format(place, error), []
        except TestError as error:
            text = "{}: error of the test, which is not evidence about {}: {}".format(place, self.name, error)
            outcome, properties = "error", []
        except AlwaysSkipped as error:
            outcome, text, properties = "skipped", "{}: {}".format(self.name, error), []
        else:
            outcome, text, properties = _outcome(report, self.item.config, place)
        self._end_fixtures()
        if is_shown:
            self._log(outcome, text, properties, began)
            hook.pytest_runtest_logfinish(nodeid=self.item.nodeid, location=self.item.location)

    def _folder(self):
        config = self.item.config
        run = getattr(config, "workerinput", {}).get("corroborate_run") or config._corroborate_run
        return os.path.join(run, hashlib.sha256(self.nodeid.encode()).hexdigest()[:16])

    def _out(self):
        folder = self.item.config.getoption("corroborate_out")
        if folder is None or self.share != 0:
            return None
        return os.path.join(folder, re.sub(r"[^A-Za-z0-9._-]+", "-", self.nodeid))

    def _decided(self):
        """Runs trials until the judge has heard enough; what it says then."""
        # `seed` takes it, unless it is a fixture of the user's own.
        if "corroborate_seed" not in self.item.fixturenames:
            raise JudgeError(
                "a test of a requirement takes `seed`, or a fixture of yours that takes `corroborate_seed`: "
                "without it its trials would all be the same"
            )
        again = ["pytest", self.nodeid, "--corroborate-seed", "{seed}"]
        call = program(self.item.config.getoption("corroborate_program"))
        judge = Judge(call, self.name, self.settings, again, self._out())
        try:
            self._trials(judge, Trials(self._folder()))
            return judge.report()
        finally:
            judge.close()

    def _trials(self, judge, trials):
        most, known, has_ended = self.settings["max_trials"], {}, False
        while not has_ended:
            self._go_on(trials, known)
            for trial, outcome, why in trials.news():
                if trial not in known:
                    known[trial] = (outcome, why)
                    has_ended = judge.tell(trial, outcome, why) or has_ended
            if has_ended:
                return
            number = trials.take(most)
            if number is not None:
                try:
                    outcome, why = self._trial(judge.seed(number))
                except TestError as error:
                    trials.stop(str(error))
                    raise
                trials.ended(number, outcome, why)
            elif self.share != 0:
                # The first share waits for the others, and says what came of it.
                return
            else:
                trials.bury(dict(known), most)
                time.sleep(LOOK_SECS)

    def _go_on(self, trials, known):
        """Ends the test where further trials would tell nothing."""
        why = trials.stopped()
        if why is not None:
            raise TestError(why)
        ends = [outcome for outcome, _ in known.values()]
        if self.share == 0 and len(ends) >= SKIPPED_ALWAYS and set(ends) == {"not-applicable"}:
            reasons = sorted({why for _, why in known.values() if why})
            said = "all of the first {} trials were skipped".format(len(ends))
            text = "{}: {}".format(said, reasons[0]) if reasons else said
            trials.stop(text)
            raise AlwaysSkipped(text)

    def _trial(self, seed):
        item = self.item
        item._corroborate_seed = seed
        if hasattr(item, "_request"):
            item._initrequest()
        reports = runtestprotocol(item, nextitem=_Sibling(item), log=False)
        for report in reports:
            wrong = mistake(report)
            if wrong is not None:
                raise TestError(wrong)
            why = str(report.longrepr or "").strip().splitlines()
            if report.failed:
                # What fails outside of the test itself is its harness.
                return ("fail" if report.when == "call" else "error"), (why[-1] if why else "")
        for report in reports:
            if report.skipped:
                reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else ""
                return "not-applicable", str(reason)
        return "pass", ""

    def _end_fixtures(self):
        """What the last trial left standing for a sibling ends if there is none."""
        self.item.session._setupstate.teardown_exact(self.nextitem)

    def _log(self, outcome, text, properties, began):
        longrepr, is_error = None, outcome == "error"
        if outcome in ("failed", "error"):
            longrepr = text
        elif outcome == "skipped":
            longrepr = (str(self.item.path), (self.item.location[1] or 0) + 1, text)
        now = time.time()
        # What fails before the test itself is an error to pytest.
        for when in ("setup", "teardown") if is_error else ("setup", "call", "teardown"):
            is_call = when == ("setup" if is_error else "call")
            outcome = "failed" if is_error else outcome
            report = TestReport(
                nodeid=self.item.nodeid,
                location=self.item.location,
                keywords={key: 1 for key in self.item.keywords},
                outcome=outcome if is_call else "passed",
                longrepr=longrepr if is_call else None,
                when=when,
                sections=[("corroborate", text)] if is_call and outcome == "passed" else [],
                duration=now - began if is_call else 0,
                user_properties=properties,
            )
            self.item.ihook.pytest_runtest_logreport(report=report)


def _outcome(report, config, place):
    """A report as pytest's outcome, its text, and properties that its JUnit XML has, too."""

    def percent(share):
        return "{:.2f} %".format(100 * share)

    rate = "no trial has a known outcome" if report["rate"] is None else percent(report["rate"])
    low, high = report["interval"]["low"], report["interval"]["high"]
    counts = report["counts"]
    lines = [
        "{}: {}".format(report["requirement"], report["verdict"]),
        "success rate {} ({} passed, {} failed, {} errors), {} CI {} to {}, required: at least {}".format(
            rate,
            counts["passed"],
            counts["failed"],
            counts["errors"],
            percent(report["confidence"]),
            percent(low),
            percent(high),
            percent(report["at_least"]),
        ),
        report["guarantee"],
        "the test: {}".format(place),
    ]
    if report["verdict"] == "undecided":
        more = report["further_trials"]
        lines.append(
            "about {} more trials would decide it at the rate seen so far".format(more)
            if more
            else "no number of trials would decide it at the rate seen so far: widen the margin"
        )
    for failing in report["failing"][:5]:
        lines.append("seed {}: {}  {}".format(failing["seed"], failing["why"], failing["command"]))
    properties = [
        ("verifies", report["requirement"]),
        ("outcome", report["verdict"]),
        ("rate", report["rate"]),
        ("interval", "{} to {}".format(low, high)),
        ("guarantee", report["guarantee"]),
        ("trials", report["trials"]),
    ]
    undecided = {"fail": "failed", "skip": "skipped"}[config.getoption("corroborate_undecided")]
    outcome = {"passed": "passed", "failed": "failed", "undecided": undecided}[report["verdict"]]
    return outcome, "\n".join(lines), properties


def pytest_sessionfinish(session):
    """One table of the counts of all tests, which a study takes as an experiment."""
    config = session.config
    folder = config.getoption("corroborate_out")
    if folder is None or hasattr(config, "workerinput") or not os.path.isdir(folder):
        return
    rows, seen = [], set()
    for name in sorted(os.listdir(folder)):
        table = os.path.join(folder, name, "requirements.csv")
        if not os.path.isfile(table):
            continue
        with open(table, encoding="utf-8") as file:
            lines = [line for line in file if not line.startswith("#")]
        for line in lines[1:]:
            requirement = line.rsplit(",", 5)[0]
            if requirement in seen:
                config.issue_config_time_warning(
                    pytest.PytestWarning(
                        "several tests verify {}: no table of all is written, see those in {}".format(
                            requirement, folder
                        )
                    ),
                    stacklevel=2,
                )
                return
            seen.add(requirement)
            rows.append(line)
    with open(os.path.join(folder, "requirements.csv"), "w", encoding="utf-8") as file:
        file.write("requirement,covered,passed,failed,undecided,stopped\n" + "".join(rows))


def _verified(reports):
    """By requirement the tests that verify it."""
    tests = {}
    for report in reports:
        tests.setdefault(dict(report.user_properties)["verifies"], []).append(report.nodeid)
    return tests


def pytest_terminal_summary(terminalreporter):
    reports = [
        report
        for outcome in ("passed", "failed", "skipped")
        for report in terminalreporter.getreports(outcome)
        if report.when == "call" and dict(report.user_properties).get("verifies")
    ]
    if not reports:
        return
    terminalreporter.section("requirements")
    for report in reports:
        told = dict(report.sections).get("corroborate") or report.longrepr
        told = told[2] if isinstance(told, tuple) else str(told)
        terminalreporter.write_line(" | ".join(told.splitlines()[:2]))
    for requirement, tests in sorted(_verified(reports).items()):
        if len(tests) > 1:
            terminalreporter.write_line(
                "{} is verified by {} tests, each decided by itself; it holds if all of them pass: {}".format(
                    requirement, len(tests), ", ".join(tests)
                )
            )
