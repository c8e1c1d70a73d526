"""Damaged certificates of periodic orbits with jumps, none of which hacheck shows; what it derives by itself."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.forgeries.test_orbit_forgeries import (
    Damage,
    Json,
    entry_of,
    made,
    on_automaton,
    on_core,
    refused,
    shown,
    with_entry,
)

from hacheck.core import Core
from hacheck.laps import Lap, Laps
from hacheck.obligations import Question, Setting
from hacheck.orbits import _come_in, _contracts, _narrow, _returns
from hacheck.rational import Refused
from hacheck.sections import ONE, section_of

# A circle cut in two: on the way over y == 0 upwards x comes to 1/2 times as far from 1.
KICKED = """automaton A {
  var x; var y
  init Up where x == 1 and y == 0
  mode Up { domain y >= 0; flow { x' = -y; y' = x }; edge down: -> Down when y == 0 and x < 0 }
  mode Down { domain y <= 0; flow { x' = -y; y' = x }; edge up: -> Up when y == 0 and x > 0 do x := 1 + K * (x - 1) }
}"""
SETTLES, LEAVES = KICKED.replace("K", "1/2"), KICKED.replace("K", "(-2)")
# A ball that is thrown up at each impact: v becomes 2 - v / 2, so it lands with -4 and starts with 4.
THROWN = """automaton A {
  var h; var v
  init M where h == 1 and v == 0
  mode M {
    domain h >= 0
    flow { h' = v; v' = -9.81 }
    urgent edge bounce: -> M when h == 0 and v < 0 do v := 2 - 0.5 * v
  }
}"""
# Van der Pol's oscillator, on the left with twice its speed: on the same ways, so its multiplier is the same.
HASTY = """automaton A {
  var x; var y
  init Right where x == 2 and y == 0
  mode Right { domain x >= 0; flow { x' = y; y' = (1 - x^2) * y - x }; edge out: -> Left when x == 0 and y < 0 }
  mode Left {
    domain x <= 0
    flow { x' = 2 * y; y' = 2 * ((1 - x^2) * y - x) }
    edge home: -> Right when x == 0 and y > 0
  }
}"""
# A clock that is set back at 1, where x is halved and gets one more.
TICK = """automaton A {
  var c; var x
  init M with { c := 0; x := 0 }
  mode M { domain c <= 1; flow { c' = 1; x' = -x }; urgent edge tick: -> M when c == 1 do { c := 0; x := x / 2 + 1 } }
}"""
# Of three variables, with a border that is crossed askew, and a reset that mixes them.
ASKEW = """automaton A {
  var c; var x; var y
  init M with { c := 0; x := 1; y := 0 }
  mode M {
    domain c + x / 4 <= 1
    flow { c' = 1; x' = -x + y; y' = -x - y }
    urgent edge tick: -> M when c + x / 4 == 1 do { c := 0; x := 1 + y / 2; y := x / 3 }
  }
}"""
UP = "cycle through jump(up) and 0.9 <= x <= 1.1 and abs(y) <= 0.1 within 7"
BOUNCE = "cycle through jump(bounce) and 3.99 <= v <= 4.01 and abs(h) <= 0.001 within 1"
HALF = "cycle through at(Right) and y == 0 and 2 <= x <= 2.02 within 7"
MIDDLE = "cycle through c == 1/2 and 0 <= x <= 2 within 1.1"
AHEAD = "cycle through jump(tick) and 0 <= x <= 2 within 2"
CASES = [
    (SETTLES, f"{UP} attracting"), (LEAVES, UP), (THROWN, f"{BOUNCE} attracting"), (HASTY, HALF),
    (TICK, f"{MIDDLE} attracting"), (ASKEW, AHEAD),
]  # fmt: skip


@pytest.mark.parametrize(("automaton", "claim"), CASES)
def test_what_is_proved_is_shown(automaton: str, claim: str) -> None:
    assert shown(*json.loads(made(automaton, claim))) == "proved"


# What the checker derives


def lap_of(automaton: str, claim: str) -> tuple[Laps, Lap]:
    """The lap that a certificate records, as the checker follows it."""
    core, certificate, files = json.loads(made(automaton, claim))
    known, entry = Core(core), entry_of(certificate)
    setting = Setting(known, known.data["automata"][0], False, files.__getitem__)
    question = Question(setting, known.data["claims"][0], known.data["claims"][0]["goals"][0])
    laps = Laps(question, entry["flow"], section_of(entry, question.scope.types, question.scope.modes), varied=True)
    return laps, laps.whole(files[entry["flow"]]["starts"][0]["pieces"])


@pytest.mark.parametrize(
    ("automaton", "claim", "period", "multiplier"),
    [(LEAVES, UP, 2 * math.pi, -2), (THROWN, BOUNCE, 8 / 9.81, 0.5), (TICK, MIDDLE, 1, 1 / (2 * math.e)),
     (HASTY, HALF, 3 / 4 * 6.663286859323, 0.0008596950636)],
)  # fmt: skip
def test_derivatives_across_jumps_are_those_that_are_known(
    automaton: str, claim: str, period: float, multiplier: float
) -> None:
    """Also where rates differ on both sides of a border that is crossed at an instant of each run's own."""
    _, lap = lap_of(automaton, claim)
    (((low, high),),) = lap.slopes
    assert low - Fraction(1, 10**9) <= multiplier <= high + Fraction(1, 10**9) and high - low < Fraction(1, 100)
    assert lap.time[0] - Fraction(1, 10**9) <= period <= lap.time[1] + Fraction(1, 10**9)


def runs(c: float, x: float, y: float, until: Callable[[float, float], float]) -> tuple[float, float, float]:
    """A run of ASKEW's flow up to where a function is zero, by its solution `exp(-t)` times a turn."""
    low, high = 0.0, 3.0

    def at(t: float) -> tuple[float, float, float]:
        e, co, si = math.exp(-t), math.cos(t), math.sin(t)
        return c + t, e * (co * x + si * y), e * (co * y - si * x)

    for _ in range(200):
        t = (low + high) / 2
        low, high = (t, high) if until(*at(t)[:2]) < 0 else (low, t)
    return at(low)


def test_a_lap_with_an_askew_border_is_as_by_the_solutions() -> None:
    """Ends and derivatives hold what the known solutions give for corners of the section, and differences of it."""
    laps, lap = lap_of(ASKEW, AHEAD)
    s = laps.section
    value, names = float(s.value), list(s.centre)
    assert s.variable == "x", "x falls on the section"

    def returned(w: list[float]) -> list[float]:
        state = {s.variable: value}
        for v, row in zip(names, s.basis, strict=True):
            state[v] = float(s.centre[v]) + sum(float(q) * x for q, x in zip(row, w, strict=True))
        _, x, y = runs(state["c"], state["x"], state["y"], lambda c, x: c + x / 4 - 1)
        end = dict(zip("cxy", runs(0.0, 1 + y / 2, x / 3, lambda _, x: value - x), strict=True))
        apart = [end[v] - float(s.centre[v]) for v in names]
        return [sum(float(q) * d for q, d in zip(row, apart, strict=True)) for row in s.back]

    for w in ([0.0, 0.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [0.3, -0.7]):
        off = Fraction(1, 10**6)  # floats, in units of a section that is 1e-6 of the state
        assert all(low - off <= x <= high + off for (low, high), x in zip(lap.end, returned(w), strict=True))
    for j in range(2):
        w = [0.0, 0.0]
        w[j] = 1.0
        ends = zip(returned(w), returned([-x for x in w]), strict=True)
        for (low, high), (more, less) in zip((row[j] for row in lap.slopes), ends, strict=True):
            assert low - Fraction(1, 10**4) <= (more - less) / 2 <= high + Fraction(1, 10**4)
            assert high - low < Fraction(1, 100)


def test_a_variable_that_is_zero_at_a_border_is_exactly_that() -> None:
    _, lap = lap_of(SETTLES, f"{UP} attracting")
    assert len(lap.jumps) == 2
    for _, found in lap.jumps:
        assert found.states["y"].radius == 0 and not any(found.states["y"].parts.values())


rationals = st.fractions(-3, 3, max_denominator=7)


@settings(deadline=None)
@given(st.lists(st.lists(rationals, min_size=3, max_size=3), min_size=3, max_size=3))
def test_coordinates_of_a_section_are_undone_exactly(basis: list[list[Fraction]]) -> None:
    entry = {"mode": "M", "section": ["v", "1"], "centre": dict.fromkeys("abc", "0"),
             "basis": [[str(q) for q in row] for row in basis]}  # fmt: skip
    (a, b, c), (d, e, f), (g, h, i) = basis
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) == 0:
        with pytest.raises(Refused):
            section_of(entry, "abcv", ["M"])
        return
    back = section_of(entry, "abcv", ["M"]).back
    columns = list(zip(*basis, strict=True))
    found = [[sum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in back]
    assert found == [[int(i == j) for j in range(3)] for i in range(3)]


# Damage


def on_stretch(change: Callable[[Json], None], jumps: int = 0, word: str = "flow") -> Damage:
    """The stretch after some jumps."""

    def damage(core: Json, certificate: Json, files: Json) -> None:
        node = files[entry_of(certificate)[word]]["starts"][0]["pieces"]
        for _ in range(jumps):
            (node,) = node["jumps"]
        change(node)

    return damage


def on_starts(change: Callable[[list[Json]], None], word: str = "basin") -> Damage:
    return lambda core, certificate, files: change(files[entry_of(certificate)[word]]["starts"])


def moved(variable: int, by: int = 1 << 44) -> Callable[[Json], None]:
    """Where a stretch after a jump begins is changed."""

    def change(node: Json) -> None:
        row = node["x"][variable]
        node["x"][variable] = [(row[0] if row else 0) + by, *row[1:]]

    return change


def skipped(node: Json) -> None:
    """The stretch goes on as the one after the jump does, without it."""
    (after,) = node.pop("jumps")
    node["steps"] += after["steps"]
    node.update({"jumps": after["jumps"]} if "jumps" in after else {})


def out_and_in(node: Json) -> None:
    """Two jumps are left out: the stretch goes on as that after them."""
    ((after,),) = (j["jumps"] for j in node["jumps"])
    node.pop("jumps")
    node["steps"] += after["steps"]


def shifted(node: Json) -> None:
    node["steps"][2]["x"][0][0][0] += 1 << 40


def bent(node: Json) -> None:
    """Of the derivatives by the start, which come after the two variables."""
    node["steps"][2]["x"][2][0] = [1 << 42]


def slower(node: Json) -> None:
    h = node["steps"][2]["h"]
    node["steps"][2]["h"] = [h[0] * 2, *h[1:]] if isinstance(h, list) else h * 2


OF_CERTIFICATES: dict[str, Damage] = {
    "another mode of the section": with_entry(mode="Down"),
    "no mode of the section": with_entry(mode="Away"),
    "another variable of the section": with_entry(section=["y", "1"], centre={"x": "0"}),
    "another value of the section": with_entry(section=["x", "1/5"]),
    "a section around another state": with_entry(centre={"y": "3/2"}),
    "a section too wide": with_entry(basis=[["2"]]),
    "a section of one state": with_entry(basis=[["0"]]),
    "the period of two laps": with_entry(period=["12", "13"]),
    "a period too narrow": with_entry(period=["6.28318530717", "6.28318530718"]),
    "a period longer than claimed": with_entry(period=["6", "8"]),
    "an understated factor": with_entry(factor="1/3"),
    "Newton's method with the inverse of nothing": with_entry(factor=None),
    "no basin": lambda core, certificate, files: entry_of(certificate).pop("basin"),
    "no shares": lambda core, certificate, files: entry_of(certificate).pop("shares"),
    "a basin to a larger section": with_entry(shares=["3"]),
    "a larger section without a lap": with_entry(shares=["3", "1"]),
    "the lap as the basin": lambda core, certificate, files: entry_of(certificate).update(
        basin=entry_of(certificate)["flow"]
    ),
    "a jump left out": on_stretch(skipped),
    "both jumps left out": on_stretch(out_and_in),
    "no jump at a border": on_stretch(lambda n: n.update(jumps=[])),
    "an end at a border": on_stretch(lambda n: n.pop("jumps")),
    "another edge": on_stretch(lambda n: n["jumps"][0].update(edge=1)),
    "an edge that is none": on_stretch(lambda n: n["jumps"][0].update(edge=7)),
    "an edge that is a word": on_stretch(lambda n: n["jumps"][0].update(edge="0")),
    "an edge twice": on_stretch(lambda n: n.update(jumps=n["jumps"] * 2)),
    "another landing": on_stretch(moved(0), 2),
    "another derivative after a jump": on_stretch(moved(2), 2),
    "another derivative of the border's variable": on_stretch(moved(3), 1),
    "a landing without derivatives": on_stretch(lambda n: n.update(x=n["x"][:2]), 1),
    "a changed coefficient after a jump": on_stretch(shifted, 1),
    "a changed derivative": on_stretch(bent, 1),
    "a longer step": on_stretch(slower, 1),
    "a step too few before a border": on_stretch(lambda n: n["steps"].pop(), 1),
    "a step too few after a jump": on_stretch(lambda n: n["steps"].pop(0), 2),
    "a step too few before the section": on_stretch(lambda n: n["steps"].pop(), 2),
    "a jump after the end": on_stretch(lambda n: n.update(jumps=[{"edge": 0, "x": n["x"], "steps": n["steps"]}]), 2),
    "a basin without states": on_starts(lambda s: s.clear()),
    "a basin with more states": on_starts(lambda s: s.append(s[0])),
    "a basin with a changed coefficient": on_stretch(shifted, 0, "basin"),
}  # fmt: skip


def edge(name: str, change: Callable[[Json], None]) -> Damage:
    return on_automaton(lambda a: change(next(e for e in a["edges"] if e["name"] == name)))


def goal(**changed: Json) -> Damage:
    return on_core(lambda c: c["claims"][0]["goals"][0].update(changed))


def also(e: Json) -> Damage:
    """One more conjunct of the claim's condition."""
    return on_core(lambda c: c["claims"][0]["goals"][0]["condition"].append(e))


def more_edges(name: str, guard: Json, urgent: bool, mode: str = "Up") -> Damage:
    new = {"name": name, "source": mode, "target": "Down", "urgent": urgent, "guard": guard, "resets": []}
    return on_automaton(lambda a: a["edges"].append(new))


X, Y = ["var", "x"], ["var", "y"]
UP_AGAIN = ["and", ["==", Y, "0"], [">", X, "0"]]
NEARLY_DOWN = ["and", [">", Y, "0"], ["<=", Y, "1/1000"], ["<", X, "0"]]
# What the hash forbids, were it not there.
OF_MODELS: dict[str, Damage] = {
    "another reset": edge("up", lambda e: e.update(resets=[{"var": "x", "to": ["+", "1", ["-", X, "1"]]}])),
    "a reset to elsewhere": edge("up", lambda e: e.update(resets=[{"var": "x", "to": "2"}])),
    "a reset with a choice": edge("up", lambda e: e.update(resets=[{"var": "x", "low": "1", "high": "1"}])),
    "a reset with a corner": edge("up", lambda e: e["resets"][0].update(to=["abs", e["resets"][0]["to"]])),
    "no reset": edge("up", lambda e: e.update(resets=[])),
    "a reset of what the other edge keeps": edge("down", lambda e: e.update(resets=[{"var": "x", "to": "-1"}])),
    "another guard": edge("up", lambda e: e.update(guard=["and", ["==", Y, "0"], [">", X, "2"]])),
    "a guard on neither side": edge("up", lambda e: e.update(guard=["and", ["==", Y, "0"], [">", X, "1"]])),
    "a guard that holds before": edge("up", lambda e: e.update(guard=["<=", Y, "0"])),
    "a guard that reads the time": edge("up", lambda e: e.update(guard=["and", UP_AGAIN, [">=", ["time"], "0"]])),
    "another target": edge("up", lambda e: e.update(target="Down")),
    "another edge at the border": more_edges("side", UP_AGAIN, False, "Down"),
    "an edge on the way": more_edges("side", [">=", Y, "1/2"], False),
    "an urgent edge on the way": more_edges("side", [">=", Y, "1/2"], True),
    "an edge just before a border": more_edges("side", NEARLY_DOWN, False),
    "a param": on_automaton(lambda a: a["params"].append({"name": "k", "low": "0", "high": "1"})),
    "a bound beside the jump that is none": goal(
        condition=["and", ["jump", "up"], ["or", ["jump", "up"], [">=", X, "9/10"]],
                   ["or", ["jump", "up"], ["<=", X, "11/10"]], ["<=", ["abs", Y], "1/10"]]
    ),
    "a flow after a jump": on_automaton(lambda a: a["modes"][1]["flow"][0].update(rate=["*", "-9/10", Y])),
    "a flow before a jump": on_automaton(lambda a: a["modes"][0]["flow"][1].update(rate=["*", "9/10", X])),
    "a domain that is left before": on_automaton(
        lambda a: a["modes"][0].update(domain=["and", [">=", Y, "0"], ["<=", Y, "1/2"]])
    ),
    "another border": on_automaton(lambda a: a["modes"][0].update(domain=[">=", Y, "-1/10"])),
    "a landing outside of the domain": on_automaton(lambda a: a["modes"][1].update(domain=["<=", Y, "-1/10"])),
    "a declared range that is left": on_automaton(lambda a: a["vars"][0].update(low="-1/2", high="2")),
    "a terminal mode": on_automaton(lambda a: a["modes"][0].update(terminal=True)),
    "a priority": on_automaton(lambda a: a["priorities"].append({"over": ["up", "down"], "when": True})),
    "another jump": goal(condition=["and", ["jump", "down"], [">=", X, "9/10"], ["<=", X, "11/10"]]),
    "a condition beside the orbit": also([">=", X, "101/100"]),
    "a condition that holds on the orbit's border": also([">=", X, "1"]),
    "a condition without the jump": on_core(lambda c: c["claims"][0]["goals"][0]["condition"].pop(1)),
    "a condition about what was before": also([">", ["pre", X], "0"]),
    "other jumps as well": goal(condition=["or", ["jump", "up"], ["jump", "down"]]),
    "too short a time": goal(within="6"),
    "an assumption": on_core(lambda c: c["claims"][0]["assume"].append([">=", X, "0"])),
}  # fmt: skip


@pytest.mark.parametrize("name", OF_CERTIFICATES)
def test_damaged_certificates_are_not_shown(name: str) -> None:
    refused(SETTLES, f"{UP} attracting", OF_CERTIFICATES[name])


@pytest.mark.parametrize("name", OF_MODELS)
def test_other_models_are_not_shown_even_without_hashes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Question, "same", lambda *_: None)
    refused(SETTLES, f"{UP} attracting", OF_MODELS[name])


def test_wider_starts_of_the_same_jump_are_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """The claim's condition is of more states than the record leads into the section."""
    monkeypatch.setattr(Question, "same", lambda *_: None)
    wide = ["and", ["jump", "up"], [">=", X, "1/2"], ["<=", X, "3/2"], ["<=", ["abs", Y], "1/10"]]
    refused(SETTLES, f"{UP} attracting", goal(condition=wide))


@pytest.mark.parametrize("name", ["a jump left out", "another landing", "another derivative after a jump"])
def test_damaged_fixed_points_are_not_shown(name: str) -> None:
    refused(LEAVES, UP, OF_CERTIFICATES[name])


BESIDE = ("a condition beside the orbit", "another jump")


@pytest.mark.parametrize("name", BESIDE)
def test_orbits_that_do_not_meet_the_condition_are_not_shown(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Question, "same", lambda *_: None)
    refused(LEAVES, UP, OF_MODELS[name])


def ending(low: str, high: str, slope: str = "0", centre: str = "0") -> Lap:
    """A lap in one coordinate."""
    middle = Fraction(centre), Fraction(centre)
    return Lap((ONE, ONE), [(Fraction(low), Fraction(high))], [[(Fraction(slope), Fraction(slope))]], [middle], [])


def test_what_contracts_comes_into_itself_and_tells_where_the_fixed_point_is() -> None:
    half = Fraction(1, 2)
    share = _contracts(ending("-1", "1", "-1/2", "1/10"), half)
    assert Fraction(1, 5) < share < Fraction(1, 4)
    assert _contracts(ending("-1", "1", "1/2", "3/4"), half) == 1
    for lap in (ending("0", "2"), ending("-2", "0"), ending("0", "1", "-3/4"), ending("0", "1", "3/4")):
        with pytest.raises(Refused):
            _contracts(lap, half)
    with pytest.raises(Refused):
        _contracts(ending("0", "0"), ONE)


def test_newtons_method_needs_the_interior() -> None:
    _returns(ending("0", "0", "3", "1/4"), [[Fraction(1, 2)]])  # R(w) = 3 w + 1/4, whose fixed point is -1/8
    for centre in ("2", "-3"):  # fixed points -1, 3/2
        with pytest.raises(Refused):
            _returns(ending("0", "0", "3", centre), [[Fraction(1, 2)]])


def test_runs_from_the_condition_have_to_come_to_the_section(monkeypatch: pytest.MonkeyPatch) -> None:
    """And from larger sections to smaller ones, as large as is said."""

    def laps(end: str) -> Any:
        record = SimpleNamespace(data={"starts": [{"pieces": None}]})
        lap = ending("0", end)
        return SimpleNamespace(record=record, parted=lambda *_: [lap], whole=lambda *_: lap)

    monkeypatch.setattr("hacheck.orbits._areas", lambda *_: [("M", {})])
    shares = [Fraction(3), Fraction(2)]
    _come_in(SimpleNamespace(), laps("3"), shares[0])
    _narrow(laps("2"), shares)
    with pytest.raises(Refused):
        _come_in(SimpleNamespace(), laps("4"), shares[0])
    with pytest.raises(Refused):
        _narrow(laps("3"), shares)
    with pytest.raises(Refused):
        _narrow(laps("2"), [*shares, ONE])


def test_a_repelling_orbit_is_not_shown_to_attract(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Question, "same", lambda *_: None)
    refused(LEAVES, UP, goal(attracting=True))


def test_the_derivative_of_a_walkers_step_is_that_of_the_literature() -> None:
    """Two jumps, one of which mixes all variables: multipliers -0.19 +- 0.56i, and none of what the impact forgets."""
    text = (Path(__file__).parents[2] / "spec" / "walker.ha").read_text()
    automaton = text[text.index("const slope") : text.index("/// From every start")].replace("Walker {", "A {")
    _, lap = lap_of(automaton, "cycle through jump(strike) and 0.2 <= theta <= 0.21 within 3.9")
    slopes = [[(float(low) + float(high)) / 2 for low, high in row] for row in lap.slopes]
    assert max(high - low for row in lap.slopes for low, high in row) < Fraction(1, 100)
    found = sorted(np.linalg.eigvals(np.array(slopes)), key=lambda m: m.imag)
    for multiplier, known in zip(found, (-0.1900998411 - 0.5575987767j, 0, -0.1900998411 + 0.5575987767j), strict=True):
        assert abs(multiplier - known) < 1e-4
