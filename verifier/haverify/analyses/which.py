"""`for which p in R`: where in R a claim holds, and where it fails whatever else is chosen (docs/core.md section 10).

A few points of R are decided; between two with different answers the simplest number is tried, until the answer changes
from it to its neighbour. The pieces in between are shown as a whole, each as if it were the declared range of p.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

from haverify.analyses.hybrid.everywhere import refuted_everywhere
from haverify.analyses.induction.pieces import everywhere
from haverify.analyses.which_boxes import Box, Cut, Ends, Map, leaves, narrowed
from haverify.elaborate.notation import quantity
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import params_of, values_of
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record, replace

Q = Fraction
Json = Any
Decide = Callable[[Spec, Claim], Evidence]
METHOD = "pieces"
UNIVERSAL = ("always", "reach", "stl")
GRID = 4
FINE = Q(1, 10**6)  # of the range: how near to its bound a piece that is refuted begins
ROUNDS = 24
WORDS: dict[type, str] = {Proved: "proved", Refuted: "refuted", Unknown: "not decided"}
LISTED = 12  # pieces; of more only the shares are told
DEPTH = 2  # how often a piece that is not shown as a whole is cut in halves


@record
class Piece:
    """A part of the ranges, and what is shown of all of it."""

    ends: Ends
    shown: Evidence | None


@holder
class Search:
    """A claim, the param that is asked for, and what has been decided."""

    spec: Spec
    automaton: HybridAutomaton
    claim: Claim
    name: str
    decide: Decide
    known: dict[tuple[Q, Q], Evidence] = field(default_factory=dict)

    def at(self, low: Q, high: Q) -> Evidence:
        """What is decided where the range of the param is [low, high]."""
        if (low, high) not in self.known:
            spec = narrowed(self.spec, self.automaton, self.name, low, high)
            self.known[low, high] = self.decide(spec, replace(self.claim, which=()))
        return self.known[low, high]

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
        ends = [q for q in (low, high) if (q, q) in self.known]
        word = self.word(ends[0] if ends else (low + high) / 2)
        found = self.at(low, high) if word is Proved else self.refuted(low, high) if word is Refuted else None
        if found is not None and type(found.verdict) is word:
            yield Piece(((low, high),), found)
        elif depth == 0 or word is Unknown:
            yield Piece(((low, high),), None)
        else:
            middle = (low + high) / 2
            yield from self.pieces(low, middle, depth - 1)
            yield from self.pieces(middle, high, depth - 1)

    def refuted(self, low: Q, high: Q) -> Evidence | None:
        """Whether the claim is false for every value in a range."""
        spec = narrowed(self.spec, self.automaton, self.name, low, high)
        automaton = next(a for a in spec.automata if a.name == self.automaton.name)
        alone = replace(self.claim, which=())
        return everywhere(spec, automaton, alone, self.name) or refuted_everywhere(spec, automaton, alone, (self.name,))


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
    if len(names) > 1:
        tree = Map(spec, automaton, claim, names, decide).tree(tuple(ends))
        return _told(claim, names, [Piece(b.ends, b.shown) for b in leaves(tree)], tree)
    found = _pieces(Search(spec, automaton, claim, names[0], decide), *ends[0])
    return _told(claim, names, found, _balanced(found))


def _pieces(search: Search, low: Q, high: Q) -> list[Piece]:
    if low == high:
        return [Piece(((low, high),), search.at(low, high))]
    cuts = [low, *(q for pair in search.bounds(low, high) for q in pair), high]
    found = list[Piece]()
    for k, (a, b) in enumerate(pairwise(cuts)):
        if a < b:
            found += [Piece(((a, b),), None)] if k % 2 else search.pieces(a, b)
    return found


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


def _told(claim: Claim, names: tuple[str, ...], pieces: list[Piece], tree: Cut | Box) -> Evidence:
    parts = tuple(_part(names, p) for p in pieces)
    kinds = {type(p.verdict) for p in parts}
    notes = tuple(f"{WORDS[type(p.verdict)]} for {p.text}" for p in parts) if len(parts) <= LISTED else _shares(pieces)
    if Refuted not in kinds and Unknown in kinds:
        return Evidence(Unknown("pieces", "; ".join(notes)), parts, METHOD)
    cells: dict[str, Json] = {}
    leaf = {p.ends: _leaf(p, k, cells) for k, p in enumerate(pieces)}
    verdict, word = (Refuted(), "refuted") if Refuted in kinds else (Proved(), "proved")
    told = {**certificate(claim.name, word, [], None), "boxes": _tree(names, tree, leaf)}
    return Evidence(verdict, parts, METHOD, told, cells, notes=notes)


def _shares(pieces: list[Piece]) -> tuple[str, ...]:
    """How much of the box is proved, refuted and left open."""
    found = dict.fromkeys(WORDS.values(), Q(0))
    for p in pieces:
        kind = Unknown if p.shown is None else type(p.shown.verdict)
        found[WORDS[kind]] += prod((high - low for low, high in p.ends if low < high), start=Q(1))
    whole = sum(found.values())
    return tuple(f"{word} for {float(100 * q / whole):.3g} % of the box" for word, q in found.items() if q)


def _part(names: tuple[str, ...], p: Piece) -> PartResult:
    verdict: Verdict = Unknown("pieces", "not decided") if p.shown is None else p.shown.verdict
    pairs = list(zip(names, p.ends, strict=True))
    where = ", ".join(f"{n} in [{rational_text(low)}, {rational_text(high)}]" for n, (low, high) in pairs)
    text = ", ".join(f"{n} in [{quantity(low, None)[1]}, {quantity(high, None)[1]}]" for n, (low, high) in pairs)
    run = next((q.run for q in p.shown.parts if q.run is not None), None) if p.shown is not None else None
    return PartResult(0, "piece", where, "", text, verdict, run)


def _leaf(p: Piece, number: int, cells: dict[str, Json]) -> Json:
    """What is shown of a piece; files of cells get names of their own."""
    if p.shown is None or p.shown.certificate is None:
        return None
    goals = []
    for entry in p.shown.certificate["goals"]:
        renamed = {key: f"{value}-{number}" if key in ("cells", "flow") else value for key, value in entry.items()}
        goals.append(renamed)
    cells |= {f"{key}-{number}": value for key, value in p.shown.cells.items()}
    return {"verdict": p.shown.certificate["verdict"], "goals": goals}


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
