"""The report of a review shows whatever labels, names and notes hold, and does none of it."""

import re
from html import unescape
from html.parser import HTMLParser

import numpy as np
import pytest

from markermend.model import Finding, Span, Take
from markermend.repairing import Refusal, Wish, repair
from markermend.review import Accept, Annotate, Review
from markermend.review.report import report

EVIL = "<img src=x onerror=alert(1)>"
WORDS = (
    EVIL, "\"'><script>alert(1)</script>", "</title><svg onload=alert(1)>", "\u202egnp.exe\u2066",
    "=cmd|' /C calc'!A0", "javascript:alert(1)", "x" * 200, "a\u2028b\x1b[31m",
)  # fmt: skip


class Looking(HTMLParser):
    """Collects tags and the names of attributes, as a browser finds them."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes += [name for name, _ in attrs]


@pytest.mark.parametrize("word", WORDS)
def test_words_are_shown_and_never_done(word: str) -> None:
    t = np.arange(60.0)[:, None, None]
    take = Take(np.concatenate([t, 2 * t], 1) + np.zeros(3), 100.0, (word, "B"))
    finding = Finding(word, Span(20, 25), "peak", amplitude=3.0)
    review = Annotate((finding,), word).apply(Accept((finding,), "pchip").apply(Review()))
    done = repair(take, word, Span(20, 25), "pchip", kind="peak")
    refused = Refusal(Wish("B", Span(1, 2)), word)
    page = report(
        take, review, [finding], [done], [refused], name=word, written=[f"Written as {word}."]
    )
    looking = Looking()
    looking.feed(page)
    assert looking.tags == {
        *("html", "head", "meta", "title", "style", "body", "h1", "h2", "p", "i"),
        *("table", "tr", "th", "td", "figure", "figcaption", "svg", "rect", "path", "text"),
    }
    assert not [a for a in looking.attributes if a.startswith("on") or a in ("src", "href")]
    assert not re.search("[\u202a-\u202e\u2066-\u2069\u2028\x1b]", page)
    assert "default-src 'none'" in page
    if word.isprintable():
        assert unescape(page).count(word) >= 5
