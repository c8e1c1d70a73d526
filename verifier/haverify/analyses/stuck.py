"""That runs can go on: in every cell of a mode an edge is certainly enabled, at the latest, when the stay ends."""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.bounds import narrow
from haverify.analyses.clocked import Cells, certain_from, certainly_lands, longest, moved
from haverify.obligations.formula import literals

Q = Fraction


def never_stuck(cells: Cells, index: int, time: Q | None) -> bool:
    """Whether a run in the cell can always go on, at least up to `time` (s)."""
    model, cell = cells.model, cells.cells[index]
    if model.mode(cell.mode).terminal:
        return True
    if any(certain_exit(cells, index, k) for k in model.leaving[cell.mode]):
        return True
    return cell.dwell is None or (time is not None and over(cells, index, time))


def over(cells: Cells, index: int, time: Q) -> bool:
    """Whether it is `time` (s) or later, for all params, when the stay in the cell ends."""
    cell = cells.cells[index]
    if cell.sigma is None or cell.sigma.low is None or cell.dwell is None:
        return False
    return cell.sigma.low + cell.dwell >= time * cells.model.rho_range[1]


def certain_exit(cells: Cells, index: int, k: int) -> bool:
    """Whether the edge is enabled, with an outcome, for every state of the cell when its stay ends."""
    model, cell = cells.model, cells.cells[index]
    edge = model.edge(k)
    at = certain_from(edge.guard, model, cell)
    if at is None or cell.dwell is None or at > cell.dwell:
        return False
    if not edge.urgent and any(leaf.op == "<" for leaf in literals(edge.guard)):
        return False
    slopes = model.mode(cell.mode).slopes
    before = {v: moved(x, slopes[v], Q(0), cell.dwell) for v, x in cell.entry.items()}
    allowed = model.mode(cell.mode).allowed or {}
    before = {v: x.meet(allowed[v]).closed if v in allowed else x for v, x in before.items()}
    gate = narrow(edge.guard, before, model.params)
    return gate is not None and longest(model, cell, cells.limit) == cell.dwell and certainly_lands(model, edge, gate)
