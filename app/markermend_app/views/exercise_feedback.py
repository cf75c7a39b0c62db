"""The page at the end of an exercise: what was right, what it cost, and what comes next."""

from base64 import b64encode
from html import escape

from markermend.model import short
from markermend.train import COLUMNS, ROWS, Grade, Mark
from markermend.train.figures import learning_curves
from markermend.train.learning import WINDOW, share
from markermend_app.state.second_review import Comparing
from markermend_app.state.sights import Sight
from markermend_app.state.training import SIGHTS, Feedback
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.views.agreement import agreement, cross
from markermend_app.views.markup import button, closing, icon, number
from markermend_app.views.sight import legend, picture

SHOWS = ("dialog", "feedback", "compared")
OUTCOMES = {
    "right": ("Right", "accepted"),
    "misclassified": ("Misclassified", "rejected"),
    "missed": ("Missed", "rejected"),
    "invented": ("Invented", "rejected"),
    "partial": ("Partly covered", "deferred"),
    "dismissed": ("False alarm, seen", "accepted"),
}
ORDER = tuple(OUTCOMES)
WORST_FIRST = ("missed", "misclassified", "invented", "partial", "right", "dismissed")


def sheet(desk: Comparing) -> str:
    """Give the page that lies over the desk, or nothing."""
    made = {"feedback": _feedback, "agreement": agreement}.get(desk.dialog)
    content = "" if made is None else made(desk)
    if not content:
        return ""
    return (
        f'<div class="sheet" role="dialog" aria-modal="true" tabindex="-1" data-dialog="'
        f'{desk.dialog}" aria-labelledby="sheet-title" data-form>{content}</div>'
    )


def _feedback(desk: Comparing) -> str:
    told = desk.feedback
    if told is None:
        return ""
    grade, practice = told.grade, told.practice
    counted = "Answers came after each decision, so it does not count." if practice.helped else ""
    level = f"level {practice.level}, {practice.title}" if practice.level else practice.title
    return (
        f'<header><div><h1 id="sheet-title">{escape(grade.verdict)}</h1>'
        f"<p>Exercise {practice.number}, {escape(level)}; {escape(practice.trainee)}. {counted}"
        f"</p></div><div class=deeds>{closing('Close')}{_report(desk)}{_next(told)}</div></header>"
        f"{_sums(grade)}"
        f'<div class="columns-2"><div>{_kinds(grade)}{_matrix(grade)}</div>'
        f"<div>{_over_time(told)}</div></div>"
        f"<section><h2>Every decision</h2>{legend(*SIGHTS)}"
        "<p>The curves are distances to what the marker really did, which is the straight line; "
        "of a gap that was passed over they are the way through it. What was recorded has the "
        "colour of its kind.</p>"
        f'<div class="marks">{_marks(told)}</div></section>'
    )


def _next(told: Feedback) -> str:
    upcoming = told.upcoming
    return button(
        "practise_next",
        f"Next: level {upcoming.level}",
        classes="deed primary",
        key=False,
        title=upcoming.why,
    )


def _report(desk: Comparing) -> str:
    """Give the report as a file of its own, inside the link: nothing has to be fetched."""
    told = desk.feedback
    page = None if told is None else desk.trainer.report(told.practice.trainee)
    if page is None:
        return ""
    data = b64encode(page.encode("utf-8")).decode("ascii")
    name = "".join(c for c in desk.person.name if c.isalnum() or c in "-_") or "trainee"
    return (
        f'<a class="deed" download="markermend-{name}.html" href="data:text/html;base64,{data}" '
        'title="A page of its own: all exercises, shares with intervals, curves">Report</a>'
    )


def _sums(grade: Grade) -> str:
    counts = [(OUTCOMES[name], grade.count(name)) for name in ORDER]  # type: ignore[arg-type]
    cells = "".join(
        f"<div><b>{n}</b><span>{icon(sign, 13)}{word}</span></div>" for (word, sign), n in counts
    )
    pace = grade.seconds_per_finding
    before, after = grade.rmse_before_mm, grade.rmse_after_mm
    cells += f"<div><b>{'–' if pace is None else f'{pace:.0f} s'}</b><span>per finding</span></div>"
    if before is not None and after is not None:
        word = "left worse" if grade.worse else "root mean square error, before and after"
        cells += (
            f'<div class="{"worse" if grade.worse else ""}"><b>{before:.1f} → {after:.1f} '
            f"mm</b><span>{word}</span></div>"
        )
    return f'<div class="sums">{cells}</div>'


