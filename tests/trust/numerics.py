"""What methods do to numbers: laws of space, time and units, for every detector and repair."""

import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation
from tests.core.repairing.conftest import Case, Lab, walker
from tests.trust import _promises
from tests.trust._frame import ROOT, Budget, Outcome, Tally, child_environment, public
from tests.trust._law import fault_of_sentence, opened

from markermend.detection import DETECTORS, detect
from markermend.errors import CannotRepair, MarkerMendError
from markermend.model import Finding, FloatArray, Span, Take
from markermend.repairing.run import REPAIRS, repair
from markermend.simulate import simulate

MINUTES = 10.0
AWAY = np.array([2500.0, -1300.0, 400.0])
TURN = Rotation.from_rotvec([0.7, -0.4, 1.1]).as_matrix()
MIRROR = np.array([-1.0, 1.0, 1.0])
SPACE: dict[str, Callable[[FloatArray], FloatArray]] = {
    "shift": lambda x: x + AWAY,
    "rotation": lambda x: x @ TURN.T,
    "mirror": lambda x: x * MIRROR,
}
_NAMES = tuple(name for name in REPAIRS.names() if name != "leave")


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for each family of laws."""
    for law in ("shift", "rotation", "mirror", "unit", "reversal"):
        yield _repairs(law, budget.share(0.07))
    yield _motions(budget.share(0.1))
    yield _detectors(budget.share(0.3))
    if not budget.short:
        yield _repeated(budget)
        yield _quiet_detectors(budget.share(0.5))
        yield _quiet_repairs(budget)


def _solved(case: Case, name: str) -> FloatArray | None:
    """Give the values, or None for a refusal; a warning is a fault."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return case.solve(name)
        except CannotRepair as refusal:
            fault = fault_of_sentence(str(refusal))
            if fault:
                raise AssertionError(fault) from None
            return None


def _repairs(law: str, budget: Budget) -> Outcome:
    tally = Tally(f"repairs: {law} acts as it must")
    excepted = _promises.REPAIRS[law]
    rng = np.random.default_rng(budget.seed)
    names = [name for name in _NAMES if name not in excepted]
    if budget.short:  # `auto` comes first, and does what a dozen others do
        names = names[1::6]
    tally.planned = budget.of(8, 1) * len(names)
    for _ in range(budget.of(8, 1)):
        for name in names:
            if budget.spent:
                break
            method = REPAIRS.get(name)
            start, seed = int(rng.integers(70, 150)), int(rng.integers(1000))
            span = Span(start, start + int(rng.integers(6, 26)))
            case = Lab.for_method(method, truth=walker(seed=seed), span=span)
            tally.case(_differs(case, name, law))
    return tally.outcome(f"{len(names)} methods; {len(excepted)} do not promise it")


def _differs(case: Case, name: str, law: str) -> str:
    try:
        if law in SPACE:
            change = SPACE[law]
            mine, other = _solved(case, name), _solved(case.moved(change), name)
            wanted = None if mine is None else change(mine)
        elif law == "unit":
            take = case.take
            metres = replace(
                case,
                take=Take(take.positions / 1000, take.rate, take.labels, "m", roles=take.roles),
            )
            wanted, other = _solved(case, name), _solved(metres, name)
        else:
            mine, other = _solved(case, name), _solved(_backward(case), name)
            wanted = None if mine is None else mine[::-1]
    except Exception as error:  # noqa: BLE001 - whatever is raised is a fault to report
        return f"{name}: {type(error).__name__} {str(error)[:100]}"
    if wanted is None or other is None:
        return "" if wanted is other else f"{name}: refuses one of the two"
    off = float(np.abs(wanted - other).max())
    return f"{name} at {case.span}: off by {off:.2g} mm" if not off <= _promises.NEAR_MM else ""


def _in_metres(take: Take) -> Take:
    return Take(take.positions / 1000, take.rate, take.labels, "m", roles=take.roles)


def _backward(case: Case) -> Case:
    n = case.take.n_frames
    return replace(
        case,
        take=case.take.with_positions(case.take.positions[::-1]),
        truth=case.truth[::-1],
        span=Span(n - case.span.stop, n - case.span.start),
        training=tuple(t.with_positions(t.positions[::-1]) for t in case.training),
    )


