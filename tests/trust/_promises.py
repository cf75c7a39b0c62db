"""Which laws a method does not promise, each with the reason: the one table of exceptions.

Laws of repairs that are tested one by one in the ordinary suite have their exceptions there, and
are taken over from it. Whoever is not named promises the law.
"""

from tests.core.repairing.test_contract import NO_REVERSAL, NO_ROTATION

_LOW_RANK = "asks for the lowest rank that fits the rest, which shrinks what it puts in"

REPAIRS: dict[str, dict[str, str]] = {
    "shift": {},
    "unit": {},
    "rotation": NO_ROTATION,
    "mirror": {"ffnn": "squares each axis, so that a coordinate and its negative look the same"},
    "reversal": NO_REVERSAL,
    "constant": {
        "butterworth": "is a filter: it keeps of the noise what lies under the cutoff",
        **dict.fromkeys(("gslr", "slr", "svt"), _LOW_RANK),
        "li_eq4": "approximates by few components, of rest as of anything",
    },
    "circular": dict.fromkeys(
        ("ffnn", "glr", "lgrnn", "li", "li_eq16", "li_eq8", "linear", "lpr", "pattern", "pca_r1",
         "pchip", "pma", "spline", "tnn", "wpca"),
        "knows no body: a circle is to it one curve among others",
    ),
}  # fmt: skip
REPAIRS["straight"] = REPAIRS["constant"] | dict.fromkeys(
    ("li_eq8", "li_eq16"), "puts pieces together that it has seen; on a line there is none alike"
)
REPAIRS["circular"] |= REPAIRS["constant"]
REPAIRS["rigid"] = REPAIRS["circular"] | {
    "polynomial": "follows the neighbours' coordinates, which turn with the body",
    "savgol": "is a polynomial over a window: near to any smooth curve, equal to few",
    "unstep": "takes the height of the step from the curve, not from a body",
}

NEAR_MM = 1e-3
"""How near two repairs must be that a law says are equal."""

DETECTORS: dict[str, dict[str, str]] = {
    "shift": {},
    "unit": {},
    "mirror": {},
    "rotation": {"published": "looks at each axis by itself, as printed"},
    "reversal": {"published": "predicts forward in time, and pairs a jump with the one back"},
}
