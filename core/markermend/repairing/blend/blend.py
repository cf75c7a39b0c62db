"""Choose among many predictions, and mix the best, by how they do on pseudo-gaps."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from markermend.model import FloatArray, Span
from markermend.repairing.blend.band import band_by_position
from markermend.repairing.blend.mixing import mix
from markermend.repairing.blend.predictors import Family, Recipe, families
from markermend.repairing.blend.pseudo import PseudoGaps, pseudo_gaps
from markermend.repairing.blend.scene import Scene
from markermend.repairing.kriging import Operator, operators

FINALISTS = 12
"""Predictions that every operator is tried on."""
POOL = 16
"""Pairs of prediction and operator that the mix is made from."""
FIRST_OPERATORS = ("Hermite", "Matérn 3/2 of 0.4 s", "Matérn 5/2 of 0.1 s", "ramp")
DISAGREEMENT, AGREED = 0.8, 0.1
"""How the error grows with the disagreement of the members, and what is left of it without any,
as a share of the usual one."""
LEAST_PSEUDO = 6
"""Pseudo-gaps without which nothing is chosen by them."""


@dataclass(frozen=True, eq=False)
class Blend:
    """A filled gap and what is known of its error.

    Attributes
    ----------
    values
        (length, n_dims) mm.
    errors
        (n_pseudo, n_inside) mm: errors of the same mix on the pseudo-gaps.
    pseudo
        The pseudo-gaps.
    members
        (weight, description) of what was mixed.
    first
        Frame of the take with which the window starts that the pseudo-gaps are counted in.
    seen
        Frames of that window in which the marker and its neighbours are seen.
    hardness
        (n_pseudo,): how many times larger an error is to be expected in the gap than in each
        pseudo-gap, told by how much more the members disagree there.
    """

    values: FloatArray
    errors: FloatArray
    pseudo: PseudoGaps
    members: tuple[tuple[float, str], ...]
    first: int
    seen: int
    hardness: FloatArray

    @cached_property
    def likely(self) -> FloatArray:
        """(n_pseudo, n_inside) mm: the errors as they would be if all were as hard as the gap."""
        return self.errors * self.hardness[:, None]

    @property
    def expected_mm(self) -> float:
        """Mean error to be expected."""
        return float(self.likely.mean())

    def spread(self) -> FloatArray:
        """Give the root mean square error to be expected by position in the gap, (length,) mm."""
        shape = np.sqrt(np.square(self.likely).mean(axis=0))
        return np.asarray(np.interp(np.arange(self.pseudo.length), self.pseudo.inside, shape))

    def band(self) -> FloatArray | None:
        """Give the 90 % band by position in the gap, (length,) mm, if enough is seen."""
        return band_by_position(self.likely, self.pseudo.inside, self.pseudo.length, self.seen)


def blend(around: Scene) -> Blend | None:
    """Fill the gap by the mix that does best on pseudo-gaps; None where none can be hidden."""
    pseudo = pseudo_gaps(around.rows, around.window.span, around.boundary)
    if len(pseudo) < LEAST_PSEUDO or not len(around.boundary) + len(around.order):
        return None
    rate = around.window.rate
    ways = operators(pseudo.inside / rate, pseudo.boundary / rate)
    kinds = families(around)
    recipes = [recipe for i, family in enumerate(kinds) for recipe in family.recipes(i)]
    residual = np.concatenate([_residuals(family, pseudo) for family in kinds])
    n_in = len(pseudo.inside)

    def errors(of: FloatArray, way: Operator) -> FloatArray:
        return np.asarray(of[:, :, :n_in] - np.matmul(way.weights, of[:, :, n_in:]))

    def score(of: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(np.einsum("mpid,mpid->mpi", of, of)).mean(axis=(1, 2)))

    first = [way for way in ways if way.name in FIRST_OPERATORS]
    scores = np.min([score(errors(residual, way)) for way in first], axis=0)
    finalists = np.argsort(scores, kind="stable")[:FINALISTS]
    trials = [errors(residual[finalists], way) for way in ways]
    table = np.array([score(trial) for trial in trials])
    flat = np.argsort(table, axis=None, kind="stable")[:POOL]
    pool = [divmod(int(i), len(finalists)) for i in flat]
    turned = np.stack(
        [_turned(kinds[recipes[finalists[f]].family], pseudo, trials[w][f]) for w, f in pool]
    )
    chosen, weights = mix(turned.reshape(len(pool), len(pseudo), -1))
    members = [(ways[pool[c][0]], recipes[finalists[pool[c][1]]]) for c in chosen]
    fills = _fills(around, kinds, members)
    values, here = mixed(weights, fills)
    left, there = mixed(weights, turned[chosen])
    described = tuple(
        (
            float(weight),
            f"{recipe.neighbours} neighbours in {kinds[recipe.family].name}, {way.name}",
        )
        for weight, (way, recipe) in zip(weights, members, strict=True)
    )
    return Blend(
        values,
        np.linalg.norm(left, axis=2),
        pseudo,
        described,
        around.window.start,
        int(around.rows.sum()),
        hardness(float(here.mean()), there.mean(axis=1)),
    )


def mixed(weights: FloatArray, members: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the mix of the members, (..., n_dims), and by how much they disagree, (...)."""
    whole = np.tensordot(weights, members, axes=1)
    apart = np.square(members - whole).sum(axis=-1)
    return whole, np.sqrt(np.tensordot(weights, apart, axes=1))


