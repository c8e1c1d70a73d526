"""`for which p in R`: where in R a claim holds, and where it fails whatever else is chosen (docs/core.md section 10).

A few points of R are decided; between two with different answers the simplest number is tried, until the answer changes
from it to its neighbour. The pieces in between are shown as a whole, each as if it were the declared range of p.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

from haverify.analyses.patience import OutOfTimeError
from haverify.analyses.which_boxes import Box, Cut, Decide, Ends, Map, Point, leaves
from haverify.elaborate.notation import quantity
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import params_of, values_of
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, record, replace

Q = Fraction
Json = Any
METHOD = "pieces"
UNIVERSAL = ("always", "reach", "stl")
GRID = 4
FINE = Q(1, 10**6)  # of the range: how near to its bound a piece that is refuted begins
ROUNDS = 24
WORDS: dict[type, str] = {Proved: "proved", Refuted: "refuted", Unknown: "not decided"}
LISTED = 12  # pieces; of more only the shares are told
POINTS = 8  # pieces left open in which a point is looked for
FILES = ("cells", "flow")  # what names a file in certificates
LATE = "the time allowed was over before all was tried"
DEPTH = 2  # how often a piece that is not shown as a whole is cut in halves


@record
class Piece:
    """A part of the ranges, what is shown of all of it, and of one point where that is nothing."""

    ends: Ends
    shown: Evidence | None
    point: Point | None = None


@holder
class Search:
    """The one param that is asked for, and what has been decided."""

    decided: Map

    def at(self, low: Q, high: Q) -> Evidence:
        """What is decided where the range of the param is [low, high]."""
        return self.decided.at(((low, high),))

    def word(self, q: Q) -> type[Verdict]:
        """Proved, Refuted or Unknown, at a point."""
        return type(self.at(q, q).verdict)

    def bounds(self, low: Q, high: Q) -> list[tuple[Q, Q]]:
        """Where the answer changes: two near or equal numbers, the last and the first of their kind."""
        found = [(a, b) for a, b in pairwise(grid(low, high)) if self.word(a) is not self.word(b)]
        return [self.between(a, b, FINE * (high - low)) for a, b in found]

    def between(self, a: Q, b: Q, near: Q) -> tuple[Q, Q]:
        """Two numbers, no more than `near` apart, between which the answer changes."""
        left, right = self.word(a), self.word(b)
        for turn in range(ROUNDS):
            if b - a <= 2 * near:
                break
            if self.word(a + near) is not left:
                return a, a + near
            if self.word(b - near) is not right:
                return b - near, b
            c = simplest(a + near, b - near) if turn % 2 == 0 else (a + b) / 2
            word = self.word(c)
            if word is not left and word is not right:
                break
            a, b = (c, b) if word is left else (a, c)
        return a, b

    def pieces(self, low: Q, high: Q, depth: int = DEPTH) -> Iterator[Piece]:
        """Pieces of a range all points of which are expected to have one answer, as far as that is shown."""
        ends = [q for q in (low, high) if ((q, q),) in self.decided.known]
        word = self.word(ends[0] if ends else (low + high) / 2)
        whole = ((low, high),)
        found = self.at(low, high) if word is Proved else self.decided.refuted(whole) if word is Refuted else None
        if found is not None and type(found.verdict) is word:
            yield Piece(((low, high),), found)
        elif depth == 0 or word is Unknown:
            yield Piece(((low, high),), None)
        else:
            middle = (low + high) / 2
            yield from self.pieces(low, middle, depth - 1)
            yield from self.pieces(middle, high, depth - 1)


def decide_which(spec: Spec, automaton: HybridAutomaton, claim: Claim, decide: Decide) -> Evidence:
    """The answer piece by piece: proved if every piece is, refuted if one is (LANGUAGE S27)."""
    if any(g.kind not in UNIVERSAL for g in claim.goals):
        return Evidence(Unknown("fragment", "`for which` beside goals about some run"), (), METHOD)
    names = tuple(name for name, _ in claim.which)
    values = values_of(spec, automaton)
    ends = []
    for name, r in claim.which:
        try:
            low, high = values.interval(r)
            declared = values.interval(next(p for p in reversed(params_of(spec, automaton)) if p.name == name).range)
        except OutsideFragmentError as e:
            return Evidence(Unknown("fragment", str(e)), (), METHOD)
        if not declared[0] <= low <= high <= declared[1]:
            reason = f"`for which` asks for values of {name} outside of its declared range"
            return Evidence(Unknown("fragment", reason, next_step=f"declare `{name}` with the wider range"), (), METHOD)
        ends.append((low, high))
    known = Map(spec, automaton, claim, names, decide)
    if len(names) == 1:
        found = _pieces(Search(known), *ends[0])
        return _told(known, _pointed(known, found), _balanced(found))
    tree = known.tree(tuple(ends))
    return _told(known, _pointed(known, [Piece(b.ends, b.shown) for b in leaves(tree)]), tree)


def _pieces(search: Search, low: Q, high: Q) -> list[Piece]:
    found = list[Piece]()
    try:
        if low == high:
            return [Piece(((low, high),), search.at(low, high))]
        cuts = [low, *(q for pair in search.bounds(low, high) for q in pair), high]
        for k, (a, b) in enumerate(pairwise(cuts)):
            if a < b:
                for p in [Piece(((a, b),), None)] if k % 2 else search.pieces(a, b):
                    found.append(p)
    except OutOfTimeError:
        search.decided.is_late = True
        begun = found[-1].ends[0][1] if found else low
        found += [Piece(((begun, high),), None)] if begun < high or not found else []
    return found


def _pointed(known: Map, pieces: list[Piece]) -> list[Piece]:
    """Points at which the claim is refuted, where no piece is: in the largest pieces, each once."""
    if any(p.shown is not None and isinstance(p.shown.verdict, Refuted) for p in pieces):
        return pieces
    told: list[Ends] = []
    chosen: dict[Ends, Point] = {}
    for p in sorted((p for p in pieces if p.shown is None), key=lambda p: -_volume(p.ends))[:POINTS]:
        point = known.counterexample(p.ends, told)
        if point is not None:
            chosen[p.ends] = point
            told.append(tuple((q, q) for q in point.at))
    return [replace(p, point=chosen.get(p.ends)) for p in pieces]


def grid(low: Q, high: Q) -> list[Q]:
    """The points that are decided first."""
    return [low + (high - low) * k / GRID for k in range(GRID + 1)]


def simplest(a: Q, b: Q) -> Q:
    """The number with the least denominator strictly between two, of those the one nearest to 0."""
    if a < 0 < b:
        return Q(0)
    if b <= 0:
        return -simplest(-b, -a)
    whole = a.numerator // a.denominator
    if whole + 1 < b:
        return Q(whole + 1)
    if a == whole:
        return whole + 1 / Q((1 / (b - whole)).__floor__() + 1)
    return whole + 1 / simplest(1 / (b - whole), 1 / (a - whole))


def _told(known: Map, pieces: list[Piece], tree: Cut | Box) -> Evidence:
    names = known.names
    parts = tuple(q for p in pieces for q in _parts(names, p))
    kinds = {type(p.verdict) for p in parts}
    notes = tuple(f"{WORDS[type(p.verdict)]} for {p.text}" for p in parts) if len(parts) <= LISTED else _shares(pieces)
    if known.is_late:
        notes += (LATE,)
    if Refuted not in kinds and Unknown in kinds:
        return Evidence(Unknown("pieces", "; ".join(notes)), parts, METHOD)
    cells: dict[str, Json] = {}
    leaf = {p.ends: _entry(names, p, k, cells) for k, p in enumerate(pieces)}
    verdict, word = (Refuted(), "refuted") if Refuted in kinds else (Proved(), "proved")
    told = {**certificate(known.claim.name, word, [], None), "boxes": _tree(names, tree, leaf)}
    return Evidence(verdict, parts, METHOD, told, cells, notes=notes)


def _volume(ends: Ends) -> Q:
    return prod((high - low for low, high in ends if low < high), start=Q(1))


def _shares(pieces: list[Piece]) -> tuple[str, ...]:
    """How much of the box is proved, refuted and left open, and how many points of that are refuted."""
    found = dict.fromkeys(WORDS.values(), Q(0))
    for p in pieces:
        kind = Unknown if p.shown is None else type(p.shown.verdict)
        found[WORDS[kind]] += _volume(p.ends)
    whole = sum(found.values())
    told = tuple(f"{word} for {float(100 * q / whole):.3g} % of the box" for word, q in found.items() if q)
    points = sum(p.point is not None for p in pieces)
    return (*told, f"of what is not decided, refuted at {points} point{'s' * (points > 1)}") if points else told


def _parts(names: tuple[str, ...], p: Piece) -> Iterator[PartResult]:
    verdict: Verdict = Unknown("pieces", "not decided") if p.shown is None else p.shown.verdict
    pairs = list(zip(names, p.ends, strict=True))
    where = ", ".join(f"{n} in [{rational_text(low)}, {rational_text(high)}]" for n, (low, high) in pairs)
    text = ", ".join(f"{n} in [{quantity(low, None)[1]}, {quantity(high, None)[1]}]" for n, (low, high) in pairs)
    yield PartResult(0, "piece", where, "", text, verdict, _run(p.shown))
    if p.point is not None:
        at = list(zip(names, p.point.at, strict=True))
        where = ", ".join(f"{n} = {rational_text(q)}" for n, q in at)
        text = ", ".join(f"{n} = {quantity(q, None)[1]}" for n, q in at)
        yield PartResult(0, "point", where, "", text, p.point.shown.verdict, _run(p.point.shown))


def _run(shown: Evidence | None) -> Run | None:
    return None if shown is None else next((q.run for q in shown.parts if q.run is not None), None)


def _entry(names: tuple[str, ...], p: Piece, number: int, cells: dict[str, Json]) -> Json:
    if p.point is None:
        return _leaf(p.shown, number, cells)
    at = {n: rational_text(q) for n, q in zip(names, p.point.at, strict=True)}
    return ["at", at, _leaf(p.point.shown, number, cells)]


def _leaf(shown: Evidence | None, number: int, cells: dict[str, Json]) -> Json:
    """What is shown of a piece or a point; files of cells get names of their own."""
    if shown is None or shown.certificate is None:
        return None
    names = {name: f"{name}-{number}" for name in shown.cells}
    goals = [_renamed(entry, names) for entry in shown.certificate["goals"]]
    cells |= {names[name]: value for name, value in shown.cells.items()}
    return {"verdict": shown.certificate["verdict"], "goals": goals}


def _renamed(value: Json, names: Mapping[str, str]) -> Json:
    """A value in which files have other names."""
    if isinstance(value, dict):
        return {
            k: names.get(v, v) if k in FILES and isinstance(v, str) else _renamed(v, names) for k, v in value.items()
        }
    return [_renamed(v, names) for v in value] if isinstance(value, list) else value


def _balanced(pieces: list[Piece]) -> Cut | Box:
    """Neighbours along one param as a tree."""
    if len(pieces) == 1:
        return Box(pieces[0].ends, pieces[0].shown)
    k = len(pieces) // 2
    return Cut(0, pieces[k].ends[0][0], _balanced(pieces[:k]), _balanced(pieces[k:]))


def _tree(names: tuple[str, ...], tree: Cut | Box, leaf: Mapping[Ends, Json]) -> Json:
    if isinstance(tree, Box):
        return leaf[tree.ends]
    halves = (_tree(names, half, leaf) for half in (tree.low, tree.high))
    return ["split", names[tree.place], rational_text(tree.at), *halves]
