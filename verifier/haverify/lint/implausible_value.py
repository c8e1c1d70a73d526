"""HA108: an angle in rad that is many turns, and few as degrees."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.lint._facts import Facts
from haverify.lint._formulas import formulas, ranges
from haverify.lint._registry import rule
from haverify.maths.exact import significant
from haverify.model.expression import Expr, nodes
from haverify.model.spec import Spec

_TWO_TURNS = Fraction(1257, 100)  # rad, about 4 pi
_TURN = Fraction(710, 113)  # 2 pi
_MOST = 720  # as degrees this is two turns as well: then degrees are no better guess


@rule("HA108")
def implausible_value(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Numbers as written: in ranges, constants and conditions."""
    seen: set[object] = set()
    for number in _numbers(spec, facts):
        value = number.args[0]
        assert isinstance(value, Fraction), "a number node holds a rational"
        if _TWO_TURNS < abs(value) <= _MOST and number.span not in seen:
            seen.add(number.span)
            yield _finding(facts, number, value)


def _numbers(spec: Spec, facts: Facts) -> Iterator[Expr]:
    """The numbers in rad."""
    owners = (*spec.constants, *(c for a in spec.automata for c in a.constants))
    written = [e for r, _, _ in ranges(facts) for e in (r.low, r.high)]
    written += [c.value for c in owners if isinstance(c.value, Expr)]
    written += [f.expr for f in formulas(facts)]
    return (n for e in written for n in nodes(e) if n.op == "num" and n.span is not None and str(n.unit) == "rad")


def _finding(facts: Facts, number: Expr, value: Fraction) -> Diagnostic:
    text = facts.text(number.span)
    turns = significant(abs(value) / _TURN)
    has_fix = number.span is not None and text.endswith("rad")
    fix = Fix("write deg", (Edit(number.span, text.removesuffix("rad") + "deg"),)) if has_fix and number.span else None
    return Diagnostic(
        "HA108",
        f"{significant(value)} rad is {turns} turns; is it in degrees?",
        span=number.span,
        help=f"write `{significant(value)} deg` if degrees are meant",
        fix=fix,
        key=f"{significant(value)} rad is many turns",
    )
