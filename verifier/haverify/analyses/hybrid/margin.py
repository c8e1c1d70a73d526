"""How far the enclosures stay from a bound, and how near one run certainly comes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.model import Start
from haverify.analyses.hybrid.question import Piece, Question, follow, from_the_middle
from haverify.evidence.verdict import Margin
from haverify.maths.interval import Interval
from haverify.model.expression import nodes
from haverify.solvers.kernel import Stretch

Q = Fraction
NO_QUANTITIES = ("abs", "jump", "jumped", "pre", "at")


def margin(question: Question, proof: Sequence[Piece], start: Start, point: Sequence[Q]) -> Margin | None:
    """For one bound in all modes: at least how far all enclosures stay from it; one run is that from a start."""
    asked = question.asked.condition
    if question.asked.kind != "always" or asked.op not in ("<", "<=", ">", ">="):
        return None
    unit = asked.children[0].unit
    if unit is None or any(n.op in NO_QUANTITIES for n in nodes(asked)):
        return None
    claimed = [next(iter(atoms), None) for atoms in question.compared]
    bounds = {(c[0], c[1]) for c in claimed if c is not None}
    trees = [p.tree for p in proof]
    if None in claimed or len(bounds) != 1 or _is_bare(trees):
        return None
    ((_, op),) = bounds
    is_above = op in (">", ">=")
    places = [c[2] for c in claimed if c is not None]
    least, at = min(_distances(question, trees, places, is_above, 0 if is_above else 1), default=(None, 0.0))
    if least is None:
        return None
    certain = [s for s in _run(question, proof[0], start, point) if s.is_certain]
    near, _ = min(_distances(question, [certain], places, is_above, 1 if is_above else 0), default=(least, 0.0))
    return Margin(Q(least), Q(max(least, near)), str(unit), f"t = {max(at, 0.0):.6g} s")


def _run(question: Question, piece: Piece, start: Start, point: Sequence[Q]) -> Sequence[Stretch]:
    """The tree of one start, or what the tree of a piece shows of it where it starts in its middle."""
    box = tuple((q, q) for q in point)
    known = question.points.get((start.mode, box))
    if known is not None:
        return known
    middle = [(low + high) / 2 for low, high in piece.box]
    if piece.start is start and not start.rest and middle == list(point):
        return from_the_middle(question, piece)
    return follow(question, start, box, "horizon")


def _distances(
    question: Question, trees: Sequence[Sequence[Stretch]], places: Sequence[int], is_above: bool, end: int
) -> Iterator[tuple[float, float]]:
    """For each step that the claim speaks of, an end of the claim's quantity as a distance to the bound."""
    # The floats next to the ends, outwards: a step that only they let in is one more.
    first, last = Interval.at(question.asked.first).low, Interval.at(question.asked.last).high
    for s in (s for tree in trees for s in tree):
        for g in s.stages:
            if g.watched and g.time[1] >= first and g.time[0] <= last:
                value = g.watched[places[s.mode]][end]
                yield (value if is_above else -value), g.time[0]


def _is_bare(trees: Sequence[Sequence[Stretch]]) -> bool:
    """Whether some landing is in no stage, so that how far it stays from the bound is not known."""
    return any(s.jump is not None and not s.stages and s.end != "cut" for tree in trees for s in tree)
