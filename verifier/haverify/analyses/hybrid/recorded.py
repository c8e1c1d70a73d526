"""What a certificate records of trees of stretches: polynomials of each stretch, and the jumps between them."""

from __future__ import annotations

from collections.abc import Sequence
from math import ldexp
from typing import Any

from haverify.analyses.flow_model import Box
from haverify.analyses.flow_record import file_json, polynomial, precision, set_of, step_json, tree
from haverify.analyses.hybrid.model import HybridModel, Start
from haverify.analyses.hybrid.question import Question, follow_record
from haverify.maths.interval import Fault
from haverify.solvers.kernel import RecordedStretch

Json = Any


def tree_json(question: Question, pieces: Sequence[Box]) -> Json | None:
    """A file of recorded flows and jumps from all starts, split down to given pieces; None where it would not do.

    Stretches have to come to the horizon or to jumps at the border of their domain; sets are not cut on their way.
    """
    model = question.model
    if len(model.starts) != len(model.automaton.init):
        return None
    try:
        grown = [{b: follow_record(question, s, b) for b in pieces if _is_within(b, s.box)} for s in model.starts]
    except Fault:
        return None
    rows = [row for trees in grown for found in trees.values() for row in found]
    steps = [step for row in rows for step in row.steps]
    varied, monomials = set_of(model.names, pieces[0]), steps[0][0] if steps else []
    if any(m != monomials for m, _ in steps) or not all(_is_plain(row, rows) for row in rows):
        return None
    bits = precision([step for _, step in steps])
    if bits is None:
        return None
    starts = [_start(model, s, trees, bits) for s, trees in zip(model.starts, grown, strict=True)]
    order = len(steps[0][1][1][0]) - 1
    return file_json(model.automaton.name, len(model.automaton.vars), bits, order, varied, monomials, starts)


def _is_within(piece: Box, box: Box) -> bool:
    return all(low <= a and b <= high for (low, high), (a, b) in zip(box, piece, strict=True))


def _is_plain(row: RecordedStretch, rows: Sequence[RecordedStretch]) -> bool:
    """Whether a stretch has steps, and jumps only at its end."""
    return bool(row.steps) and row.end in ("horizon", "jumped", "left")


def _start(model: HybridModel, start: Start, trees: dict[Box, list[RecordedStretch]], bits: int) -> Json:
    leaves = {piece: _stretch(model, rows, 0, bits) for piece, rows in trees.items()}
    return tree(model.names, start.box, leaves)


def _stretch(model: HybridModel, rows: Sequence[RecordedStretch], number: int, bits: int) -> Json:
    """A stretch with its steps; where it ends at the border of its domain, its jumps and what follows each."""
    row, moving = rows[number], len(model.automaton.vars)
    steps = []
    for _, (h, series) in row.steps:
        pace = series[len(model.names)][0] if len(series) > len(model.names) else None
        steps.append(step_json(max(1, round(ldexp(h, bits))), series[:moving], bits, pace))
    if row.end == "horizon":
        return {"steps": steps}
    jumps = []
    for i, after in enumerate(rows):
        if after.parent == number and after.edge is not None:
            begun = [polynomial(x[0], 1.0, bits) for x in after.steps[0][1][1][:moving]]
            edge = model.edges[row.mode][after.edge]
            jumps.append({"edge": edge, "x": begun, **_stretch(model, rows, i, bits)})
    return {"steps": steps, "jumps": jumps}
