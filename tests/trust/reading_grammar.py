"""Files that are nearly right: every format built by its grammar with odd pieces (Hypothesis).

Mutated bytes seldom get past a header; these do.
"""

import io
import json
import struct
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from tests.trust._frame import Budget, Outcome, Tally
from tests.trust._law import fault_of, read_wholly
from tests.trust._seeds import decisions

from markermend.io.c3d_writer import write_c3d
from markermend.model import Take
from markermend.review.decisions import parse_decisions

MINUTES = 10.0
EXAMPLES = 3000
_BATCH = 100
"""The clock is looked at after so many."""

_HOSTILE = (
    "<img src=x onerror=alert(1)>", "=cmd|' /C calc'!A0", "../../etc/passwd", "x" * 200, "",
    "\u202egnp.exe", "a\u200bb", "قدم", "A", "A", "*3", "Ann:A", '"q"', "\ud800", "\0", "-TX",
)  # fmt: skip
labels = st.one_of(st.sampled_from(_HOSTILE), st.text(max_size=12))
cells = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-(10**6), 10**6).map(str),
    st.sampled_from(
        ["", " ", "NaN", "nan(ind)", "-1.#IND", "inf", "1e999", "1,5", '"2"', "--", "0", "0x1F",
         "1_000", "٣", "1e-400", "9" * 400, "=1+1"]
    ),
)  # fmt: skip
counts = st.one_of(st.integers(-1, 9), st.sampled_from([65535, 65536, 10**9, 2**63])).map(str)
ends = st.sampled_from(["\n", "\r\n", "\r", "\n\n"])
encodings = st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1", "utf-16-be"])


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for each format."""
    ways = WAYS if not budget.short else {name: WAYS[name] for name in ("trc", "c3d", "decisions")}
    for i, (name, way) in enumerate(ways.items()):
        yield _try(name, way, budget.share(1 / (len(ways) - i)))


def _try(name: str, way: st.SearchStrategy[bytes], budget: Budget) -> Outcome:
    examples = budget.of(EXAMPLES, 40)
    tally = Tally(f"files nearly right (Hypothesis): {name}", examples)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"input{_SUFFIX.get(name, '.csv')}"
        read: Callable[[bytes], object] = parse_decisions
        if name != "decisions":
            read = lambda data: (path.write_bytes(data), read_wholly(path))  # noqa: E731

        @settings(
            max_examples=min(examples, _BATCH), deadline=None, database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        @given(way)
        def check(data: bytes) -> None:
            tally.case(fault_of(lambda: read(data)))

        for batch in range(-(-examples // _BATCH)):
            if budget.spent:
                break
            seed(budget.seed + batch)(check)()
    return tally.outcome()


@st.composite
def _encoded(draw: st.DrawFn, lines: list[str]) -> bytes:
    text = draw(ends).join(lines)
    data = text.encode(draw(encodings), "replace")
    return data[: draw(st.integers(0, len(data)))] if draw(st.integers(0, 4)) == 0 else data


@st.composite
def _rows(draw: st.DrawFn, n_columns: int, separator: str) -> list[str]:
    rows = []
    for i in range(draw(st.integers(0, 5))):
        width = max(0, n_columns + draw(st.sampled_from([0, 0, 0, 0, -1, -3, 1, 3])))
        row = draw(st.lists(cells, min_size=width, max_size=width))
        first = draw(st.sampled_from([str(i + 1), str(i), "", "7", "nan", "1e5"]))
        rows.append(separator.join([first, *row]))
    return rows


@st.composite
def _trc(draw: st.DrawFn) -> bytes:
    names = draw(st.lists(labels, max_size=4))
    unit = draw(st.sampled_from(["mm", "m", "inch", "", "x" * 300]))
    said = [draw(counts), draw(counts), draw(counts), draw(counts), unit, "1", "1", draw(counts)]
    keys = "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate Start OrigNumFrames"
    head = [
        "PathFileType\t4\t(X/Y/Z)\tx.trc", "\t".join(keys.split()), "\t".join(said),
        "Frame#\tTime\t" + "\t\t\t".join(names), "",
    ]  # fmt: skip
    return draw(_encoded(head + draw(_rows(1 + 3 * len(names), "\t"))))


@st.composite
def _tsv(draw: st.DrawFn) -> bytes:
    names = draw(st.lists(labels, max_size=4))
    head = [
        f"NO_OF_FRAMES\t{draw(counts)}", f"NO_OF_MARKERS\t{draw(counts)}",
        f"FREQUENCY\t{draw(counts)}", f"DATA_INCLUDED\t{draw(st.sampled_from(['3D', '6D', '']))}",
        "MARKER_NAMES\t" + "\t".join(names),
    ]  # fmt: skip
    if draw(st.booleans()):
        head.append("Frame\tTime\t" + "\t".join(f"{n} {a}" for n in names for a in "XYZ"))
    return draw(_encoded(head + draw(_rows(1 + 3 * len(names), "\t"))))


@st.composite
def _nexus(draw: st.DrawFn) -> bytes:
    names = draw(st.lists(labels, max_size=4))
    mark = draw(st.sampled_from(",;\t"))
    blank = mark * 2
    head = [
        "Trajectories", draw(counts), blank + blank.join(f"{n}{mark}" for n in names),
        mark.join(["Frame", "Sub Frame", *(["X", "Y", "Z"] * len(names))]),
        mark.join(["", "", *(["mm", "mm", "mm"] * len(names))]),
    ]  # fmt: skip
    return draw(_encoded(head + draw(_rows(1 + 3 * len(names), mark))))


@st.composite
def _motive(draw: st.DrawFn) -> bytes:
    names = draw(st.lists(labels, max_size=4))
    kind = draw(st.sampled_from(["Marker", "Rigid Body", "Bone Marker", ""]))
    length = draw(st.sampled_from(["Meters", "Millimeters", "q"]))
    said = ["Format Version", "1.23", "Export Frame Rate", draw(counts)]
    said += ["Total Exported Frames", draw(counts), "Length Units", length]
    head = [
        ",".join(said), "",
        *(",," + ",".join(x for name in names for x in [f(name)] * 3) for f in (
            lambda _: kind, lambda name: name, lambda _: "1", lambda _: "Position")),
        "Frame,Time," + ",".join("XYZ" * len(names)),
    ]  # fmt: skip
    return draw(_encoded(head + draw(_rows(1 + 3 * len(names), ","))))


@st.composite
def _plain(draw: st.DrawFn) -> bytes:
    names = draw(st.lists(labels, min_size=1, max_size=4))
    mark = draw(st.sampled_from(",;\t"))
    style = draw(st.sampled_from(["-T", "_", " ", ".", ":", ""]))
    head = mark.join(["Frame", "Time", *(f"{n}{style}{a}" for n in names for a in "XYZ")])
    return draw(_encoded([head, *draw(_rows(1 + 3 * len(names), mark))]))


_numbers = st.one_of(
    st.floats(), st.integers(-(2**70), 2**70), st.none(), st.text(max_size=3), st.booleans()
)


@st.composite
def _json(draw: st.DrawFn) -> bytes:
    person = st.fixed_dictionaries(
        {"pose_keypoints_2d": st.lists(_numbers, max_size=9)}, optional={"x": labels}
    )
    sizes = draw(st.sampled_from([3, 54, 75]))
    good = st.lists(st.floats(0, 999), min_size=sizes, max_size=sizes)
    people = draw(
        st.lists(st.one_of(person, good.map(lambda x: {"pose_keypoints_2d": x})), max_size=3)
    )
    return json.dumps({"version": 1.3, "people": people}).encode()


@st.composite
def _npz(draw: st.DrawFn) -> bytes:
    shape = draw(st.lists(st.integers(0, 4), min_size=1, max_size=4))
    kinds = ["f8", "f4", "f2", "i8", "u1", "c16", "b1", "U3", "S3", "M8[s]", ">f8", "f16"]
    kind = draw(st.sampled_from(kinds))
    shape = draw(st.sampled_from([shape, [3, 2, 3], [4, 2, 2]]))
    arrays = {"positions": np.ones(shape).astype(kind if kind != "M8[s]" else "i8").astype(kind)}
    if draw(st.booleans()):
        names = draw(st.lists(labels, max_size=3))
        arrays["labels"] = np.array(names, dtype=np.str_)
    odd = st.sampled_from([np.nan, np.inf, -1.0, 0.0, 100.0, 1e308])
    for name in ("rate", "first_frame", "units", "roles", "event_labels", "event_times_s",
                 "event_contexts"):  # fmt: skip
        if draw(st.integers(0, 2)) == 0:
            arrays[name] = np.array(draw(st.one_of(odd, labels, st.lists(odd, max_size=3))))
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


@st.composite
def _c3d(draw: st.DrawFn) -> bytes:
    n_frames, n_points = draw(st.integers(1, 5)), draw(st.integers(1, 4))
    names = draw(st.lists(labels, min_size=n_points, max_size=n_points, unique=True))
    named = [
        name.encode("utf-8", "replace").decode()[:120] or f"m{i}" for i, name in enumerate(names)
    ]
    named = [f"{name}{i}" for i, name in enumerate(named)]
    odd = st.floats(width=32)
    values = draw(st.lists(odd, min_size=3 * n_points * n_frames, max_size=3 * n_points * n_frames))
    clean = np.nan_to_num(
        np.array(values).reshape(n_frames, n_points, 3), posinf=1e30, neginf=-1e30
    )
    data = bytearray(write_c3d(Take(clean, draw(st.sampled_from([1e-3, 100.0, 1e6])), named)))
    for _ in range(draw(st.integers(0, 3))):  # words of the header and bytes of the parameters
        if draw(st.booleans()):
            word = draw(st.sampled_from([1, 2, 3, 4, 6, 8, 9, 10]))
            struct.pack_into("<H", data, 2 * word, draw(st.sampled_from([0, 1, 2, 255, 65535])))
        else:
            at = draw(st.integers(512, min(len(data), 1536) - 1))
            data[at] = draw(st.integers(0, 255))
    return bytes(data)


_plain_json = st.recursive(
    st.one_of(_numbers, labels), lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(st.sampled_from(["a", "span", "verdict"]), inner, max_size=3), max_leaves=6,
)  # fmt: skip


@st.composite
def _decisions(draw: st.DrawFn) -> bytes:
    """Take a right file and put anything at one or two places of it."""
    content = json.loads(decisions())
    for _ in range(draw(st.integers(1, 2))):
        place = content
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = draw(st.sampled_from(keys))
            deeper = isinstance(place[key], dict | list) and draw(st.integers(0, 4)) > 0
            if deeper:
                place = place[key]
                continue
            how = draw(st.integers(0, 5))
            if how == 0:
                del place[key]
            else:
                place[key] = draw(_plain_json)
            break
    return json.dumps(content).encode("utf-8", "replace")


WAYS = {
    "c3d": _c3d(), "trc": _trc(), "qtm_tsv": _tsv(), "nexus_csv": _nexus(),
    "motive_csv": _motive(), "plain_csv": _plain(), "npz": _npz(), "openpose": _json(),
    "decisions": _decisions(),
}  # fmt: skip
_SUFFIX = {"c3d": ".c3d", "trc": ".trc", "qtm_tsv": ".tsv", "npz": ".npz", "openpose": ".json"}
