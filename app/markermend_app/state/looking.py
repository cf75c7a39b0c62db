"""Where the operator looks: playhead, window, view, and what the lanes show."""

import param

from markermend.model import Span
from markermend_app.state.held import Held
from markermend_app.state.values import OverviewValues, SpanMark

ZOOMS = ("span", "5 s", "take")
VIEWS = ("oblique", "front", "side", "top")
BONES = ("inferred", "template")
SIGNALS = ("residual", "speed", "acceleration", "distance")


class Looking(Held):
    """What is looked at; nothing here is a decision, and undo does not touch it."""

    frame: int = param.Integer(0, bounds=(0, None))
    window: tuple[float, float] = param.Parameter((0.0, 1.0), doc="Seconds that the lanes show.")
    zoom: str = param.Selector(default="span", objects=list(ZOOMS))
    playing: bool = param.Boolean(False)
    looping: bool = param.Boolean(True)
    speed: float = param.Number(1.0, bounds=(0.1, 4.0))
    view: str = param.Selector(default="oblique", objects=[*VIEWS, "free"])
    following: bool = param.Boolean(True)
    bones: str = param.Selector(default="inferred", objects=list(BONES))
    raw_only: bool = param.Boolean(False)
    relative: bool | None = param.Boolean(
        default=None, allow_None=True, doc="Without the neighbours' motion; None: as it serves."
    )
    signal: str = param.Selector(default="residual", objects=list(SIGNALS))
    theme: str = param.Selector(default="light", objects=["light", "dark"])

    @property
    def skeleton(self) -> tuple[str, tuple[tuple[int, int], ...]]:
        """Which bones are drawn: the name of the set of markers, or empty, and pairs of markers."""
        assert self.opened is not None
        named = self.opened.skeleton if self.bones == "template" else None
        return ("", self.opened.mesh.bones) if named is None else named

    def seek(self, frame: float) -> None:
        """Put the playhead on a frame."""
        if self.opened is not None:
            self.frame = min(max(0, round(frame)), self.opened.take.n_frames - 1)

    def step_frame(self, by: int) -> None:
        """Stop playing and move the playhead by some frames."""
        self.playing = False
        self.seek(self.frame + by)

    def seek_s(self, time_s: float) -> None:
        """Put the playhead at a time."""
        if self.opened is not None:
            self.seek(time_s * self.opened.take.rate)

    def zoom_next(self) -> None:
        """Show the span, five seconds, or the whole take."""
        self.zoom = ZOOMS[(ZOOMS.index(self.zoom) + 1) % len(ZOOMS)]
        self._fit_window()

    def signal_next(self) -> None:
        """Show the next evidence."""
        self.signal = SIGNALS[(SIGNALS.index(self.signal) + 1) % len(SIGNALS)]

    def _fit_window(self) -> None:
        if self.opened is None:
            return
        take, span = self.opened.take, self.span
        if self.zoom == "take":
            self.window = (0.0, take.duration_s)
            return
        start, stop = (span.start, span.stop) if span else (self.frame, self.frame + 1)
        middle, length = (start + stop) / 2 / take.rate, (stop - start) / take.rate
        half = max(2.5, length * 0.6) if self.zoom == "5 s" else max(0.35, length * 1.2)
        half = half if span else 2.5
        self.window = (max(0.0, middle - half), min(take.duration_s, middle + half))

    @property
    def loop(self) -> Span | None:
        """The frames that playback repeats: the span and a second on both sides."""
        if self.opened is None or self.span is None or not self.looping:
            return None
        take = self.opened.take
        return self.span.padded(round(take.rate), take.n_frames)

    def nearest(self, time_s: float, row: float, shown: OverviewValues) -> str | None:
        """Give the finding of the overview nearest to a place, or None if there is none near."""
        near = 0.02 * shown.duration_s

        def distance(entry: tuple[str, SpanMark]) -> float:
            label, mark = entry
            away_s = max(mark.start_s - time_s, time_s - mark.stop_s, 0.0)
            return away_s / near + abs(shown.rows[label] + 0.5 - row) / 2

        found = min(shown.marks, key=distance, default=None)
        return found[1].id if found is not None and distance(found) <= 1.0 else None

    def go(self, time_s: float, duration_s: float) -> None:
        """Move the window and the playhead to a time."""
        low, high = self.window
        half = (high - low) / 2
        middle = min(max(time_s, half), max(half, duration_s - half))
        self.window = (middle - half, middle + half)
        self.seek_s(time_s)
