"""Random polynomial systems whose claim is true, or false, by construction.

python -m tests.properties.planted 200      so many of each: how many are found, and that no answer is wrong
"""

from __future__ import annotations

import random
import sys
from fractions import Fraction

from hacheck.flows import Flow
from hacheck.functions import Functions as CheckedFunctions
from hacheck.positivity import Premises as Checked
from hacheck.positivity import formula, polynomial
from haverify.analyses.synthesis.integrals import derivative
from haverify.analyses.synthesis.saturate import invent
from haverify.analyses.synthesis.system import Cut, System
from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.obligations.formula import Literal, conjunction
from haverify.obligations.functions import Functions
from haverify.obligations.premises import Premises, formula_json, polynomial_json, whole

X, Y = variable("x"), variable("y")
SECONDS = 3.0


def _number(r: random.Random) -> Polynomial:
    return constant(Fraction(r.randint(-4, 4), 2))


def _system(start: dict[str, Fraction], radius: Fraction, goal: Polynomial, field: dict[str, Polynomial]) -> System:
    """Starts in a square, the goal `goal <= 0`."""
    common = Premises(Functions())
    sides = [s * (variable(v) - constant(q)) - constant(radius) for v, q in start.items() for s in (_one(1), _one(-1))]
    return System(common, (common.with_(*(Literal("<=", p) for p in sides)),), Literal("<=", whole(goal)), field)


def _one(sign: int) -> Polynomial:
    return constant(Fraction(sign))


def _kept(r: random.Random) -> tuple[Polynomial, dict[str, Polynomial]]:
    """A polynomial p, and a field with `p' = (b p_x + c p_y) p`."""
    p = total([X * X, (Y * Y).scaled(Fraction(r.randint(1, 3))), _number(r) * X, _number(r) * Y, constant(-3)])
    a, b, c = (_number(r) for _ in range(3))
    a = a + constant(Fraction(9, 2))
    px, py = p.derivative("x"), p.derivative("y")
    return p, {"x": a * py + b * p, "y": c * p - a * px}


def true_one(seed: int) -> System:
    """The starts are inside of a curve that no run crosses; the goal holds inside of it."""
    r = random.Random(seed)
    while True:
        p, field = _kept(r)
        at = {"x": Fraction(r.randint(-2, 2), 2), "y": Fraction(r.randint(-2, 2), 2)}
        corners = [{"x": at["x"] + dx, "y": at["y"] + dy} for dx in (-R, R) for dy in (-R, R)]
        if all(p.value(q) < -Fraction(1, 10) for q in corners):  # p is convex
            return _system(at, R, p - constant(Fraction(r.randint(0, 2), 2)), field)


R = Fraction(1, 8)


def false_one(seed: int) -> System:
    """A quantity s grows along each run as a clock does, and the goal bounds it."""
    r = random.Random(seed)
    slope = Fraction(r.randint(1, 4), 2)
    bent = _number(r) * Y * Y + _number(r) * Y
    rate_y = _number(r) * Y - (Y * Y * Y).scaled(Fraction(1, 2))
    rate_x = constant(slope) - derivative(bent, {"y": rate_y})
    s = X + bent  # s' = slope
    at = {"x": Fraction(r.randint(-2, 2)), "y": Fraction(r.randint(-2, 2), 2)}
    return _system(at, R, s - constant(s.value(at) + r.randint(2, 20)), {"x": rate_x, "y": rate_y})


def accepted(system: System, cuts: list[Cut]) -> bool:
    """Whether hacheck accepts that the flow keeps the cuts; it raises what it refuses with."""
    known = Checked(CheckedFunctions(), [formula(formula_json(e)) for e in system.common.entries])
    flow = Flow(known, {v: polynomial(polynomial_json(p)) for v, p in system.field.items()}, set(system.field))
    told = [{"formula": formula_json(conjunction(c.literals)), "start": "t", "keep": c.rule} for c in cuts]
    all_of_them = formula(formula_json(conjunction(q for c in cuts for q in c.literals)))
    flow.kept({"cuts": told, "end": "t"}, [all_of_them], all_of_them)
    return True


def main(count: int) -> int:
    """Say how many were found; the exit code is 1 where something false was."""
    found = wrong = 0
    for seed in range(count):
        system = true_one(seed)
        cuts = invent(system, SECONDS)
        found += cuts is not None and accepted(system, cuts)
        wrong += invent(false_one(seed), SECONDS) is not None
    print(f"{found} of {count} true ones found, {wrong} of {count} false ones")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
