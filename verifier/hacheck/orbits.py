"""`cycle through P`: a return of a box of a section has a fixed point, and where it is claimed it attracts all of P.

P holds on the box X of the plane `v = value`. All runs from X come to the plane again, which they cross at a certain
speed: the return R is a smooth map of X. It has a fixed point where Krawczyk's operator maps X into its interior, or
where R maps X into itself and contracts it, in the greatest component in units of given sizes (Banach). For both all
of X makes one lap: returns of its pieces need not be parts of one continuous map. In the latter
case all runs from X tend to the orbit, and so do all that come to X: those of a box that holds all states with P.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from hacheck.flow_starts import FlowStarts
from hacheck.laps import Lap, Laps
from hacheck.rational import Beyond, Refused, number
from hacheck.records import Ends

if TYPE_CHECKING:
    from hacheck.obligations import Question, Shown

Json = Any
Box = dict[str, Ends]
ZERO = Fraction(0), Fraction(0)


def shown_orbit(question: Question, entry: Json) -> Shown:
    """The verdict that an entry of kind `cycle` establishes: that the claim holds."""
    _fits(question, entry)
    scope = question.scope
    (mode,), section = scope.modes, (str(entry["section"][0]), str(number(entry["section"][1])))
    question.same(entry, "flow", mode, "")
    columns = [v for v in scope.types if v != section[0]]
    box = {v: (number(entry["box"][v][0]), number(entry["box"][v][1])) for v in columns}
    if section[0] not in scope.types or set(entry["box"]) != set(columns) or any(a > b for a, b in box.values()):
        raise Refused("a section is no plane of its variables, or its box is empty")
    laps = Laps(scope, mode, section, question.setting.load(entry["flow"]), columns)
    if not laps.exactly(question.condition, box):
        raise Refused("a section where the claim's condition does not hold")
    found = list(laps.all(box))
    _last(question, found, number(entry["period"][0]), number(entry["period"][1]))
    if "factor" in entry:
        _contracts(box, found, [number(q) for q in entry["sizes"]], number(entry["factor"]))
    else:
        _returns(box, found, laps.middle(box), [[number(q) for q in row] for row in entry["back"]])
    if question.goal["attracting"] is not False:
        if "factor" not in entry:
            raise Refused("an orbit that is not shown to attract")
        _come_in(question, Laps(scope, mode, section, question.setting.load(entry["basin"]), []), box)
    return "proved", [(mode, "", "proved")]


def _fits(q: Question, entry: Json) -> None:
    a = q.scope.automaton
    if "flow" not in entry:
        raise Beyond("a periodic orbit without a record")
    if len(a["modes"]) != 1 or a["edges"] or a["modes"][0]["terminal"] or a["inputs"]:
        raise Beyond("a periodic orbit of an automaton with several modes, edges or inputs")
    if q.scope.ranges or q.scope.rounding or any(t != "real" for t in q.scope.types.values()):
        raise Beyond("a periodic orbit beside params, rounded constants or discrete variables")
    if q.assume or q.goal["window"] or q.claim["inductive"] or set(q.claim["horizon"].values()) != {None}:
        raise Beyond("a periodic orbit beside assumptions, a window or a horizon")


def _last(question: Question, laps: list[Lap], least: Fraction, most: Fraction) -> None:
    """Raise unless all laps take a time in the stated period, and that is in time."""
    if least <= 0 or not all(least <= lap.time[0] and lap.time[1] <= most for lap in laps):
        raise Beyond("a lap takes a time that is not in the stated period")
    if question.limit is not None and most > question.limit:
        raise Beyond("a period that may be longer than what is claimed")


def _come_in(question: Question, laps: Laps, box: Box) -> None:
    """Raise Refused unless all states with P are on the plane, and runs from there come to it in the box."""
    found = FlowStarts(laps.scope, laps.record).box({"where": question.condition, "with": []}, laps.mode, {})
    if found[laps.variable] != (laps.value, laps.value):
        raise Refused("states with the claim's condition are not on the section")
    if not all(_is_in(lap, box) for lap in laps.all({v: found[v] for v in laps.ends})):
        raise Beyond("a run from the section does not certainly come to where laps contract")


def _is_in(lap: Lap, box: Box) -> bool:
    return all(low <= a and b <= high for (low, high), (a, b) in zip(box.values(), lap.state, strict=True))


def _contracts(box: Box, laps: list[Lap], sizes: list[Fraction], factor: Fraction) -> None:
    """Raise Refused unless the box comes into itself, and derivatives, so also means of them, contract."""
    if len(laps) != 1 or len(sizes) != len(box) or any(d <= 0 for d in sizes) or not 0 <= factor < 1:
        raise Refused("a contraction is shown by one lap, sizes and a factor below 1")
    if not all(_is_in(lap, box) for lap in laps):
        raise Beyond("a lap leads out of its box")
    for row, own in ((r, d) for lap in laps for r, d in zip(lap.slopes, sizes, strict=True)):
        if sum(max(-low, high) * d for (low, high), d in zip(row, sizes, strict=True)) > factor * own:
            raise Beyond("a lap does not contract as stated")


def _returns(box: Box, laps: list[Lap], centre: list[Fraction], back: list[list[Fraction]]) -> None:
    """Raise Refused unless `c - C (R(c) - c) + (1 - C (DR(X) - 1)) (X - c)` is in the interior of X (Krawczyk)."""
    n, sides = len(box), list(box.values())
    if len(laps) != 1 or len(back) != n or any(len(row) != n for row in back):
        raise Refused("a fixed point is shown by one lap and a square matrix")
    lap = laps[0]
    for i, (low, high) in enumerate(sides):
        if not low <= centre[i] <= high:
            raise Refused("a middle that is not in its box")
        found = centre[i], centre[i]
        for j in range(n):
            missing = lap.centre[j][0] - centre[j], lap.centre[j][1] - centre[j]
            found = _plus(found, _times((-back[i][j],) * 2, missing))
            rest = (back[i][j] + (i == j),) * 2
            for k in range(n):
                rest = _plus(rest, _times((-back[i][k],) * 2, lap.slopes[k][j]))
            found = _plus(found, _times(rest, (sides[j][0] - centre[j], sides[j][1] - centre[j])))
        if not low < found[0] <= found[1] < high:
            raise Beyond("Newton's method does not show a periodic orbit in the box")


def _plus(a: Ends, b: Ends) -> Ends:
    return a[0] + b[0], a[1] + b[1]


def _times(a: Ends, b: Ends) -> Ends:
    products = [x * y for x in a for y in b]
    return min(products), max(products)
