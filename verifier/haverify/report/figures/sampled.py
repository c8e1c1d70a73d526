"""A few runs of a flow in floating point, to be drawn into a flowpipe: steps no longer than those of the flowpipe."""

from __future__ import annotations

from math import isfinite

from haverify.report.figures.evaluate import Scope, State, Value, with_params
from haverify.report.figures.material import Undrawable
from haverify.report.figures.pipes import Piece
from haverify.text.record import record

_RUNS = 5
_WORK = 14_000  # evaluations of rates for all runs together


@record
class Trail:
    """A sampled run: instants and states."""

    times: tuple[float, ...]
    states: tuple[State, ...]


def trails(s: Scope, piece: Piece) -> list[Trail]:
    """Runs from the middle and from some corners of a piece's start; none where the flow cannot be computed."""
    parts = max(1, _WORK // (_RUNS * 4 * max(1, len(s.rates)) * len(piece.steps)))
    found = []
    for start in starts(piece):
        own = with_params(s, {n: repr(x) for n, x in start.items() if n in s.params})
        try:
            rates = {"time": _one, **{n: own.value(rate) for n, rate in s.rates.items()}}
        except Undrawable:
            return []
        found.append(_trail(rates, start, piece, min(parts, 4)))
    return [t for t in found if t is not None]


def _one(_: State) -> float:
    return 1.0


def starts(piece: Piece) -> list[State]:
    """The middle, then corners: ends taken in turn, so that they lie far apart."""
    wide = [n for n, (low, high) in piece.start.items() if low < high]
    middle = {n: (low + high) / 2 for n, (low, high) in piece.start.items()}
    ends = [{n: piece.start[n][k >> (j % 2) & 1] for j, n in enumerate(wide)} for k in range(2 ** len(wide[:2]))]
    return [middle, *({**middle, **e} for e in ends if e)][:_RUNS]


def _trail(rates: dict[str, Value], start: State, piece: Piece, parts: int) -> Trail | None:
    times, states = [piece.steps[0].time[0]], [start]
    for step in piece.steps:
        h = (step.time[1] - times[-1]) / parts
        for _ in range(parts):
            try:
                states.append(stepped(rates, states[-1], h))
            except (ArithmeticError, ValueError, Undrawable):
                return None
            times.append(times[-1] + h)
        if not all(map(isfinite, states[-1].values())):
            return None
    return Trail(tuple(times), tuple(states))


def stepped(rates: dict[str, Value], state: State, h: float) -> State:
    """The classical method of order 4."""
    a = _slopes(rates, state)
    b = _slopes(rates, _moved(state, a, h / 2))
    c = _slopes(rates, _moved(state, b, h / 2))
    d = _slopes(rates, _moved(state, c, h))
    return {n: x + h / 6 * (a[n] + 2 * b[n] + 2 * c[n] + d[n]) if n in a else x for n, x in state.items()}


def _slopes(rates: dict[str, Value], state: State) -> dict[str, float]:
    return {n: float(rate(state)) for n, rate in rates.items()}


def _moved(state: State, slopes: dict[str, float], h: float) -> State:
    return {n: x + h * slopes[n] if n in slopes else x for n, x in state.items()}
