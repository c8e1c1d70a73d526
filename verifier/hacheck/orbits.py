"""`cycle through P`: a return of a part of a section has a fixed point, and where it is claimed it attracts all of P.

All runs from a section, a set X of states on a plane, come to the plane again, which they cross at a certain speed, as
they do the borders of jumps: the return R is a smooth map of X. It has a fixed point where Krawczyk's operator maps X
into its interior, or where R maps X into itself and contracts it, in the greatest of the section's coordinates
(Banach). For both all of X makes one lap: returns of its pieces need not be parts of one continuous map. P holds on a
part of X in which the fixed point is, or right after a jump of all runs from there. Where R contracts, all runs from X
tend to the orbit, so they come to that part; and so do all that come to X: those of boxes that hold all states with P.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from hacheck.along import Along
from hacheck.expressions import EVENTS, nodes
from hacheck.flow_starts import FlowStarts, conjuncts
from hacheck.laps import Box, Lap, Laps
from hacheck.rational import Beyond, Refused, number
from hacheck.records import Ends
from hacheck.sections import ONE, section_of
from hacheck.tapes import Tape

if TYPE_CHECKING:
    from hacheck.obligations import Question, Shown

Json = Any
ROOM, WIDER = Fraction(1, 1 << 20), Fraction(17, 16)  # of a section, and times a part of it: around a fixed point


def shown_orbit(question: Question, entry: Json) -> Shown:
    """The verdict that an entry of kind `cycle` establishes: that the claim holds."""
    _fits(question, entry)
    scope, first = question.scope, next(iter(question.scope.modes))
    question.same(entry, "flow", first, "")
    section = section_of(entry, scope.types, scope.modes)
    laps = Laps(question, entry["flow"], section, varied=True)
    (start,) = laps.record.data["starts"]
    lap = laps.whole(start["pieces"])
    _last(question, lap, number(entry["period"][0]), number(entry["period"][1]))
    if "factor" in entry:
        share = _contracts(lap, number(entry["factor"]))
    else:
        share = _returns(lap, [[number(q) for q in row] for row in entry["back"]])
    if not laps.passes(lap, share):
        raise Refused("an orbit on which the claim's condition does not hold, nor after one of its jumps")
    if question.goal["attracting"] is not False:
        if "factor" not in entry:
            raise Refused("an orbit that is not shown to attract")
        shares = [number(q) for q in entry["shares"]]
        _come_in(question, Laps(question, entry["basin"], section, varied=False), shares[0])
        if shares[1:]:
            _narrow(Laps(question, entry["narrower"], section, varied=False), shares)
        if shares[-1] != 1 or min(shares) <= 0:
            raise Refused("runs from the claim's condition that are not led into the section")
    return "proved", [(first, "", "proved")]


def _fits(q: Question, entry: Json) -> None:
    if "flow" not in entry:
        raise Beyond("a periodic orbit without a record")
    if q.scope.automaton["inputs"] or q.scope.ranges or q.claim["on"] not in q.setting.core.automata:
        raise Beyond("a periodic orbit beside params or inputs, or of a system")
    if q.assume or q.goal["window"] or q.claim["inductive"] or set(q.claim["horizon"].values()) != {None}:
        raise Beyond("a periodic orbit beside assumptions, a window or a horizon")


def _last(question: Question, lap: Lap, least: Fraction, most: Fraction) -> None:
    """Raise unless all laps take a time in the stated period, and that is in time."""
    if least <= 0 or not (least <= lap.time[0] and lap.time[1] <= most):
        raise Beyond("a lap takes a time that is not in the stated period")
    if question.limit is not None and most > question.limit:
        raise Beyond("a period that may be longer than what is claimed")


def _come_in(question: Question, laps: Laps, share: Fraction) -> None:
    """Raise Refused unless all runs from states with P come to the section, made larger by a factor."""
    found, given = list(_areas(question, laps)), laps.record.data["starts"]
    if len(given) != len(found):
        raise Refused("a recorded flow has other starts than the claim's condition")
    for start, (mode, box) in zip(given, found, strict=True):
        if not all(_is_in(lap, share) for lap in laps.parted(start["pieces"], mode, box)):
            raise Beyond("a run from the claim's condition does not certainly come to where laps contract")


def _narrow(laps: Laps, shares: list[Fraction]) -> None:
    """Raise Refused unless a lap of each of some sections, which are larger by factors, comes to the next."""
    given = laps.record.data["starts"]
    if len(given) != len(shares) - 1:
        raise Refused("a recorded flow has other starts than there are sections")
    for start, here, there in zip(given, shares, shares[1:], strict=False):
        if not _is_in(laps.whole(start["pieces"], here), there):
            raise Beyond("a lap does not certainly come from a section to a narrower one")


def _areas(question: Question, laps: Along) -> Iterator[tuple[str, Box]]:
    """Boxes of modes that hold all states with P: of each mode while dwelling there, and right after each edge.

    After an edge only what does not speak of the jump is counted on.
    """
    scope, condition = question.scope, question.condition
    seen = {n[0] for n in nodes(condition)} & EVENTS
    if "pre" in seen:
        raise Beyond("an attracting orbit of a condition about what was before a jump")
    starts = FlowStarts(scope, laps.record)
    lasting = ["and", *(e for e in conjuncts(condition) if not any(n[0] in EVENTS for n in nodes(e)))]
    found = [(mode, condition) for mode in scope.modes if Tape(scope, mode).truth(condition) is not False]
    for edge in question.model.edges if seen else ():
        if Tape(scope, edge["target"], edge).truth(condition) is not False:
            found.append((edge["target"], lasting))
    for mode, e in found:
        box = starts.box({"where": e, "with": []}, mode, {})
        if all(low <= high for low, high in box.values()):
            yield mode, box


def _is_in(lap: Lap, share: Fraction = ONE) -> bool:
    return all(_size(x) <= share for x in lap.end)


def _contracts(lap: Lap, factor: Fraction) -> Fraction:
    """In which share of the section the fixed point is, with room around it.

    Raises Refused unless the section comes into itself, and derivatives, so also means of them, contract. The fixed
    point w has `|w| <= |R(w) - R(0)| + |R(0)| <= factor |w| + |R(0)|`.
    """
    if not 0 <= factor < 1:
        raise Refused("a contraction is shown by a factor below 1")
    if not _is_in(lap):
        raise Beyond("a lap leads out of its section")
    shown = max((sum(map(_size, row), Fraction(0)) for row in lap.slopes), default=Fraction(0))
    if shown > factor:
        raise Beyond("a lap does not contract as stated")
    far = max((_size(x) for x in lap.centre), default=Fraction(0)) / (1 - shown)
    return min(ONE, far * WIDER + ROOM)


def _returns(lap: Lap, back: list[list[Fraction]]) -> Fraction:
    """The whole section, in which the fixed point is.

    Raises Refused unless `-C R(0) + (1 - C (DR - 1)) w` is inside of ]-1, 1[ for all w in [-1, 1] (Krawczyk).
    """
    n = len(lap.end)
    if len(back) != n or any(len(row) != n for row in back):
        raise Refused("a fixed point is shown by a square matrix")
    for i, row in enumerate(back):
        far = _size(_sum((q, x) for q, x in zip(row, lap.centre, strict=True)))
        for j in range(n):
            moved = _sum((q, lap.slopes[k][j]) for k, q in enumerate(row))
            one = row[j] + (i == j)
            far += _size((one - moved[1], one - moved[0]))
        if not far < 1:
            raise Beyond("Newton's method does not show a periodic orbit on the section")
    return ONE


def _sum(products: Iterator[tuple[Fraction, Ends]]) -> Ends:
    """A sum of intervals times numbers."""
    low = high = Fraction(0)
    for q, (a, b) in products:
        low, high = low + min(q * a, q * b), high + max(q * a, q * b)
    return low, high


def _size(x: Ends) -> Fraction:
    return max(abs(x[0]), abs(x[1]))
