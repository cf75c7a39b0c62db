"""Why something was right or wrong, in the marker's own numbers."""

from collections.abc import Mapping

from markermend.model import Kind, Span
from markermend.train.marks import Repaired
from markermend.truth import Truth

SIGNS: Mapping[Kind, str] = {
    "gap": "in a gap the marker has no positions at all",
    "peak": "a peak leaves the curve for a frame or two and comes straight back",
    "noise": "a burst of noise trembles over many frames and goes nowhere",
    "step": "a step jumps within one frame, stays away, and jumps back",
    "slow": "a slow change drifts away and back without any jump",
}
NAMES: Mapping[Kind, str] = {
    "gap": "gap",
    "peak": "peak",
    "noise": "burst of noise",
    "step": "step",
    "slow": "slow change",
}
WORTH_SAYING_MM = 0.1
"""A smaller gain is none that anybody could see."""
WHERE: Mapping[Kind, str] = {
    "gap": "the overview shows it",
    "peak": "look at the acceleration, where a single frame stands out",
    "noise": "look at the acceleration, which stays high for all of it",
    "step": "look at both edges, where the speed is far too high for one frame",
    "slow": "its speed looks normal, so look at the distance to the neighbours",
}


def what(truth: Truth, rate: float) -> str:
    """Say what it was: its size and length."""
    size = "" if truth.amplitude is None else f" of {truth.amplitude:.0f} mm"
    frames = len(truth.span)
    length = f"{frames} frame{'s' * (frames > 1)}" if frames < 5 else f"{frames / rate:.2f} s"
    return f"A {NAMES[truth.kind]}{size} over {length}"


def found(truth: Truth, rate: float, iou: float, repair: str) -> str:
    """Explain something that was found and named."""
    return f"{what(truth, rate)}, found and named; the edges agree to {iou:.0%}. {repair}".strip()


def misnamed(truth: Truth, rate: float, called: Kind, repair: str) -> str:
    """Explain something that was found and named wrong."""
    text = (
        f"{what(truth, rate)}, which you called a {NAMES[called]}: {SIGNS[truth.kind]}, while "
        f"{SIGNS[called]}. {repair}"
    )
    return text.strip()


def missed(truth: Truth, rate: float, was_rejected: bool, touched: Span | None) -> str:
    """Explain something that was not found."""
    begin = what(truth, rate)
    if was_rejected:
        return f"{begin}, which you called a false alarm; {WHERE[truth.kind]}."
    if touched is not None:
        return (
            f"{begin} in frames {truth.span.start} to {truth.span.stop - 1}, of which your "
            f"frames {touched.start} to {touched.stop - 1} are too different; move the edges."
        )
    return f"{begin} that you passed over; {WHERE[truth.kind]}."


def invented(called: Kind, error_mm: float | None) -> str:
    """Explain a decision on something that was right."""
    harm = ""
    if error_mm is not None:
        harm = f"; your repair moved it {error_mm:.1f} mm away from where it was"
    return f"Nothing is wrong here: {SIGNS[called]}, and this does not{harm}."


def partial(covered: bool) -> str:
    """Explain a decision that is on an artefact and not its best one."""
    if covered:
        return "It lies on an artefact that another of your findings covers already; merge them."
    return "It lies on an artefact, and covers too little of it or far too much; move the edges."


def repair(done: Repaired) -> str:
    """Say what a repair is worth."""
    if done.error_mm is None:
        return f"With {done.method} its data is given up, so nothing can be said of it in mm."
    text = f"{done.method} left {_mm(done.error_mm)}"
    gain = 0.0 if done.best_mm is None else done.error_mm - done.best_mm
    if done.best_mm is not None and gain >= WORTH_SAYING_MM:
        text += f", {done.best} would have left {_mm(done.best_mm)}"
        text += " and was the recommended one" if done.recommended == done.best else ""
    if done.recommended == done.method:
        text += ", as recommended"
    elif done.recommended_mm is not None and not (
        done.recommended == done.best and gain >= WORTH_SAYING_MM
    ):
        text += f", the recommended {done.recommended} {_mm(done.recommended_mm)}"
    if done.new_artefacts:
        kinds = ", ".join(sorted({NAMES[kind] for kind in done.new_artefacts}))
        text += f"; afterwards there is something new: {kinds}"
    return f"{text[0].upper()}{text[1:]}."


def verdict(
    right: int, true: int, invented: int, before: float | None, after: float | None, worse: bool
) -> str:
    """Say the whole in one sentence."""
    text = f"You found and named {right} of {true}"
    text += f" and invented {invented}" if invented else ""
    if before is None or after is None:
        return f"{text}."
    change = f"{_mm(before)} to {_mm(after)}"
    if worse and _mm(before) == _mm(after):
        return f"{text}, and left the take a little worse than you got it: {_mm(after)} now."
    if worse:
        return f"{text}, and left the take worse than you got it: {change}."
    if before - after <= 1e-6:
        return f"{text}, and left the take as wrong as it was: {_mm(before)}."
    return f"{text}, and left the take better than you got it: {change}."


def _mm(value: float) -> str:
    return f"{value:.1f} mm" if value >= 0.05 else "less than 0.1 mm"
