"""Claims without a horizon: where sets of states return into those that were followed before, all later ones are known.

A set that does not return is followed anew from a wider box of starts, which has the ends of its runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.hybrid.model import HybridModel, Start
from haverify.analyses.hybrid.question import Piece, Question, follow
from haverify.analyses.hybrid.starts import Box
from haverify.evidence.verdict import Unknown
from haverify.solvers.kernel import Pair, Stretch

Q = Fraction
WIDENINGS = 8
MARGIN = Q(1, 20)  # of the width of a box is added on each side
ENDS = ("passed", "jumped", "left", "cut")


def proved_for_ever(question: Question) -> list[Piece] | None:
    """Trees from boxes that hold all starts, whose sets all return and show the goal; None where there are none."""
    found = []
    for start in question.model.starts:
        piece = _returning(question, start)
        if piece is None:
            return None
        found.append(piece)
    question.shown = found
    return found


def _returning(question: Question, start: Start) -> Piece | None:
    box = start.box
    for _ in range(WIDENINGS):
        piece = Piece(start, box, follow(question, start, box, "passed"))
        question.pieces += 1
        question.shown = question.shown or [piece]
        if not all(map(_is_held, piece.tree)):
            question.trouble = "what holds at the starts does not hold on all the way"
            return None
        ends = {s.end for s in piece.tree if s.end not in ENDS}
        if not ends:
            return piece
        if ends != {"horizon"} or len(piece.tree) > 1:
            question.trouble = next(iter(sorted(ends - {"horizon"})), "after jumps")
            return None
        box = _wider(question.model, box, piece.tree[0].last)
    question.trouble = "boxes around the starts became wider and wider"
    return None


def _is_held(s: Stretch) -> bool:
    return all(g.claim.holds and g.keeps_window for g in s.stages) and (s.jump is None or s.jump.claim.holds)


def _wider(model: HybridModel, box: Box, last: Sequence[Pair]) -> Box:
    """A box around another one and later states, with a margin; params and time are as they were."""
    count = len(model.automaton.vars)

    def side(ends: tuple[Q, Q], later: Pair) -> tuple[Q, Q]:
        low, high = min(ends[0], Q(later[0])), max(ends[1], Q(later[1]))
        return low - MARGIN * (high - low), high + MARGIN * (high - low)

    moved = [side(ends, later) for ends, later in zip(box[:count], last[:count], strict=True)]
    return (*moved, *box[count:])


def not_for_ever(question: Question) -> Unknown:
    """What is said where nothing decides."""
    why = f" ({question.trouble})" if question.trouble else ""
    reason = f"a flow without a horizon, whose sets of states were not seen to return into earlier ones{why}"
    return Unknown("budget", reason, next_step="a horizon, `within T`, or an invariant")
