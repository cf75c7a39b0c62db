"""Files that come with the package."""

from pathlib import Path

from markermend.errors import MarkerMendError


def demonstration() -> Path:
    """Give the path of the demonstration take.

    Raises
    ------
    MarkerMendError
        If the installation is incomplete.
    """
    here = Path(__file__).parent
    places = (here / "assets" / "takes", here.parents[1] / "assets" / "takes")
    for place in places:
        for path in sorted(place.glob("demo.*")):
            if path.suffix in (".c3d", ".npz"):
                return path
    raise MarkerMendError("The demonstration take is missing; install markermend again.")
