"""One performance of every scenario, shared by all tests of this folder."""

from collections.abc import Callable
from functools import cache

import pytest

from markermend.model import Take
from markermend.simulate import perform, simulate
from markermend.simulate.frames import Movement

SEED = 3


@pytest.fixture(scope="session")
def moved() -> Callable[[str], Movement]:
    return cache(lambda scenario: perform(scenario, SEED))


@pytest.fixture(scope="session")
def taken() -> Callable[[str], Take]:
    return cache(lambda scenario: simulate(scenario, SEED))


@pytest.fixture(scope="session")
def glued() -> Callable[[str], Take]:
    return cache(lambda scenario: simulate(scenario, SEED, measured=False))
