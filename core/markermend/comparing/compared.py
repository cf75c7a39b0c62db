"""How far two or more people agree who reviewed the same take, each on their own."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from markermend.comparing.coefficients import MISSING, cohen_kappa, krippendorff_alpha
from markermend.comparing.differing import Difference, apart, difference
from markermend.comparing.grouping import Group, Said, groups, sayings
from markermend.comparing.table2 import TableRow, own_row, table2
from markermend.errors import BadInput
from markermend.evaluate.matching import IOU
from markermend.evaluate.scores import CLASSES, classes_of, cross_table
from markermend.model import Span, Take
from markermend.review import Review
from markermend.review.decisions import Decisions
from markermend.review.mending import mend

ARTEFACTS = CLASSES[1:]
"""The kinds that people can disagree on: where a marker was not seen is no judgement."""
NOTHING = "nothing"
SPAN_CLASSES: tuple[str, ...] = (NOTHING, *ARTEFACTS)
"""What can be said of a thing that somebody judged: nothing is wrong, or a kind."""
SLACK_S = 0.02
"""Spans are widened by this before they are matched, as in the grading of exercises."""


@dataclass(frozen=True)
class PairAgreement:
    """Two people.

    Attributes
    ----------
    names
        Who.
    accepted
        How many artefacts each of them accepted.
    both
        Those accepted by both, and of these those given the same kind.
    same_kind
        See above.
    iou
        Mean agreement of the edges of those accepted by both, or None.
    kappa_samples, kappa_spans
        Cohen's kappa over all samples, and over the things that one of them judged and both had
        a chance to: see `Agreement`.
    samples
        Counts of samples, in the order of `markermend.evaluate.scores.CLASSES`.
    spans
        Counts of things, in the order of `SPAN_CLASSES`: the class confusion between the two.
    difference
        Between the repaired trajectories, where the take is at hand.
    """

    names: tuple[str, str]
    accepted: tuple[int, int]
    both: int
    same_kind: int
    iou: float | None
    kappa_samples: float | None
    kappa_spans: float | None
    samples: tuple[tuple[int, ...], ...]
    spans: tuple[tuple[int, ...], ...]
    difference: Difference | None

    @property
    def found_by_both(self) -> float | None:
        """Share of all artefacts accepted by either that both accepted; None without any."""
        either = sum(self.accepted) - self.both
        return self.both / either if either else None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        record = asdict(self)
        record["difference"] = None if self.difference is None else self.difference.to_json()
        return {**record, "found_by_both": self.found_by_both}


@dataclass(frozen=True)
class Thing:
    """One thing that somebody judged.

    Attributes
    ----------
    marker, span
        Where, in the eyes of the first who has it.
    said
        Per person the kind accepted, ``"nothing"``, or None where it is open or set aside.
    apart_mm
        Largest mean distance of two repaired versions over the span, or None.
    """

    marker: str
    span: Span
    said: tuple[str | None, ...]
    apart_mm: float | None

    @property
    def agreed(self) -> bool:
        """Whether everybody says the same."""
        return len(set(self.said)) == 1

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {
            "marker": self.marker,
            "start": self.span.start,
            "stop": self.span.stop,
            "said": list(self.said),
            "agreed": self.agreed,
            "apart_mm": self.apart_mm,
        }


@dataclass(frozen=True)
class Agreement:
    """Two or more reviews of one take; gaps are left out throughout.

    Samples are a marker in a frame: of all measured markers where the take is at hand, else of
    those that somebody accepted something on.  Where accepted spans overlap, peak goes before
    noise, step and slow change.

    Things are the groups of judgements that are about the same: on one marker, spans that overlap
    by at least ``iou``.  Who accepted it says its kind, who rejected it or has no judgement on it
    says nothing, who left it open or set it aside says neither.  Things that nobody judged are
    unknown, so the count of ``nothing`` by both is only of the false alarms that both called so,
    and the coefficients over spans are lower than with all that both rightly passed over.

    Attributes
    ----------
    names
        Who.
    iou
        Overlap from which two spans are about the same thing.
    pairs
        Every two of them.
    alpha_samples, alpha_spans
        Krippendorff's alpha of all of them.
    things
        Every thing that somebody judged, ordered by time.
    own
        Everybody's own verdicts on the detector, as in Table 2 of Skurowski & Pawlyta.
    table2
        The table itself with the detector run again on every version, where an expert was named.
    """

    names: tuple[str, ...]
    iou: float
    pairs: tuple[PairAgreement, ...]
    alpha_samples: float | None
    alpha_spans: float | None
    things: tuple[Thing, ...]
    own: tuple[TableRow, ...]
    table2: tuple[TableRow, ...] | None

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend agree --json``."""
        return {
            "version": 1,
            "operators": list(self.names),
            "iou": self.iou,
            "sample_classes": list(CLASSES),
            "span_classes": list(SPAN_CLASSES),
            "alpha_samples": self.alpha_samples,
            "alpha_spans": self.alpha_spans,
            "pairs": [pair.to_json() for pair in self.pairs],
            "things": [thing.to_json() for thing in self.things],
            "own_verdicts": [row.to_json() for row in self.own],
            "table2": None if self.table2 is None else [row.to_json() for row in self.table2],
        }


