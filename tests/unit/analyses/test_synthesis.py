"""The search for invariants: rules for given cuts, polynomials with `p' = c p`, barriers, exact starts."""

from fractions import Fraction
from time import process_time

from haverify.analyses.induction.written import written
from haverify.analyses.synthesis.equations import kept_together
from haverify.analyses.synthesis.integrals import darboux_polynomials, derivative, first_integrals
from haverify.analyses.synthesis.keep import keep
from haverify.analyses.synthesis.starts import exact_points
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.hybrid import HybridAutomaton, Variable
from haverify.model.unit import parse_unit
from haverify.obligations.formula import Literal, compare, conjunction, holds
from haverify.obligations.functions import Functions
from haverify.obligations.premises import Premises, whole
from haverify.solvers.positivity.levels import NUMBERS, PAIRS, SQUARES
from haverify.solvers.positivity.refute import Effort

X, Y, Z = variable("x"), variable("y"), variable("z")
ONE = constant(1)
NOTHING = Premises(Functions())


def rule(field: dict[str, Polynomial], *cut: Literal, known: Premises = NOTHING) -> str | None:
    found = keep(known, cut, field, Effort((NUMBERS, SQUARES, PAIRS), process_time() + 5))
    return None if found is None else found["rule"]


def test_a_sign_is_kept() -> None:
    assert rule({"x": -X}, Literal("<", -X)) == "darboux"


def test_a_bound_is_kept() -> None:
    assert rule({"x": constant(1) - X}, Literal("<=", X - constant(2))) == "growth"


def test_a_bound_that_is_crossed_is_not_kept() -> None:
    assert rule({"x": ONE}, Literal("<=", X - constant(2))) is None


def test_literals_that_need_each_other() -> None:
    """Each alone is left: x <= -1 needs y <= -1, and the reverse."""
    field = {"x": Y, "y": X}
    sides = [Literal("<=", X + ONE), Literal("<=", Y + ONE)]
    assert [rule(field, q) for q in sides] == [None, None]
    assert rule(field, *sides) == "barrier"


def test_equations_together() -> None:
    """(1, 1, 1) is at rest, though no coordinate alone is known to be."""
    field = {"x": X * (Y - Z), "y": Y * (Z - X), "z": Z * (X - Y)}
    found = kept_together([X - ONE, Y - ONE, Z - ONE], field)
    assert len(found) == 3
    assert rule(field, *(Literal("==", p) for p in found)) == "darboux"
    assert kept_together([X - ONE], {"x": ONE}) == []


def test_first_integrals() -> None:
    (found,) = first_integrals({"x": Y, "y": -X}, ("x", "y"), 2)
    assert found in (X * X + Y * Y, -(X * X) - Y * Y)


def test_polynomials_that_keep_their_sign() -> None:
    """The circle of a limit cycle is found from its equation alone."""
    field = {"x": Y, "y": Y * (ONE - X * X - Y * Y) - X}
    found = dict(darboux_polynomials(field, ("x", "y"), 2, 20))
    circle = X * X + Y * Y - ONE
    assert any(p in (circle, -circle) for p in found)
    assert all(derivative(p, field) == c * p for p, c in found.items())


def test_exact_starts_solve_equations() -> None:
    entries = [compare("==", X * Y - Z), compare("<=", X * X + Y * Y - constant(Fraction(1, 4))), compare("<", -Z)]
    point = next(exact_points(entries, ("x", "y", "z")))
    assert all(holds(e, point) for e in entries)


def test_formulas_as_text() -> None:
    metres = parse_unit("m")
    automaton = HybridAutomaton.__new__(HybridAutomaton)
    variables = (Variable("x", "real", metres, None), Variable("y", "real", None, None))
    for name, value in (("vars", variables), ("params", ())):
        object.__setattr__(automaton, name, value)
    f = conjunction([Literal("<=", whole(X * X - Y + constant(Fraction(1, 2)))), Literal("<", -Y)])
    assert written(f, automaton) == "2 * (x / (1 m))^2 <= 2 * y - 1 and y > 0"
