"""Why a mode is never entered, where that is simple to say."""

from __future__ import annotations

from haverify.analyses.clocked import Cells
from haverify.model.expression import Expr
from haverify.obligations.parts import edge_names


def why_unreached(condition: Expr, cells: Cells) -> tuple[str, ...]:
    """A note for each mode that the condition asks for and no run enters: what becomes of the edges into it."""
    if cells.trouble is not None:
        return ()
    members = condition.children if condition.op == "and" else (condition,)
    wanted = dict.fromkeys(m.name for m in members if m.op == "at")
    return tuple(_note(name, cells) for name in wanted if not cells.of_mode(cells.model.index[name]))


def _note(name: str, cells: Cells) -> str:
    model = cells.model
    names = edge_names(model.automaton.edges)
    found = []
    for k, edge in enumerate(model.automaton.edges):
        if edge.target == name and edge.source != name:
            is_reached = bool(cells.of_mode(model.index[edge.source]))
            what = "is enabled in no state reached" if is_reached else f"starts in {edge.source}, which no run enters"
            found.append(f"edge {edge.name} ({names[k]}) {what}")
    return f"no run enters mode {name}: " + ("; ".join(found[:4]) if found else "no edge leads into it")
