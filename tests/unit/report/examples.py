"""Small claims and evidence for the tests of this folder."""

from fractions import Fraction

from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Proved, Refuted, Trust, Unknown, Verdict
from haverify.model.claim import Claim, Expectation, Goal
from haverify.model.expression import TRUE, number
from haverify.model.unit import parse_unit

DEG = parse_unit("deg")


def claim(expect: str | None = None, margin: tuple[str, str] | None = None, goals: int = 1) -> Claim:
    """`property range on Gait` with an expectation; the margin is in deg."""
    bound = (margin[0], number(Fraction(margin[1]), DEG)) if margin else None
    return Claim(
        name="range",
        on="Gait",
        kind="property",
        goals=(Goal("always", TRUE),) * goals,
        time=None,
        jumps=None,
        assume=(),
        which=(),
        using=(),
        method=None,
        expect=Expectation(expect, margin=bound) if expect else None,
        inductive=False,
        text="always true",
    )


def margin(value: str, high: str | None = None) -> Margin:
    return Margin(Fraction(value), Fraction(high or value), "deg")


PROVED = Proved(margin("2"), Trust.CHECKED)
REFUTED = Refuted(margin("-5/2"), Trust.CHECKED)
UNKNOWN = Unknown("budget", "stopped after 60 s")


def part(where: str, verdict: Verdict, goal: int = 0) -> PartResult:
    return PartResult(goal, "dwell", where, "lk", f"lk in range in {where}", verdict)


def evidence(verdict: Verdict, *parts: PartResult) -> Evidence:
    run = Run("LR", (("x", Fraction(2, 5)),), (), (), Fraction(1, 10)) if isinstance(verdict, Refuted) else None
    return Evidence(verdict, parts, "poly-range", {"claim": "range"}, run=run)
