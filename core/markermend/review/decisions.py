"""The decision file: what was decided on one take, complete enough to export it again.

JSON with a schema and a version. Everything that a repair needs stands in it with its full
parameters, so that the same program makes the byte-identical file from the same take.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from markermend import __version__
from markermend.errors import BadDecisions
from markermend.io.disk import write_whole
from markermend.model import Take
from markermend.params import checked
from markermend.repairing.problem import Repair
from markermend.repairing.run import REPAIRS, Wish
from markermend.review.records import (
    MAX_FRAMES,
    Record,
    judgement_from_json,
    judgement_to_json,
)
from markermend.review.state import Judgement, Review

SCHEMA = "markermend/decisions"
VERSION = 1
MAX_BYTES = 64 * 2**20
MAX_FINDINGS = 200_000


class Attribution(Protocol):
    """Who decided, and when, as far as known."""

    @property
    def operator(self) -> str:
        """Who it was, or empty."""

    @property
    def at(self) -> datetime | None:
        """When it was."""


@dataclass(frozen=True)
class Decided:
    """A judgement with where it comes from.

    Attributes
    ----------
    judgement
        The finding and what was said of it; an accepted one with the method that was really used.
    expected_mm
        The mean error that the repair expects of itself, or None.
    operator, at
        Who decided last, and when, as far as known.
    """

    judgement: Judgement
    expected_mm: float | None = None
    operator: str = ""
    at: datetime | None = None


@dataclass(frozen=True)
class Decisions:
    """The content of a decision file.

    Attributes
    ----------
    name, sha256, n_frames, rate, units
        The take: its file's name, the hash of its content, and how it was read.
    findings
        All judgements.
    written, program
        When the file was written, as far as known, and by which version.
    """

    name: str
    sha256: str
    n_frames: int
    rate: float
    units: str
    findings: tuple[Decided, ...]
    written: datetime | None
    program: str = __version__

    @property
    def review(self) -> Review:
        """The decisions as a review."""
        return Review({d.judgement.finding.id: d.judgement for d in self.findings})

    @property
    def decided(self) -> Mapping[str, Attribution]:
        """Finding id -> who decided and when, to be handed on when the decisions are used again."""
        return {d.judgement.finding.id: d for d in self.findings}

    def wishes(self, take: Take) -> tuple[Wish, ...]:
        """Give the accepted repairs, for `markermend.repairing.repair_all`.

        Raises
        ------
        BadDecisions
            If they were made on another take, or on this one read otherwise.
        UnknownName, BadParameter
            If a method is not installed here or has other parameters.
        """
        self._fit(take)
        wishes = self.review.accepted()
        for wish in wishes:
            if wish.method:
                checked(REPAIRS.get(wish.method).function, wish.parameters)
        return wishes

    def to_json(self) -> dict[str, Any]:
        """Give the content as a JSON object."""
        return {
            "schema": SCHEMA,
            "version": VERSION,
            "program": self.program,
            "written": None if self.written is None else self.written.isoformat(),
            "take": {
                "name": self.name,
                "sha256": self.sha256,
                "n_frames": self.n_frames,
                "rate": self.rate,
                "units": self.units,
            },
            "findings": [
                {
                    **judgement_to_json(decided.judgement),
                    "expected_mm": decided.expected_mm,
                    "operator": decided.operator,
                    "decided": None if decided.at is None else decided.at.isoformat(),
                }
                for decided in self.findings
            ],
        }

    def write(self, path: str | Path) -> None:
        """Write the file, whole or not at all.

        Raises
        ------
        CannotWrite
            If the disk refuses.
        """
        text = json.dumps(self.to_json(), allow_nan=False, indent=1)
        write_whole(Path(path), f"{text}\n".encode("ascii"), overwrite=True)

    def _fit(self, take: Take) -> None:
        if self.sha256 != take.content_hash:
            raise BadDecisions(
                f"The decisions were made on {self.name} with content {self.sha256[:12]}, and this "
                f"take has content {take.content_hash[:12]}; give the take they were made on."
            )
        units = _units(take)
        if (self.rate, self.units) != (take.rate, units):
            raise BadDecisions(
                f"The decisions were made at {self.rate:g} Hz in {self.units}, and the take was "
                f"read at {take.rate:g} Hz in {units}; give --rate and --units as they were then."
            )
        for judgement in self.review:
            take.index(judgement.finding.marker)
        if self.n_frames != take.n_frames:
            raise BadDecisions(
                f"The decisions are for {self.n_frames} frames, and the take has {take.n_frames}."
            )


def decisions_on(
    take: Take,
    review: Review,
    *,
    repairs: Iterable[Repair] = (),
    decided: Mapping[str, Attribution] | None = None,
    written: datetime | None = None,
) -> Decisions:
    """Put together what an export writes down beside the repaired file.

    Parameters
    ----------
    take, review
        The take as recorded, and the decisions on it.
    repairs
        The repairs that were computed from the accepted findings: their methods and full
        parameters go into the file, also where the default was asked for.
    decided
        Finding id -> who decided and when: `ReviewSession.decided`, or `Decisions.decided`.
    written
        Now, if not given.
    """
    done = {(repair.marker, repair.span): repair for repair in repairs}
    steps = decided or {}

    def complete(judgement: Judgement) -> Decided:
        step = steps.get(judgement.finding.id)
        who = ("", None) if step is None else (step.operator, step.at)
        repair = done.get((judgement.finding.marker, judgement.span))
        if judgement.decision.verdict != "accepted" or judgement.replaced_by or repair is None:
            return Decided(judgement, None, *who)
        decision = replace(judgement.decision, method=repair.method, parameters=repair.parameters)
        return Decided(replace(judgement, decision=decision), repair.expected_mm, *who)

    return Decisions(
        name="untitled" if take.source is None else take.source.path.name,
        sha256=take.content_hash,
        n_frames=take.n_frames,
        rate=take.rate,
        units=_units(take),
        findings=tuple(complete(judgement) for judgement in review),
        written=written or datetime.now(UTC),
    )


def read_decisions(path: str | Path) -> Decisions:
    """Read a decision file; nothing in it is believed unchecked.

    Raises
    ------
    BadDecisions
        If it is no decision file, is broken, or was written by a newer version.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise BadDecisions(f"{path} cannot be read ({error.strerror}); give another.") from None
    return parse_decisions(content, path.name)


