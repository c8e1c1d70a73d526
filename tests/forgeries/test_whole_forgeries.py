"""Systems with flows, put together by the checker: true certificates about other systems, and damaged ones."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import established
from hacheck.rational import Meter, Refused, Unreadable
from hacheck.systems import SystemCheck
from haverify.analyses.networks import lazily
from haverify.analyses.networks.whole import whole_of
from haverify.analyses.portfolio import Contexts, decide
from haverify.evidence.verdict import Proved
from haverify.model.core import to_core

Json = Any
TEXT = (Path(__file__).parent / "small" / "whole.ha").read_text()
FAULTS = (Refused, Unreadable, RecursionError, KeyError, IndexError, TypeError, ValueError, AttributeError)


class Case:
    """A core with the certificates and records of its claims, to be damaged."""

    def __init__(self, text: str, few: int) -> None:
        spec, _, _ = read(text)
        self.core: Json = json.loads(json.dumps(to_core(spec)))
        self.certificates: Json = {}
        self.files: Json = {}
        usual, lazily.FEW = lazily.FEW, few
        try:
            contexts = Contexts(spec)
            for claim in spec.claims:
                e = decide(spec, claim, contexts)
                self.certificates[claim.name] = json.loads(json.dumps(e.certificate))
                self.files |= json.loads(json.dumps(e.cells))
        finally:
            lazily.FEW = usual

    def system(self) -> Json:
        return self.core["systems"][0]

    def automaton(self, name: str) -> Json:
        return next(a for a in self.core["automata"] if a["name"] == name)

    def edge(self, name: str, edge: str) -> Json:
        return next(e for e in self.automaton(name)["edges"] if e["name"] == edge)

    def sync(self, name: str) -> Json:
        return next(s for s in self.system()["syncs"] if s["name"] == name)

    def accepted(self, claim: str, rehashed: bool = False) -> bool:
        """Whether a claim is shown; `rehashed`: with the hash that this core asks for."""
        Meter.left = 60_000_000
        try:
            core = Core(self.core)
            check = SystemCheck(core, self.system(), self.files.__getitem__, lambda n: core.claims[n])
            certificate = self.certificates[claim]
            if rehashed:
                certificate = copy.deepcopy(certificate)
                self.rehash(core, check, claim, certificate)
            found = established(core, core.claims[claim], certificate, None, lambda _: check)
            return found[0] == certificate["verdict"]
        except FAULTS:
            return False

    @staticmethod
    def rehash(core: Core, check: SystemCheck, claim: str, certificate: Json) -> None:
        """Put in the hashes that a forger would, who knows how they are made."""
        from hacheck import obligations

        told, _, setting = check.whole(core.claims[claim], certificate)
        for goal, entry in zip(told["goals"], certificate["goals"], strict=True):
            question = obligations.Question(setting, told, goal)
            if "hash" in entry:
                where = setting.a["init"][0]["mode"]
                parts = ["haverify.obligation/1", setting.hash, question.hash, "flow", where, ""]
                entry["hash"] = obligations.canonical_hash(parts)


@pytest.fixture(scope="module")
def truth() -> Case:
    return Case(TEXT, few=40)


@pytest.fixture(scope="module")
def lazy() -> Case:
    return Case(TEXT, few=1)


ALONG = ("warm", "cool", "late", "apart")


def test_the_truth_is_accepted(truth: Case, lazy: Case) -> None:
    for case in (truth, lazy):
        assert {n: case.accepted(n) for n in case.certificates} == dict.fromkeys(case.certificates, True)
        assert all(case.accepted(n, rehashed=True) for n in ALONG)
    assert all(lazy.certificates[n]["whole"] is not True for n in ALONG)
    assert all(c["whole"] is True for c in truth.certificates.values())


def _set(**values: Any) -> Callable[[Json], None]:
    return lambda d: d.update(values)


# What is said of the model, each a change of what the system does before a claim is decided.
CHANGES: dict[str, Callable[[Case], Any]] = {
    "another edge in a rendezvous": lambda c: c.sync("hand").update(edges=["a.cool", "w.note"]),
    "an edge dropped from a rendezvous": lambda c: c.sync("hand").update(edges=["a.heat"]),
    "the other edge dropped": lambda c: c.sync("hand").update(edges=["w.note"]),
    "a rendezvous for a broadcast": lambda c: c.sync("call").update(edges=["b.heat", "w.hear"], listeners=[]),
    "a listener dropped": lambda c: c.sync("call").update(listeners=[]),
    "a listener and a speaker exchanged": lambda c: c.sync("call").update(edges=["w.hear"], listeners=["b.heat"]),
    "a sync dropped": lambda c: c.system()["syncs"].pop(0),
    "a sync that never fires": lambda c: c.sync("hand").update(guard=False),
    "what a sync writes": lambda c: c.sync("hand").update(resets=[{"var": "w.seen", "to": "7"}]),
    "a priority turned round": lambda c: c.system()["priorities"][0]["over"].reverse(),
    "a priority dropped": lambda c: c.system()["priorities"].clear(),
    "a priority under a condition": lambda c: c.system()["priorities"][0].update(when=["<=", ["var", "w.seen"], "0"]),
    "a part dropped": lambda c: c.system()["parts"].pop(1),
    "a part of another kind": lambda c: c.system()["parts"][1].update(of="Lazy"),
    "parts exchanged": lambda c: c.system()["parts"].reverse(),
    "another variable read": lambda c: c.system()["parts"][0]["bindings"][-1].update(to=["var", "w.seen"]),
    "its own variable read": lambda c: c.system()["parts"][0]["bindings"][-1].update(to=["var", "a.T"]),
    "a number read": lambda c: c.system()["parts"][1]["bindings"][-1].update(to="5"),
    "another start": lambda c: c.system()["parts"][0]["bindings"][0].update(to="25"),
    "a start in another mode": lambda c: c.automaton("Room")["init"][0].update(mode="On"),
    "another flow": lambda c: c.automaton("Room")["modes"][1]["flow"][0].update(rate="-9"),
    "another domain": lambda c: c.automaton("Room")["modes"][0].update(domain=[">=", ["var", "T"], "15"]),
    "another guard": lambda c: c.edge("Room", "heat").update(guard=["<=", ["var", "T"], "19"]),
    "another target": lambda c: c.edge("Room", "heat").update(target="Off"),
    "a jump that resets": lambda c: c.edge("Room", "heat").update(resets=[{"var": "T", "to": "30"}]),
    "urgency": lambda c: c.edge("Room", "heat").update(urgent=True),
    "a terminal mode": lambda c: [m.update(terminal=True) for a in c.core["automata"] for m in a["modes"]],
    "a let of another value": lambda c: c.automaton("Room")["lets"][0].update(expr="100"),
    "another constant": lambda c: c.core["constants"][0].update(value="30"),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("kind", ["full", "as far as runs come"])
def test_a_certificate_about_another_system_is_refused(truth: Case, lazy: Case, change: str, kind: str) -> None:
    case = copy.deepcopy(truth if kind == "full" else lazy)
    CHANGES[change](case)
    assert not any(case.accepted(n) for n in case.certificates)


# Changes after which a claim is false, or its record says nothing: with the hash that belongs to them, too.
FATAL = {
    "another edge in a rendezvous": ("warm", "late"),
    "an edge dropped from a rendezvous": ("late",),
    "a sync that never fires": ("late",),
    "a part dropped": ALONG,
    "another variable read": ("warm",),
    "a number read": ("late",),
    "another start": ALONG,
    "a start in another mode": ALONG,
    "another flow": ("warm",),
    "another guard": ("warm", "apart"),
    "a terminal mode": ALONG,
    "what a sync writes": ALONG,
    "another constant": ("warm",),
}


@pytest.mark.parametrize("change", FATAL)
def test_what_is_false_of_it_is_refused_with_the_right_hash(truth: Case, lazy: Case, change: str) -> None:
    for case in map(copy.deepcopy, (truth, lazy)):
        CHANGES[change](case)
        assert not any(case.accepted(n, rehashed=True) for n in FATAL[change]), change


def _file(c: Case, claim: str) -> Json:
    return c.files[c.certificates[claim]["goals"][0]["flow"]]


def _pieces(c: Case, claim: str = "warm") -> Json:
    return _file(c, claim)["starts"][0]["pieces"]


DAMAGES: dict[str, Callable[[Case], Any]] = {
    "the mode of the start left out": lambda c: c.certificates["warm"].update(whole=[]),
    "a mode left out": lambda c: c.certificates["warm"]["whole"].pop(),
    "a mode that is none": lambda c: c.certificates["warm"]["whole"].append("a.On"),
    "a mode of parts in another order": lambda c: c.certificates["warm"]["whole"].append("w.Idle, a.Off, b.Off"),
    "all modes": lambda c: c.certificates["warm"].update(whole=True),
    "modes as one text": lambda c: c.certificates["warm"].update(whole=c.certificates["warm"]["whole"][0]),
    "no word of a system": lambda c: c.certificates["warm"].pop("whole"),
    "a number for the modes": lambda c: c.certificates["warm"].update(whole=1),
    "the record of another claim": lambda c: c.certificates["warm"]["goals"][0].update(
        flow=c.certificates["late"]["goals"][0]["flow"]
    ),
    "a jump by another edge": lambda c: _pieces(c)["jumps"][0].update(edge=_pieces(c)["jumps"][0]["edge"] + 1),
    "no jump": lambda c: _pieces(c).pop("jumps"),
    "a step left out": lambda c: _pieces(c)["steps"].pop(),
    "another automaton": lambda c: _file(c, "warm").update(automaton="Room"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_certificates_are_refused(lazy: Case, damage: str) -> None:
    case = copy.deepcopy(lazy)
    DAMAGES[damage](case)
    assert not case.accepted("warm")
    assert damage in ("no word of a system", "all modes") or not case.accepted("warm", rehashed=True)


def test_an_invariant_needs_all_modes(truth: Case) -> None:
    case = copy.deepcopy(truth)
    case.certificates["bounded"]["whole"] = ["a.Off, b.Off, w.Idle"]
    assert not case.accepted("bounded")


HIDDEN = """spec "t" version "1.0" unitless
automaton A {
  var x
  init Down where 0 <= x <= 1
  mode Down { flow { x' = -x } }
  mode Up { flow { x' = x } }
}
automaton B {
  var y
  init Down where 0 <= y <= 1
  mode Down { flow { y' = -y }; edge turn: -> Flat }
  mode Flat { flow { y' = 0 } }
}
system S {
  part a = A
  part b = B
}
invariant low on S: a.x <= 1 inductive
invariant held on S: b.y <= 1 inductive
invariant low_so_far on S: a.x <= 1
"""


def test_what_is_inductive_is_kept_in_modes_that_no_edge_leads_to() -> None:
    case = Case(HIDDEN, few=40)
    assert case.certificates["low"] is None
    assert case.accepted("held") and case.accepted("low_so_far")


def test_modes_that_no_edge_leads_to_are_not_left_out_of_what_is_inductive() -> None:
    spec, _, _ = read(HIDDEN)
    case = Case(HIDDEN, few=40)
    inner = whole_of(spec, "S", to_core(spec))
    reached = [m.name for m in inner.automata[0].modes]
    assert reached == ["a.Down, b.Down", "a.Down, b.Flat"]
    for name in ("low", "held"):
        found = decide(inner, next(c for c in inner.claims if c.name == name), Contexts(inner))
        assert isinstance(found.verdict, Proved)
        for whole in (True, reached):
            case.certificates[name] = json.loads(json.dumps({**found.certificate, "whole": whole}))
            assert not case.accepted(name)


BOUNCES = """spec "t" version "1.0" unitless
param kept in [0.4, 0.5]
automaton Ball {
  var h
  var v
  init Fly where h == 5 and v == 0
  mode Fly {
    domain h >= 0
    flow { h' = v; v' = -10 }
    urgent edge bounce: -> Fly when h <= 0 and v < 0 do v := -kept * v
  }
}
automaton Lamp {
  param speed in [1, 2]
  var lit
  init On where lit == 0
  mode On { flow { lit' = speed } }
}
system S {
  part ball = Ball
  part lamp = Lamp
}
property waits on S { reach time >= 4 within 4 }
property waits_less on S { reach time >= 2 within 4 }
"""
UNMET: dict[str, Callable[[Case], Any]] = {
    "a start that is none": lambda c: _start(c).update(values={**_start(c)["values"], "ball.h": "6"}),
    "another start than the invariant is of": lambda c: _start(c).update(params={**_start(c)["params"], "kept": "2/5"}),
    "a param out of its range": lambda c: _start(c).update(params={**_start(c)["params"], "lamp.speed": "3"}),
    "no value of a param": lambda c: _start(c)["params"].pop("lamp.speed"),
    "no value of a variable": lambda c: _start(c)["values"].pop("lamp.lit"),
    "a mode that is none": lambda c: _start(c).update(mode="ball.Fly"),
    "the claim on another goal": lambda c: c.core["claims"][0]["goals"][0].update(within="3"),
    "another ball": lambda c: c.edge("Ball", "bounce")["resets"][0].update(to=["*", "-4/5", ["var", "v"]]),
    "another lamp": lambda c: c.automaton("Lamp")["params"][0].update(low="9/5", high="9/5"),
    "no invariant": lambda c: c.certificates["waits"]["goals"][0].update(invariant={}),
    "modes left out": lambda c: c.certificates["waits"].update(whole=[]),
}


def _start(c: Case) -> Json:
    return c.certificates["waits"]["goals"][0]["start"]


@pytest.fixture(scope="module")
def bounces() -> Case:
    return Case(BOUNCES, few=40)


def test_goals_that_parts_never_meet_are_refuted(bounces: Case) -> None:
    assert bounces.certificates["waits"]["goals"][0]["kind"] == "unmet"
    assert bounces.certificates["waits"]["verdict"] == "refuted" and bounces.accepted("waits")


def test_a_start_that_meets_the_goal_does_not_refute_it(bounces: Case) -> None:
    case = copy.deepcopy(bounces)
    case.certificates["waits_less"] = {**case.certificates["waits"], "claim": "waits_less"}
    assert not case.accepted("waits_less")


@pytest.mark.parametrize("damage", UNMET)
def test_damaged_refutations_of_goals_are_refused(bounces: Case, damage: str) -> None:
    case = copy.deepcopy(bounces)
    UNMET[damage](case)
    assert not case.accepted("waits")
