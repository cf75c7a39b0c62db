"""Fill gaps whose truth is known, and compare with what other programs did on the same gaps.

A protocol is a folder with a file of masks (JSON), ``datasets.json``, ``data/NAME.npy`` with the
complete recordings, and, where at hand, ``peers_per_gap.csv`` with the errors of other programs.
"""

import csv
import json
import math
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from markermend.errors import BadInput, CannotRepair
from markermend.model import Span, Take
from markermend.repairing.run import REPAIRS, repair

BEST_OF = ("WPCA_R2", "GLR", "LPR", "LGRNN", "LI", "PMA", "gapfill_rbt4", "cubic", "pchip")
"""The other programs among which the best one is looked for."""

Gap = tuple[str, int]
"""Identity of a mask and number of the gap in it."""


@dataclass(frozen=True)
class GapError:
    """How one method did on one gap.

    Attributes
    ----------
    mask, gap
        Which gap.
    dataset, seed, cell
        The recording, the seed of the mask, and the group that means are taken over: protocol and
        length, or protocol, number of gaps and share.
    method
        Name of the repair.
    mean_mm, max_mm
        Mean (Li et al. 2020, Eq. 17) and largest distance to the truth over the gap's frames; NaN
        where the method refused.
    seconds
        Time for this gap.
    refusal
        Why it was not filled, or empty.
    """

    mask: str
    gap: int
    dataset: str
    seed: int
    cell: str
    method: str
    mean_mm: float
    max_mm: float
    seconds: float
    refusal: str = ""


@dataclass(frozen=True)
class Row:
    """One cell of the table of a method, beside the other programs.

    Attributes
    ----------
    n, left
        Gaps, and how many of them were not filled.
    mean_mm, sd_mm, median_mm
        Over the gaps that were filled.
    best, best_mm, ratio
        The other program with the lowest mean on the gaps for which all of `BEST_OF` have a
        number, that mean, and ours on the same gaps divided by it; empty and NaN without any.
    ms
        Mean time for a gap.
    """

    cell: str
    method: str
    n: int
    left: int
    mean_mm: float
    sd_mm: float
    median_mm: float
    best: str
    best_mm: float
    ratio: float
    ms: float


