"""Fixtures for all tests."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of test recordings beside the checkout, which is not part of the project."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("the recordings for tests are not at hand: no folder ../shared")
    return folder


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    """The address of a PostgreSQL server that lives as long as this process of the tests."""
    with subprocess.Popen(
        [sys.executable, ROOT / "tests" / "postgres.py"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as server:
        assert server.stdout is not None
        assert server.stdin is not None
        said = json.loads(server.stdout.readline())
        try:
            if "why" in said:
                give_up = pytest.fail if said["fault"] and os.environ.get("CI") else pytest.skip
                give_up(said["why"])
            yield said["address"]
        finally:
            server.stdin.close()
            server.wait(timeout=60)
