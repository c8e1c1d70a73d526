"""Periodic orbits: Newton's method on the return of a run to where it was, in floats; with period and multipliers.

The unknowns are a state inside a stay and the period. Its section is the plane through the state across the flow. The
derivative of the flow over a period, jumps included, is taken by differences of runs (Richardson's extrapolation), so
it is exact to about ten digits, and the root itself to rounding: an inexact derivative only costs a step more.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.draws import Draw
from haverify.simulate.run import Settings, SimulatedRun, followed
from haverify.text.record import holder, record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

NEWTON = 20  # steps of Newton's method
NEAR = 0.2  # of the size of the orbit: a return so near is one to start from
WIDTHS = (4e-3, 2e-3, 1e-3)  # of each variable's size: differences that are extrapolated
TIGHTER = 16  # times less where a jump is too near
LAST = 12  # stays of which the longest is cut by the plane
DONE = 1e-16  # of the size of the orbit: it closes as well as can be told
WORSE = 3  # steps after which nothing closes any better: rounding is all that is left
WRONG = 1e-9  # of the size of the orbit: an orbit that closes no better is none


@record
class Orbit:
    """A periodic orbit: a mode and state on it, period (s), jumps in one, multipliers by size, how well it closes."""

    mode: int
    state: tuple[float, ...]
    period: float
    jumps: int
    multipliers: tuple[complex, ...]
    gap: float
    run: SimulatedRun

    @property
    def is_attracting(self) -> bool:
        """Whether all near orbits come to it, as far as floats tell."""
        return all(abs(m) < 1 for m in self.multipliers)

    def told(self) -> str:
        """The orbit in a sentence."""
        model, count = self.run.model, len(self.run.model.automaton.vars)
        state = ", ".join(f"{n} = {x:.12g}" for n, x in zip(model.names[:count], self.state, strict=False))
        multipliers = ", ".join(_written(m) for m in self.multipliers)
        kind = "attracting" if self.is_attracting else "not attracting"
        jumps = f"{self.jumps} jump{'' if self.jumps == 1 else 's'}"
        where = f"through {model.automaton.modes[self.mode].name}: {state}"
        return f"period {self.period:.15g} s with {jumps}, {kind}, multipliers {multipliers}; {where}"

    def as_json(self) -> dict[str, Any]:
        """The orbit as a JSON value; multipliers as pairs of real and imaginary part."""
        model, count = self.run.model, len(self.run.model.automaton.vars)
        return {
            "mode": model.automaton.modes[self.mode].name,
            "state": dict(zip(model.names[:count], self.state, strict=False)),
            "period": self.period,
            "jumps": self.jumps,
            "multipliers": [[m.real, m.imag] for m in self.multipliers],
            "attracting": self.is_attracting,
            "gap": self.gap,
        }


def orbit_of(run: SimulatedRun) -> Orbit:
    """The periodic orbit that a run has come near to.

    Raises
    ------
    OutsideFragmentError    if the run never comes back, reads the time, or Newton's method does not converge
    """
    if any(w[1] for w in run.draw.writes) or _reads_time(run):
        raise OutsideFragmentError("a flow that reads the time or an input: make it a clock of the model")
    return _Closing(run, *_return(run)).orbit()


def _reads_time(run: SimulatedRun) -> bool:
    clock = run.model.names.index("time")
    return any(op[0] == "variable" and op[1] == [clock] for code in run.model.codes for op in code.operations)


def _return(run: SimulatedRun) -> tuple[int, list[float], float]:
    """A mode and state inside a late stay, and how long before or after it the run is near to it, across the flow."""
    import numpy as np

    pieces = [p for p in run.record.pieces() if p[3] > 0]
    mode, start, now, state = _inside(pieces)
    count = len(run.model.automaton.vars)
    across = np.array(run.model.kernel.slopes(mode, state)[:count])
    size = _sizes(run, count)
    here, found = np.array(state[:count]), list[tuple[float, float]]()
    for p in pieces:
        for t in _crossings(p, here, across, count) if p[0] == mode and p[2] != start else ():
            apart = float(np.max(np.abs(np.array(_at(p[4], t)[:count]) - here) / size))
            found.append((apart, abs(p[2] + t - now)))
    near = [t for apart, t in found if apart < NEAR]
    if not near:
        raise OutsideFragmentError("the run comes to no place a second time: simulate longer (--until)")
    return mode, state, min(near)


def _inside(pieces: Sequence[Any]) -> tuple[int, float, float, list[float]]:
    """The mode, a time just before, time and state in the middle of the longest of the last whole stays."""
    last = max((p[1] for p in pieces), default=0)
    stays: dict[int, list[Any]] = {}
    for p in pieces:
        if p[1] >= max(last - LAST, last // 2) and (p[1] < last or last == 0):
            stays.setdefault(p[1], []).append(p)
    if not stays:
        raise OutsideFragmentError("the run has no stay of some length")
    stay = max(stays.values(), key=lambda s: sum(float(p[3]) for p in s))
    end = stay[-1][2] + stay[-1][3]
    middle = (stay[0][2] + end) / 2 if last else end - stay[-1][3] / 2
    mode, _, start, _, series, _ = next(p for p in reversed(stay) if p[2] <= middle)
    return mode, start, middle, _at(series, middle - start)


def _crossings(piece: Any, here: Vector, across: Vector, count: int) -> list[float]:
    """The times in a piece at which it goes through the plane across the flow, onwards."""
    import numpy as np

    _, _, _, length, series, _ = piece
    scaled = [np.array(s) * length ** np.arange(len(s)) for s in series[:count]]
    height = sum(a * s for a, s in zip(across, scaled, strict=True))
    height[0] -= float(across @ here)
    last = np.flatnonzero(np.abs(height) > 1e-14 * np.max(np.abs(height)))
    roots = np.roots(height[: last[-1] + 1][::-1]) if len(last) else np.array([])
    real = [float(r.real) for r in roots if abs(r.imag) < 1e-8 and -1e-9 <= r.real < 1]
    slope = np.polynomial.polynomial.polyder(height)
    return [r * length for r in real if np.polynomial.polynomial.polyval(r, slope) > 0]


def _at(series: Sequence[Sequence[float]], t: float) -> list[float]:
    found = []
    for s in series:
        value = 0.0
        for c in reversed(s):
            value = value * t + c
        found.append(value)
    return found


def _sizes(run: SimulatedRun, count: int) -> Vector:
    """How far each variable moves on a run."""
    import numpy as np

    states = np.array([row[3][:count] for row in run.rows([run.time * k / 400 for k in range(401)])])
    wide = np.max(states, axis=0) - np.min(states, axis=0)
    return np.where(wide > 0, wide, 1.0)


@holder
class _Closing:
    """An orbit that nearly closes, and Newton's method on what is missing."""

    run: SimulatedRun
    mode: int
    state: list[float]
    period: float

    def __post_init__(self) -> None:
        count = len(self.run.model.automaton.vars)
        self.sizes = _sizes(self.run, count)
        states = [s for _, _, _, s, _ in self.run.rows([self.run.time * k / 400 for k in range(401)])]
        self.moving = [v for v in range(count) if any(s[v] != self.state[v] for s in states)]

    def orbit(self) -> Orbit:
        """The orbit.

        Raises
        ------
        OutsideFragmentError    if the steps do not get smaller
        """
        import numpy as np

        best, gap, worse = np.inf, np.inf, 0
        kept = list(self.state), self.period
        for _ in range(NEWTON):
            missing = self._end(self._vector(), self.period) - self._vector()
            gap = float(np.max(np.abs(missing) / self._size()))
            if gap < best:
                best, kept = gap, (list(self.state), self.period)
            else:
                worse += best < WRONG
            if best < DONE or worse >= WORSE:
                break
            self._move(self._step(self._derivative(), self._flow(), missing))
        self.state, self.period = kept
        if not best < WRONG or self.period <= 0:
            raise OutsideFragmentError("no periodic orbit was found: simulate longer (--until), or start nearer to it")
        run = followed(self.run.model, self._draw(self._vector()), Settings(self.period))
        found = self._multipliers(self._derivative(), self._flow())
        return Orbit(self.mode, tuple(self.state), self.period, len(run.jumps), found, best, run)

    def _step(self, jacobian: Vector, flow: Vector, missing: Vector) -> Vector:
        """The change of state, across the flow, and of the period that closes the orbit to first order."""
        import numpy as np

        n, size = len(self.moving), self._size()
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = (jacobian - np.eye(n)) * size / size[:, None]
        matrix[:n, n] = flow / size
        matrix[n, :n] = flow / size / np.linalg.norm(flow / size)
        found = np.linalg.lstsq(matrix, np.append(-missing / size, 0.0), rcond=None)[0]
        return np.asarray(np.append(found[:n] * size, found[n]))

    def _move(self, step: Vector) -> None:
        for v, by in zip(self.moving, step, strict=False):
            self.state[v] += float(by)
        self.period += float(step[-1])

    def _derivative(self) -> Vector:
        """How the state after a period depends on the state before it."""
        import numpy as np

        try:
            return np.stack([self._column(k, 1.0) for k in range(len(self.moving))], axis=1)
        except OutsideFragmentError:
            return np.stack([self._column(k, 1.0 / TIGHTER) for k in range(len(self.moving))], axis=1)

    def _column(self, k: int, share: float) -> Any:
        """The derivative by one variable, by differences of a share of the widths."""
        here, by = self._vector(), self._vector() * 0
        by[k] = self._size()[k] * share
        slopes = []
        for w in WIDTHS:
            ahead, behind = self._end(here + w * by, self.period), self._end(here - w * by, self.period)
            slopes.append((ahead - behind) / (2 * w * by[k]))
        return _extrapolated(slopes)

    def _multipliers(self, jacobian: Vector, flow: Vector) -> tuple[complex, ...]:
        """Eigenvalues of the return map on the plane across the flow, the largest first."""
        import numpy as np

        size = self._size()
        scaled, along = jacobian * size / size[:, None], flow / size / np.linalg.norm(flow / size)
        plane = np.linalg.svd(along[None, :])[2][1:].T
        onto = np.eye(len(size)) - np.outer(along, along)
        values: Any = np.linalg.eigvals(plane.T @ onto @ scaled @ plane) if len(size) > 1 else ()
        return tuple(sorted((complex(v) for v in values), key=lambda m: (-abs(m), m.imag)))

    def _vector(self) -> Vector:
        import numpy as np

        return np.array([self.state[v] for v in self.moving])

    def _size(self) -> Vector:
        return self.sizes[self.moving]

    def _flow(self) -> Vector:
        import numpy as np

        rates = self.run.model.kernel.slopes(self.mode, self.state)
        return np.array([rates[v] for v in self.moving])

    def _draw(self, vector: Vector) -> Draw:
        state = list(self.state)
        for v, x in zip(self.moving, vector, strict=True):
            state[v] = float(x)
        state[self.run.model.places["time"]] = 0.0
        return Draw(self.mode, state, [])

    def _end(self, vector: Vector, after: float) -> Vector:
        """The state some time after one.

        Raises
        ------
        OutsideFragmentError    if the run ends before, or elsewhere
        """
        import numpy as np

        run = followed(self.run.model, self._draw(vector), Settings(after))
        if run.end != "horizon" or run.mode != self.mode:
            raise OutsideFragmentError(f"a run beside the orbit does not return: {run.told()}")
        return np.array([run.state[v] for v in self.moving])


def _extrapolated(slopes: list[Any]) -> Any:
    """Central differences of halved widths without their errors of second and fourth order."""
    order = 4.0
    while len(slopes) > 1:
        slopes = [(order * b - a) / (order - 1) for a, b in pairwise(slopes)]
        order *= 4
    return slopes[0]


def _written(m: complex) -> str:
    """A multiplier to the nine decimals that differences of runs give."""
    real, imaginary = round(m.real, 9) + 0.0, round(abs(m.imag), 9)
    if imaginary == 0:
        return f"{real:.9g}"
    return f"{real:.9g}{'+' if m.imag > 0 else '-'}{imaginary:.9g}i"
