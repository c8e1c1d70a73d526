"""HA201: an interval or a chain of comparisons whose lower bound is above its upper bound."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import Formula, formulas, ranges
from haverify.lint._registry import rule
from haverify.lint._wording import quantity
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Range
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame
from haverify.solvers.literals import number_of
from haverify.text.record import record

_STATE = frozenset({"var", "let", "input", "time", "pre", "der", "bound"})


@record
class Bounds:
    """`low op term` and `term op high`, as two comparisons of one conjunction say; units of the terms may differ."""

    low: Expr
    low_op: str
    term: Expr
    high_op: str
    high: Expr
    high_term: Expr


@rule("HA201")
def empty_interval(_spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Intervals first, then the conditions of automata, assumptions and claims."""
    for interval, frame, owner in ranges(facts):
        if _is_above(interval.low, "<=", interval.high, frame):
            yield _of_range(facts, interval, frame, owner)
    for formula in formulas(facts):
        yield from (_of_bounds(facts, formula, b) for b in empty_bounds(formula))


def empty_bounds(formula: Formula) -> Iterator[Bounds]:
    """The pairs of bounds on one term that no value meets."""
    for node in nodes(formula.expr):
        if node.op == "and":
            yield from (b for b in _bounds(node) if _is_empty(b, formula.frame))


def _bounds(conjunction: Expr) -> Iterator[Bounds]:
    lower: list[tuple[Expr, str, Expr]] = []
    upper: list[tuple[Expr, str, Expr]] = []
    for c in conjunction.children:
        if c.op in ("<", "<=", ">", ">="):
            left, right = c.children if c.op in ("<", "<=") else c.children[::-1]
            op = "<" if c.op in ("<", ">") else "<="
            if _rank(left) < _rank(right):
                lower.append((right, op, left))
            elif _rank(right) < _rank(left):
                upper.append((left, op, right))
    for term, low_op, low in lower:
        yield from (Bounds(low, low_op, term, op, high, t) for t, op, high in upper if _bare(t) == _bare(term))


def _bare(e: Expr) -> Expr:
    """An expression without the conversion of its unit."""
    inner = e.args[2] if e.op == "scale" else e
    return inner if isinstance(inner, Expr) else e


def _rank(e: Expr) -> int:
    """What varies more: the state (2), params (1), nothing (0). In a pair of bounds that is the term bounded."""
    ops = {n.op for n in nodes(e)}
    return 2 if ops & _STATE else 1 if "param" in ops else 0


def _is_empty(b: Bounds, frame: Frame) -> bool:
    op = "<=" if b.low_op == b.high_op == "<=" else "<"
    low, high = _converted(b.low, b.high_term, b.term), _converted(b.high, b.term, b.high_term)
    return _is_above(low, op, high, frame)


def _converted(bound: Expr, other: Expr, own: Expr) -> Expr:
    """A bound on `own` after the conversion of the unit that the other bound's term has, so that the two compare."""
    return bound if other.op != "scale" or own == other else Expr("scale", (*other.args[:2], bound))


def _is_above(low: Expr, op: str, high: Expr, frame: Frame) -> bool:
    """Whether `low op high` is false for every value of the params."""
    a, b = number_of(low, frame), number_of(high, frame)
    if a is not None and b is not None:
        return a > b or (a == b and op == "<")
    return isinstance(decide([Condition(Expr(op, (low, high)), frame)]), Contradiction)


def _of_range(facts: Facts, interval: Range, frame: Frame, owner: str) -> Diagnostic:
    low, high = facts.text(interval.low.span), facts.text(interval.high.span)
    what = owner if " " in owner else f"`{owner}`"
    return Diagnostic(
        "HA201",
        f"empty interval for {what}: the lower bound is above the upper bound",
        span=interval.high.span,
        label=_distance(interval.low, interval.high, frame),
        labels=_labels(interval.low),
        notes=(f"nothing lies in `[{low}, {high}]`",) if low and high else (),
        help=f"as a range: `[{high}, {low}]`" if low and high else None,
        fix=_swap(facts, interval.low, interval.high),
        key=f"empty interval for {owner}",
    )


def _of_bounds(facts: Facts, formula: Formula, b: Bounds) -> Diagnostic:
    low, term, high = (facts.text(e.span) for e in (b.low, b.term, b.high))
    written = f"{low} {b.low_op} {term} {b.high_op} {high}"
    return Diagnostic(
        "HA201",
        f"empty interval in {formula.place}: " + _summary(b, formula.frame),
        span=b.high.span,
        label=_distance(b.low, b.high, formula.frame) if b.term == b.high_term else "",
        labels=_labels(b.low),
        notes=(f"no value of `{term}` satisfies `{written}`",) if low and term and high else (),
        help=f"as a range: `{high} {b.high_op} {term} {b.low_op} {low}`" if low and term and high else None,
        fix=_swap(facts, b.low, b.high),
        key=f"empty interval in {formula.place}: {written}",
    )


def _summary(b: Bounds, frame: Frame) -> str:
    low, high = number_of(b.low, frame), number_of(b.high, frame)
    if low is not None and low == high:
        return f"both bounds are {quantity(low, b.low.unit)} and not both are included"
    return "the lower bound is above the upper bound"


def _distance(low: Expr, high: Expr, frame: Frame) -> str:
    a, b = number_of(low, frame), number_of(high, frame)
    return "" if a is None or b is None or a == b else f"below the lower bound by {quantity(a - b, low.unit)}"


def _labels(low: Expr) -> tuple[Label, ...]:
    return (Label(low.span, "the lower bound"),) if low.span else ()


def _swap(facts: Facts, low: Expr, high: Expr) -> Fix | None:
    """Exchange the texts of the bounds."""
    texts = facts.text(low.span), facts.text(high.span)
    if low.span is None or high.span is None or not all(texts):
        return None
    return Fix("exchange the bounds", (Edit(low.span, texts[1]), Edit(high.span, texts[0])))