def agreement(
    reviews: Mapping[str, Decisions | Review] | Sequence[Decisions | Review],
    take: Take | None = None,
    *,
    iou: float = IOU,
    expert: str | None = None,
    detector: str = "published",
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Agreement:
    """Compare reviews of the same take.

    Parameters
    ----------
    reviews
        Two or more reviews, or contents of decision files, by the operator's name; those of a list
        get numbers for names.
    take
        The take that was reviewed; needed for reviews, for the differences in mm, and for
        Table 2.
    iou
        Overlap, above 0 and at most 1, from which two spans are about the same thing.
    expert
        Name of the one whose repaired take is the reference of Table 2; without, there is none.
    detector
        Name of the detector that searches everybody's version for Table 2.
    progress
        Called with the versions repaired and their total.

    Raises
    ------
    BadInput
        If there are fewer than two reviews, they are not of one take, or something is lacking.
    """
    named = _named(reviews)
    if len(named) < 2:
        raise BadInput(f"Agreement needs two or more reviews; got {len(named)}.")
    if not 0.0 < iou <= 1.0:
        raise BadInput(f"iou must be above 0 and at most 1; got {iou!r}.")
    if expert is not None and (take is None or expert not in named):
        raise BadInput(
            "Table 2 needs the take and an expert among the reviews; got "
            f"{expert!r} of {', '.join(named)}{'' if take is not None else ' and no take'}."
        )
    frame = take if take is not None else _frame(named)
    opinions = {name: _review(given, take) for name, given in named.items()}
    people = [sayings(review, ARTEFACTS) for review in opinions.values()]
    samples = [classes_of(frame, [s for s in said if s.verdict == "accepted"]) for said in people]
    things = groups(people, iou, round(SLACK_S * frame.rate))
    values = np.array([[_class(said) for said in thing.said] for thing in things], np.intp)
    values = values.reshape(-1, len(people)).T
    versions = {} if take is None else _versions(take, opinions, progress)
    return Agreement(
        names=tuple(named),
        iou=iou,
        pairs=tuple(
            _pair(i, j, tuple(named), samples, things, values, take, versions)
            for i, j in combinations(range(len(named)), 2)
        ),
        alpha_samples=krippendorff_alpha(
            np.stack([table.ravel() for table in samples]), len(CLASSES)
        ),
        alpha_spans=krippendorff_alpha(values, len(SPAN_CLASSES)),
        things=tuple(
            _thing(thing, values[:, n], list(versions.values())) for n, thing in enumerate(things)
        ),
        own=tuple(own_row(name, review) for name, review in opinions.items()),
        table2=None
        if expert is None or take is None
        else table2(take, versions, opinions, expert, detector=detector),
    )


def _named(
    reviews: Mapping[str, Decisions | Review] | Sequence[Decisions | Review],
) -> Mapping[str, Decisions | Review]:
    if isinstance(reviews, Mapping):
        return dict(reviews)
    return {str(number): review for number, review in enumerate(reviews, 1)}


def _review(given: Decisions | Review, take: Take | None) -> Review:
    if isinstance(given, Review):
        return given
    if take is not None:
        given.wishes(take)  # refuses another take, and repairs that are unknown here
    return given.review


def _frame(named: Mapping[str, Decisions | Review]) -> Take:
    """Make a take without positions of the markers that somebody accepted something on."""
    files = [given for given in named.values() if isinstance(given, Decisions)]
    if len(files) < len(named):
        raise BadInput("A review does not say how long its take is; give the take too.")
    if len({(f.sha256, f.n_frames, f.rate) for f in files}) > 1:
        raise BadInput(
            "The decisions were made on different takes: "
            + ", ".join(f"{name} on {f.sha256[:12]}" for name, f in zip(named, files, strict=True))
            + "; compare reviews of one take."
        )
    said = [s for f in files for s in sayings(f.review, ARTEFACTS) if s.verdict == "accepted"]
    labels = sorted({s.marker for s in said}) or ["none"]
    shape = (files[0].n_frames, len(labels), 3)
    return Take(np.zeros(shape), files[0].rate, labels, roles=["measured"] * len(labels))


def _class(said: Said | None) -> int:
    if said is None or said.verdict == "rejected":
        return 0
    return SPAN_CLASSES.index(said.kind) if said.verdict == "accepted" else MISSING


def _versions(
    take: Take, opinions: Mapping[str, Review], progress: Callable[[int, int], None]
) -> dict[str, Take]:
    versions = {}
    for done, (name, review) in enumerate(opinions.items(), 1):
        versions[name] = mend(take, review.accepted()).repaired
        progress(done, len(opinions))
    return versions


def _pair(
    i: int,
    j: int,
    names: tuple[str, ...],
    samples: Sequence[NDArray[np.intp]],
    things: Sequence[Group],
    values: NDArray[np.intp],
    take: Take | None,
    versions: Mapping[str, Take],
) -> PairAgreement:
    one, other = values[i], values[j]
    known = (one != MISSING) & (other != MISSING)
    n = len(SPAN_CLASSES)
    spans = np.bincount(one[known] * n + other[known], minlength=n * n).reshape(n, n)
    both: list[int] = np.flatnonzero((one > 0) & (other > 0)).tolist()
    edges = [
        mine.span.iou(theirs.span)
        for k in both
        if (mine := things[k].said[i]) and (theirs := things[k].said[j])
    ]
    table = cross_table(samples[i], samples[j])
    return PairAgreement(
        names=(names[i], names[j]),
        accepted=(int((one > 0).sum()), int((other > 0).sum())),
        both=len(both),
        same_kind=int((one[both] == other[both]).sum()),
        iou=float(np.mean(edges)) if edges else None,
        kappa_samples=cohen_kappa(table),
        kappa_spans=cohen_kappa(spans),
        samples=tuple(tuple(int(v) for v in row) for row in table),
        spans=tuple(tuple(int(v) for v in row) for row in spans),
        difference=None
        if take is None
        else difference(take, versions[names[i]], versions[names[j]]),
    )


def _thing(group: Group, classes: NDArray[np.intp], versions: Sequence[Take]) -> Thing:
    first = group.first
    said = tuple(None if c == MISSING else SPAN_CLASSES[c] for c in classes)
    distances = [
        mm
        for one, other in combinations(versions, 2)
        if (mm := apart(one, other, first.marker, first.span)) is not None
    ]
    return Thing(first.marker, first.span, said, max(distances, default=None))
