"""One coverage-guided run of one parser, in a process that libFuzzer may end as it likes.

Run as ``python -m tests.trust._fuzzed TARGET RUNS SEED SECONDS FOLDER``; it leaves ``count.json``
and ``fault-*`` in the folder. libFuzzer ends the process by itself when one input takes longer
than `SLOWEST_S` or more than `MOST_MB` of memory: the input is then left in ``slow-*``, ``oom-*``.
"""

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import atheris

with atheris.instrument_imports(
    include=["markermend.io", "markermend.recipes", "markermend.review.records"]
):
    import markermend.io
    import markermend.io.formats.c3d
    import markermend.io.formats.motive_csv
    import markermend.io.formats.nexus_csv
    import markermend.io.formats.npz
    import markermend.io.formats.openpose
    import markermend.io.formats.plain_csv
    import markermend.io.formats.qtm_tsv
    import markermend.io.formats.trc
    import markermend.recipes
    import markermend.review.decisions

import numpy as np
from tests.trust._law import fault_of, read_wholly
from tests.trust._seeds import seeds

from markermend.errors import CannotWrite
from markermend.io import Reading
from markermend.io.format import all_formats
from markermend.model import FloatArray

SLOWEST_S = 20
MOST_MB = 3000
_WORDS = (
    "NaN", "nan", "inf", "-1", "1e308", "1e-320", "65535", "65536", "0x", "1_0", "\\x00", "\\xff",
    "\\x09", "\\x0d\\x0a", ";", ",", "\\xef\\xbb\\xbf", "\\xff\\xfe", "NO_OF_FRAMES",
    "MARKER_NAMES",
    "DATA_INCLUDED", "FREQUENCY", "PathFileType", "Frame#", "DataRate", "Units", "Trajectories",
    "Sub Frame", "Format Version", "Position", "pose_keypoints_2d", "people", "POINT", "LABELS",
    "USED", "SCALE", "FRAMES", "DATA_START", "positions", "-TX", "-TY", "-TZ", "findings",
    "verdict", "accepted", "null", "1e999", "sensitivity", "repair", "kinds", "parameters",
)  # fmt: skip


def target(name: str, folder: Path) -> Callable[[bytes], object]:
    """Give what is done with one input."""
    if name == "decisions":
        return markermend.review.decisions.parse_decisions
    if name == "recipe":
        file = folder / "recipe.json"
        return lambda data: (file.write_bytes(data), markermend.recipes.read_recipe(file))
    format_ = next(f for f in all_formats() if f.name == name)
    path = folder / f"input{format_.extensions[0]}"

    def read(data: bytes) -> None:
        path.write_bytes(data)
        take = read_wholly(path)
        if format_.patching is None or len(data) % 8:
            return
        # Every eighth input that reads is also patched, and must come back as it should.
        reading = Reading()
        before = format_.patching.positions(data, reading)
        if take is None or before.size == 0:
            return
        rng = np.random.default_rng(len(data))
        _patch(format_.patching, data, before, rng)

    return read


def _patch(patching, data: bytes, before: FloatArray, rng: np.random.Generator) -> None:
    frame, point = (int(rng.integers(n)) for n in before.shape[:2])
    wanted, changed = before.copy(), np.zeros(before.shape[:2], bool)
    wanted[frame, point] = rng.uniform(-300, 300, before.shape[2])
    changed[frame, point] = True
    try:
        patch = patching.patch(data, Reading(), wanted, changed)
        new = bytes(patch.data)
        differs = patching.compare(data, new, Reading())
        after = patching.positions(new, Reading())
    except CannotWrite:
        return
    # `export` refuses to write where one of these does not hold; here only a crash is a fault.
    del differs, after


def main(arguments: list[str]) -> None:
    """Fuzz, as the module's docstring says."""
    name, runs, seed, seconds, where = arguments
    folder = Path(where)
    corpus = folder / "corpus"
    corpus.mkdir()
    for i, data in enumerate(seeds(name)):
        (corpus / f"seed-{i}").write_bytes(data)
    words = folder / "words"
    words.write_text("".join(f'"{word}"\n' for word in _WORDS), encoding="ascii")
    longest = max(path.stat().st_size for path in corpus.iterdir())
    count, faults = 0, set[str]()

    with tempfile.TemporaryDirectory() as scratch:
        act = target(name, Path(scratch))

        def once(data: bytes) -> None:
            nonlocal count
            count += 1
            fault = fault_of(lambda: act(data))
            if fault and fault not in faults:
                faults.add(fault)
                (folder / f"fault-{len(faults)}").write_bytes(data)
            if count % 100 == 0 or fault:
                record = {"count": count, "faults": sorted(faults)}
                (folder / "count.json").write_text(json.dumps(record), encoding="utf-8")

        options = [
            f"-runs={runs}", f"-seed={seed}", f"-max_len={longest + 2048}", f"-dict={words}",
            f"-timeout={SLOWEST_S}", f"-rss_limit_mb={MOST_MB}", f"-artifact_prefix={folder}/",
            f"-max_total_time={int(float(seconds))}", "-len_control=0", "-verbosity=0",
            "-print_final_stats=0",
        ]  # fmt: skip
        atheris.Setup([sys.argv[0], str(corpus), *options], once, enable_python_coverage=True)
        atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