def _turning(angles: FloatArray) -> FloatArray:
    c, s, zero, one = np.cos(angles), np.sin(angles), 0 * angles, 0 * angles + 1
    rows = ((c, -s, zero), (s, c, zero), (zero, zero, one))
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _bodies() -> dict[str, FloatArray]:
    """Give motions of one rigid body whose course is known exactly."""
    pose, n = walker(noise=0)[:1], 240
    t = np.arange(n) / 100
    sway = np.einsum("fij,mj->fmi", _turning(0.8 * np.sin(3 * t)), pose[0])
    way = np.stack([900 * t, 40 * np.sin(4 * t), 30 * np.cos(5 * t)], -1)
    return {
        "constant": np.repeat(pose, n, 0),
        "straight": pose + np.arange(n)[:, None, None] * np.array([3.0, -1.0, 0.5]),
        "circular": np.einsum("fij,mj->fmi", _turning(2 * t), pose[0]),
        "rigid": sway + way[:, None],
    }


def _motions(budget: Budget) -> Outcome:
    tally = Tally("repairs: rest, lines, circles, rigid bodies are exact")
    rng = np.random.default_rng(budget.seed)
    exact = [(m, x, n) for m, x in _bodies().items() for n in _NAMES]
    exact = [(m, x, n) for m, x, n in exact if n not in _promises.REPAIRS[m]]
    if budget.short:
        exact = [one for one in exact if one[2] != "auto"][::4]
    tally.planned = budget.of(5, 1) * len(exact)
    for _ in range(budget.of(5, 1)):
        for motion, truth, name in exact:
            if not budget.spent:
                start = int(rng.integers(90, 130))
                span = Span(start, start + int(rng.integers(12, 22)))
                case = Lab.for_method(REPAIRS.get(name), truth=truth, span=span)
                try:
                    values = _solved(case, name)
                except Exception as error:  # noqa: BLE001 - a fault to report
                    tally.case(f"{name}, {motion}: {type(error).__name__} {str(error)[:80]}")
                    continue
                off = 0.0 if values is None else float(np.abs(values - case.truth).max())
                fault = f"{name}, {motion} {span}: off by {off:.2g} mm"
                tally.case(fault if off > _promises.NEAR_MM else "")
    return tally.outcome("of the methods that promise it")


