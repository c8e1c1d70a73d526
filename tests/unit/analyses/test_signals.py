"""Robustness of bounded STL: exact where it can be, as a fine sampling has it, absent where it means nothing."""

import random
from fractions import Fraction as Q

import pytest
from tests.unit.analyses.models import Y, claim, n, op, schedule, spec

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.claim import Goal
from haverify.model.expression import Expr

TEMPORAL = {"globally": min, "eventually": max}
STEP = Q(1, 100)


def over(word, low, high, e):
    return Expr(word, (n(low), n(high), e))


def decided(machine, formula):
    return decide_all(spec(machine, claim("c", Goal("stl", formula))))["c"]


def sampled(polynomials, formula, horizon):
    """The robustness at the start, by values of y on a grid; each formula is `(word, low, high, inner)` or a number."""
    k = len(polynomials)
    instants = []  # (time, value); both sides of each jump
    for i in range(int(horizon / STEP) + 1):
        t = float(i * STEP)
        x = t % k
        if abs(x - round(x)) < 1e-9 and t > 0:
            before = (round(x) - 1) % k
            instants.append((t, evaluate(polynomials[before], before + 1.0)))
            x = float(round(x) % k)
        instants.append((t, evaluate(polynomials[int(x)], x)))
    return robust(formula, instants)[0]


def evaluate(coefficients, x):
    return sum(float(c) * x**i for i, c in enumerate(coefficients))


def robust(formula, instants):
    if not isinstance(formula, tuple):
        return [float(formula) - v for _, v in instants]
    word, low, high, inner = formula
    below = robust(inner, instants)
    found = []
    for i, (t, _) in enumerate(instants):
        inside = [below[j] for j in range(i, len(instants)) if t + low - 1e-9 <= instants[j][0] <= t + high + 1e-9]
        found.append(TEMPORAL[word](inside) if inside else 0.0)
    return found


def expression(formula):
    """`y <= number` under temporal operators."""
    if not isinstance(formula, tuple):
        return op("<=", Y, n(formula))
    word, low, high, inner = formula
    return over(word, low, high, expression(inner))


@pytest.mark.parametrize("seed", range(5))
def test_margins_agree_with_a_fine_sampling(seed):
    pick = random.Random(seed)
    polynomials = [[pick.randint(-3, 3) for _ in range(pick.randint(1, 4))] for _ in range(2)]
    words = [pick.choice(["globally", "eventually"]) for _ in range(2)]
    ends = [sorted([Q(pick.randint(0, 3), 2), Q(pick.randint(1, 4), 2)]) for _ in range(2)]
    formula = (words[0], *ends[0], (words[1], *ends[1], Q(pick.randint(-4, 6))))
    found = decided(schedule(polynomials), expression(formula))
    assert not isinstance(found.verdict, Unknown)
    margin, near = found.verdict.margin, sampled(polynomials, formula, ends[0][1] + ends[1][1])
    assert margin is not None
    slope = max(sum(abs(c) * i * 2**i for i, c in enumerate(p)) for p in polynomials) + 1
    assert float(margin.low) - slope * float(STEP) <= near <= float(margin.high) + slope * float(STEP)
    assert isinstance(found.verdict, Proved) or margin.low <= 0
    assert isinstance(found.verdict, Refuted) or margin.high >= 0


def test_a_value_at_the_end_of_a_window_is_exact_and_placed():
    found = decided(schedule([[0, 1], [2]]), over("globally", 0, Q(1, 2), op("<=", Y, n(2))))
    assert (found.verdict.margin.low, found.verdict.margin.high) == (Q(3, 2), Q(3, 2))
    assert "time = 0.5" in found.verdict.margin.at


def test_no_margin_where_modes_alone_count():
    found = decided(schedule([[0, 1], [2]]), over("eventually", 0, 1, op("at", "M1")))
    assert isinstance(found.verdict, Proved) and found.verdict.margin is None


def test_a_long_run_is_followed():
    found = decided(schedule([[0, 1], [2]]), over("globally", 0, 120, over("eventually", 0, 2, op("at", "M1"))))
    assert isinstance(found.verdict, Proved)
