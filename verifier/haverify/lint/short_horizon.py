"""HA606: a horizon `within` that is shorter than the one a goal brings."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import quantity
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.spec import Spec
from haverify.solvers.literals import number_of

_REACH = frozenset({"globally", "eventually", "until"})


@rule("HA606")
def short_horizon(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """`reach P within T`, `stl F` and windows name instants themselves; a shorter `within` beside them is a slip."""
    for claim in spec.claims:
        frame = facts.frame(facts.automata.get(claim.on or ""))
        horizon = number_of(claim.time, frame) if claim.time is not None else None
        for goal in claim.goals if horizon is not None else ():
            ends = [goal.within] if goal.within is not None else [goal.window[1]] if goal.window else []
            for end in (*ends, *_stl_ends(goal.condition)):
                needed = number_of(end, frame)
                if horizon is not None and needed is not None and horizon < needed:
                    yield _finding(claim, end, horizon, needed)


def _stl_ends(e: Expr) -> Iterator[Expr]:
    """The right ends of the outermost temporal operators."""
    if e.op in _REACH:
        yield e.children[1]
        return
    for child in e.children:
        yield from _stl_ends(child)


def _finding(claim: Claim, end: Expr, horizon: Fraction, needed: Fraction) -> Diagnostic:
    assert claim.time is not None
    return Diagnostic(
        "HA606",
        f"{claim.kind} {claim.name}: the horizon {quantity(horizon, claim.time.unit)} ends before the goal's "
        f"{quantity(needed, end.unit)}",
        span=claim.time.span or claim.span,
        labels=(Label(end.span, "the goal speaks of instants up to here"),) if end.span else (),
        help="leave `within` out, or make it as long as the goal's",
        key=f"{claim.name}: horizon shorter than the goal's",
    )
