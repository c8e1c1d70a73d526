"""`for which p in R, q in S`: the box of some params, cut into boxes that are proved, refuted or left open.

A box whose corners and middle have one answer is shown as a whole, as if it were the declared range; others are halved
across their widest side, the largest box first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product

from haverify.analyses.hybrid.everywhere import refuted_everywhere
from haverify.analyses.induction.pieces import everywhere
from haverify.analyses.patience import OutOfTimeError
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Param, Range
from haverify.model.spec import Spec
from haverify.text.record import field, holder, record, replace

Q = Fraction
Ends = tuple[tuple[Q, Q], ...]
Decide = Callable[[Spec, Claim], Evidence]
MOST = 64  # boxes
LEAST = Q(1, 10**6)  # of the whole: smaller boxes are not cut


@record
class Box:
    """A box of the params that are asked for, and what is shown of all of it."""

    ends: Ends
    shown: Evidence | None = None


@record
class Point:
    """Values of the params that are asked for, and what is shown of them."""

    at: tuple[Q, ...]
    shown: Evidence


@record
class Cut:
    """A box in two halves: the place of the param, and where it is cut."""

    place: int
    at: Q
    low: Cut | Box
    high: Cut | Box


@holder
class Map:
    """A claim, the params that are asked for, and what has been decided."""

    spec: Spec
    automaton: HybridAutomaton
    claim: Claim
    names: tuple[str, ...]
    decide: Decide
    known: dict[Ends, Evidence] = field(default_factory=dict)
    boxes: int = 1
    # Whether the time allowed was over before all was tried.
    is_late: bool = False

    def at(self, ends: Ends) -> Evidence:
        """What is decided where the ranges of the params are these."""
        if ends not in self.known:
            self.known[ends] = self.decide(self.narrowed(ends), replace(self.claim, which=()))
        return self.known[ends]

    def narrowed(self, ends: Ends) -> Spec:
        """The spec with other ranges of the params."""
        spec, automaton = self.spec, self.automaton
        for name, (low, high) in zip(self.names, ends, strict=True):
            spec = narrowed(spec, automaton, name, low, high)
            automaton = next(a for a in spec.automata if a.name == automaton.name)
        return spec

    def tree(self, ends: Ends) -> Cut | Box:
        """The box cut until each piece is shown, or there are many, or the time allowed is over."""
        done: dict[Ends, Evidence | None] = {}
        cuts: dict[Ends, tuple[int, Q]] = {}
        try:
            self._cut(ends, cuts, done)
        except OutOfTimeError:
            self.is_late = True
        return _joined(ends, cuts, done)

    def _cut(self, whole: Ends, cuts: dict[Ends, tuple[int, Q]], done: dict[Ends, Evidence | None]) -> None:
        leaves = [whole]
        while leaves:
            leaves.sort(key=lambda b: -_share(b, whole))
            box = leaves.pop(0)
            shown = self.shown(box)
            if shown is not None or self.boxes >= MOST or not _is_large(box, whole):
                done[box] = shown
                continue
            cuts[box] = _widest(box, whole)
            leaves += list(_halves(box, *cuts[box]))
            self.boxes += 1

    def shown(self, box: Ends) -> Evidence | None:
        """What is shown of all of a box, which its corners and middle agree about."""
        words: set[type[Verdict]] = set()
        for p in _points(box):
            words.add(type(self.at(p).verdict))
            if len(words) > 1 or Unknown in words:
                return None
        if words == {Proved}:
            found = self.at(box)
            return found if isinstance(found.verdict, Proved) else None
        return self.refuted(box)

    def refuted(self, ends: Ends) -> Evidence | None:
        """Whether the claim is false for all values in a box."""
        spec, alone = self.narrowed(ends), replace(self.claim, which=())
        automaton = next(a for a in spec.automata if a.name == self.automaton.name)
        wide = [n for n, (low, high) in zip(self.names, ends, strict=True) if low < high]
        by_start = everywhere(spec, automaton, alone, wide[0]) if len(wide) == 1 else None
        return by_start or refuted_everywhere(spec, automaton, alone, self.names)

    def counterexample(self, ends: Ends, told: Sequence[Ends]) -> Point | None:
        """A point of a box, and not of others, at which the claim was refuted; the middle rather than a corner."""
        wrong = [p for p, e in self.known.items() if isinstance(e.verdict, Refuted) and e.certificate is not None]
        fresh = [p for p in wrong if _is_point_of(p, ends) and not any(_is_point_of(p, other) for other in told)]
        found = next((p for p in (*reversed(_points(ends)), *fresh) if p in fresh), None)
        return None if found is None else Point(tuple(q for q, _ in found), self.known[found])


def narrowed(spec: Spec, automaton: HybridAutomaton, name: str, low: Q, high: Q) -> Spec:
    """The spec with another range of a param, the automaton's own one where it has one."""
    fresh = Range(Expr("num", (low,)), Expr("num", (high,)))

    def put(params: tuple[Param, ...]) -> tuple[Param, ...]:
        return tuple(replace(p, range=fresh) if p.name == name else p for p in params)

    if any(p.name == name for p in automaton.params):
        own = replace(automaton, params=put(automaton.params))
        return replace(spec, automata=tuple(own if a is automaton else a for a in spec.automata))
    return replace(spec, params=put(spec.params))


def leaves(tree: Cut | Box) -> list[Box]:
    """The boxes of a tree, in order."""
    return [tree] if isinstance(tree, Box) else [*leaves(tree.low), *leaves(tree.high)]


def _points(box: Ends) -> list[Ends]:
    """The corners of a box, which others share, and its middle, as boxes."""
    points = dict.fromkeys([*product(*box), tuple((low + high) / 2 for low, high in box)])
    return [tuple((q, q) for q in p) for p in points]


def _is_point_of(p: Ends, box: Ends) -> bool:
    return all(low <= a == b <= high for (a, b), (low, high) in zip(p, box, strict=True))


def _share(box: Ends, whole: Ends) -> Q:
    found = Q(1)
    for (low, high), (first, last) in zip(box, whole, strict=True):
        found *= (high - low) / (last - first) if first < last else 1
    return found


def _is_large(box: Ends, whole: Ends) -> bool:
    return any(low < high for low, high in box) and _share(box, whole) >= LEAST


def _widest(box: Ends, whole: Ends) -> tuple[int, Q]:
    shares = [_share((b,), (w,)) if b[0] < b[1] else Q(0) for b, w in zip(box, whole, strict=True)]
    place = shares.index(max(shares))
    return place, (box[place][0] + box[place][1]) / 2


def _halves(box: Ends, place: int, at: Q) -> Sequence[Ends]:
    low, high = box[place]
    return tuple((*box[:place], side, *box[place + 1 :]) for side in ((low, at), (at, high)))


def _joined(box: Ends, cuts: dict[Ends, tuple[int, Q]], done: dict[Ends, Evidence | None]) -> Cut | Box:
    if box not in cuts:
        return Box(box, done.get(box))
    place, at = cuts[box]
    low, high = (_joined(half, cuts, done) for half in _halves(box, place, at))
    return Cut(place, at, low, high)
