"""The flowpipes to draw: those that decide a goal, or the first one that did not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.hybrid.question import Piece, Question, sides
from haverify.evidence.flowpipe import Stretch as Drawn
from haverify.evidence.flowpipe import flowpipe_json
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Pair, Stage, Stretch

Q = Fraction
Json = Any
Bound = tuple[int, int, float]


def drawing(question: Question) -> Json:
    """The value of a drawing, None where there is nothing to draw."""
    model = question.model
    bounds = [_bounds(question, mode) for mode in range(len(model.modes))]
    drawn = [
        Drawn(
            model.places[s.mode].mode, jumps, _first(s, piece), [(g.time, _seen(bounds[s.mode], g)) for g in s.stages]
        )
        for piece in question.shown
        for s, jumps in zip(piece.tree, jumps_of(model, piece.tree), strict=True)
        if s.stages
    ]
    return flowpipe_json(model.names, drawn) if drawn else None


def jumps_of(model: HybridModel, tree: Sequence[Stretch]) -> list[int]:
    """How many jumps of the automaton led to each stretch: changes of side are none."""
    found: list[int] = []
    for s in tree:
        is_jump = s.jump is not None and s.parent is not None
        number = model.edges[tree[s.parent].mode][s.jump.edge] if is_jump else None  # type: ignore[index,union-attr]
        before = found[s.parent] if s.parent is not None else 0
        found.append(before + (number is not None and model.origins[number] is not None))
    return found


def _first(s: Stretch, piece: Piece) -> Sequence[Pair]:
    """The box of a stretch where it starts."""
    if s.jump is not None:
        return s.jump.after
    return sides(piece.box) if s.parent is None else s.stages[0].states


def _seen(bounds: Sequence[Bound], g: Stage) -> Sequence[Pair]:
    """The box of a step, cut where a variable was looked at more closely because the claim compares it."""
    box = list(g.states)
    for place, v, shift in bounds if g.watched else ():
        low, high = g.watched[place]
        cut = max(box[v][0], low + shift), min(box[v][1], high + shift)
        box[v] = cut if cut[0] <= cut[1] else box[v]
    return box


def _bounds(question: Question, mode: int) -> list[Bound]:
    """The comparisons of variables with numbers: where the difference is watched, the variable, the number."""
    found = ((place, _bound(question, quantity)) for quantity, _, place in question.compared[mode])
    return list(dict.fromkeys((place, *bound) for place, bound in found if bound is not None))


def _bound(question: Question, quantity: Expr) -> tuple[int, float] | None:
    """The variable that is compared with a number, and the number."""
    left, right = quantity.children if quantity.op == "-" and len(quantity.children) == 2 else (quantity, None)
    if left.op != "var" or left.name not in question.model.names:
        return None
    try:
        number = Q(0) if right is None else question.model.values.number(right)
    except OutsideFragmentError:
        return None
    return question.model.names.index(left.name), float(number)
