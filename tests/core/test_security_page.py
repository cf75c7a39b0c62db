"""Every promise of SECURITY.md names a test that is there."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_every_test_that_the_page_names_is_there() -> None:
    page = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if re.match(r"\| [A-Z]", line)]
    assert len(rows) > 12
    for row in rows:
        named = re.findall(r"`((?:tests/[\w/]+\.py)?(?:::\w+)?)`", row.rpartition(" | ")[2])
        assert named, f"no test holds: {row}"
        file = ""
        for place in named:
            path, _, test = place.partition("::")
            file = path or file
            text = (ROOT / file).read_text(encoding="utf-8")
            assert not test or f"def {test}(" in text, place
