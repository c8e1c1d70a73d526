"""A stay without end: what moves has no bounds, what stands still does."""

from tests.unit.analyses.models import X, always, claim, n, op, spec

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.expression import TRUE
from haverify.model.hybrid import Assign, FlowLine, HybridAutomaton, Init, Mode, Variable


def test_an_endless_stay_is_not_its_entry():
    mode = Mode("M", TRUE, (FlowLine("x", n(1)),), (), False)
    init = Init("M", TRUE, (Assign("x", n(0)),))
    machine = HybridAutomaton("A", (), (), (), (Variable("x", "real", None, None),), (), (init,), (mode,), (), ())
    claims = (claim("low", always(op("<=", X, n(1)))), claim("free", always(op("not", op("stuck")))))
    found = decide_all(spec(machine, *claims))
    assert isinstance(found["low"].verdict, Refuted)
    assert isinstance(found["free"].verdict, Proved)
