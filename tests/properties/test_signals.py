"""Laws of bounded STL: against a monitor that tries every instant, and against what formulas say of each other."""

import random
from fractions import Fraction as Q

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.properties.clocked import COMPARE, Bound, Jump, Machine, Walker, show, text
from tests.properties.monitor import Stay, points, truth
from tests.properties.test_clocked_laws import refused, spec_from

from haverify.analyses import clocked, signals
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted

WINDOWS = [(Q(0), Q(1)), (Q(0), Q(1, 2)), (Q(1, 2), Q(1)), (Q(1), Q(1)), (Q(0), Q(0)), (Q(0), Q(3, 2))]


@pytest.fixture(autouse=True, scope="module")
def short_searches():
    """Few shares: what is found is judged, not how far it looks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signals, "LEAVES", 4)
        patch.setattr(signals, "AT_FIRST", 60)
        patch.setattr(signals, "FURTHER", 40)
        patch.setattr(clocked, "MOST_TIMED", 120)
        yield


@st.composite
def machines(draw):
    """Machines that stay at least half a second everywhere: x is reset by every jump, y by some."""
    modes, has_y = draw(st.integers(1, 2)), draw(st.booleans())
    edges = []
    for n in range(draw(st.integers(1, 3))):
        guard = (Bound("x", draw(st.sampled_from([">=", ">=", "=="])), draw(st.sampled_from([Q(1, 2), Q(1)]))),)
        resets = (
            ("x", Q(0)),
            *([("y", draw(st.sampled_from([Q(0), (Q(0), Q(1))])))] if has_y and draw(st.booleans()) else []),
        )
        ends = draw(st.integers(0, modes - 1)), draw(st.integers(0, modes - 1))
        edges.append(Jump(f"e{n}", *ends, draw(st.booleans()), guard, resets))
    slopes = tuple(draw(st.sampled_from([Q(1), Q(-1), Q(0)])) if has_y else None for _ in range(modes))
    domains = tuple((Bound("x", "<=", draw(st.sampled_from([Q(1), Q(3, 2)]))),) for _ in range(modes))
    start = (Q(0), draw(st.sampled_from([Q(0), Q(0), Q(1, 2)])))
    return Machine(slopes, domains, tuple(edges), ((Q(0),),) * modes, start, False, draw(st.booleans()), False)


@st.composite
def atoms(draw, machine):
    """Text, the same on points, and the number it compares with."""
    kind = draw(st.sampled_from(["clock", "clock", "clock", "at", "jump", "jumped", "time"]))
    if kind == "at":
        mode = draw(st.integers(0, machine.modes - 1))
        return f"at(M{mode})", lambda p: p.stay.mode == mode, None
    if kind == "jump":
        edge = draw(st.sampled_from(machine.edges)).name
        return f"jump({edge})", lambda p: p.landed and p.stay.edge == edge, None
    if kind == "jumped":
        return "jumped", lambda p: p.landed, None
    op, c = draw(st.sampled_from(["<=", "<", ">=", ">", "=="])), Q(draw(st.integers(0, 6)), 2)
    if kind == "time":
        return f"time {op} {show(c)}", lambda p: COMPARE[op](p.time, c), c
    v = draw(st.sampled_from(machine.clocks()))
    return f"{v} {op} {show(c)}", lambda p: COMPARE[op](p.values[v], c), c


@st.composite
def formulas(draw, machine, depth=2):
    """Text, the formula for the monitor, the numbers compared with, and how far it looks."""
    op = draw(
        st.sampled_from(["globally", "eventually", "until", "globally", "eventually", "and", "or", "implies", "not"])
    )
    if depth == 0 or (depth < 2 and draw(st.integers(0, 3)) == 0):
        words, of, c = draw(atoms(machine))
        return words, of, [] if c is None else [c], Q(0)
    a = draw(formulas(machine, depth - 1))
    if op == "not":
        return f"(not {a[0]})", ("not", a[1]), a[2], a[3]
    if op in ("globally", "eventually"):
        low, high = draw(st.sampled_from(WINDOWS))
        return f"({op}[{show(low)}, {show(high)}] {a[0]})", (op, low, high, a[1]), [*a[2], low, high], a[3] + high
    b = draw(formulas(machine, depth - 1))
    if op == "until":
        low, high = draw(st.sampled_from(WINDOWS))
        words = f"({a[0]} until[{show(low)}, {show(high)}] {b[0]})"
        return words, (op, low, high, a[1], b[1]), [*a[2], *b[2], low, high], max(a[3], b[3]) + high
    return f"({a[0]} {op} {b[0]})", (op, a[1], b[1]), [*a[2], *b[2]], max(a[3], b[3])


@st.composite
def cases(draw):
    machine = draw(machines())
    return machine, [draw(formulas(machine)) for _ in range(4)], draw(st.integers(0, 2**16))


def stays_of(machine, speed, instants):
    """The dwells of a run, from its instants."""
    found = []
    for at in instants:
        slopes = {"x": speed, "y": (machine.slopes[at.mode] or Q(0)) * speed}
        if not found or at.jumps > found[-1][0]:
            clocks = {v: (at.values[v], c) for v, c in slopes.items()}
            found.append((at.jumps, at.mode, clocks, at.time, at.edge.name if at.edge else None, at.time))
        found[-1] = (*found[-1][:5], at.time)
    return [Stay(m, clocks, begin, end - begin, edge) for _, m, clocks, begin, edge, end in found]


def walked(machine, speed, run, horizon):
    """The dwells of the run that a refutation shows."""
    walker = Walker(machine, speed, Q(1), horizon, random.Random(0))
    values = {"y": Q(0), "on": Q(0), **dict(run.values)}
    found, time, mode, edge = [], Q(0), 0, None
    for step in (*run.steps, None):
        length = run.last if step is None else step.dwell
        slopes = {"x": speed, "y": (machine.slopes[mode] or Q(0)) * speed}
        found.append(Stay(mode, {v: (values[v], c) for v, c in slopes.items()}, time, length, edge))
        if step is not None:
            taken = machine.edges[sorted(range(len(machine.edges)), key=lambda n: machine.edges[n].source)[step.edge]]
            values = {v: values[v] + slopes.get(v, Q(0)) * length for v in values}
            assert taken.source == mode and walker.inside(mode, values)
            chosen = {v: to for v, to in taken.resets if not isinstance(to, tuple)}
            values = {**values, **chosen, **dict(step.values)}
            assert walker.inside(taken.target, values)
            time, mode, edge = time + length, taken.target, taken.name
    return found


def judged(formula, stays, horizon):
    """The truth at the start of a run that goes past the horizon, None where there are too many instants."""
    instants = points(stays, formula[2], formula[2], horizon)
    return None if not instants else truth(formula[1], instants)[0]


@settings(max_examples=8, deadline=None, derandomize=True)
@given(cases())
def test_verdicts_are_accepted_and_agree_with_a_monitor_that_tries_every_instant(case):
    machine, asked, seed = case
    spec = spec_from(text(machine, [f"stl {f[0]}" for f in asked]), len(asked))
    evidence = decide_all(spec)
    assert not refused(spec, evidence)
    pick = random.Random(seed)
    speed = pick.choice([Q(1, 2), Q(1), Q(2)]) if machine.has_speed else Q(1)
    for n, formula in enumerate(asked):
        found, horizon = evidence[f"c{n}"], formula[3]
        if isinstance(found.verdict, Refuted):
            k = dict(found.run.params).get("k", Q(1))
            stays = walked(machine, k, found.run, horizon)
            if stays[-1].begin + stays[-1].length > horizon:
                assert judged(formula, stays, horizon) in (False, None), (formula[0], text(machine, []))
        if isinstance(found.verdict, Proved):
            for _ in range(4):
                run = Walker(machine, speed, Q(1), horizon, pick).walk(12)
                if run is not None and run[0][-1].time > horizon:
                    stays = stays_of(machine, speed, run[0])
                    assert judged(formula, stays, horizon) in (True, None), (formula[0], text(machine, []), stays)
