"""Whoever waits for a detector hears how far it is, and the findings do not depend on it."""

import pytest

from markermend.detection import scan
from markermend.detection.likelihood import findings
from markermend.evaluate.contamination import contaminate
from markermend.model import Take
from markermend.simulate import simulate


@pytest.fixture(scope="module")
def take() -> Take:
    clean = simulate("static", 0, duration_s=5)
    clean = simulate("static", 0, duration_s=5)
    few = Take(clean.positions[:, :6], clean.rate, clean.labels[:6])
    return contaminate(few, seed=1)[0]


@pytest.mark.parametrize("detector", ["likelihood", "published"])
def test_progress_rises_to_the_end(
    detector: str, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "_WINDOW", 150)
    monkeypatch.setattr(findings, "_OVERLAP", 15)
    heard: list[tuple[int, int]] = []
    found = scan(take, detector, progress=lambda *both: heard.append(both))
    assert found == scan(take, detector)
    done, totals = [n for n, _ in heard], {total for _, total in heard}
    assert totals == {done[-1]}
    assert done == sorted(done)
    assert len(done) >= 4
