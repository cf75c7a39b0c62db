"""Five models of where a marker is, their average, and the skeleton's say in it.

After M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018: local interpolation (LI),
local polynomial regression (LPR), local generalised regression neural network (LGRNN), global
linear regression (GLR), weighted PCA, and their probabilistic averaging (PMA).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.repairing.pca import Settings, centred, fill_r2
from markermend.repairing.remembering import remembered
from markermend.repairing.smoothing import smooth_runs
from markermend.repairing.triads import Triad, keep_distances, triad
from markermend.repairing.window import Window

LOCAL_FRAMES, GLOBAL_FRAMES, DENSITY_FRAMES = 1000, 500, 500
"""Frames that suffice to learn a local model, a global one, a distribution of distances."""


@dataclass(frozen=True)
class Recovery:
    """What the models share.

    Attributes
    ----------
    smoothing_s
        Duration that references and results are smoothed over.
    quantile
        Share of distances on either side that counts as unusual.
    spread
        Width of the neural network's kernel, in standard deviations.
    loosest
        Largest variation of the distance, in mm, with which a marker enters the global model.
    by_axis
        Whether medians and unit variances are taken axis by axis, as in the paper; if not, the
        result turns with the room.
    """

    smoothing_s: float = 0.07
    quantile: float = 0.01
    spread: float = 0.3
    loosest: float = 1000.0
    by_axis: bool = True


Model = Callable[[Triad, Recovery], FloatArray]


def recover(cut: Window, models: Sequence[Model], settings: Recovery) -> FloatArray:
    """Fill the span by one model, or by several weighted by how usual their distances are.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If there are too few references, or no model applies.
    """
    place = triad(cut, settings.smoothing_s, settings.by_axis)
    found, refusals = [], []
    for model in models:
        try:
            found.append(model(place, settings))
        except CannotRepair as refusal:
            refusals.append(refusal)
    if not found:
        raise refusals[0]
    references = cut.positions[place.stretch][:, place.references]
    points = found[0] if len(found) == 1 else average(place, found, references, settings.by_axis)
    known = place.distances[np.isfinite(place.distances).all(axis=1)]
    usual = np.quantile(known, [settings.quantile, 1 - settings.quantile], axis=0, method="hazen")
    return _smoothed(place, keep_distances(points, references, usual), settings.by_axis)


def _smoothed(place: Triad, points: FloatArray, by_axis: bool) -> FloatArray:
    reach = 2 * place.width
    near = slice(max(0, place.stretch.start - reach), place.stretch.stop + reach)
    curve = place.cut.own[near].copy()
    start = place.stretch.start - near.start
    curve[start : start + place.size] = points
    return place.inner(smooth_runs(curve, place.width, by_axis)[start : start + place.size])


def average(
    place: Triad, found: Sequence[FloatArray], references: FloatArray, by_axis: bool
) -> FloatArray:
    """Weight curves, frame by frame, by the density of their distances to the references."""
    known = place.distances[np.isfinite(place.distances).all(axis=1)]
    samples = known[_some(len(known), DENSITY_FRAMES)]
    curves = [smooth_runs(curve, place.width, by_axis) for curve in found]
    width = min(place.width, 2 * ((place.size - 2) // 4) + 1)
    weights = []
    for curve in curves:
        distance = np.linalg.norm(curve[:, None] - references, axis=2)
        density = np.prod([_density(samples[:, j], distance[:, j]) for j in range(3)], axis=0)
        weights.append(smooth_runs(np.maximum(density, 1e-200)[:, None], width))
    total = np.sum(weights, axis=0)
    return np.asarray(np.sum([w * c for w, c in zip(weights, curves, strict=True)], axis=0) / total)


def _density(samples: FloatArray, at: FloatArray) -> FloatArray:
    """Estimate a density by Gaussian kernels of the normal-optimal width (Silverman 1986)."""
    deviation = np.median(np.abs(samples - np.median(samples))) / 0.6745
    width = max(deviation, 1e-6) * (4.0 / (3.0 * len(samples))) ** 0.2
    bells = np.exp(-0.5 * np.square((at[:, None] - samples) / width))
    return np.asarray(bells.mean(axis=1) / (width * np.sqrt(2 * np.pi)))


def _some(n: int, enough: int) -> NDArray[np.intp]:
    """Choose `enough` of n frames evenly, or every second, third ... of very many."""
    if n >= 2 * enough:
        return np.arange(0, n, n // enough)
    return np.unique(np.linspace(0, n - 1, min(n, enough)).round().astype(np.intp))


@remembered
def interpolate_locally(place: Triad, settings: Recovery) -> FloatArray:
    """LI: a straight line in the local frame."""
    if not (place.before or place.after):
        raise CannotRepair(
            f"{place.cut.label} is seen on neither side nearby; choose a method that learns."
        )
    local = place.axes.to_local(place.cut.own[place.stretch])
    first = local[0] if place.before else local[-1]
    last = local[-1] if place.after else local[0]
    return place.axes.to_world(np.linspace(first, last, place.size))


def _local_features(place: Triad) -> FloatArray:
    """Give what the references' own triangle looks like: (n_frames, 3) mm."""
    second, third = (place.smooth_axes.to_local(place.smooth_references[:, j]) for j in (1, 2))
    return np.column_stack([second[:, 0], third[:, 0], third[:, 1]])


