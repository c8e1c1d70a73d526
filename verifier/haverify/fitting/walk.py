"""Recordings to the curves of a walk: cycles, phases, one polynomial for each joint and phase, what they are worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import ceil, floor

from haverify.diagnostics.codes import is_error
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.fitting.bands import Band, band
from haverify.fitting.bounded import Interval
from haverify.fitting.curve import Curve, Residual, residual
from haverify.fitting.kept_bounds import broken, contradictions
from haverify.fitting.knots import Knots, knots
from haverify.fitting.solve import curve, points
from haverify.recordings.cycles import Cycle, cycles, timed, whole
from haverify.recordings.events import Steps, steps
from haverify.recordings.leaps import settled
from haverify.recordings.phases import boundaries
from haverify.recordings.recording import JOINTS, Forces, Recording
from haverify.recordings.stride import Stride, is_still, stride
from haverify.text.record import field, record, replace

Q = Fraction

_TRAINING = (True, False, True, False, True)  # 60 % of cycles, or recordings, spread evenly


@record
class Options:
    """What a fit is asked for.

    `leg`: whose heel strikes begin cycles (`l`, `r`; empty: the one with more cycles, else the right). `order`: of the
    derivatives without a step. `degree`: of all polynomials (None: chosen for each). `events`: how they are seen.
    `outliers`: samples that leap are left out if they are `single`, all (`drop`), or none (`keep`). `bounds`: where
    hips (`h`), knees (`k`) or ankles (`a`) have to stay.
    """

    leg: str = ""
    order: int = 1
    degree: int | None = None
    events: str = "zeni"
    outliers: str = "single"
    bounds: Mapping[str, Interval] = field(default_factory=dict)


@record
class Walk:
    """A fitted walk. `training` cycles made the curves, `held_out` ones did not; residuals are of each.

    `shifts` are how far whole recordings lie from each curve, of several recordings. `rounding` is that of the angles.
    `is_tried` where the held-out cycles are of recordings given for that, whose claims are to be proved as they are.
    """

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
    shifts: tuple[tuple[Q, Q], ...]
    rounding: Q
    is_tried: bool

    @property
    def cycles(self) -> tuple[Cycle, ...]:
        return (*self.training, *self.held_out)

    @property
    def whole_sample(self) -> tuple[Cycle, ...]:
        """The cycles of the population that is fitted: all, but for those of recordings that are only tried."""
        return self.training if self.is_tried else self.cycles


def walk(
    recordings: Sequence[Recording],
    forces: Sequence[Forces],
    options: Options,
    tried: Sequence[Recording] = (),
) -> tuple[Walk | None, list[Diagnostic]]:
    """The walk in some recordings, with findings; None where one of them is an error.

    Cycles of `tried` recordings are the ones held out, if there are any: all cycles of the others make the curves.
    """
    found: list[Diagnostic] = []
    seen = [_seen(r, forces, options, found) for r in (*recordings, *tried)]
    there = [x for x in seen if x is not None]
    if not there or len(there) < len(seen) or any(is_error(d) for d in found):
        return None, found
    options = replace(options, leg=options.leg or _leg(there))
    groups = [cycles(*one, options.leg) for one in there]
    n = len(recordings)
    training, held_out = split(groups) if not tried else (_joined(groups[:n]), _joined(groups[n:]))
    against = contradictions(options.bounds, training)
    if any(is_error(d) for d in against):
        return None, [*found, *against]
    made, more = _fitted(tuple(recordings), there[:n], training, held_out, options)
    more += [*against, *broken(options.bounds, made.curves)]
    if any(is_error(d) for d in more):
        return None, [*found, *more]
    return (replace(made, is_tried=True, rounding=_rounding(*recordings, *tried)) if tried else made), [*found, *more]


Seen = tuple[Recording, Stride, Steps]


def _seen(r: Recording, forces: Sequence[Forces], options: Options, found: list[Diagnostic]) -> Seen | None:
    """A recording with its stride and its events; None where findings say why."""
    r, more = settled(r, options.outliers)
    found += more
    s, more = _stride(r)
    found += more
    if s is None:
        return None
    events = steps(r, s, _forces_of(r, forces), options.events)
    found += events.found
    return r, timed(s, events), events


def _rounding(*recordings: Recording) -> Q:
    return max(r.rounding for r in recordings)


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
    recordings: tuple[Recording, ...],
    seen: Sequence[Seen],
    training: list[Cycle],
    held_out: list[Cycle],
    options: Options,
) -> tuple[Walk, list[Diagnostic]]:
    shares, found = boundaries(training)
    grid = knots(shares, sum((c.length for c in training), Q(0)) / len(training))
    curves = [
        curve(points(training, j, grid), j, grid, options.order, options.degree, options.bounds.get(j[1]))
        for j in JOINTS
    ]
    rounding = _rounding(*recordings)
    trained, left = (tuple(residual(c, part, rounding) for c in curves) for part in (training, held_out))
    made = Walk(
        recordings=recordings,
        strides=tuple(s for _, s, _ in seen),
        methods=tuple(e.of[options.leg].method for _, _, e in seen),
        training=tuple(training),
        held_out=tuple(held_out),
        knots=grid,
        curves=tuple(curves),
        residuals=trained,
        held_residuals=left,
        options=options,
        bands=tuple(b for j in JOINTS if (b := band(training, j)) is not None),
        shifts=tuple(_shift(c, training) for c in curves) if len(recordings) > 1 else (),
        rounding=rounding,
        is_tried=False,
    )
    return made, found


def _shift(c: Curve, cycles: Sequence[Cycle]) -> tuple[Q, Q]:
    """How far recordings are from a curve on average: an interval in tenths of a degree that holds 0 and all."""
    import numpy as np

    means = [0.0]
    for origin in dict.fromkeys(x.origin for x in cycles):
        near = [x.near[c.joint] for x in cycles if x.origin == origin]
        t = np.concatenate([np.array(at) for at, _ in near]) * float(c.knots.period)
        means.append(float(np.mean(np.concatenate([np.array(y) for _, y in near]) - c.at(t))))
    return Q(floor(min(means) * 10), 10), Q(ceil(max(means) * 10), 10)


def _joined(groups: Sequence[Sequence[Cycle]]) -> list[Cycle]:
    return [c for g in groups for c in g]


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
