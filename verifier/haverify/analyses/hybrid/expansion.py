"""An automaton whose modes are written out by what the flowpipe analyses cannot follow within one of them.

Discrete variables have one value in each of its modes (`discrete`), and functions with corners have one side
(`corners`). Runs are the same: only a change of side is no jump of the automaton.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify.model.expression import FALSE, TRUE, Expr, rebuild
from haverify.model.hybrid import HybridAutomaton
from haverify.obligations.residual import Situation, residual
from haverify.text.record import record

Q = Fraction
Known = Mapping[str, Expr]
# Modes and jumps are decided already; `pre` is not to be.
DECIDED = Situation("", "", "")
CONSTANT = ("num", "sym", "true", "false")


@record
class Place:
    """What a mode stands for: a mode of the automaton as written, with the values of its discrete variables."""

    mode: str
    values: tuple[tuple[str, Expr], ...] = ()


@record
class Expanded:
    """The automaton written out, what each of its modes stands for, and each of its edges (None: a change of side)."""

    automaton: HybridAutomaton
    places: Mapping[str, Place]
    edges: tuple[int | None, ...]


def unchanged(automaton: HybridAutomaton) -> Expanded:
    """The automaton as it is."""
    places = {m.name: Place(m.name) for m in automaton.modes}
    return Expanded(automaton, places, tuple(range(len(automaton.edges))))


def dwelling(e: Expr, place: Place, lets: Known) -> Expr:
    """What is left of a condition during a stay."""
    return folded(residual(e, Situation(place.mode)), dict(place.values), lets)


def landing(e: Expr, name: str, source: tuple[Place, Known], target: tuple[Place, Known]) -> Expr:
    """What is left of a condition right after a jump between places, with their lets; `pre` of a number stays."""
    at = Situation(target[0].mode, source[0].mode, name)
    return folded(residual(e, at), dict(target[0].values), target[1], (dict(source[0].values), source[1]))


def folded(e: Expr, known: Known, lets: Known, before: tuple[Known, Known] = ({}, {})) -> Expr:
    """An expression with discrete variables (and lets, where constant) replaced, and what follows from that."""
    if e.op == "var":
        return known.get(e.name, e)
    if e.op == "let":
        meant = lets.get(e.name)
        return meant if meant is not None and meant.op in CONSTANT else e
    if e.op == "pre":
        inner = folded(e.children[0], *before)
        return inner if inner.op in CONSTANT else Expr("pre", (inner,), e.unit, e.span)
    return simplified(rebuild(e, lambda c: folded(c, known, lets, before)))


def simplified(e: Expr) -> Expr:
    """An expression over simplified ones: constants compared, added and multiplied, truths joined."""
    if e.op in ("and", "or", "not", "implies", "if"):
        return residual(e, DECIDED)
    parts = e.children
    if len(parts) == 2 and all(c.op in CONSTANT for c in parts):
        return _of_constants(e, *parts)
    if e.op in ("==", "!=") and any(c.op in ("true", "false") for c in parts):
        truth, other = (parts[0], parts[1]) if parts[0].op in ("true", "false") else (parts[1], parts[0])
        return other if (truth.op == "true") is (e.op == "==") else simplified(Expr("not", (other,)))
    if e.op == "neg" and parts[0].op == "num":
        return Expr("num", (-Q(str(parts[0].args[0])),), e.unit)
    return e


def _of_constants(e: Expr, left: Expr, right: Expr) -> Expr:
    if e.op in ("==", "!="):
        return TRUE if (left == right) is (e.op == "==") else FALSE
    if left.op != "num" or right.op != "num":
        return e
    a, b = Q(str(left.args[0])), Q(str(right.args[0]))
    truths = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b}
    if e.op in truths:
        return TRUE if truths[e.op] else FALSE
    numbers = {"+": a + b, "-": a - b, "*": a * b, "min": min(a, b), "max": max(a, b)}
    return Expr("num", (numbers[e.op],), e.unit) if e.op in numbers else e


def both(conditions: Sequence[Expr]) -> Expr:
    """Their conjunction."""
    kept = [c for c in conditions if c.op != "true"]
    if any(c.op == "false" for c in kept):
        return FALSE
    return TRUE if not kept else kept[0] if len(kept) == 1 else Expr("and", tuple(kept))
