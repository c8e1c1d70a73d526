"""Formulas in negation normal form over polynomial literals, free of modes, jumps and quantifiers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction

from haverify.maths.polynomial import Polynomial
from haverify.text.record import record

HOLDS: Mapping[str, Callable[[Fraction], bool]] = {
    "<": lambda v: v < 0,
    "<=": lambda v: v <= 0,
    "==": lambda v: v == 0,
    "!=": lambda v: v != 0,
}


@record
class Literal:
    """`polynomial op 0` with `op` one of `<`, `<=`, `==`, `!=`."""

    op: str
    polynomial: Polynomial


@record
class Junction:
    """A conjunction (`is_and`) or disjunction of at least two formulas, none of them constant or of the same kind."""

    is_and: bool
    members: tuple[Literal | Junction, ...]


Formula = bool | Literal | Junction


def literal(op: str, p: Polynomial) -> Formula:
    """`p op 0`, decided at once where `p` is constant."""
    value = p.constant
    return Literal(op, p) if value is None else HOLDS[op](value)


def compare(op: str, p: Polynomial) -> Formula:
    """`p op 0` for any of the six comparisons."""
    if op in (">", ">="):
        return literal("<" if op == ">" else "<=", -p)
    return literal(op, p)


def conjunction(members: Iterable[Formula]) -> Formula:
    """All of them."""
    return _join(True, members)


def disjunction(members: Iterable[Formula]) -> Formula:
    """At least one of them."""
    return _join(False, members)


def _join(is_and: bool, members: Iterable[Formula]) -> Formula:
    kept: dict[Literal | Junction, None] = {}
    for m in members:
        if isinstance(m, bool):
            if m is not is_and:
                return m
        elif isinstance(m, Junction) and m.is_and is is_and:
            kept.update(dict.fromkeys(m.members))
        else:
            kept[m] = None
    if not kept:
        return is_and
    if not is_and and 1 < len(kept) <= 8 and any(negation(m) in kept for m in kept if isinstance(m, Literal)):
        return True
    return next(iter(kept)) if len(kept) == 1 else Junction(is_and, tuple(kept))


def negation(f: Formula) -> Formula:
    """The formula that holds where `f` does not."""
    if isinstance(f, bool):
        return not f
    if isinstance(f, Junction):
        return _join(not f.is_and, [negation(m) for m in f.members])
    if f.op in ("==", "!="):
        return Literal("!=" if f.op == "==" else "==", f.polynomial)
    return Literal("<=" if f.op == "<" else "<", -f.polynomial)


def literals(f: Formula) -> Iterator[Literal]:
    """Every literal, from left to right."""
    if isinstance(f, Literal):
        yield f
    elif isinstance(f, Junction):
        for m in f.members:
            yield from literals(m)


def variables(f: Formula) -> set[str]:
    """The variables that occur."""
    return {v for leaf in literals(f) for v in leaf.polynomial.variables}


def transform(f: Formula, change: Callable[[Polynomial], Polynomial]) -> Formula:
    """The formula with each literal's polynomial changed, constants folded."""
    if isinstance(f, Literal):
        changed = change(f.polynomial)
        return f if changed is f.polynomial else literal(f.op, changed)
    if isinstance(f, Junction):
        return _join(f.is_and, [transform(m, change) for m in f.members])
    return f


def holds(f: Formula, values: Mapping[str, Fraction]) -> bool:
    """Whether `f` is true at a point that gives every variable."""
    return truth(f, lambda leaf: HOLDS[leaf.op](leaf.polynomial.value(values))) is True


def truth(f: Formula, of: Callable[[Literal], bool | None]) -> bool | None:
    """Three-valued truth from that of the literals; None where they do not decide it."""
    if isinstance(f, bool):
        return f
    if isinstance(f, Literal):
        return of(f)
    open_ = False
    for m in f.members:
        t = truth(m, of)
        if t is (not f.is_and):
            return t
        open_ = open_ or t is None
    return None if open_ else f.is_and


def by_bounds(op: str, low: Fraction, high: Fraction) -> bool | None:
    """The truth of `p op 0` where `low <= p <= high` is all that is known."""
    if op == "<":
        return True if high < 0 else False if low >= 0 else None
    if op == "<=":
        return True if high <= 0 else False if low > 0 else None
    apart = low > 0 or high < 0
    if op == "!=":
        return True if apart else False if low == high else None
    return False if apart else True if low == high else None


def text(f: Formula) -> str:
    """The formula as people read it."""
    if isinstance(f, bool):
        return "true" if f else "false"
    if isinstance(f, Literal):
        return f"{f.polynomial} {f.op} 0"
    word = " and " if f.is_and else " or "
    return word.join(f"({text(m)})" if isinstance(m, Junction) else text(m) for m in f.members)
