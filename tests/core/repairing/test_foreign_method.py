"""A package of somebody else's adds a method, and nothing of ours is edited."""

import importlib
import sys

import pytest

from markermend.errors import BadParameter, MarkerMendError
from markermend.repairing.run import REPAIRS, repair

METHOD = '''
"""A repair method of another distribution."""
from typing import Annotated
import numpy as np
from markermend.params import Within
from markermend.registry import method

@method(title="Halfway house", kinds=("gap",), source="nobody's paper")
def halfway(problem, *, share: Annotated[float, Within(0, 1)] = 0.5):
    """Stand still somewhere between the edges.

    Parameters
    ----------
    share
        0 is the edge before, 1 the edge after.
    """
    a, b = problem.own[problem.span.start - 1], problem.own[problem.span.stop]
    return np.repeat([a + share * (b - a)], len(problem.span), axis=0)

def unmarked(problem):
    return problem.own[problem.span.frames]
'''


@pytest.fixture
def foreign(tmp_path, monkeypatch):
    """Install a distribution with two entry points, for one test."""
    (tmp_path / "someones_mend.py").write_text(METHOD)
    info = tmp_path / "someones_mend-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: someones-mend\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[markermend.repairs]\nhalfway = someones_mend:halfway\nunmarked = someones_mend:unmarked\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    REPAIRS.__dict__.pop("_foreign", None)
    yield
    REPAIRS.__dict__.pop("_foreign", None)
    sys.modules.pop("someones_mend", None)


@pytest.mark.usefixtures("foreign")
def test_is_found_with_all_that_is_said_of_it():
    found = REPAIRS.get("halfway")
    assert "halfway" in REPAIRS.names()
    assert (found.title, found.summary) == (
        "Halfway house",
        "Stand still somewhere between the edges.",
    )
    (share,) = found.parameters
    assert (share.default, str(share.bounds)) == (0.5, "0 to 1")
    assert share.doc == "0 is the edge before, 1 the edge after."


@pytest.mark.usefixtures("foreign")
def test_repairs_with_checked_parameters(lab):
    given = lab.case()
    done = repair(given.take, given.marker, given.span, "halfway", share=0)
    before = given.take.positions[given.span.start - 1, given.take.index(given.marker)]
    assert (done.values == before).all()
    assert done.parameters == {"share": 0.0}
    with pytest.raises(BadParameter, match="share must be a number in 0 to 1"):
        repair(given.take, given.marker, given.span, "halfway", share=2)


@pytest.mark.usefixtures("foreign")
def test_that_is_not_marked_is_refused_in_a_sentence():
    with pytest.raises(MarkerMendError, match="under @method; mark it so"):
        REPAIRS.get("unmarked")


def test_leaves_no_trace_behind():
    assert "halfway" not in REPAIRS.names()
