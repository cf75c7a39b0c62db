"""How well markers can be predicted: the tables behind Figs. 3, 6, 7 and 9."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from markermend.body import infer
from markermend.detection.published.interpolate import interpolated
from markermend.errors import BadInput, UnknownName
from markermend.evaluate import prediction_measures
from markermend.evaluate.prediction_measures import Case
from markermend.evaluate.prediction_tables import Predictors
from markermend.model import Take

TABLES = ("correlation", "residuals", "sweep", "replicas", "regressors")


def predictors(
    take: Take,
    *,
    tables: Iterable[str] = TABLES,
    markers: Sequence[str] = (),
    n_markers: int = 8,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Predictors:
    """Measure how well markers of a take are predicted, and by what.

    Parameters
    ----------
    take
        The take.
    tables
        Which of correlation, residuals, sweep, replicas, regressors to make.
    markers
        Labels of the markers to look at (the correlation takes all); by default `n_markers`,
        evenly through the body.
    n_markers
        How many, where no labels are given.
    seed
        Of networks and trees.
    progress
        Called with the number of tables made and of all.

    Raises
    ------
    UnknownName
        If a table or a marker is unknown.
    BadInput
        If the take is shorter than two seconds or has no marker with neighbours.

    Notes
    -----
    Skurowski & Pawlyta, Figs. 3, 6, 7 and 9, and the regressors named in sections 3.3.2 and 4.2.1.
    Held-out figures are of contiguous folds with a pause beside them: interleaved frames leak.
    """
    wanted = tuple(tables)
    for table in wanted:
        if table not in TABLES:
            raise UnknownName.among("table", table, TABLES)
    case = _case(take, markers, n_markers, seed)
    made: dict[str, Any] = {}
    makers = {
        "correlation": prediction_measures.correlation,
        "residuals": prediction_measures.residuals,
        "sweep": prediction_measures.sweep,
        "replicas": prediction_measures.replicas,
        "regressors": prediction_measures.regressors,
    }
    for done, table in enumerate(wanted, 1):
        with threadpool_limits(1):
            made[table] = makers[table](case)
        progress(done, len(wanted))
    labels = tuple(take.labels[m] for m in case.markers)
    return Predictors(take.n_frames, take.rate, labels, seed, **made)


def _case(take: Take, markers: Sequence[str], n_markers: int, seed: int) -> Case:
    if take.duration_s < 2.0:
        raise BadInput(
            f"The take lasts {take.duration_s:.2g} s; predictors are measured on 2 s or more."
        )
    body = infer(take)
    able = [m for m in body.order if body.neighbours(m)]
    if not able:
        raise BadInput(
            "No marker of the take has neighbours; give a take with two markers or more."
        )
    if markers:
        chosen = [take.index(label) for label in markers]
        for marker in chosen:
            if marker not in able:
                raise BadInput(f"{take.labels[marker]} has no neighbours; choose another marker.")
    else:
        places = np.linspace(0, len(able) - 1, min(n_markers, len(able))).round().astype(int)
        chosen = [able[place] for place in places]
    shape = take.positions.shape
    flat = take.positions.reshape(shape[0], -1)
    positions = interpolated(flat, ~np.isfinite(flat)).reshape(shape)
    return Case(positions, take.seen, take.rate, take.labels, body, tuple(chosen), seed)