def _kinds(grade: Grade) -> str:
    body = ""
    for kind, score in grade.kinds.items():
        found = share(score.right, score.true)
        wrong = share(score.wrong, score.called)
        body += (
            f'<tr><th><span class="kind">{glyph(kind)}{KIND_STYLES[kind].title}</span></th>'
            f"<td>{_share(found.right, found.of, found.low, found.high)}</td>"
            f"<td>{_share(wrong.right, wrong.of, wrong.low, wrong.high)}</td>"
            f"<td>{_two(score.mcc)}</td><td>{_two(score.iou)}</td>"
            f"<td>{number(score.error_mm)}</td><td>{number(score.best_mm)}</td>"
            f"<td>{number(score.recommended_mm)}</td></tr>"
        )
    return (
        "<section><h2>By kind</h2><table class=wide><thead><tr><th>Kind</th>"
        "<th>Found and named</th><th>Called so, wrongly</th>"
        '<th title="Matthews correlation over samples">MCC</th><th>Edges</th>'
        '<th title="Mean error of your repairs, mm">Yours mm</th><th>Best mm</th>'
        f"<th>Advised mm</th></tr></thead><tbody>{body}</tbody></table></section>"
    )


def _share(right: int, of: int, low: float, high: float) -> str:
    if not of:
        return "–"
    return f'{right} of {of} <span class="quiet">{100 * low:.0f}–{100 * high:.0f} %</span>'


def _two(value: float | None) -> str:
    return "–" if value is None else f"{round(value, 2) + 0.0:.2f}"


def _matrix(grade: Grade) -> str:
    return (
        "<section><h2>What it was (down) and what you called it (across)</h2>"
        f"{cross(ROWS, COLUMNS, grade.matrix)}</section>"
    )


def _over_time(told: Feedback) -> str:
    upcoming = told.upcoming
    n = told.n_done
    said = f"{n} exercise{'' if n == 1 else 's'} so far."
    drawn = learning_curves(told.curves) or "<p>Nothing counts yet.</p>"
    return (
        f"<section><h2>Over time</h2><p>{said} Next: level {upcoming.level}, "
        f"{escape(', '.join(upcoming.kinds))}. {escape(upcoming.why)}</p>"
        f'<div class="curves">{drawn}</div><p class="quiet">Dots: share found and named in one '
        f"exercise with its 95 % interval, its level below. Line and band: {WINDOW} exercises "
        "together; there is none before the third.</p></section>"
    )


def _marks(told: Feedback) -> str:
    numbered = list(enumerate(zip(told.grade.marks, told.sights, strict=True)))
    numbered.sort(key=lambda item: WORST_FIRST.index(item[1][0].outcome))
    return "".join(_mark(i, mark, seen) for i, (mark, seen) in numbered)


def _mark(i: int, mark: Mark, seen: Sight | None) -> str:
    word, sign = OUTCOMES[mark.outcome]
    name = escape(short(mark.marker))
    drawn = "" if seen is None else picture(seen, f"{name} {mark.kind}")
    facts = []
    if mark.iou is not None:
        facts.append(f"edges {mark.iou:.0%}")
    if mark.repaired is not None:
        done = mark.repaired
        facts.append(f"{escape(done.method)} {number(done.error_mm)} mm")
        if done.best:
            facts.append(f"best {escape(done.best)} {number(done.best_mm)} mm")
        if done.recommended:
            facts.append(f"advised {escape(done.recommended)} {number(done.recommended_mm)} mm")
        if done.new_artefacts is not None:
            kinds = ", ".join(done.new_artefacts)
            facts.append(f"brought in {kinds}" if kinds else "nothing new brought in")
    return (
        f'<article class="mark" data-outcome="{mark.outcome}"><h3>{glyph(mark.kind)}{name}'
        f'<span class="outcome">{icon(sign, 13)}{word}</span>'
        + button("feedback_look", "Look", classes="tool", arg=str(i), key=False,
                 title="Show it on the desk")
        + f'</h3>{drawn}<p>{escape(mark.why)}</p><p class="quiet num">{" · ".join(facts)}</p>'
        "</article>"
    )  # fmt: skip
