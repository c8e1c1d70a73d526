"""Verdicts on small schedules, and the checker's opinion of every certificate."""

import json
import subprocess
import sys
from fractions import Fraction as Q
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.analyses.models import X, Y, always, claim, n, op, schedule, spec

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.claim import Goal
from haverify.model.core import canonical, to_core
from haverify.model.expression import Expr

ROOT = Path(__file__).parents[3]


def checked(tmp_path, the_spec, found):
    """What `hacheck` says of each certificate."""
    (tmp_path / "certificates" / "cells").mkdir(parents=True, exist_ok=True)
    (tmp_path / "core.json").write_bytes(canonical(to_core(the_spec)))
    for name, e in found.items():
        if e.certificate is not None:
            (tmp_path / "certificates" / f"{name}.json").write_bytes(canonical(e.certificate))
        for cells, value in e.cells.items():
            (tmp_path / "certificates" / "cells" / f"{cells}.json").write_bytes(canonical(value))
    command = [sys.executable, "-m", "hacheck", str(tmp_path), "--no-report", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT / "verifier", check=False)
    return {k: v["outcome"] for k, v in json.loads(done.stdout)["claims"].items()}


def test_a_closed_bound_that_is_touched_is_kept_and_a_strict_one_is_not(tmp_path):
    automaton = schedule([[0, 4, -4]])  # 1 at x = 1/2
    s = spec(automaton, claim("closed", always(op("<=", Y, n(1)))), claim("strict", always(op("<", Y, n(1)))))
    found = decide_all(s)
    assert isinstance(found["closed"].verdict, Proved)
    assert isinstance(found["strict"].verdict, Refuted)
    assert found["strict"].verdict.margin.strict
    assert found["strict"].run.last == Q(1, 2)
    assert checked(tmp_path, s, found) == {"closed": "accepted", "strict": "accepted"}


def test_a_guard_beyond_the_domain_blocks(tmp_path):
    automaton = schedule([[0]], urgent=False, last="2")
    s = spec(automaton, claim("free", always(op("not", Expr("stuck")))))
    found = decide_all(s)
    assert isinstance(found["free"].verdict, Refuted)
    assert found["free"].run.last == 1
    assert checked(tmp_path, s, found) == {"free": "accepted"}


def test_reach_in_time_and_too_late(tmp_path):
    at = Expr("at", ("M2",))
    soon, late = Goal("reach", at, within=n(2)), Goal("reach", at, within=n("1.5"))
    s = spec(schedule([[0], [0], [0]]), claim("soon", soon), claim("late", late), claim("can", Goal("can_reach", at)))
    found = decide_all(s)
    assert [type(found[k].verdict) for k in ("soon", "late", "can")] == [Proved, Refuted, Proved]
    assert set(checked(tmp_path, s, found).values()) == {"accepted"}


def test_a_jump_that_comes_in_time_and_one_that_is_too_late(tmp_path):
    jump = Expr("jump", ("e1",))
    soon, late = Goal("reach", jump, within=n(2)), Goal("reach", jump, within=n("1.9"))
    other = Goal("reach", Expr("jump", ("none",)), within=n(2))
    s = spec(schedule([[0], [0], [0]]), claim("soon", soon), claim("late", late), claim("other", other))
    found = decide_all(s)
    assert [type(found[k].verdict) for k in ("soon", "late", "other")] == [Proved, Refuted, Refuted]
    assert set(checked(tmp_path, s, found).values()) == {"accepted"}


def test_a_premise_that_is_never_true_decides_nothing():
    never = op("implies", op("and", Expr("at", ("M0",)), Expr("at", ("M1",))), op("<", X, n(0)))
    verdict = decide_all(spec(schedule([[0], [0]]), claim("c", always(never))))["c"].verdict
    assert isinstance(verdict, Unknown)
    assert verdict.kind == "vacuous"


coefficients = st.lists(st.integers(-5, 5), min_size=1, max_size=5)


@given(st.lists(coefficients, min_size=1, max_size=3), st.integers(-8, 8), st.booleans())
@settings(max_examples=60, deadline=None, derandomize=True)
def test_verdicts_agree_with_dense_sampling(polynomials, bound, strict):
    s = spec(schedule(polynomials), claim("c", always(op("<" if strict else "<=", Y, n(bound)))))
    evidence = decide_all(s)["c"]
    values = [
        sum(c * (i + Q(k, 40)) ** d for d, c in enumerate(p)) for i, p in enumerate(polynomials) for k in range(41)
    ]
    violated = any(v >= bound if strict else v > bound for v in values)
    if isinstance(evidence.verdict, Proved):
        assert not violated
    else:
        assert isinstance(evidence.verdict, Refuted)
        run = evidence.run
        x = sum((step.dwell for step in run.steps), Q(0)) + run.last
        mode = len(run.steps) % len(polynomials)
        x -= len(run.steps) // len(polynomials) * len(polynomials)
        v = sum(c * x**d for d, c in enumerate(polynomials[mode]))
        assert v >= bound if strict else v > bound
