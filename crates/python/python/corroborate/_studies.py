"""Studies: opened, planned, run, compared, replayed."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Union

from . import _checked, _engine
from ._problem import Problem
from ._surroundings import surroundings
from ._table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Conclusion", "Pack", "Planned", "Produced", "Replay", "Requirement", "Study", "StudyResult"]

PathLike = Union[str, os.PathLike[str]]
Progress = Union[Callable[[dict[str, Any]], object], None]


@dataclass(frozen=True)
class Requirement:
    """What is required."""

    id: str
    text: str
    """Verbatim."""
    direction: Union[str, None]
    """``at-least`` or ``at-most``; ``None`` if certainty is asked for."""
    threshold: float
    """The probability it asks for; 1 if it asks for certainty."""
    margin: float
    """The largest difference of two rates that counts as agreement."""


@dataclass(frozen=True)
class Planned:
    """What a run would do for one entry of the ledger."""

    id: str
    title: str
    technique: str
    freshness: str
    """``fresh`` (what was kept is taken), or why it is produced: ``not-produced``, ``files-changed``, ``other-inputs``, ``damaged``,
    ``awaits`` (evidence it depends on comes first), ``cannot-produce``."""
    why: Mapping[str, Any]
    """What is known besides: ``files``, ``evidence`` or ``reason``."""
    last_took_secs: Union[float, None]
    """How long it took when it was last produced."""


@dataclass(frozen=True)
class Produced:
    """A piece of evidence that was produced by itself."""

    id: str
    headline: str
    """Its main figure in words."""
    data: Mapping[str, Any]
    """All of it, as ``study.json`` has evidence."""


@dataclass(frozen=True)
class Conclusion:
    """What all evidence on a requirement amounts to."""

    requirement: str
    verdict: str
    """``satisfied``, ``violated``, ``undecided``, ``conflicting``, ...; ``corroborate explain`` has each."""
    step: Union[str, None]
    """On which step it holds: for the system, in simulation, for the model."""
    statement: str
    """In words."""


@dataclass(frozen=True)
class Replay:
    """An episode that was run again."""

    episode: str
    seed: int
    shown: Union[bool, None]
    """Whether it shows again what it is replayed for."""
    same_bytes: Union[bool, None]
    """Whether the recording is the same as before, byte for byte; ``None`` where that is not known."""
    verdicts: Mapping[str, str]
    """By requirement and failure mode."""
    files: tuple[str, ...]
    """What was written: the recording, verdicts over time, the scene, a page."""


@dataclass(frozen=True)
class Pack:
    """An evidence pack that was written."""

    file: pathlib.Path
    """The archive."""
    bytes: int
    """Its size."""
    sha256: str
    """Its SHA-256 in hexadecimal."""
    parts: int
    """How many parts its manifest names."""
    signed_by: Union[str, None]
    """The SHA-256 of the public key that verifies its signature; ``None`` if it is not signed."""
    not_shown: tuple[tuple[str, str], ...]
    """What the pack does not show, as it stands in it: of what, and in words."""


class Study:
    """A study: a folder of requirements and of what is known about them.

    Args:
        folder: where ``study.toml`` lies.
        out: the folder of results; by default ``results`` in the study.
        trust: whether programs that the study names may run; else those that this user has allowed (``corroborate trust STUDY``).

    Raises:
        Problem: all mistakes of its files, each with its place.
    """

    def __init__(self, folder: PathLike, *, out: Union[PathLike, None] = None, trust: bool = False) -> None:
        named = _checked.path(folder, "folder", "a study's folder", "name the folder that holds study.toml")
        self.folder = pathlib.Path(named)
        self.out = self.folder / "results" if out is None else pathlib.Path(_checked.path(out, "out", "a folder", "name the folder of results"))
        self._trust = _checked.flag(trust, "trust")
        self._about = _engine.study_open(named, self._surroundings())

    def _surroundings(self) -> dict[str, Any]:
        return surroundings(trust=self._trust)

    @property
    def title(self) -> str:
        """As ``study.toml`` has it."""
        return str(self._about["title"])

    @property
    def requirements(self) -> dict[str, Requirement]:
        """By identifier, in the order of the file."""
        return {it["id"]: _requirement(it) for it in self._about["requirements"]}

    @property
    def evidence(self) -> list[str]:
        """The identifiers of the ledger's entries."""
        return list(self._about["evidence"])

    def plan(self, *, only: Sequence[str] = ()) -> list[Planned]:
        """What a run would do. Reads and checks everything, and produces nothing."""
        plan = _engine.study_plan(self._asked(only), self._surroundings())
        return [_planned(it) for it in plan["evidence"]]

    def run(self, *, progress: Progress = None) -> StudyResult:
        """Produces what is missing or stale, compares, concludes; writes ``study.json`` and ``report.html``. Ctrl-C ends it; what was
        finished is kept, and the next run goes on there.

        Args:
            progress: called with each event, a dictionary: ``{"event": "started", "stage": 0, "title": ..., "total": ...}``,
                ``advanced`` (with ``done`` and ``left_secs``), ``finished``, ``note``. What it raises ends the run.
        """
        told = _checked.optional_callback(progress, "progress")
        return StudyResult(_engine.study_run(self._asked(()), self._surroundings(), told), self.out)

    def produce(self, *evidence: str, progress: Progress = None) -> list[Produced]:
        """Produces only the evidence with these identifiers, and compares nothing. What is fresh is taken as it was kept."""
        if not evidence:
            raise Problem("unknown-evidence", "no evidence is named", remedy=f"the ledger has {', '.join(self.evidence)}")
        found = _engine.study_run(self._asked(evidence), self._surroundings(), _checked.optional_callback(progress, "progress"))
        return [Produced(it["evidence"]["id"], it["headline"], it["evidence"]) for it in found]

    def shard(
        self, shard: int, of: int, out: PathLike, *, only: Sequence[str] = (), progress: Progress = None
    ) -> dict[str, Any]:
        """Simulates the episodes of one shard alone, on this machine; ``merge`` puts shards together.

        Args:
            shard: which one, from 1.
            of: of how many.
            out: the folder of the shard; one that was interrupted is gone on with.
            only: simulations of the ledger; all if there are none.
            progress: as for ``run``.

        Returns:
            What was run, as ``shard.json`` in the folder has it.

        Raises:
            Problem: ``bad-shard``, ``nothing-to-shard``, and all mistakes of the study's files.
        """
        named = _checked.path(out, "out", "a folder", "name the folder of the shard")
        which = (_checked.whole(shard, "shard"), _checked.whole(of, "of"))
        return _engine.study_shard(self._asked(only), which, named, self._surroundings(), _checked.optional_callback(progress, "progress"))

    def merge(self, *shards: PathLike) -> dict[str, Any]:
        """Takes the episodes of shards over into the results, after which ``run`` simulates none of them again.

        Args:
            shards: folders that ``shard`` or ``corroborate run --shard`` wrote, in any order.

        Returns:
            By simulation what was taken over, and what is ``missing``.

        Raises:
            Problem: ``no-shard``, ``other-shard``, ``shards-differ``, ...
        """
        named = [_checked.path(it, "shards", "a folder", "name the folder of a shard") for it in shards]
        return _engine.study_merge(self._asked(()), named, self._surroundings())

    def result(self) -> StudyResult:
        """The result of the last run.

        Raises:
            Problem: ``not-run`` without one, ``stale-result`` if the study's files have changed since.
        """
        return StudyResult(_engine.study_result(self._asked(())), self.out)

    def compare(self, *evidence: str) -> list[dict[str, Any]]:
        """The comparisons of the last run: all; of one piece of evidence; or, of several, the pairs among them."""
        return list(_engine.study_compare(self._asked(evidence))["comparisons"])

    def replay(self, episode: PathLike, *, out: Union[PathLike, None] = None) -> Replay:
        """Runs an episode again, bit for bit: the file of a finding, or an episode of an evidence by its number (``E4:17``)."""
        to = None if out is None else _checked.path(out, "out", "a folder", "name the folder for what is written")
        asked: dict[str, Any] = {"folder": os.fspath(self.folder), "out": to, "only": []}
        wanted = _checked.path(episode, "episode", "a finding, or an episode", "for example \"E4:17\"")
        found = _engine.study_replay(asked, wanted, self._surroundings())
        verdicts = {it["subject"]: it["verdict"] for it in found["verdicts"]}
        return Replay(found["episode"], int(found["seed"]), found["shown"], found["same_bytes"], verdicts, tuple(found["files"]))

    def _asked(self, only: Sequence[str]) -> dict[str, Any]:
        remedy = f"the ledger has {', '.join(self.evidence)}"
        named = [_checked.text(it, "an evidence", "its identifier", remedy) for it in _checked.several(only, "only", "identifiers", remedy)]
        return {"folder": os.fspath(self.folder), "out": os.fspath(self.out), "only": named}

    def pack(
        self,
        to: Union[PathLike, None] = None,
        *,
        key: Union[PathLike, None] = None,
        sboms: Sequence[PathLike] = (),
        pdf: Union[PathLike, None] = None,
        with_recordings: bool = False,
        progress: Progress = None,
    ) -> Pack:
        """Packs what assessors ask for into one archive: the study, its results, the argument, traceability, and what all of it
        does not show. The study has to have been run; ``corroborate verify PACK --key PUBLIC`` checks every byte.

        Args:
            to: the archive; by default ``evidence-pack.zip`` in the folder of results. No file but an earlier pack is replaced.
            key: the Ed25519 key that signs, in PEM (``corroborate pack --new-key FILE`` makes one); without one nothing shows who
                made the pack.
            sboms: bills of materials of the system under test (CycloneDX or SPDX, in JSON).
            pdf: the report as PDF, if it was made elsewhere; otherwise a browser prints it, where there is one.
            with_recordings: puts recordings into the pack; otherwise they are named by their hashes.
            progress: as of ``run``.

        Raises:
            Problem: ``not-run`` without a run, ``stale-result`` if something has changed since, ``result-does-not-follow`` if a figure
                does not follow from its evidence, ``pack-over-file``, ``bad-key``, ``bad-sbom``, ``bad-pdf``.
        """

        def named(file: Union[PathLike, None], name: str, what: str) -> Union[str, None]:
            return None if file is None else _checked.path(file, name, what, "name its file")

        listed = _checked.several(sboms, "sboms", "paths", "write sboms=[\"robot.cdx.json\"]")
        asked = {
            "to": named(to, "to", "the archive"),
            "key": named(key, "key", "a key"),
            "sboms": [_checked.path(it, f"sboms[{place}]", "a bill of materials", "name its file") for place, it in enumerate(listed)],
            "pdf": named(pdf, "pdf", "a PDF"),
            "with_recordings": _checked.flag(with_recordings, "with_recordings"),
        }
        found = _engine.study_pack(self._asked(()), asked, self._surroundings(), _checked.optional_callback(progress, "progress"))
        not_shown = tuple((it["of"], it["words"]) for it in found["not_shown"])
        return Pack(pathlib.Path(found["pack"]), found["bytes"], found["sha256"], found["parts"], found["signed_by"], not_shown)

    def __repr__(self) -> str:
        return f"<Study {self.folder}: {self.title}>"


