"""Random systems: what is said about them agrees with an interpreter that knows nothing of zones, and is checked."""

import itertools
import json
from fractions import Fraction as Q
from math import lcm

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.analyses.random_networks import Interpreter, families, networks
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.rational import Meter
from hacheck.systems import SystemCheck, shown
from haverify.analyses.zones import decide_network
from haverify.evidence.verdict import Unknown
from haverify.model.core import to_core

SOME = st.one_of(st.none(), st.integers(0, 2))
BAD = st.tuples(st.integers(0, 2), SOME, SOME, SOME)


def decided(text):
    """The evidence for each claim of a text, each accepted by the checker where it is decided."""
    spec, _, _ = read(text)
    core = json.loads(json.dumps(to_core(spec)))
    checks = {}
    out = {}
    for claim in spec.claims:
        e = decide_network(claim, core, Q(1))
        out[claim.name] = e
        if not isinstance(e.verdict, Unknown):
            Meter.left = 60_000_000
            files = json.loads(json.dumps(e.cells))
            check = checks.setdefault(
                claim.on, SystemCheck(Core(core), next(s for s in core["systems"] if s["name"] == claim.on), None)
            )
            check.load = files.__getitem__
            data = next(c for c in core["claims"] if c["name"] == claim.name)
            word = type(e.verdict).__name__.lower()
            assert shown(data, json.loads(json.dumps(e.certificate)), check)[0] == word
    return out


def condition(bad, net):
    """A condition about modes, counters and v, as text and as a function of states."""
    m0, m1, n0, v = bad
    m0 = m0 % len(net.parts[0].domains)
    m1 = None if m1 is None else m1 % len(net.parts[1].domains)
    texts = [f"at(a.M{m0})", f"at(b.M{m1})" * (m1 is not None), f"a.n == {n0}" * (n0 is not None)]
    texts.append(f"v == {v}" * (v is not None))

    def is_bad(s):
        return s[0][0] == m0 and m1 in (None, s[0][1]) and n0 in (None, s[1][0]) and v in (None, s[2])

    return " and ".join(t for t in texts if t), is_bad


def replayed(net, run):
    """The interpreter walks a run of the evidence; the states it passes, in full."""
    machine = Interpreter(net, Q(1, 4))
    state = machine.start()
    for k, m in enumerate(run.moments):
        given_values = dict(m.values)
        wanted = (
            tuple(int(mode[1:]) for _, mode in m.modes),
            tuple(int(given_values[f"{p.name}.n"]) for p in net.parts),
            int(given_values["v"]),
            tuple(given_values[f"{p.name}.x"] for p in net.parts),
        )
        if k:
            machine.step = step_of(state, wanted)
            assert (m.names[0], wanted) in machine.jumps(state, Q(1, 10**9)), (m, state)
        state = wanted
        assert machine.allowed(state)
        state = waited(machine, state, m.dwell)
    return state


def step_of(*states):
    """A distance of which all clock values are multiples."""
    d = 1
    for s in states:
        for x in s[3]:
            d = lcm(d, x.denominator)
    return Q(1, d)


def waited(machine, state, dwell):
    """The state after some time, in which nothing urgent is due at any moment before the end."""
    marks = sorted({Q(0), *(c - x for x in state[3] for c in range(5) if 0 < c - x < dwell), dwell})
    for a, b in itertools.pairwise(marks):
        for t in (a, (a + b) / 2):
            now = (*state[:3], tuple(x + t for x in state[3]))
            assert not machine.due(now, (b - a) / 8), (state, t)
    later = (*state[:3], tuple(x + dwell for x in state[3]))
    assert machine.allowed(later)
    return later


@given(networks(closed=True), BAD)
@settings(max_examples=50, deadline=None, derandomize=True)
def test_whole_seconds_decide_closed_systems(net, bad):
    reached = Interpreter(net, Q(1)).explore()
    if reached is None:
        return
    text, is_bad = condition(bad, net)
    out = decided(f"{net.text()}\nproperty p on S {{ never {text} }}\nproperty q on S {{ can reach {text} }}")
    jumps = min((j for s, j in reached.items() if is_bad(s)), default=None)
    words = [type(out[n].verdict).__name__ for n in "pq"]
    assert words == (["Proved", "Refuted"] if jumps is None else ["Refuted", "Proved"]), out["p"].verdict
    if jumps is not None:
        run = out["p"].trace
        assert len(run.moments) - 1 == jumps
        assert is_bad(replayed(net, run))


@given(networks(closed=False), BAD)
@settings(max_examples=50, deadline=None, derandomize=True)
def test_what_is_proved_no_sampled_run_contradicts(net, bad):
    text, is_bad = condition(bad, net)
    out = decided(f"{net.text()}\nproperty p on S {{ never {text} }}\nproperty q on S {{ never stuck }}")
    words = {n: type(out[n].verdict).__name__ for n in "pq"}
    assert "Unknown" not in words.values(), (out["p"].verdict, out["q"].verdict)
    if words["p"] == "Refuted":
        assert is_bad(replayed(net, out["p"].trace))
    if words["q"] == "Refuted":
        end = replayed(net, out["q"].trace)
        machine = Interpreter(net, step_of(end) / 8)
        assert machine.is_stuck(end)
    reached = Interpreter(net, Q(1, 2)).explore(3000) or {}
    machine = Interpreter(net, Q(1, 2))
    for s in reached:
        assert not (is_bad(s) and words["p"] == "Proved")
        assert not (words["q"] == "Proved" and machine.is_stuck(s))


@given(families(), st.integers(0, 2), st.integers(0, 2), st.integers(0, 3))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_exchanges_of_parts_change_no_verdict(family, m0, m1, v):
    net = family.net()
    reached = Interpreter(net, Q(1)).explore(4000)
    if reached is None:
        return
    m0, m1 = (m % len(family.part.domains) for m in (m0, m1))
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    claims = {
        "two": (
            f"exists i in I: exists j in I: i != j and at(p[i].M{m0}) and at(p[j].M{m1}) and v == i",
            lambda s: any(s[0][i] == m0 and s[0][j] == m1 and s[2] == i + 1 for i, j in pairs),
        ),
        "one": (f"at(p[1].M{m0}) and v == {v}", lambda s: s[0][0] == m0 and s[2] == v),
        "all": (f"forall i in I: at(p[i].M{m1}) and p[i].n == 1", lambda s: set(s[0]) == {m1} and set(s[1]) == {1}),
    }
    text = "\n".join([family.text(), *(f"property {n} on S {{ never {c} }}" for n, (c, _) in claims.items())])
    out = decided(text)
    for n, (_, is_bad) in claims.items():
        jumps = min((j for s, j in reached.items() if is_bad(s)), default=None)
        assert type(out[n].verdict).__name__ == ("Proved" if jumps is None else "Refuted"), n
        if jumps is not None:
            assert len(out[n].trace.moments) - 1 == jumps
            assert is_bad(replayed(net, out[n].trace))
        elif n != "one":
            assert "up to exchanges of p[1], p[2], p[3]" in out[n].notes[0]
