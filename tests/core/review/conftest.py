from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from markermend.model import Take
from markermend.review.store import Store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "reviews.sqlite") as opened:
        yield opened


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
