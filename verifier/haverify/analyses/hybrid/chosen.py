"""What a fuzzy system chooses, as a function of the one variable its inputs read: a value on each of few intervals.

Degrees and strengths are piecewise linear. Their corners, and where two of them are equal, cut the declared range of
the variable into pieces on each of which the order of all strengths, and so the choice, is one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations, pairwise

from haverify.analyses.fuzzy_systems import Systems
from haverify.analyses.hybrid.expansion import both
from haverify.analyses.regions import Node, Place, linear, named
from haverify.model.expression import TRUE, Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import Values
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Q = Fraction
MOST_PIECES = 400


@record
class Piece:
    """Numbers between two ends, whether each end belongs to them, and what is chosen there."""

    low: Q
    high: Q
    has_low: bool
    has_high: bool
    value: str


def choices_of(spec: Spec, automaton: HybridAutomaton, values: Values, e: Expr) -> Iterator[tuple[Expr, str]]:
    """Conditions on a variable and the term that a fuzzy system chooses where each holds; together its whole range.

    Raises
    ------
    OutsideFragmentError    if its inputs read more than one variable with a range, or no rule fires somewhere in it
    """
    name, output, given = str(e.args[0]), str(e.args[1]), e.args[2]
    assert isinstance(given, tuple)
    read = {n.name for _, x in given for n in nodes(x) if n.op not in ("num", "const", "+", "-", "*", "neg")}
    asked = next((v for v in automaton.vars if read == {v.name}), None)
    if asked is None or asked.range is None:
        raise OutsideFragmentError(f"{name}, whose inputs read more than one variable with a declared range")
    low, high = values.interval(asked.range)
    at = {word: _input(name, x, asked.name, values) for word, x in given}
    systems = Systems(spec)
    terms = systems.outputs(name)[output]
    strengths = [systems.strength(name, output, t, at) for t in terms]
    for p in _merged(_pieces(asked.name, strengths, terms, low, high)):
        yield _inside(Expr("var", (asked.name,)), p, low, high), p.value


def _input(name: str, x: Expr, variable: str, values: Values) -> Node:
    if x.op == "var":
        return named(variable)
    try:
        return linear(values.number(x))
    except OutsideFragmentError:
        raise OutsideFragmentError(f"an input of {name} that is neither a variable nor a number") from None


class _Points(dict[Q, Place]):
    """Numbers at values of the variable, each computed once."""

    def __init__(self, variable: str) -> None:
        self.variable = variable

    def __missing__(self, x: Q) -> Place:
        self[x] = Place({self.variable: x})
        return self[x]


def _pieces(variable: str, strengths: Sequence[Node], terms: Sequence[str], low: Q, high: Q) -> Iterator[Piece]:
    at = _Points(variable)
    cuts = _cuts(at, strengths, low, high)

    def chosen(x: Q) -> str:
        found = [at[x].value(s) for s in strengths]
        if max(found) <= 0:
            raise OutsideFragmentError(f"no rule fires where {variable} is {x}")
        return terms[found.index(max(found))]

    yield Piece(low, low, True, True, chosen(low))
    for a, b in pairwise(cuts):
        yield Piece(a, b, False, False, chosen((a + b) / 2))
        yield Piece(b, b, True, True, chosen(b))


def _cuts(at: _Points, strengths: Sequence[Node], low: Q, high: Q) -> list[Q]:
    """Numbers between which all strengths, and all numbers they are made of, are linear and keep their order."""
    made = list(dict.fromkeys(n for s in strengths for n in _inner(s)))
    cuts = [low, high] if low < high else [low]
    for n in made:
        compared = [*_parts(n)]
        for a, b in pairwise(list(cuts)):
            cuts += [x for f, g in combinations(compared, 2) if (x := _equal(at, f, g, a, b)) is not None]
        cuts = sorted(set(cuts))
        if len(cuts) > MOST_PIECES:
            raise OutsideFragmentError("a fuzzy system with too many corners")
    for a, b in pairwise(list(cuts)):
        cuts += [x for f, g in combinations(strengths, 2) if (x := _equal(at, f, g, a, b)) is not None]
    return sorted(set(cuts))


def _inner(n: Node) -> Iterator[Node]:
    """A number and all that it is made of, each after its parts."""
    for p in _parts(n):
        yield from _inner(p)
    yield n


def _parts(n: Node) -> list[Node]:
    if n.op == "lin":
        return []
    if n.op == "sum":
        return [m for _, m in n.parts[1]]
    if n.op == "if":
        if isinstance(n.parts[0], bool) or n.parts[0].op != "le":
            raise OutsideFragmentError("a term with more than one step")
        return [*n.parts[0].parts[:2], *n.parts[1:]]
    return list(n.parts)


def _equal(at: _Points, f: Node, g: Node, a: Q, b: Q) -> Q | None:
    """Where two numbers that are linear between two ends are equal in between, if that is one point."""
    thirds = [(2 * a + b) / 3, (a + 2 * b) / 3]
    first, second = (at[x].value(f) - at[x].value(g) for x in thirds)
    if first == second:
        return None
    x = thirds[0] + first * (thirds[1] - thirds[0]) / (first - second)
    return x if a < x < b else None


def _merged(pieces: Iterator[Piece]) -> list[Piece]:
    """Neighbours with the same choice are put together."""
    found = list[Piece]()
    for p in pieces:
        if found and found[-1].value == p.value:
            found[-1] = replace(found[-1], high=p.high, has_high=p.has_high)
        else:
            found.append(p)
    return found


def _inside(x: Expr, p: Piece, low: Q, high: Q) -> Expr:
    """Inside a piece; runs that leave the declared range, which ends at the outermost ones, are not followed."""
    above = Expr(">=" if p.has_low else ">", (x, Expr("num", (p.low,)))) if p.low > low else TRUE
    below = Expr("<=" if p.has_high else "<", (x, Expr("num", (p.high,)))) if p.high < high else TRUE
    return both([above, below])