def _spoilt(seed: int, n: int = 700) -> Take:
    """Give a simulated person with a peak, a step and a gap."""
    take = simulate("walk", seed, duration_s=n / 100)
    if n < 480:  # the short version: one leg is a body too
        take = Take(take.positions[:, ::4], take.rate, take.labels[::4])
    positions = take.positions.copy()
    rng = np.random.default_rng(seed)
    markers = rng.choice(take.measured, 3, replace=False)
    positions[n // 4, markers[0]] += 60.0
    positions[n // 2 : n // 2 + 60, markers[1]] += [40.0, -30.0, 25.0]
    positions[n - 60 : n - 40, markers[2]] = np.nan
    return take.with_positions(positions)


def _key(finding: Finding) -> tuple:
    return (finding.marker, finding.span.start, finding.span.stop, finding.kind)


def _detectors(budget: Budget) -> Outcome:
    tally = Tally("detectors: shift, rotation, mirror, unit, reversal")
    for seed in range(budget.of(6, 1)):
        for name in DETECTORS.names()[budget.short :]:
            if budget.spent:
                tally.planned = 60
                break
            take = _spoilt(seed, budget.of(700, 260))
            found = sorted(map(_key, detect(take, name)))
            tally.case("" if found else f"{name}: finds nothing where something is")
            for law in _promises.DETECTORS:
                if name not in _promises.DETECTORS[law]:
                    tally.case(_finds_otherwise(take, name, law, found))
    excepted = "; ".join(f"{n}: no {law}" for law, e in _promises.DETECTORS.items() for n in e)
    return tally.outcome(excepted)


def _finds_otherwise(take: Take, name: str, law: str, found: list[tuple]) -> str:
    if law in SPACE:
        other = take.with_positions(SPACE[law](take.positions))
    elif law == "unit":
        other = _in_metres(take)
    else:
        other = take.with_positions(take.positions[::-1])
    again = [_key(finding) for finding in detect(other, name)]
    if law == "reversal":
        n = take.n_frames
        again = [(m, n - stop, n - start, kind) for m, start, stop, kind in again]
    missing = set(found) ^ set(again)
    return f"{name}, {law}: {len(missing)} of {len(found)} differ" if missing else ""


_AGAIN = """
import hashlib, json, sys
import numpy as np
from markermend.detection import DETECTORS, detect
from markermend.errors import CannotRepair
from markermend.repairing.run import REPAIRS
from tests.core.repairing.conftest import Lab, walker
from tests.trust.numerics import _key, _spoilt
take = _spoilt(1, 480)
said = {f"detector {n}": sorted(map(_key, detect(take, n))) for n in DETECTORS.names()}
for name in REPAIRS.names():
    case = Lab.for_method(REPAIRS.get(name))
    said[name] = np.round(np.nan_to_num(case.solve(name)), 6).tolist()
print(json.dumps(said))
"""


def _repeated(budget: Budget) -> Outcome:
    tally = Tally("the same again, with 1, 1, 2 and 4 threads")
    threads = ("1", "1", "2", "4")
    said = []
    for n in threads:
        if said and budget.spent:
            break
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        done = subprocess.run(
            [sys.executable, "-c", _AGAIN], cwd=ROOT, capture_output=True, text=True,
            env=child_environment() | dict.fromkeys(names, n),
        )  # fmt: skip
        if done.returncode:
            tally.case(f"{n} threads: {done.stderr[-150:]!r}")
            return tally.outcome()
        said.append(json.loads(done.stdout))
    tally.planned = (len(threads) - 1) * len(said[0])
    for n, other in zip(threads[1:], said[1:], strict=False):
        for name, values in said[0].items():
            same = values == other[name] if name.startswith("detector") else np.allclose(
                values, other[name], rtol=0, atol=2e-6
            )  # fmt: skip
            tally.case("" if same else f"{name} is another with {n} threads")
    return tally.outcome("findings equal, repairs within 0.000002 mm")


def _takes(budget: Budget, n_frames: int) -> Iterator[tuple[str, Take]]:
    """Yield the public takes, at most so many frames of each."""
    for path in public():
        if budget.spent:
            return
        contents = opened(path)
        take = contents.take(units=contents.units or "mm", rate=contents.rate or 100.0)
        yield path.name, take.with_positions(take.positions[:n_frames])


def _quiet_detectors(budget: Budget) -> Outcome:
    tally = Tally("detectors on every public take: no warning", 2 * len(public()))
    for label, take in _takes(budget, 6000):
        for name in DETECTORS.names():
            if budget.spent:
                break
            tally.case(_quietly(f"{name} on {label}", lambda n=name, t=take: detect(t, n)))
    return tally.outcome()


def _quiet_repairs(budget: Budget) -> Outcome:
    planned = len(REPAIRS.names()) * (len(public()) - 1)  # one take has no measured marker
    tally = Tally("repairs on every public take: no warning, finite or refused", planned)
    rng = np.random.default_rng(budget.seed)
    for label, take in _takes(budget, 900):
        if not len(take.measured):
            continue
        for name in REPAIRS.names():
            if budget.spent:
                break
            marker = take.labels[int(rng.choice(take.measured))]
            length = int(min(take.n_frames, rng.integers(1, 40)))
            start = int(rng.integers(0, take.n_frames - length + 1))
            span = Span(start, start + length)
            kind = REPAIRS.get(name).kinds[0]

            def act(name=name, take=take, marker=marker, span=span, kind=kind) -> None:
                done = repair(take, marker, span, name, kind=kind)
                assert done.values.shape == (len(span), take.n_dims)
                assert name == "leave" or np.isfinite(done.values).all()

            tally.case(_quietly(f"{name} on {label} {span}", act))
    return tally.outcome()


def _quietly(what: str, act: Callable[[], object]) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            act()
        except MarkerMendError as refusal:
            fault = fault_of_sentence(str(refusal))
            return f"{what}: {fault}" if fault else ""
        except Exception as error:  # noqa: BLE001 - whatever is raised is a fault to report
            return f"{what}: {type(error).__name__} {str(error)[:100]}"
    return ""
