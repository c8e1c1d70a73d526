"""A smaller budget follows fewer runs: work is counted, not time, and it decides less, never otherwise."""

from fractions import Fraction as Q

from tests.unit.analyses.models import X, claim, n, op, spec

from haverify.analyses.counterexample import MOST_NODES
from haverify.analyses.portfolio import Contexts, contexts_of, decide_all
from haverify.evidence.verdict import Proved, Unknown
from haverify.model.claim import Goal
from haverify.model.expression import TRUE
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Mode, Range, Variable
from haverify.model.spec import Spec

Y = op("var", "y")


def counting(*claims, urgent=False) -> Spec:
    """A lap of half a second (where not urgent: to a second) again and again, and a clock that is never reset."""
    rates = (FlowLine("x", n(1)), FlowLine("y", n(1)))
    lap = Edge("lap", "A", "A", urgent, op(">=", X, n("1/2")), (Assign("x", n(0)),))
    mode = Mode("A", op("<=", X, n(1)), rates, (), False)
    variables = (
        Variable("x", "real", None, Range(n(0), n(2))),
        Variable("y", "real", None, Range(n(0), n(1000))),
    )
    init = Init("A", TRUE, (Assign("x", n(0)), Assign("y", n(0))))
    return spec(HybridAutomaton("A", (), (), (), variables, (), (init,), (mode,), (lap,), ()), *claims)


def followed(contexts: Contexts) -> int:
    return max(len(e.nodes) for e in contexts.get("A").explorers.known.values())


def test_the_budget_bounds_how_many_states_runs_are_followed_through():
    s = counting(claim("far", Goal("can_reach", op("and", op(">", X, n("3/2")), op(">", Y, n(3))))))
    found = decide_all(s, budget=Q(1, 60))
    assert isinstance(found["far"].verdict, Unknown)
    assert followed(contexts_of(s)) <= MOST_NODES // 60


def test_the_budget_bounds_how_far_a_goal_is_followed():
    s = counting(claim("late", Goal("reach", op(">=", Y, n(20)), within=n(30))), urgent=True)
    small, usual = decide_all(s, budget=Q(1, 60)), decide_all(s)
    assert isinstance(small["late"].verdict, Unknown)
    assert isinstance(usual["late"].verdict, Proved)