def _standardised(features: FloatArray) -> FloatArray:
    deviation = np.nanstd(features, axis=0, ddof=1)
    return np.asarray(
        (features - np.nanmean(features, axis=0)) / np.where(deviation > 0, deviation, 1.0)
    )


def _trained_on(
    place: Triad, features: FloatArray, own: FloatArray, enough: int
) -> NDArray[np.intp]:
    frames = np.flatnonzero(np.isfinite(features).all(axis=1) & np.isfinite(own[:, 0]))
    if len(frames) < 2:
        raise CannotRepair(
            f"{place.cut.label} and its references are seen together in {len(frames)} frames; "
            "choose a method that does not learn, such as li."
        )
    return frames[_some(len(frames), enough)]


@remembered
def regress_locally(place: Triad, settings: Recovery) -> FloatArray:
    """LPR: a polynomial of second degree in the shape of the references' triangle."""
    x = _local_features(place)
    products = [x[:, i] * x[:, j] for i in range(3) for j in range(i, 3)]
    features = _standardised(np.column_stack([x, *products]))
    design = np.column_stack([np.ones(len(features)), features])
    frames = _trained_on(place, features, place.local, LOCAL_FRAMES)
    mean = place.local[frames].mean(axis=0)
    solved = np.linalg.lstsq(design[frames], place.local[frames] - mean, rcond=None)[0]
    predicted = design[place.stretch] @ solved + mean
    return place.axes.to_world(place.ramped(predicted, place.local))


@remembered
def regress_by_kernel(place: Triad, settings: Recovery) -> FloatArray:
    """LGRNN: the mean of what was seen while the triangle looked alike (Specht 1991)."""
    features = _standardised(_local_features(place))
    frames = _trained_on(place, features, place.local, LOCAL_FRAMES)
    here, there = features[place.stretch], features[frames]
    far = np.square(here).sum(axis=1)[:, None] + np.square(there).sum(axis=1) - 2 * here @ there.T
    exponent = far * (np.log(2.0) / settings.spread**2)
    weight = np.exp(exponent.min(axis=1, keepdims=True) - exponent)
    predicted = weight @ place.local[frames] / weight.sum(axis=1, keepdims=True)
    return place.axes.to_world(place.ramped(predicted, place.local))


@remembered
def regress_globally(place: Triad, settings: Recovery) -> FloatArray:
    """GLR: linear regression on all markers whose distance varies little."""
    cut = place.cut
    use = cut.seen[place.stretch].all(axis=0) & np.isfinite(place.spread)
    if place.spread[use].min() <= settings.loosest:
        use &= place.spread <= settings.loosest
    middle = centred(cut)
    own = cut.own - middle
    others = (cut.positions[:, use] - middle[:, None]).reshape(cut.n_frames, -1)
    frames = _trained_on(place, others, own, GLOBAL_FRAMES)
    design = np.column_stack([np.ones(len(others)), others])
    mean = own[frames].mean(axis=0)
    solved = np.linalg.lstsq(design[frames], own[frames] - mean, rcond=None)[0]
    predicted = design[place.stretch] @ solved + mean
    return place.ramped(predicted, own) + middle[place.stretch]


def by_components(place: Triad, settings: Recovery) -> FloatArray:
    """WPCA: strategy R2 of Gløersen and Federolf, made to meet the edges."""
    cut = place.cut
    filled = fill_r2(cut, Settings(by_axis=settings.by_axis), 0.5)
    curve = cut.own[place.stretch].copy()
    start = cut.span.start - place.stretch.start
    curve[start : start + len(filled)] = filled
    return curve
