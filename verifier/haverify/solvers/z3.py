"""z3, the one door to it: polynomial conditions in several unknowns, within a budget of work units."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.maths.polynomial import Polynomial
from haverify.solvers.answer import Undecided
from haverify.solvers.linear import Infeasible, Row

RLIMIT = 2_000_000


def solve(rows: list[Row], rlimit: int = RLIMIT) -> dict[str, Fraction] | Infeasible | Undecided:
    """A rational point that satisfies the rows, a contradiction among them, or undecided when the budget is spent."""
    import z3

    context = z3.Context()
    solver = z3.SolverFor("QF_NRA", ctx=context)
    solver.set("rlimit", rlimit)
    for number, row in enumerate(rows):
        solver.assert_and_track(_formula(row, context), z3.Bool(f"row {number}", ctx=context))
    answer = solver.check()
    if answer == z3.unsat:
        numbers = [int(str(name).strip("|").split()[1]) for name in solver.unsat_core()]
        return Infeasible(frozenset(k for n in numbers for k in rows[n].origins))
    if answer == z3.sat:
        return _point(solver.model()) or Undecided("the solver's point is irrational")
    return Undecided(f"the solver gave up after {rlimit} work units")


def _formula(row: Row, context: Any) -> Any:
    value = _term(row.poly, context)
    return value < 0 if row.relation == "<" else value <= 0 if row.relation == "<=" else value == 0


def _term(poly: Polynomial, context: Any) -> Any:
    import z3

    total = z3.RealVal(0, ctx=context)
    for monomial, c in poly.terms.items():
        factor = z3.RealVal(f"{c.numerator}/{c.denominator}", ctx=context)
        for name, power in monomial:
            for _ in range(power):
                factor = factor * z3.Real(name, ctx=context)
        total = total + factor
    return total


def _point(model: Any) -> dict[str, Fraction] | None:
    point = {}
    for declared in model.decls():
        value = model[declared]
        if declared.name().startswith("row "):
            continue
        if not hasattr(value, "numerator_as_long"):
            return None
        point[declared.name()] = Fraction(value.numerator_as_long(), value.denominator_as_long())
    return point