def evaluate_masks(
    file: Path,
    methods: Sequence[str],
    *,
    parameters: Mapping[str, Any] | None = None,
    datasets: Collection[str] = (),
    lengths: Collection[int] = (),
    seeds: Collection[int] = (),
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[GapError, ...]:
    """Fill every gap of a protocol by every method.

    Parameters
    ----------
    file
        The masks.
    methods
        Names of registered repairs.
    parameters
        Parameters handed to every method.
    datasets, lengths, seeds
        Only these; all where empty.
    workers
        Processes to work with; the result does not depend on their number.
    progress
        Called with the masks done and their total.

    Raises
    ------
    BadInput
        If the file is no protocol, or nothing of it is wanted.
    UnknownName
        If there is no such method.
    """
    for name in methods:
        REPAIRS.get(name)
    try:
        described = json.loads((file.parent / "datasets.json").read_text())
        masks = [
            m
            for m in json.loads(file.read_text())
            if (not datasets or m["dataset"] in datasets)
            and (not lengths or m["length"] in lengths)
            and (not seeds or m["seed"] in seeds)
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(
            f"{file} is no file of masks beside its datasets.json ({error}); name such a file."
        ) from None
    if not masks:
        raise BadInput(f"{file} has no mask of the kind wanted; ask for other ones.")
    work = partial(
        _one_mask,
        folder=file.parent,
        described=described,
        methods=tuple(methods),
        parameters=dict(parameters or {}),
    )
    errors: list[GapError] = []
    for done, found in enumerate(_mapped(work, masks, workers), 1):
        errors += found
        progress(done, len(masks))
    return tuple(errors)


def _mapped(
    work: Callable[[Any], list[GapError]], masks: Sequence[Any], workers: int
) -> Iterator[list[GapError]]:
    if workers == 1:
        yield from map(work, masks)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(work, masks)


def _one_mask(
    mask: dict[str, Any],
    folder: Path,
    described: dict[str, Any],
    methods: tuple[str, ...],
    parameters: dict[str, Any],
) -> list[GapError]:
    name = mask["dataset"]
    first, last = mask["window"]
    array = np.load(folder / "data" / f"{name}.npy", mmap_mode="r")
    truth = np.array(array[first:last, mask["markers"]])
    labels = tuple(described[name]["labels"][m] for m in mask["markers"])
    gaps = [
        (mask["markers"].index(g["marker"]), Span(g["start"] - first, g["stop"] - first))
        for g in mask["gaps"]
    ]
    seen = truth.copy()
    for marker, span in gaps:
        seen[span.frames, marker] = np.nan
    take = Take(seen, described[name]["rate"], labels)
    errors = []
    for i, (marker, span) in enumerate(gaps):
        for method in methods:
            start = time.perf_counter()
            mean = worst = math.nan
            refusal = ""
            try:
                done = repair(take, labels[marker], span, method, **parameters)
                off = np.linalg.norm(done.values - truth[span.frames, marker], axis=1)
                mean, worst = float(off.mean()), float(off.max())
            except CannotRepair as error:
                refusal = str(error)
            spent = time.perf_counter() - start
            errors.append(
                GapError(
                    mask["id"], i, name, mask["seed"], _cell(mask), method, mean, worst, spent,
                    refusal,
                )
            )  # fmt: skip
    return errors


def _cell(mask: dict[str, Any]) -> str:
    if "frac" in mask:
        return f"{mask['protocol']} {mask['ngaps']} gaps of {mask['frac']:.0%}"
    return f"{mask['protocol']} {mask['length']} frames"


def read_peers(file: Path) -> dict[str, dict[Gap, float]]:
    """Read the other programs' errors: program -> gap -> mm, NaN where it failed.

    A program's runs in its own code go before those of a port of it, and runs whose name ends in
    ``_w7`` (its smoothing window forced to be odd) replace the others.
    """
    rows: dict[str, dict[Gap, float]] = {}
    with file.open(newline="") as lines:
        ranked = sorted(
            csv.DictReader(lines),
            key=lambda r: (r["method"].endswith("_w7"), r["engine"] != "port"),
        )
    for row in ranked:
        program = row["method"].removesuffix("_w7")
        error = float(row["err_mm"]) if row["err_mm"] else math.nan
        rows.setdefault(program, {})[row["mask_id"], int(row["gap"])] = error
    return rows


def table(
    errors: Iterable[GapError], peers: Mapping[str, Mapping[Gap, float]] | None = None
) -> tuple[Row, ...]:
    """Summarise errors by cell and method, beside the best other program of the cell."""
    groups: dict[tuple[str, str], list[GapError]] = {}
    for error in errors:
        groups.setdefault((error.cell, error.method), []).append(error)
    return tuple(_row(cell, name, found, peers or {}) for (cell, name), found in groups.items())


def _row(
    cell: str, name: str, found: list[GapError], peers: Mapping[str, Mapping[Gap, float]]
) -> Row:
    means = np.array([e.mean_mm for e in found])
    filled = means[np.isfinite(means)]
    common = [
        (e, [peers[p][e.mask, e.gap] for p in BEST_OF])
        for e in found
        if all(math.isfinite(peers.get(p, {}).get((e.mask, e.gap), math.nan)) for p in BEST_OF)
    ]
    best, best_mm, ratio = "", math.nan, math.nan
    if common:
        theirs = np.mean([numbers for _, numbers in common], axis=0)
        best, best_mm = BEST_OF[int(theirs.argmin())], float(theirs.min())
        ratio = float(np.mean([e.mean_mm for e, _ in common])) / best_mm
    return Row(
        cell,
        name,
        len(found),
        len(found) - len(filled),
        float(filled.mean()) if len(filled) else math.nan,
        float(filled.std()) if len(filled) else math.nan,
        float(np.median(filled)) if len(filled) else math.nan,
        best,
        best_mm,
        ratio,
        1000 * float(np.mean([e.seconds for e in found])),
    )


def against(errors: Iterable[GapError], peer: Mapping[Gap, float]) -> tuple[int, float, float]:
    """Compare one method with one program on the gaps that both have filled.

    Returns
    -------
    Number of gaps, our mean and theirs in mm.
    """
    pairs = [
        (e.mean_mm, peer[e.mask, e.gap])
        for e in errors
        if math.isfinite(e.mean_mm) and math.isfinite(peer.get((e.mask, e.gap), math.nan))
    ]
    if not pairs:
        return 0, math.nan, math.nan
    ours, theirs = np.mean(pairs, axis=0)
    return len(pairs), float(ours), float(theirs)
