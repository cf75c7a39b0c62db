"""Files through ezc3d's child process: it may crash, hang or fill its memory; we may not."""

import os
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

import psutil
from tests.trust._frame import Budget, Outcome, Tally, recordings
from tests.trust._law import fault_of
from tests.trust._seeds import seeds

from markermend.io import second_reader
from markermend.io.c3d_layout import layout_in

MINUTES = 34.0
INPUTS = 3000
LIMIT_S = 4.0
"""Of a child that has a processor to itself; on a busy machine as many times more."""
_WORST = ("HANG_BKINtechnologies.c3d", "SEGV_trcreader_01.c3d", "gen_flip_v10.c3d")


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for mutated files and one for the files that are known to be the worst."""
    yield _worst(budget)
    yield _mutated(budget)


def _mutated(budget: Budget) -> Outcome:
    inputs = budget.of(INPUTS, 3)
    tally = Tally("mutated C3D files through ezc3d's child process", inputs)
    rng = random.Random(budget.seed)
    begun = [data for data in seeds("c3d") if len(data) > 1024]
    ends: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "input.c3d"
        for _ in range(inputs):
            if budget.spent:
                break
            path.write_bytes(mutated(rng.choice(begun), rng))
            tally.case(_ask(path, ends))
    said = ", ".join(f"{n} {end}" for end, n in sorted(ends.items()))
    return tally.outcome(said)


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Flip bytes, most of them in the header and the parameters, cut, repeat, exchange."""
    new = bytearray(data)
    try:
        head = layout_in(data).data_start
    except Exception:  # noqa: BLE001 - a seed that is odd already
        head = 1024
    for _ in range(rng.choice((1, 1, 2, 3, 8, 30))):
        at = rng.randrange(min(len(new), head if rng.random() < 0.9 else len(new)))
        how = rng.random()
        if how < 0.5:
            new[at] = rng.choice((0, 1, 2, 127, 128, 255, rng.randrange(256)))
        elif how < 0.7:
            new[at : at + 2] = rng.choice((0, 1, 32767, 32768, 65535)).to_bytes(2, "little")
        elif how < 0.85:
            other = rng.randrange(len(new))
            new[at : at + 16] = new[other : other + 16]
        elif how < 0.95:
            new[at] ^= 1 << rng.randrange(8)
        else:
            del new[max(at, 600) :]
    return bytes(new)


def _ask(path: Path, ends: dict[str, int]) -> str:
    """Ask ezc3d about one file, and give the fault."""
    given: list[second_reader.Opinion] = []
    limit = LIMIT_S * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
    fault = fault_of(lambda: given.append(second_reader.ask(path, limit)))
    end = " ".join(given[0].trouble.split()[:2]) if given and given[0].trouble else "read"
    end = {"did not": "hung", "crashed on": "crashed", "refused it": "refused"}.get(end, end)
    ends[end] = ends.get(end, 0) + 1
    children = psutil.Process().children(recursive=True)
    return fault or (f"{len(children)} children are left" if children else "")


def _worst(budget: Budget) -> Outcome:
    tally = Tally("files that crash or hang ezc3d: read, and nothing left running")
    before = psutil.Process().memory_info().rss
    files = [p for p in recordings() if p.name in _WORST and p.parent.name == "odd"]
    for path in files if not budget.short else files[1:]:
        ends: dict[str, int] = {}
        tally.case(_ask(path, ends))
    grown = psutil.Process().memory_info().rss - before
    tally.case(f"the reader grew by {grown / 1e6:.0f} MB" if grown > 300e6 else "")
    return tally.outcome()
