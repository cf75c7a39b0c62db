"""A trainee's report as one HTML page that asks nothing of the network."""

from collections.abc import Sequence
from html import escape

from markermend import __version__
from markermend.train.figures import learning_curves
from markermend.train.group import standing
from markermend.train.learning import CONFIDENCE, WINDOW, Result, Share, curves

_STYLE = """
:root{--line:#d8dde1;--ink3:#59636b;--accent:#1d5c8a}
body{font:15px/1.5 system-ui,sans-serif;color:#1d2327;max-width:52rem;margin:3rem auto;
padding:0 1rem}
h1{font-size:1.6rem;margin:0}h2{font-size:1.1rem;margin:2.2rem 0 .4rem}
table{border-collapse:collapse;width:100%}
th,td{text-align:left;padding:.3rem .8rem .3rem 0;border-bottom:1px solid #d8dde1}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
figure{display:inline-block;margin:.6rem 1.2rem .6rem 0}figcaption{font-weight:600}
.note{color:#59636b;font-size:.87rem}
@media print{body{margin:0}}
"""


def report(results: Sequence[Result]) -> str:
    """Give the page of one trainee.

    Parameters
    ----------
    results
        Of one trainee, oldest first, at least one.

    Returns
    -------
    HTML with its style and its pictures inside; every text in it is escaped.
    """
    now = standing(results)
    name = escape(now.trainee)
    first, last = results[0].at, now.last
    rows = "".join(
        f"<tr><td>{escape(kind)}</td><td class=n>{one.right} of {one.of}</td>"
        f"<td class=n>{_percent(one)}</td><td class=n>{one.low:.0%} to {one.high:.0%}</td></tr>"
        for kind, one in now.found.items()
    )
    pace = "" if now.seconds_per_finding is None else f" {now.seconds_per_finding:.0f} s a finding."
    return (
        "<!doctype html><html lang=en><head><meta charset=utf-8>"
        '<meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'; style-src 'unsafe-inline'\">"
        '<meta name=viewport content="width=device-width">'
        f"<title>Training of {name}</title><style>{_STYLE}</style></head><body>"
        f"<h1>{name}</h1>"
        f"<p>{now.exercises} exercise{'s' * (now.exercises > 1)} with known truth, "
        f"{first:%d %B %Y} to {last:%d %B %Y}; last at level {now.level}.{pace} "
        f"The take was left worse than it was in {now.worse.right} of {now.worse.of}.</p>"
        f"<h2>Found and named, last {WINDOW} exercises of each kind</h2>"
        f"<table><tr><th>Kind<th class=n>Found<th class=n>Share<th class=n>"
        f"{CONFIDENCE:.0%} interval</tr>{rows}</table>"
        f"<p>Of what was accepted lately, {now.invented.right} of {now.invented.of} was another "
        "kind or nothing at all.</p>"
        f"<h2>Over time</h2>{learning_curves(curves(results))}"
        f"<p class=note>Dots: share found and named in one exercise, with its interval (Wilson). "
        f"Line and band: {WINDOW} exercises together; there is none before the third. Levels grow "
        "harder and stand under the dots.</p>"
        f"<h2>Exercises</h2>{_exercises(results)}"
        f"<p class=note>Only the first grade of an exercise counts. Next: level "
        f"{now.upcoming.level}, {escape(', '.join(now.upcoming.kinds))}. "
        f"{escape(now.upcoming.why)}</p>"
        f"<p class=note>MarkerMend {escape(__version__)}</p></body></html>\n"
    )


def _percent(one: Share) -> str:
    return "" if one.value is None else f"{one.value:.0%}"


def _exercises(results: Sequence[Result]) -> str:
    rows = []
    for result in results:
        true = sum(t.true for t in result.tallies.values())
        right = sum(t.right for t in result.tallies.values())
        left = (
            ""
            if result.before_mm is None or result.after_mm is None
            else f"{result.before_mm:.1f} to {result.after_mm:.1f} mm"
        )
        rows.append(
            f"<tr><td>{result.at:%d %b %Y}</td><td class=n>{result.level or 'real take'}</td>"
            f"<td class=n>{right} of {true}</td><td class=n>{left}</td>"
            f"<td>{'left worse' if result.worse else ''}</td></tr>"
        )
    return (
        "<table><tr><th>Day<th class=n>Level<th class=n>Found<th class=n>Error in the take<th></tr>"
        f"{''.join(rows)}</table>"
    )
