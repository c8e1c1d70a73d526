"""That runs can go on: in every cell of a mode an edge is certainly enabled, at the latest, when the stay ends."""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.bounds import Box, Interval, narrow, single
from haverify.analyses.cell import moved
from haverify.analyses.clock_model import ClockEdge, closed
from haverify.analyses.clocked import Cells
from haverify.analyses.opening import certainly, certainly_lands, due
from haverify.maths.bernstein import bounds as range_on
from haverify.maths.polynomial import constant
from haverify.obligations.formula import conjunction, literals

Q = Fraction
ENTRY = Q(0)


def never_stuck(cells: Cells, index: int, time: Q | None) -> bool:
    """Whether a run in the cell can always go on, at least up to `time` (s)."""
    model, cell = cells.model, cells.cells[index]
    if model.mode(cell.mode).terminal:
        return True
    if any(certain_exit(cells, index, k) for k in model.leaving[cell.mode]):
        return True
    endless = cell.dwell is None or (time is not None and over(cells, index, time))
    return endless and certainly(model, model.mode(cell.mode).domain, states(cells, index))


def over(cells: Cells, index: int, time: Q) -> bool:
    """Whether it is `time` (s) or later, for all params, when the stay in the cell ends."""
    cell = cells.cells[index]
    if cell.sigma is None or cell.sigma.low is None or cell.dwell is None:
        return False
    return cell.sigma.low + cell.dwell >= time * cells.model.rho_range[1]


def certain_exit(cells: Cells, index: int, k: int) -> bool:
    """Whether the edge is enabled, with an outcome, for every state of the cell, at the latest when its stay ends."""
    model, cell = cells.model, cells.cells[index]
    edge, domain = model.edge(k), model.mode(cell.mode).domain
    found = due(model, cell, edge)
    if found is None or not certainly(model, domain, found.until):
        return False
    if edge.urgent:
        return cell.dwell is None or found.last <= cell.dwell
    strict = [leaf for leaf in literals(edge.guard) if leaf.op == "<"]
    if cell.dwell is None or not all(certainly(model, leaf, cell.entry) for leaf in strict):
        return False
    if not _at_the_end(cells, index, edge):
        return False
    gate = narrow(conjunction([closed(edge.guard), domain]), states(cells, index, found.first), model.params)
    return gate is not None and certainly_lands(model, edge, gate)


def _at_the_end(cells: Cells, index: int, edge: ClockEdge) -> bool:
    """Whether what the guard wants to be equal is so at the end of every stay, which the domain forces."""
    model, cell = cells.model, cells.cells[index]
    mode = model.mode(cell.mode)
    space = {v: moved(x, mode.slopes[v], ENTRY, None) for v, x in cell.entry.items()}
    inside = narrow(mode.domain, space, model.params)
    for leaf in literals(edge.guard):
        one = single(leaf.polynomial, cell.entry) if leaf.op == "==" else None
        v, factor, rest = one or (None, Q(0), constant(0))
        if v is not None and mode.slopes[v] and all(n in model.params for n in rest.variables):
            low, high = sorted(-x / factor for x in range_on(rest, model.params))
            limit = Interval(None, low) if mode.slopes[v] > 0 else Interval(high, None)
            if inside is None or not limit.contains(inside[v]):
                return False
    return True


def states(cells: Cells, index: int, first: Q = ENTRY) -> Box:
    """The states of a cell from a scaled dwell on, its domain ignored."""
    cell = cells.cells[index]
    slopes = cells.model.mode(cell.mode).slopes
    return {v: moved(x, slopes[v], first, cell.dwell) for v, x in cell.entry.items()}