def parse_decisions(content: bytes, name: str = "The file") -> Decisions:
    """Read the bytes of a decision file.

    Raises
    ------
    BadDecisions
        As `read_decisions`.
    """
    if len(content) > MAX_BYTES:
        raise BadDecisions(f"{name} is larger than {MAX_BYTES // 2**20} MB; it cannot be read.")
    try:
        given = json.loads(content, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise BadDecisions(f"{name} is no JSON, or cut; give a file of decisions.") from None
    record = Record(given, name)
    if record.value("schema", None) != SCHEMA:
        raise BadDecisions(f"{name} is no file of decisions: its schema is not {SCHEMA!r}.")
    version = record.whole("version", 1, 10**6)
    if version > VERSION:
        raise BadDecisions(
            f"{name} was written by a newer markermend (version {version}, this one reads "
            f"{VERSION}); update markermend."
        )
    take = Record(record.value("take"), f"The take of {name}")
    findings = record.value("findings")
    if not isinstance(findings, list) or len(findings) > MAX_FINDINGS:
        raise record.wrong("findings", f"a list of at most {MAX_FINDINGS}", findings)
    decisions = Decisions(
        name=take.text("name"),
        sha256=take.text("sha256"),
        n_frames=take.whole("n_frames", 0, MAX_FRAMES),
        rate=take.number("rate", 1e-9, 1e9),
        units=take.text("units"),
        findings=tuple(_decided(f, f"Finding {i}") for i, f in enumerate(findings)),
        written=_moment(record, "written"),
        program=record.text("program", ""),
    )
    _consistent(decisions)
    return decisions


def _decided(given: Any, where: str) -> Decided:
    record = Record(given, where)
    return Decided(
        judgement=judgement_from_json(given, where),
        expected_mm=record.number_or_none("expected_mm", 0, 1e12),
        operator=record.text("operator", ""),
        at=_moment(record, "decided"),
    )


def _consistent(decisions: Decisions) -> None:
    ids = [decided.judgement.finding.id for decided in decisions.findings]
    known = set(ids)
    if len(known) != len(ids):
        raise BadDecisions("A finding stands twice among the decisions; keep one of them.")
    for i, decided in enumerate(decisions.findings):
        judgement = decided.judgement
        if max(judgement.span.stop, judgement.finding.span.stop) > decisions.n_frames:
            raise BadDecisions(
                f"Finding {i} ends at frame {judgement.span.stop}, and the take has "
                f"{decisions.n_frames} frames."
            )
        if not known.issuperset(judgement.replaced_by):
            raise BadDecisions(f"Finding {i} was replaced by findings that are not in the file.")


def _moment(record: Record, name: str) -> datetime | None:
    text = record.text_or_none(name)
    if text is None:
        return None
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        raise record.wrong(name, "a date and time", text) from None
    if moment.tzinfo is None:
        raise record.wrong(name, "a date and time with its zone", text)
    return moment.astimezone(UTC)


def _units(take: Take) -> str:
    return take.units if take.source is None else take.source.units


def _refuse(constant: str) -> None:
    raise ValueError(constant)