def hardness(here: float, there: FloatArray) -> FloatArray:
    """Say how much harder the gap is than each pseudo-gap, within the range of these.

    Where the members disagree more, all of them err more. The exponent was chosen on other
    recordings than are reported.
    """
    usual = float(np.median(there)) + 1e-9
    each = (there / usual + AGREED) ** DISAGREEMENT
    own = (here / usual + AGREED) ** DISAGREEMENT
    return np.asarray(np.clip(own, each.min(), each.max()) / each)


def _residuals(family: Family, pseudo: PseudoGaps) -> FloatArray:
    """Give (n_recipes, n_pseudo, n_inside + n_boundary, n_dims) mm: marker minus prediction."""
    offsets = np.concatenate([pseudo.inside, pseudo.boundary])
    parts = []
    for members, hidden in pseudo.groups:
        predicted = family.predictions(hidden, hidden)
        frames = pseudo.starts[members][:, None] + offsets
        parts.append(family.y[frames] - predicted[:, frames - hidden.start])
    return np.concatenate(parts, axis=1)


def _turned(family: Family, pseudo: PseudoGaps, errors: FloatArray) -> FloatArray:
    frames = pseudo.starts[:, None] + pseudo.inside
    return np.asarray(np.einsum("kfij,kfj->kfi", family.frames.rotation[frames], errors))


def _fills(
    around: Scene, kinds: tuple[Family, ...], members: list[tuple[Operator, Recipe]]
) -> FloatArray:
    """Fill the real gap by each member, learning from all rows: (n_members, length, n_dims)."""
    cut = around.window
    span, edge = cut.span, around.boundary
    hull = Span(
        min(span.start, edge.min(initial=span.start)), max(span.stop, edge.max(initial=0) + 1)
    )
    inside = np.arange(span.start, span.stop)
    ways = {
        way.name: way.weights
        for way in operators((inside - span.start) / cut.rate, (edge - span.start) / cut.rate)
    }
    made: dict[int, FloatArray] = {}
    fills = []
    for way, recipe in members:
        family = kinds[recipe.family]
        if recipe.family not in made:
            made[recipe.family] = family.predictions(hull, None)
        predicted = made[recipe.family][family.recipes(recipe.family).index(recipe)]
        left = family.y[edge] - predicted[edge - hull.start]
        local = predicted[inside - hull.start] + ways[way.name] @ left
        fills.append(family.frames.at(span.frames).to_world(local))
    return np.stack(fills)
