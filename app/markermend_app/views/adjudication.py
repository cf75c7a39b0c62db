"""What several people said of the finding at hand, side by side."""

from html import escape

from markermend_app.state.second_review import Comparing
from markermend_app.views.markup import button, icon
from markermend_app.views.sight import picture

SHOWS = ("opinions", "review", "selected", "adjudicating")


def opinions(desk: Comparing) -> str:
    """Give a card for each person, and one for the adjudicator's own decision."""
    if not desk.adjudicating:
        return ""
    if not desk.opinions:
        said = "All say the same here." if desk.current is not None else "Nothing is at hand."
        return f'<div class="opinions"><p class="quiet">{said}</p></div>'
    cards = "".join(
        f'<section class="opinion{" taken" if one.taken else ""}">'
        f"<h2>{escape(one.name)}{icon('accepted', 13) if one.taken else ''}</h2>"
        f'<p title="{escape(one.words)}">{escape(one.words)}</p>'
        f"{picture(one.sight, f'Version of {escape(one.name)}')}"
        + button(
            f"opinion_{i}", f"As {escape(one.name)}", classes="tool boxed",
            title=f"Decide as {one.name} did, and go on",
        )
        + "</section>"
        for i, one in enumerate(desk.opinions, 1)
    )  # fmt: skip
    own = (
        '<section class="opinion own"><h2>Own</h2><p>Decide as on any desk: kind, edges, repair, '
        "verdict. The lanes below show the recording.</p></section>"
    )
    return f'<div class="opinions">{cards}{own}</div>'
