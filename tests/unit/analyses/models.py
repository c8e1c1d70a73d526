"""Small clock-driven models, built by hand."""

from fractions import Fraction as Q

from haverify.model.claim import Claim, Goal
from haverify.model.expression import TRUE, Expr, number
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Mode, Output, Range, Variable
from haverify.model.spec import Spec


def n(x):
    return number(Q(x))


def op(name, *args):
    return Expr(name, args)


X, Y = Expr("var", ("x",)), Expr("let", ("y",))


def polynomial(coefficients):
    """`sum c[i] x^i`, lowest power first."""
    terms = [op("*", n(c), op("^", X, n(i))) if i else n(c) for i, c in enumerate(coefficients)]
    return op("+", *terms) if len(terms) > 1 else terms[0]


def schedule(polynomials, urgent=True, last="1"):
    """Modes M0, M1, ... for one second each on a clock x; y is the mode's polynomial; the last guard is x
    >= k - 1 + last."""
    k = len(polynomials)
    modes, edges = [], []
    for i, p in enumerate(polynomials):
        domain = op("and", op("<=", n(i), X), op("<=", X, n(i + 1)))
        modes.append(Mode(f"M{i}", domain, (FlowLine("x", n(1)),), (Output("y", "real", None, polynomial(p)),), False))
        end = i + 1 if i < k - 1 else Q(i) + Q(last)
        resets = () if i < k - 1 else (Assign("x", n(0)),)
        edges.append(Edge(f"e{i}", f"M{i}", f"M{(i + 1) % k}", urgent, op(">=", X, n(end)), resets))
    variable = Variable("x", "real", None, Range(n(0), n(k)))
    init = Init("M0", TRUE, (Assign("x", n(0)),))
    return HybridAutomaton("A", (), (), (), (variable,), (), (init,), tuple(modes), tuple(edges), ())


def claim(name, *goals):
    return Claim(name, "A", "property", goals, None, None, (), (), (), None, None, False)


def spec(automaton, *claims):
    return Spec("s", "1.0", False, (), (), (), (), (), (), (), (), (automaton,), (), (), (), (), claims, ())


def always(e):
    return Goal("always", e)
