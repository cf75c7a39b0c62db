"""What ``markermend evaluate mesh`` says of a body: its clusters, parents and siblings."""

from typing import Any

from markermend.body import Body
from markermend.errors import BadInput
from markermend.model import Take


def mesh_table(body: Body) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Give the columns and rows of a table for the terminal: one row per cluster, counted from 1.

    The markers of a cluster are each other's siblings.

    Raises
    ------
    BadInput
        If no marker of the take is of the body.
    """
    if not body.clusters:
        raise BadInput("The take has no body: no measured marker is ever seen.")
    names = [" ".join(body.labels[m] for m in cluster) for cluster in body.clusters]
    width = max(map(len, names))  # padded here, since text is read from the left
    rows: list[tuple[str, ...]] = [
        (
            str(number),
            "-" if parent is None else str(parent + 1),
            "-" if marker is None else body.labels[marker],
            markers.ljust(width),
        )
        for number, (parent, marker, markers) in enumerate(
            zip(body.parents, body.parent_markers, names, strict=True), 1
        )
    ]
    return ("cluster", "parent", "parent marker", "siblings".ljust(width)), rows


def mesh_record(take: Take, body: Body) -> dict[str, Any]:
    """Give the body in the form of ``markermend evaluate mesh --json``; clusters count from 1."""
    return {
        "version": 1,
        "experiment": "mesh",
        "n_frames": take.n_frames,
        "rate": take.rate,
        "clusters": [
            {
                "cluster": number,
                "parent": None if parent is None else parent + 1,
                "parent_marker": None if marker is None else body.labels[marker],
                "markers": [body.labels[m] for m in cluster],
            }
            for number, (cluster, parent, marker) in enumerate(
                zip(body.clusters, body.parents, body.parent_markers, strict=True), 1
            )
        ],
        "siblings": {
            body.labels[m]: [body.labels[other] for other in body.siblings(m)] for m in body.order
        },
        "bones": [[body.labels[a], body.labels[b]] for a, b in body.bones],
    }
