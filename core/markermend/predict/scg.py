"""Scaled conjugate gradients for many small networks at once.

All networks of a batch have the same shape and are trained side by side; matrices are stacked
along the first axis, and each network has its own step sizes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray

SIGMA = 1e-4
LAMBDA = 1e-6


@dataclass(frozen=True)
class Shape:
    """Widths of the layers, input first, output last; all but the output are tanh."""

    widths: tuple[int, ...]

    @property
    def n_weights(self) -> int:
        """Number of weights of one network."""
        return sum((a + 1) * b for a, b in zip(self.widths[:-1], self.widths[1:], strict=True))

    def layers(self, weights: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Give views (n_networks, a, b) and (n_networks, 1, b) of each layer of `weights`."""
        views, at = [], 0
        for a, b in zip(self.widths[:-1], self.widths[1:], strict=True):
            matrix = weights[:, at : at + a * b].reshape(-1, a, b)
            bias = weights[:, at + a * b : at + (a + 1) * b].reshape(-1, 1, b)
            views.append((matrix, bias))
            at += (a + 1) * b
        return views


def initial(shape: Shape, seeds: Sequence[int]) -> FloatArray:
    """Draw weights of variance 1 / inputs; each network has a seed of its own."""
    weights = np.zeros((len(seeds), shape.n_weights))
    for network, seed in enumerate(seeds):
        rng = np.random.default_rng(seed)
        for matrix, bias in shape.layers(weights[network : network + 1]):
            matrix[:] = rng.standard_normal(matrix.shape) / np.sqrt(matrix.shape[1])
            bias[:] = 0.5 * rng.standard_normal(bias.shape)
    return weights


def forward(shape: Shape, weights: FloatArray, inputs: FloatArray) -> list[FloatArray]:
    """Give the activations of each layer, inputs (n_networks, n, width) first."""
    values = [inputs]
    layers = shape.layers(weights)
    for place, (matrix, bias) in enumerate(layers):
        value = values[-1] @ matrix
        value += bias
        values.append(value if place == len(layers) - 1 else np.tanh(value, out=value))
    return values


def loss_and_gradient(
    shape: Shape, weights: FloatArray, inputs: FloatArray, targets: FloatArray, mass: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Half the mean squared error of each network, and its gradient (n_networks, n_weights).

    `mass` (n_networks, n, 1) weighs the samples and sums to 1 in each network.
    """
    values = forward(shape, weights, inputs)
    error = values.pop()
    error -= targets
    weighed = error * mass
    loss = 0.5 * np.einsum("bno,bno->b", error, weighed)
    gradient = np.empty_like(weights)
    slots = shape.layers(gradient)
    for place in range(len(slots) - 1, -1, -1):
        matrix, _ = shape.layers(weights)[place]
        below = values[place]
        slots[place][0][:] = below.transpose(0, 2, 1) @ weighed
        slots[place][1][:] = weighed.sum(axis=1, keepdims=True)
        if place:
            weighed = weighed @ matrix.transpose(0, 2, 1)
            weighed *= 1.0 - below * below
    return loss, gradient


def train(
    shape: Shape,
    weights: FloatArray,
    inputs: FloatArray,
    targets: FloatArray,
    mass: FloatArray,
    epochs: int,
) -> FloatArray:
    """Train all networks for some epochs and give their weights.

    Notes
    -----
    Møller, A scaled conjugate gradient algorithm for fast supervised learning, Neural Networks
    1993.  The algorithm branches on each network by itself; a step that would not lower the error
    is not taken.
    """

    def dot(a: FloatArray, b: FloatArray) -> FloatArray:
        product: FloatArray = np.einsum("bn,bn->b", a, b)
        return product

    loss, gradient = loss_and_gradient(shape, weights, inputs, targets, mass)
    residue = -gradient
    direction = residue.copy()
    damping, raised = np.full(len(weights), LAMBDA), np.zeros(len(weights))
    curvature = np.zeros(len(weights))
    fresh: NDArray[np.bool_] = np.ones(len(weights), bool)
    for epoch in range(1, epochs + 1):
        length2 = np.maximum(dot(direction, direction), 1e-30)
        step = SIGMA / np.sqrt(length2)
        moved = weights + step[:, None] * direction
        _, ahead = loss_and_gradient(shape, moved, inputs, targets, mass)
        second = dot(direction, ahead + residue) / step
        curvature = np.where(fresh, second, curvature)
        curvature = curvature + (damping - raised) * length2
        negative = curvature <= 0.0
        raised = np.where(negative, 2.0 * (damping - curvature / length2), raised)
        curvature = np.where(negative, -curvature + damping * length2, curvature)
        damping = np.where(negative, raised, damping)
        push = dot(direction, residue)
        size = push / curvature
        proposed = weights + size[:, None] * direction
        new_loss, new_gradient = loss_and_gradient(shape, proposed, inputs, targets, mass)
        agreement = 2.0 * curvature * (loss - new_loss) / np.maximum(push**2, 1e-30)
        fresh = agreement >= 0.0
        taken = fresh[:, None]
        after = -new_gradient
        beta = (dot(after, after) - dot(after, residue)) / np.where(push == 0.0, 1e-30, push)
        if epoch % weights.shape[1] == 0:
            beta = np.zeros_like(beta)
        direction = np.where(taken, after + beta[:, None] * direction, direction)
        residue = np.where(taken, after, residue)
        weights = np.where(taken, proposed, weights)
        loss = np.where(fresh, new_loss, loss)
        raised = np.where(fresh, 0.0, damping)
        damping = np.where(agreement >= 0.75, 0.25 * damping, damping)
        damping = np.where(
            agreement < 0.25, damping + curvature * (1.0 - agreement) / length2, damping
        )
        damping = np.clip(damping, 1e-15, 1e15)
    return weights
