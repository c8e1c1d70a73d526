"""A schedule of two modes whose outputs have printed coefficients, and the same with other coefficients."""

from fractions import Fraction as Q

from tests.unit.analyses.models import X, Y, always, claim, n, op, schedule

from haverify.analyses.portfolio import decide_all
from haverify.model.expression import Expr
from haverify.model.hybrid import Constant, Output
from haverify.text.record import replace

HALF = Q(1, 20)  # one digit after the point


def constant(name, value):
    return Constant(name, "real", None, n(value), HALF)


def model(coefficients, base):
    """The spec with `y = a0 + a1 x + a2 x^2` in M0, `b0 + b1 x + b2 x^2` in M1; `coefficients` by name."""
    automaton = schedule([[0], [0]])
    modes = tuple(
        replace(m, lets=(Output("y", "real", None, polynomial(letter)),))
        for m, letter in zip(automaton.modes, "ab", strict=True)
    )
    constants = tuple(constant(name, value) for name, value in coefficients.items())
    return replace(base, automata=(replace(automaton, modes=modes),), constants=constants)


def polynomial(letter):
    terms = [Expr("const", (f"{letter}0",))]
    terms += [op("*", Expr("const", (f"{letter}{i}",)), op("^", X, n(i))) for i in (1, 2)]
    return op("+", *terms)


def names():
    return [f"{letter}{i}" for letter in "ab" for i in range(3)]


def below(bound):
    return claim("c", always(op("<=", Y, n(bound))))


def decided(coefficients, bound, empty):
    """The evidence for `always y <= bound`."""
    return decide_all(replace(model(coefficients, empty), claims=(below(bound),)))["c"]


def value(coefficients, letter, x):
    return sum(coefficients[f"{letter}{i}"] * x**i for i in range(3))
