"""Flowpipes as figures read them: boxes over time by piece, and the levels that a claim compares variables with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf, isfinite
from statistics import median
from typing import Any

from haverify.report.figures.evaluate import Scope, reads
from haverify.report.figures.material import Json, Undrawable
from haverify.text.record import record

Pair = tuple[float, float]

_MOST = 2000  # steps of a file that is still drawn
_WIDE = 20.0  # a box so many times wider than most is cut off at the frame
_COMPARED = ("<", "<=", ">", ">=", "==", "!=")


@record
class Step:
    """The instants of a step, and the box of its states by name."""

    time: Pair
    box: dict[str, Pair]


@record
class Piece:
    """Steps in one mode after some jumps, from a box of starts."""

    mode: str
    jumps: int
    start: dict[str, Pair]
    steps: tuple[Step, ...]


@record
class Pipe:
    """All pieces, the names of what their boxes are about, the last instant to show."""

    names: tuple[str, ...]
    pieces: tuple[Piece, ...]
    end: float

    @property
    def modes(self) -> list[str]:
        """The modes in the order in which they occur."""
        return list(dict.fromkeys(p.mode for p in self.pieces))

    def range(self, name: str) -> Pair:
        """What a drawing of a variable should show: all boxes but those far wider than most."""
        boxes = [s.box[name] for p in self.pieces for s in p.steps]
        usual = median(high - low for low, high in boxes)
        shown = [b for b in boxes if b[1] - b[0] <= _WIDE * usual + 1e-12 * (abs(b[0]) + abs(b[1]))] or boxes
        return min(low for low, _ in shown), max(high for _, high in shown)


@record
class Level:
    """A value that a claim compares a variable with, and the instants at which it does (None: until the end).

    `kind` is `jump` where it is a guard that compares.
    """

    name: str
    value: float
    first: float = 0.0
    last: float | None = None
    kind: str = "bound"


def read(value: Json) -> Pipe:
    """The flowpipe of a file.

    Raises
    ------
    Undrawable      if it holds no steps, or too many
    ValueError, TypeError, KeyError, AttributeError     if it is no such file
    """
    names = tuple(str(n) for n in value["names"])
    pieces = tuple(p for p in (_piece(names, p) for p in value["pieces"]) if p.steps)
    if not pieces or not names or sum(len(p.steps) for p in pieces) > _MOST:
        raise Undrawable
    return Pipe(names, pieces, max(s.time[1] for p in pieces for s in p.steps))


def _piece(names: Sequence[str], value: Json) -> Piece:
    start = dict(zip(names, (_pair(p) for p in value["start"]), strict=True))
    return Piece(str(value["mode"]), int(value["jumps"]), start, tuple(_step(names, s) for s in value["steps"]))


def _step(names: Sequence[str], value: Sequence[Any]) -> Step:
    pairs = [_pair(value[k : k + 2]) for k in range(0, len(value), 2)]
    return Step(pairs[0], dict(zip(names, pairs[1:], strict=True)))


def _pair(value: Sequence[Any]) -> Pair:
    low, high = value
    if not (isfinite(low) and isfinite(high) and low <= high):
        raise Undrawable
    return float(low), float(high)


def levels(claim: Json, s: Scope) -> list[Level]:
    """The values that the goals of a claim compare single variables with, each once."""
    found = [x for goal in claim.get("goals", []) for x in _of_goal(goal, s)]
    return list(dict.fromkeys(found))


def _of_goal(goal: Json, s: Scope) -> Iterator[Level]:
    window = goal.get("window")
    first, last = (float(s.value(e)({})) for e in window) if window else (0.0, None)
    for name, value in _compared(goal.get("condition"), s):
        yield Level(name, value, first, last)


def horizon(claim: Json, s: Scope) -> float:
    """The last instant that a claim speaks of; infinite where it does not say."""
    ends = [(claim.get("horizon") or {}).get("time"), *(g.get("within") for g in claim.get("goals", []))]
    ends += [g["window"][1] for g in claim.get("goals", []) if g.get("window")]
    known = [float(s.value(e)({})) for e in ends if e is not None]
    return min((t for t in known if t > 0), default=inf)


def compared(guard: Any, s: Scope) -> list[Level]:
    """The values that a guard compares single variables with."""
    return [Level(name, value, kind="jump") for name, value in _compared(guard, s)]


def _compared(e: Any, s: Scope) -> Iterator[tuple[str, float]]:
    if not isinstance(e, list) or not e:
        return
    if e[0] not in _COMPARED or len(e) != 3:
        for x in e[1:]:
            yield from _compared(x, s)
        return
    for one, other in ((e[1], e[2]), (e[2], e[1])):
        if isinstance(one, list) and one[0] in ("var", "abs") and not reads(other, s):
            yield from _level(one, other, s)


def _level(one: Any, other: Any, s: Scope) -> Iterator[tuple[str, float]]:
    try:
        value = float(s.value(other)({}))
    except Undrawable:
        return
    if one[0] == "var":
        yield str(one[1]), value
    elif isinstance(one[1], list) and one[1][0] == "var":
        yield str(one[1][1]), value
        yield str(one[1][1]), -value


def read_by(claim: Json, s: Scope) -> list[str]:
    """The variables that a claim is about, in order of their names' appearance."""
    return list(dict.fromkeys(n for goal in claim.get("goals", []) for n in _variables(goal.get("condition"), s)))


def _variables(e: Any, s: Scope) -> Iterator[str]:
    if not isinstance(e, list) or not e:
        return
    if e[0] == "var":
        yield str(e[1])
    elif e[0] == "let":
        yield from sorted(reads(e, s))
    else:
        for x in e[1:]:
            yield from _variables(x, s)
