"""One sentence that says why a finding is there, in the marker's own numbers."""

from markermend.body import Body
from markermend.model import Finding, Take, short


def why(take: Take, mesh: Body, finding: Finding) -> str:
    """Say why, naming the neighbours that it was judged by.

    Parameters
    ----------
    take, mesh
        The take as recorded and its body.
    finding
        As judged: with the operator's kind and span.
    """
    seconds = len(finding.span) / take.rate
    unit = take.units
    size = "" if finding.amplitude is None else f"{_round(finding.amplitude)} {unit}"
    near = _named([short(take.labels[m]) for m in mesh.neighbours(finding.marker, 3)])
    if finding.kind == "gap":
        span = finding.span
        seen = [
            short(take.labels[m])
            for m in mesh.neighbours(finding.marker)
            if take.seen[span.frames, m].all()
        ][:3]
        rest = f"{_named(seen)} stay visible" if seen else "none of its neighbours stays visible"
        return f"Not seen for {seconds:.2f} s; {rest}."
    if finding.partner is not None:
        return f"Changes places with {short(finding.partner)} for {seconds:.2f} s and back."
    n = len(finding.span)
    frames = f"{n} frames" if n > 1 else "one frame"
    sentence = {
        "peak": f"Leaves its path by {size or 'a spike'} for {frames} and returns",
        "noise": f"Scatters {size or 'widely'} around its path for {seconds:.2f} s",
        "step": f"Jumps {size or 'away'} within one frame and back {seconds:.2f} s later",
        "slow": f"Drifts {size or 'away'} from where it is expected and back in {seconds:.2f} s",
    }[finding.kind]
    return f"{sentence}; {near} move on smoothly." if near else f"{sentence}."


def _named(labels: list[str]) -> str:
    return (
        labels[0]
        if len(labels) == 1
        else ", ".join(labels[:-1]) + " and " + labels[-1]
        if labels
        else ""
    )


def _round(value: float) -> str:
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"
