"""High even powers bounded together: the bounds of squares that follow, and why."""

from fractions import Fraction
from time import process_time

from haverify.maths.polynomial import constant, variable
from haverify.obligations.formula import Literal, holds
from haverify.obligations.functions import Functions
from haverify.obligations.premises import Premises, whole
from haverify.solvers.positivity.levels import NUMBERS, SQUARES
from haverify.solvers.positivity.powers import is_tall, lowered, powers
from haverify.solvers.positivity.refute import Effort, refute

X, Y = variable("x"), variable("y")
TALL = Literal("<=", (X - constant(9)) ** 2 + (Y - constant(20)) ** 20 - constant(4))


def test_what_is_tall() -> None:
    assert is_tall(TALL)
    assert not is_tall(Literal("<=", X**2 - constant(4)))
    assert not is_tall(Literal("<=", X**4 - X * Y - constant(4)))
    assert powers(X**3 - constant(1)) is None
    assert powers(X**2 + constant(1)) is None


def test_bounds_hold_where_the_literal_does() -> None:
    low = lowered(TALL)
    assert len(low) == 2
    for x, y in ((7, 20), (11, 20), (9, 21), (9, 19)):
        assert all(holds(q, {"x": Fraction(x), "y": Fraction(y)}) for q in low)
    assert not any(holds(q, {"x": Fraction(6), "y": Fraction(22)}) for q in low)


def test_a_proof_that_needs_them() -> None:
    """An identity of degree 20 is not looked for: the bound of the square is."""
    start = Premises(Functions()).with_(TALL)
    effort = Effort((NUMBERS, SQUARES), process_time() + 5)
    proof = refute(start.with_(Literal("<", whole(constant(24) - Y))), effort)
    assert proof is not None and proof[0] == "cut"
    assert refute(start.with_(Literal("<", whole(constant(20) - Y))), effort) is None