class StudyResult:
    """What a study amounts to."""

    def __init__(self, outcome: _engine.StudyOutcome, folder: pathlib.Path) -> None:
        remedy = "results come from Study.run() and Study.result()"
        self._outcome = _checked.instance(outcome, "outcome", _engine.StudyOutcome, "what the engine found", remedy)
        self.folder = folder

    @cached_property
    def data(self) -> dict[str, Any]:
        """All of it, as ``study.json`` has it (``corroborate schema study-result`` describes it)."""
        return self._outcome.data()

    @property
    def exit_code(self) -> int:
        """That of ``corroborate run``: 0 if all requirements hold, 1 if one is violated or evidence conflicts, 3 if something is
        undecided."""
        return self._outcome.exit_code

    @property
    def confidence(self) -> float:
        """The level of all intervals."""
        return float(self.data["confidence"])

    @property
    def requirements(self) -> dict[str, Requirement]:
        """By identifier."""
        return {it["id"]: _requirement(it) for it in self.data["requirements"]}

    @property
    def conclusions(self) -> dict[str, Conclusion]:
        """By requirement."""
        found = (Conclusion(it["requirement"], it["verdict"], it["step"], it["statement"]) for it in self.data["conclusions"])
        return {it.requirement: it for it in found}

    @property
    def evidence(self) -> Table:
        """One row for each piece of evidence and each requirement or failure mode: ``evidence``, ``title``, ``technique``, ``kind``,
        ``subject``, ``count``, ``trials``, ``effective_trials`` (after clustering), ``estimate``, ``low``, ``high`` (of the interval
        at the study's level, or of the bounds), ``guarantee``, ``reason`` (why there is no figure)."""
        return Table(self._outcome.evidence())

    @property
    def comparisons(self) -> Table:
        """One row for each pair of evidence on each subject: ``outcome``, ``difference`` (right minus left) with its interval,
        ``margin``, p-values of a difference and of equivalence."""
        return Table(self._outcome.comparisons())

    def episodes(self, evidence: str) -> pathlib.Path:
        """The Parquet table of a simulation's episodes, one row each: ``polars.read_parquet(result.episodes("E4"))``."""
        _checked.path(evidence, "evidence", "an evidence's episodes", "name a simulation of the ledger, for example \"E4\"")
        found = sorted((self.folder / "episodes" / evidence).glob("episodes*.parquet"))
        if not found:
            message = f"{evidence} has no table of episodes in {self.folder}"
            raise Problem("no-episodes", message, remedy="name the evidence of a simulation that was run")
        return found[0]

    def forest_plot(self, ax: Union[Axes, None] = None, *, subject: Union[str, None] = None) -> Axes:
        """Draws all evidence along one axis, as in the report (needs matplotlib): of all requirements, or of one subject."""
        from ._plots import forest_plot

        return forest_plot(self, ax, subject)

    def summary(self, width: int = 100) -> str:
        """As ``corroborate run`` prints it, in lines of so many characters (at most 10 000)."""
        return self._outcome.text(_checked.whole(width, "width", 10_000))

    def html(self) -> str:
        """The report: one page that opens offline."""
        return self._outcome.html()

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{_escaped(it.requirement)}</td><td>{_escaped(it.verdict)}</td><td>{_escaped(it.statement)}</td></tr>"
            for it in self.conclusions.values()
        )
        return f"<table><tr><th>Requirement</th><th>Verdict</th><th>Why</th></tr>{rows}</table>"

    def __repr__(self) -> str:
        said = ", ".join(f"{it.requirement}: {it.verdict}" for it in self.conclusions.values())
        return f"<StudyResult {self.data['title']}: {said}>"


def _escaped(text: str) -> str:
    import html

    return html.escape(text)


def _requirement(it: Mapping[str, Any]) -> Requirement:
    threshold = it["threshold"]
    direction, value = (None, 1.0) if threshold is None else (threshold["direction"], threshold["value"])
    return Requirement(it["id"], it["text"], direction, value, it["margin"])


def _planned(it: Mapping[str, Any]) -> Planned:
    why = dict(it["freshness"])
    return Planned(it["id"], it["title"], it["technique"], why.pop("is"), why, it["last_took_secs"])
