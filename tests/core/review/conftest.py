from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import text

from markermend.model import Take
from markermend.review.schema import metadata
from markermend.review.store import Store

EMPTY = text(f"TRUNCATE {', '.join(metadata.tables)} RESTART IDENTITY")


@pytest.fixture
def file_store(tmp_path: Path) -> Iterator[Store]:
    """A store in a file."""
    with Store(tmp_path / "reviews.sqlite") as opened:
        yield opened


@pytest.fixture(scope="session")
def lab(postgres: str) -> str:
    """The address of a store on a server; use `server_store`, which leaves it empty."""
    Store(postgres).close()
    return postgres


@pytest.fixture
def server_store(lab: str) -> Iterator[Store]:
    """A store on a server."""
    with Store(lab) as opened:
        try:
            yield opened
        finally:
            with opened.transaction() as connection:
                connection.execute(EMPTY)


@pytest.fixture(params=["sqlite", "postgresql"])
def store(request: pytest.FixtureRequest) -> Store:
    """A store of either sort: what holds of one holds of the other."""
    named = "file_store" if request.param == "sqlite" else "server_store"
    found = request.getfixturevalue(named)
    assert isinstance(found, Store)
    return found


@pytest.fixture
def take() -> Take:
    """Two markers on smooth paths, 200 frames; A has a gap and a spike."""
    t = np.arange(200) / 100
    positions = np.stack(
        [
            np.stack([1000 * t, 100 * np.sin(3 * t), 900 + 50 * np.cos(5 * t)], axis=1),
            np.stack([1000 * t, 100 + 100 * np.sin(3 * t), 700 + 50 * np.cos(5 * t)], axis=1),
        ],
        axis=1,
    )
    positions[40:60, 0] = np.nan
    positions[120:123, 0, 2] += 30
    return Take(positions, 100.0, ("A", "B"))
