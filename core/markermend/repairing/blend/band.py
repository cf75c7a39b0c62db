"""The 90 % band by position in a gap, from the errors on pseudo-gaps."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from markermend.model import FloatArray

SHARE = 0.9
WIDER, WIDER_FRAMES = 1.03, 100.0
"""How much wider the band is made, for the mix was chosen on the same pseudo-gaps, and for these
know only the motions of the frames that are seen; set on other recordings than are reported."""
LEAST_LENGTHS = 2.5
"""Gap lengths that must be seen for a band to be shown ..."""
FEW_FRAMES, LEAST_LENGTHS_OF_FEW = 300, 4.0
"""... and how many more where so few frames are seen that they know little motion."""


def band_by_position(
    errors: FloatArray, inside: NDArray[np.intp], length: int, seen: int
) -> FloatArray | None:
    """Give the level under which 90 % of the errors stay, growing away from the edges.

    All gaps share one shape over the position, their root mean square error; the level is the
    quantile of all errors relative to it.

    Parameters
    ----------
    errors
        (n_pseudo, n_inside) mm.
    inside
        (n_inside,): the offsets in the gap that they belong to.
    length
        Frames of the gap.
    seen
        Frames in which the marker and its neighbours are seen.

    Returns
    -------
    (length,) mm, or None where too little is seen.
    """
    least = LEAST_LENGTHS_OF_FEW if seen < FEW_FRAMES else LEAST_LENGTHS
    if seen < least * length:
        return None
    shape = np.sqrt(np.square(errors).mean(axis=0))
    shape = gaussian_filter1d(shape, max(0.04 * len(shape), 0.5), mode="nearest") + 1e-6
    level = np.quantile(errors / shape, SHARE) * (WIDER + WIDER_FRAMES / seen)
    return np.interp(np.arange(length), inside, level * shape)
