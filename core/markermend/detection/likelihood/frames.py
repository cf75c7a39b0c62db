"""Local frames of reference: the best rotation of a few markers onto their usual shape."""

import numpy as np

from markermend.model import FloatArray

_NEWTON_STEPS = 8


def best_rotations(H: FloatArray, sizes: FloatArray) -> FloatArray:
    """Rotations R that maximise ``sum(a_i . (R b_i))``, in closed form for many frames at once.

    The largest eigenvalue of the quaternion key matrix is found by Newton's iteration from above,
    its eigenvector as a column of the adjugate (Theobald, Acta Cryst. A61:478, 2005). Arrays of
    one component each make this several times cheaper than batched singular value decompositions.

    Parameters
    ----------
    H
        (3, 3, n_frames): ``sum_i b_i a_i^T`` of the centred points b (observed) and a (usual).
    sizes
        (n_frames,): ``(sum |a|^2 + sum |b|^2) / 2``, an upper bound of the eigenvalue.

    Returns
    -------
    FloatArray
        (3, 3, n_frames): rotations that turn observed into usual directions.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = H / np.maximum(sizes, 1e-300)
    k01, k02, k03 = yz - zy, zx - xz, xy - yx
    k12, k13, k23 = xy + yx, zx + xz, yz + zy
    diagonal = (xx + yy + zz, xx - yy - zz, -xx + yy - zz, -xx - yy + zz)
    squares = xx**2 + xy**2 + xz**2 + yx**2 + yy**2 + yz**2 + zx**2 + zy**2 + zz**2
    c2 = -2.0 * squares
    c1 = -8.0 * (xx * (yy * zz - yz * zy) - xy * (yx * zz - yz * zx) + xz * (yx * zy - yy * zx))
    d0, d1, d2, d3 = diagonal
    upper = _pairs((d0, k01, k02, k03), (k01, d1, k12, k13))
    lower = _pairs((k02, k12, d2, k23), (k03, k13, k23, d3))
    c0 = (
        upper[0] * lower[5] - upper[1] * lower[4] + upper[2] * lower[3]
        + upper[3] * lower[2] - upper[4] * lower[1] + upper[5] * lower[0]
    )  # fmt: skip
    value = np.ones_like(xx)
    for _ in range(_NEWTON_STEPS):
        square = value * value
        slope = (4.0 * square + 2.0 * c2) * value + c1
        value = value - ((square + c2) * square + c1 * value + c0) / np.where(slope, slope, 1.0)
    d0, d1, d2, d3 = (d - value for d in diagonal)
    u = _pairs((d0, k01, k02, k03), (k01, d1, k12, k13))
    v = _pairs((k02, k12, d2, k23), (k03, k13, k23, d3))
    a00 = d1 * v[5] - k12 * v[4] + k13 * v[3]
    a01 = -k01 * v[5] + k02 * v[4] - k03 * v[3]
    a02 = k13 * u[5] - k23 * u[4] + d3 * u[3]
    a03 = -k12 * u[5] + d2 * u[4] - k23 * u[3]
    a11 = d0 * v[5] - k02 * v[2] + k03 * v[1]
    a12 = -k03 * u[5] + k23 * u[2] - d3 * u[1]
    a13 = k02 * u[5] - d2 * u[2] + k23 * u[1]
    a22 = k03 * u[4] - k13 * u[2] + d3 * u[0]
    a23 = -k02 * u[4] + k12 * u[2] - k23 * u[0]
    a33 = k02 * u[3] - k12 * u[1] + d2 * u[0]
    adjugate = np.array(
        [[a00, a01, a02, a03], [a01, a11, a12, a13], [a02, a12, a22, a23], [a03, a13, a23, a33]]
    )
    # The adjugate is the outer product of the eigenvector with itself: take its largest column.
    column = np.abs(adjugate[range(4), range(4)]).argmax(0)
    q = adjugate[column, :, np.arange(xx.size)].T
    length = np.sqrt((q * q).sum(0))
    undefined = length < 1e-14  # all points on one line, or fewer than two: do not turn
    q = np.where(undefined, [[1.0], [0.0], [0.0], [0.0]], q / np.where(undefined, 1.0, length))
    return _matrices(q)


def _pairs(a: tuple[FloatArray, ...], b: tuple[FloatArray, ...]) -> tuple[FloatArray, ...]:
    """2x2 determinants of two rows over the six pairs of columns."""
    order = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    return tuple(a[i] * b[j] - a[j] * b[i] for i, j in order)


def _matrices(q: FloatArray) -> FloatArray:
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
