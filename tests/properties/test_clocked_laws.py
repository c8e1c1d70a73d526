"""Verdicts about random machines: the checker accepts every one, no run contradicts one, less work flips none."""

import json
import random
import subprocess
import sys
import tempfile
from fractions import Fraction as Q
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.properties.clocked import COMPARE, Walker, machines, small, text

from haverify.analyses import counterexample, inevitable
from haverify.analyses.portfolio import decide_all
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.core import canonical, to_core
from haverify.syntax.parse import parse
from haverify.text.source import Source

VERIFIER = Path(__file__).parents[2] / "verifier"
HORIZON = Q(4)
SOME = Q(1, 4)  # of the usual work


@pytest.fixture(autouse=True, scope="module")
def short_searches():
    """Searches for runs and for ways to a goal give up early: what they find is judged, not how far they look."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(counterexample, "MOST_NODES", 80)
        patch.setattr(inevitable, "MOST", 60)
        yield


@st.composite
def asked(draw, modes, edges):
    """A claim: its text, and how an instant is judged (None: not by instants)."""
    c, op = draw(small) * draw(st.sampled_from([1, 3])), draw(st.sampled_from(["<=", "<", ">="]))
    mode, edge = draw(st.integers(0, modes - 1)), f"e{draw(st.integers(0, edges - 1))}"
    low = draw(st.sampled_from([Q(0), Q(1, 2), Q(2)]))

    def f(w, i):
        return COMPARE[op](w.f(i), c)

    def step(w, i):
        return i.edge is None or COMPARE[op](w.f(i) - w.f(i.before), c)

    def taken(w, i):
        return i.edge is not None and i.edge.name == edge

    def window(w, i):
        return not low <= i.time <= 3 or COMPARE[op](i.values["x"], c)

    return draw(st.sampled_from([
        ("always", f"always f {op} {c}", f),
        ("always", f"always at(M{mode}) implies f {op} {c}", lambda w, i: i.mode != mode or f(w, i)),
        ("always", f"never f {op} {c}", lambda w, i: not f(w, i)),
        ("always", f"always jumped implies f - pre(f) {op} {c}", step),
        ("always", f"always during [{low}, 3] x {op} {c}", window),
        ("always", f"within 2 jumps; always f {op} {c}", lambda w, i: i.jumps > 2 or f(w, i)),
        ("always", f"always jump({edge}) implies at(M{mode})", lambda w, i: not taken(w, i) or i.mode == mode),
        ("can", f"can reach f {op} {c} within 4", lambda w, i: i.time <= HORIZON and f(w, i)),
        ("can", f"can reach at(M{mode})", lambda w, i: i.mode == mode),
        ("reach", f"reach at(M{mode}) within 4", lambda w, i: i.mode == mode),
        ("reach", f"reach jump({edge}) within 4", taken),
        ("stuck", "never stuck", None),
    ]))  # fmt: skip


@st.composite
def cases(draw):
    machine = draw(machines())
    claims = [draw(asked(machine.modes, len(machine.edges))) for _ in range(6)]
    return machine, claims, draw(st.integers(0, 2**16))


def spec_of(machine, claims):
    return spec_from(text(machine, [c[1] for c in claims]), len(claims))


def spec_from(content, claims):
    source = Source("random.ha", content, "")
    tree, problems = parse(source)
    spec, found = elaborate(tree, Files({source.path: source}, {}, {}))
    assert not problems and all(d.code not in ("HA001", "HA002", "HA003", "HA101", "HA105") for d in found), content
    assert len(spec.claims) == claims, content
    return spec


def refused(spec, evidence):
    """The claims whose certificates `hacheck` does not accept, and why."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "certificates" / "cells").mkdir(parents=True)
        (folder / "core.json").write_bytes(canonical(to_core(spec)))
        for claim, e in evidence.items():
            if e.certificate is not None:
                (folder / "certificates" / f"{claim}.json").write_bytes(canonical(e.certificate))
            for cells, value in e.cells.items():
                (folder / "certificates" / "cells" / f"{cells}.json").write_bytes(canonical(value))
        command = [sys.executable, "-m", "hacheck", name, "--no-report", "--json"]
        done = subprocess.run(command, capture_output=True, text=True, cwd=VERIFIER, check=False)
        answers = json.loads(done.stdout)["claims"]
    return {
        c: answers[c]["reason"] for c, e in evidence.items() if e.certificate and answers[c]["outcome"] != "accepted"
    }


