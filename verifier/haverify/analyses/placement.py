"""From the states of a cell to a box of independent unknowns, named as certificates name them."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.analyses.bounds import Interval
from haverify.analyses.cell import Cell, Exit
from haverify.analyses.clock_model import CLOCK, DWELL, PI, ClockModel
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, transform
from haverify.text.record import record

Q = Fraction
Tree = Any  # "b" | "u" | ["s", variable, q, Tree, Tree] | ["e", [variable, ...], Tree]


@record
class Placement:
    """A box of unknowns and what the variables of a formula are in terms of them.

    The scaled dwell is `(axis - origin) / slope`, where `axis` is the unknown that moves; it is the first variable of
    the state with a single entry value, where there is one, so that most polynomials stay as they are, else `s`.
    """

    box: Mapping[str, tuple[Q, Q]]
    replaced: Mapping[str, Polynomial]
    axis: str | None
    origin: Q
    slope: Q
    bounded: bool

    def apply(self, p: Polynomial) -> Polynomial:
        """The polynomial in the box's unknowns."""
        return p.substitute(self.replaced)

    def place(self, f: Formula) -> Formula:
        """The formula in the box's unknowns."""
        return transform(f, self.apply)

    def dwell(self, point: Mapping[str, Q]) -> Q:
        """The scaled dwell at a point of the box."""
        return Q(0) if self.axis is None else (point[self.axis] - self.origin) / self.slope


def written(t: Tree) -> Tree:
    """A proof as a certificate has it, with numbers as text."""
    if isinstance(t, str):
        return t
    if t[0] == "e":
        return ["e", t[1], written(t[2])]
    return ["s", t[1], str(t[2]), written(t[3]), written(t[4])]


def place(model: ClockModel, cell: Cell, out: Exit | None, extra: Mapping[str, tuple[Q, Q]]) -> Placement:
    """The states of a cell (or those at which an exit leaves it); `extra` are symbolic constants with their ranges."""
    first, last = (Q(0), cell.dwell) if out is None else out.dwell
    slopes = model.mode(cell.mode).slopes
    box: dict[str, tuple[Q, Q]] = {**model.params, "pi": PI, **extra}
    bounded = last is not None
    axis: str | None
    axis, origin, slope = _axis(cell, slopes)
    if first == last:
        axis = None
        dwell = constant(first)
    else:
        dwell = (variable(axis) - constant(origin)).scaled(1 / slope)
        if last is not None:
            ends = sorted((origin + slope * first, origin + slope * last))
            box[axis] = (ends[0], ends[1])
    replaced: dict[str, Polynomial] = {}
    for v, entry in cell.entry.items():
        if v != axis:
            bounded = _start(v, entry, box, replaced, dwell.scaled(slopes[v])) and bounded
    if cell.sigma is not None:
        bounded = _start(CLOCK, cell.sigma, box, replaced, dwell) and bounded
    if out is not None:
        bounded = _chosen(model, out, box) and bounded
    return Placement(box, replaced, axis, origin, slope, bounded)


def _axis(cell: Cell, slopes: Mapping[str, Q]) -> tuple[str, Q, Q]:
    for v, entry in cell.entry.items():
        if slopes[v] and entry.is_point and entry.low is not None:
            return v, entry.low, slopes[v]
    return DWELL, Q(0), Q(1)


def _start(
    v: str, entry: Interval, box: dict[str, tuple[Q, Q]], replaced: dict[str, Polynomial], way: Polynomial
) -> bool:
    """What a variable is: its entry value, a number or an unknown of the box, and the way it has gone since."""
    if entry.is_point and entry.low is not None:
        replaced[v] = constant(entry.low) + way
        return True
    if way.terms:
        replaced[v] = variable(v) + way
    if entry.low is None or entry.high is None:
        return False
    box[v] = (entry.low, entry.high)
    return True


def _chosen(model: ClockModel, out: Exit, box: dict[str, tuple[Q, Q]]) -> bool:
    bounded = True
    for v, reset in model.edge(out.edge).resets.items():
        if reset.is_set:
            after = out.after[v]
            if after.low is None or after.high is None:
                bounded = False
            else:
                box[f"{v}'"] = (after.low, after.high)
    return bounded
