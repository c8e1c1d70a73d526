"""Recordings to the curves of a walk: cycles, phases, one polynomial for each joint and phase, what they are worth."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.fitting.bands import Band, band
from haverify.fitting.curve import Curve, Residual, residual
from haverify.fitting.knots import Knots, knots
from haverify.fitting.solve import curve, points
from haverify.recordings.cycles import Cycle, cycles, timed, whole
from haverify.recordings.events import Steps, steps
from haverify.recordings.phases import boundaries
from haverify.recordings.recording import JOINTS, Forces, Recording
from haverify.recordings.stride import Stride, is_still, stride
from haverify.text.record import record, replace

Q = Fraction

_TRAINING = (True, False, True, False, True)  # 60 % of cycles, or recordings, spread evenly


@record
class Options:
    """What a fit is asked for.

    `leg`: whose heel strikes begin cycles (`l`, `r`; empty: the one with more cycles, else the right). `order`: of the
    derivatives without a step. `degree`: of all polynomials (None: chosen for each). `events`: how they are seen.
    """

    leg: str = ""
    order: int = 1
    degree: int | None = None
    events: str = "zeni"


@record
class Walk:
    """A fitted walk. `training` cycles made the curves, `held_out` ones did not; residuals are of each."""

    recordings: tuple[Recording, ...]
    strides: tuple[Stride, ...]
    methods: tuple[str, ...]
    training: tuple[Cycle, ...]
    held_out: tuple[Cycle, ...]
    knots: Knots
    curves: tuple[Curve, ...]
    residuals: tuple[Residual, ...]
    held_residuals: tuple[Residual, ...]
    options: Options
    bands: tuple[Band, ...]
    fixed: bool  # whether some boundary of phases is a usual share, not an event

    @property
    def cycles(self) -> tuple[Cycle, ...]:
        return (*self.training, *self.held_out)


def walk(
    recordings: Sequence[Recording], forces: Sequence[Forces], options: Options
) -> tuple[Walk | None, list[Diagnostic]]:
    """The walk in some recordings, with findings; None where one of them is an error."""
    found: list[Diagnostic] = []
    seen: list[tuple[Recording, Stride, Steps]] = []
    for r in recordings:
        s, more = _stride(r)
        found += more
        if s is not None:
            events = steps(r, s, _forces_of(r, forces), options.events)
            found += events.found
            seen.append((r, timed(s, events), events))
    options = replace(options, leg=options.leg or _leg(seen))
    groups = [cycles(*one, options.leg) for one in seen]
    strides, methods = [s for _, s, _ in seen], [e.of[options.leg].method for _, _, e in seen]
    if not groups or any(d.severity is Severity.ERROR for d in found) or len(groups) < len(recordings):
        return None, found
    made, more = _fitted(recordings, groups, strides, methods, options)
    return made, [*found, *more]


def _leg(seen: Sequence[tuple[Recording, Stride, Steps]]) -> str:
    """The leg with more whole cycles; the right one where both have as many."""
    count = {leg: sum(len(whole(r, s, e, leg)) for r, s, e in seen) for leg in "rl"}
    return "l" if count["l"] > count["r"] else "r"


def _forces_of(r: Recording, forces: Sequence[Forces]) -> Forces | None:
    """The forces that cover most of a recording, if any do."""
    best, most = None, Q(0)
    for f in forces:
        shared = min(r.times[-1], f.times[-1]) - max(r.times[0], f.times[0])
        if shared > most:
            best, most = f, shared
    return best


def _stride(r: Recording) -> tuple[Stride | None, list[Diagnostic]]:
    """How long a stride takes, or why that cannot be said."""
    if len(r.times) < 15:
        return None, [Diagnostic("HA224", f"{r.path}: {len(r.times)} samples are too few for a stride")]
    if is_still(r):
        message = f"{r.path}: hips and knees hardly move: nobody walks here, or angles are in another unit"
        return None, [Diagnostic("HA224", message)]
    s = stride(r)
    if not s.kind:
        message = f"{r.path}: {float(r.duration):.3f} s without a stride: nothing repeats, no leg follows the other"
        return None, [Diagnostic("HA224", message, help="record at least one whole stride of both legs")]
    if s.kind == "mirrors":
        message = f"{r.path}: half a stride, ending as it begins with the legs exchanged: completed by its mirror image"
        return s, [Diagnostic("HA226", message, severity=Severity.WARNING)]
    return s, []


def _fitted(
    recordings: Sequence[Recording],
    groups: Sequence[Sequence[Cycle]],
    strides: Sequence[Stride],
    methods: Sequence[str],
    options: Options,
) -> tuple[Walk, list[Diagnostic]]:
    every = [c for g in groups for c in g]
    training, held_out = split(groups)
    shares, found = boundaries(every)
    grid = knots(shares, sum((c.length for c in every), Q(0)) / len(every))
    curves = []
    for joint in JOINTS:
        curves.append(curve(points(training, joint, grid), joint, grid, options.order, options.degree))
    rounding = max(r.rounding for r in recordings)
    trained, left = (tuple(residual(c, part, rounding) for c in curves) for part in (training, held_out))
    made = Walk(
        recordings=tuple(recordings),
        strides=tuple(strides),
        methods=tuple(methods),
        training=tuple(training),
        held_out=tuple(held_out),
        knots=grid,
        curves=tuple(curves),
        residuals=trained,
        held_residuals=left,
        options=options,
        bands=tuple(b for j in JOINTS if (b := band(training, j)) is not None),
        fixed=bool(found),
    )
    return made, found


def split(groups: Sequence[Sequence[Cycle]]) -> tuple[list[Cycle], list[Cycle]]:
    """60 % of the recordings, or of the cycles where there are fewer than three, for training, and the rest.

    With fewer than three of both, all is training.
    """
    if len(groups) < 3:
        groups = [[c] for g in groups for c in g]
    if len(groups) < 3:
        return [c for g in groups for c in g], []
    chosen = [_TRAINING[i % 5] for i in range(len(groups))]
    return (
        [c for g, is_in in zip(groups, chosen, strict=True) if is_in for c in g],
        [c for g, is_in in zip(groups, chosen, strict=True) if not is_in for c in g],
    )
