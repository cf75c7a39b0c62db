"""What a page shows of several reviews of one take."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from markermend.comparing import Agreement, Case, agreement, cases
from markermend.errors import BadInput
from markermend.model import Take
from markermend.review import Review
from markermend.review.decisions import Decisions
from markermend.review.mending import mend
from markermend.review.session import ReviewSession
from markermend.review.store import ReviewRecord, Store
from markermend_app.state.sights import Sight, around, sight

PURPOSE = "adjudication"
MOST_PEOPLE = 3
"""So many opinions stand side by side, each with a key."""


@dataclass(frozen=True, eq=False)
class Material:
    """What is compared.

    Attributes
    ----------
    reviews
        Operator -> what was decided.
    take
        The take that all of them reviewed, or None where only the files are at hand.
    iou, detector
        As in `markermend.agreement`.
    """

    reviews: Mapping[str, Review | Decisions]
    take: Take | None = None
    iou: float = 0.5
    detector: str = "published"

    def compare(self, expert: str | None, progress: Callable[[int, int], None]) -> "Compared":
        """Compare them; with an expert also as in Table 2 of the paper."""
        found = agreement(
            self.reviews,
            self.take,
            iou=self.iou,
            expert=expert,
            detector=self.detector,
            progress=progress,
        )
        return Compared(self, found, expert)

    def opinions(self) -> "Opinions":
        """Put side by side what was said, for the take at hand.

        Raises
        ------
        BadInput
            If there is no take, or more people than fit beside each other.
        """
        if self.take is None:
            raise BadInput("Adjudication needs the take that was reviewed; give it with --take.")
        if len(self.reviews) > MOST_PEOPLE:
            raise BadInput(
                f"At most {MOST_PEOPLE} reviews stand side by side; got {len(self.reviews)}."
            )
        plain = [r.review if isinstance(r, Decisions) else r for r in self.reviews.values()]
        found = cases(plain, iou=self.iou)
        versions = tuple(mend(self.take, review.accepted()).repaired for review in plain)
        return Opinions(
            tuple(self.reviews), self.take, versions, {case.finding.id: case for case in found}
        )


@dataclass(frozen=True, eq=False)
class Compared:
    """An agreement, of what, and with whom as the expert."""

    material: Material
    agreement: Agreement
    expert: str | None


@dataclass(frozen=True, eq=False)
class Opinion:
    """What one person said of the finding at hand.

    Attributes
    ----------
    name, words
        Who, and what in short.
    sight
        What that person's version looks like beside the recording.
    taken
        Whether the adjudicator has followed it.
    """

    name: str
    words: str
    sight: Sight
    taken: bool


@dataclass(frozen=True, eq=False)
class Opinions:
    """What everybody said of everything, and everybody's version of the take."""

    names: tuple[str, ...]
    take: Take
    versions: tuple[Take, ...]
    cases: Mapping[str, Case]

    def of(self, finding: str, review: Review) -> tuple[Opinion, ...]:
        """Give the opinions on one finding; none where they all agree or it is nobody's."""
        case = self.cases.get(finding)
        if case is None or case.agreed:
            return ()
        span = case.finding.span
        for said in case.said:
            if said is not None:
                span = type(span)(min(span.start, said.span.start), max(span.stop, said.span.stop))
        take, m = self.take, self.take.index(case.finding.marker)
        frames = around(take, span).frames
        everything = {
            "recorded": take.positions[frames, m],
            **{f"{i}": version.positions[frames, m] for i, version in enumerate(self.versions)},
        }
        whole = sight(take, case.first.kind, span, everything)
        now = review.decision(finding)
        return tuple(
            Opinion(
                name,
                _words(case, i),
                Sight(
                    whole.kind, whole.start_s, whole.stop_s, whole.axis, whole.unit, whole.time,
                    {"recorded": whole.lines["recorded"], "yours": whole.lines[f"{i}"]},
                ),
                now.settled and _same(now, case.decision(i)),
            )
            for i, name in enumerate(self.names)
        )  # fmt: skip


def _same(one: object, other: object) -> bool:
    fields = ("verdict", "kind", "span", "method")
    return all(getattr(one, name) == getattr(other, name) for name in fields)


def _words(case: Case, person: int) -> str:
    said = case.said[person]
    if said is None:
        return "nothing is wrong here"
    decision = said.judgement.decision
    if decision.verdict == "rejected":
        return "false alarm"
    if decision.verdict is None:
        return "left open"
    if decision.verdict == "deferred":
        return "set aside"
    with_ = f", {decision.method}" if decision.method else ""
    return f"{said.kind} {said.span.start}–{said.span.stop - 1}{with_}"


def others(store: Store, take: Take, but: str | None = None) -> tuple[ReviewRecord, ...]:
    """Give the reviews of a take on which somebody decided something, but one person's."""
    return tuple(
        record
        for record in store.reviews(take.content_hash)
        if record.purpose == "review" and record.operator != but and store.entries(record.id)
    )


def in_store(store: Store, take: Take) -> Material:
    """Give all reviews of a take.

    Raises
    ------
    BadInput
        If there are fewer than two.
    """
    records: Sequence[ReviewRecord] = others(store, take)
    if len(records) < 2:
        who = records[0].operator if records else "nobody"
        raise BadInput(
            f"So far {who} alone has reviewed this take; a second review is asked for by the "
            "commands (P), or with markermend review TAKE --blind --operator NAME."
        )
    reviews = {record.operator: ReviewSession(store, record).review for record in records}
    return Material(reviews, take)