def contradicted(machine, claims, evidence, seed):
    """The claims that some run shows to be decided wrongly."""
    pick = random.Random(seed)
    wrong = set()
    for speed in (Q(1, 2), Q(2)) if machine.has_speed else (Q(1),):
        for amplitude in (Q(-1), Q(2)) if machine.has_amplitude else (Q(1),):
            walker = Walker(machine, speed, amplitude, HORIZON, pick)
            for _ in range(4):
                run = walker.walk()
                for n, (kind, _, judge) in enumerate(claims):
                    if run is not None and contradicts(evidence[f"c{n}"].verdict, kind, judge, walker, run):
                        wrong.add(f"c{n}")
    return wrong


def contradicts(verdict, kind, judge, walker, run):
    instants, end = run
    if kind == "stuck":
        return isinstance(verdict, Proved) and end == "stuck"
    if kind == "always":
        return isinstance(verdict, Proved) and not all(judge(walker, i) for i in instants)
    if kind == "can":
        return isinstance(verdict, Refuted) and any(judge(walker, i) for i in instants)
    missed = not any(i.time <= HORIZON and judge(walker, i) for i in instants)
    return isinstance(verdict, Proved) and missed and (end == "stuck" or instants[-1].time > HORIZON)


@given(cases())
@settings(max_examples=25, deadline=None, derandomize=True, database=None)
def test_verdicts_are_accepted_and_no_run_contradicts_them(case):
    machine, claims, seed = case
    spec = spec_of(machine, claims)
    evidence = decide_all(spec, budget=SOME)
    assert refused(spec, evidence) == {}, text(machine, [c[1] for c in claims])
    assert contradicted(machine, claims, evidence, seed) == set(), text(machine, [c[1] for c in claims])


@given(cases(), st.sampled_from([Q(1, 4000), Q(1, 400), Q(1, 40)]))
@settings(max_examples=15, deadline=None, derandomize=True, database=None)
def test_less_work_decides_less_but_not_otherwise(case, budget):
    spec = spec_of(*case[:2])
    full, less = decide_all(spec, budget=SOME), decide_all(spec, budget=budget)
    for name, e in less.items():
        assert isinstance(e.verdict, Unknown) or type(e.verdict) is type(full[name].verdict), name


EDGES = {
    "an urgent edge none of whose outcomes is possible": "urgent edge e0: -> M0 when x >= 1 do { x in [3, 4] }",
    "an urgent edge that chooses, due before its guard holds": "urgent edge e0: -> M0 when x > 1 do { x in [0, 1/2] }",
    "an urgent edge that chooses by the state": "urgent edge e0: -> M0 when x > 1 do { x in [x - 1, x - 1/2] }",
    "a plain edge that chooses": "edge e0: -> M0 when x >= 1 do { x in [1/2, 3] }",
}


@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES.keys())
def test_certificates_about_choices_are_accepted(edge):
    claims = ["never stuck", "always x <= 1", "can reach jump(e0)", "reach jump(e0) within 4", "reach x > 9 within 1"]
    mode = ["  mode M0 {", "    domain x <= 2", "    flow { x' = 1 }", "    " + edge, "  }", "}"]
    head = ['spec "random" version "1.0" unitless', "automaton A {", "  var x", "  init M0 with { x := 0 }"]
    asked_for = [f"property c{n} on A {{ {c} }}" for n, c in enumerate(claims)]
    spec = spec_from("\n".join([*head, *mode, *asked_for]) + "\n", len(claims))
    assert refused(spec, decide_all(spec, budget=SOME)) == {}
