"""Damages to certificates about systems, and true certificates about other systems: the checker accepts none."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from fractions import Fraction as Q
from pathlib import Path
from typing import Any

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.rational import Meter, Refused, Unreadable
from hacheck.systems import SystemCheck, obligation, shown
from haverify.analyses.zones import decide_network
from haverify.model.core import to_core

TEXT = (Path(__file__).parent / "small" / "network.ha").read_text()
FAULTS = (Refused, Unreadable, RecursionError, KeyError, IndexError, TypeError, ValueError, AttributeError)
Json = Any


class Case:
    """A core with the certificates and states of all its claims; copies may be damaged."""

    def __init__(self, text: str) -> None:
        spec, _, _ = read(text)
        self.core: Json = json.loads(json.dumps(to_core(spec)))
        self.certificates: Json = {}
        self.files: Json = {}
        for claim in spec.claims:
            e = decide_network(claim, self.core, Q(1))
            self.certificates[claim.name] = json.loads(json.dumps(e.certificate))
            self.files.update(json.loads(json.dumps(e.cells)))

    def states(self, claim: str) -> Json:
        """The file of states that a claim rests on."""
        return self.files[self.certificates[claim]["goals"][0]["states"]]

    def run(self, claim: str) -> Json:
        return self.certificates[claim]["goals"][0]["run"]

    def system(self, name: str) -> Json:
        return next(s for s in self.core["systems"] if s["name"] == name)

    def automaton(self, name: str) -> Json:
        return next(a for a in self.core["automata"] if a["name"] == name)

    def claim(self, name: str) -> Json:
        return next(c for c in self.core["claims"] if c["name"] == name)

    def rehash(self) -> None:
        """Give every certificate the hash that the core asks for: it is what is shown that has to be wrong."""
        core = Core(self.core)
        for c in self.core["claims"]:
            if c["name"] in self.certificates:
                self.certificates[c["name"]]["goals"][0]["hash"] = obligation(core, c, c["goals"][0])

    def accepted(self, claim: str) -> bool:
        Meter.left = 30_000_000
        try:
            core = Core(self.core)
            check = SystemCheck(core, core.systems[core.claims[claim]["on"]], self.files.__getitem__)
            certificate = self.certificates[claim]
            return shown(core.claims[claim], certificate, check)[0] == certificate["verdict"]
        except FAULTS:
            return False


@pytest.fixture(scope="module")
def truth() -> Case:
    return Case(TEXT)


def test_the_truth_is_accepted(truth: Case) -> None:
    accepted = {c["name"]: truth.accepted(c["name"]) for c in truth.core["claims"]}
    assert accepted == dict.fromkeys(truth.certificates, True)
    verdicts = {c["verdict"] for c in truth.certificates.values()}
    assert verdicts == {"proved", "refuted"}
    assert any(f["symmetry"] for f in truth.files.values())


def states_damages(case: Case, claim: str) -> Iterator[tuple[str, Callable[[Json], None]]]:
    """Changes of a file of states that make it incomplete, or say of other states what is true of these."""
    data = case.states(claim)
    yield "schema", lambda d: d.update(schema="haverify.states/2")
    yield "system", lambda d: d.update(system="B" if d["system"] == "F" else "F")
    yield "scale", lambda d: d.update(scale=2 * d["scale"])
    yield "scale 0", lambda d: d.update(scale=0)
    yield "no starts", lambda d: d.update(starts=[])
    yield "no states", lambda d: d.update(states=[])
    yield "ends early", lambda d: d.update(time="1")
    if data["jumps"] is None:
        yield "no jumps", lambda d: (d.update(jumps=0), [s.update(jumps=0) for s in d["states"]])
    for k, s in list(enumerate(data["states"]))[:: len(data["states"]) // 6 + 1]:
        yield f"state {k} dropped", lambda d, k=k: d["states"].pop(k)
        yield f"state {k} in another mode", lambda d, k=k: d["states"][k]["at"].__setitem__(0, "Nowhere")
        yield f"state {k} short", lambda d, k=k: d["states"][k]["at"].pop()
        if s["next"]:
            yield f"state {k} leads nowhere", lambda d, k=k: d["states"][k].update(next=[])
            yield f"state {k} leads beyond", lambda d, k=k: d["states"][k].update(next=[[[], 10**6]])
            yield f"state {k} leads behind", lambda d, k=k: d["states"][k].update(next=[[[], -1]])
        for i, b in enumerate(s["zone"]):
            if b is None or b == 1:
                continue
            yield f"state {k} bound {i} tighter", lambda d, k=k, i=i: _add(d["states"][k]["zone"], i, -1)
            yield f"state {k} bound {i} far", lambda d, k=k, i=i: _add(d["states"][k]["zone"], i, -(10**6))


def _add(zone: list[int], i: int, by: int) -> None:
    zone[i] += by


@pytest.mark.parametrize("claim", ["exclusion", "moves", "few", "lit", "soon", "in_order"])
def test_damaged_states_are_refused(truth: Case, claim: str) -> None:
    seen = 0
    for name, damage in states_damages(truth, claim):
        forged = copy.copy(truth)
        name_of = truth.certificates[claim]["goals"][0]["states"]
        forged.files = {**truth.files, name_of: copy.deepcopy(truth.states(claim))}
        damage(forged.states(claim))
        assert not forged.accepted(claim), name
        seen += 1
    assert seen >= 20


def run_damages(run: Json) -> Iterator[tuple[str, Callable[[Json], None]]]:
    """Changes after which a run is none, or ends elsewhere."""
    yield "negative end", lambda r: r.update(last="-1")
    yield "end at 1/0", lambda r: r.update(last="1/0")
    for part in run["start"]["modes"]:
        yield f"starts {part} nowhere", lambda r, p=part: r["start"]["modes"].update({p: "Nowhere"})
        yield f"starts without {part}", lambda r, p=part: r["start"]["modes"].pop(p)
    for v in run["start"]["values"]:
        yield f"starts with another {v}", lambda r, v=v: r["start"]["values"].update({v: "7"})
        yield f"starts without {v}", lambda r, v=v: r["start"]["values"].pop(v)
    for k, step in enumerate(run["steps"]):
        yield f"step {k} dropped", lambda r, k=k: r["steps"].pop(k)
        yield f"step {k} twice", lambda r, k=k: r["steps"].insert(k, r["steps"][k])
        yield f"step {k} waits backwards", lambda r, k=k: r["steps"][k].update(dwell="-1")
        yield f"step {k} waits for long", lambda r, k=k: r["steps"][k].update(dwell="1000")
        yield f"step {k} fires nothing", lambda r, k=k: r["steps"][k].update(names=[])
        yield f"step {k} fires less", lambda r, k=k: r["steps"][k]["names"].pop()
        yield f"step {k} fires more", lambda r, k=k: r["steps"][k]["names"].append("c.again")
        for v in step["values"]:
            yield f"step {k} sets {v}", lambda r, k=k, v=v: r["steps"][k]["values"].update({v: "17"})


@pytest.mark.parametrize("claim", ["enters", "dark", "locked", "late"])
def test_damaged_runs_are_refused(truth: Case, claim: str) -> None:
    seen = 0
    for name, damage in run_damages(truth.run(claim)):
        forged = copy.copy(truth)
        forged.certificates = {**truth.certificates, claim: copy.deepcopy(truth.certificates[claim])}
        damage(forged.run(claim))
        assert not forged.accepted(claim), name
        seen += 1
    assert seen >= 12


def _sync(c: Case, system: str, name: str) -> Json:
    return next(s for s in c.system(system)["syncs"] if s["name"] == name)


def _edge(c: Case, automaton: str, name: str) -> Json:
    return next(e for e in c.automaton(automaton)["edges"] if e["name"] == name)


def _mode(c: Case, automaton: str, name: str) -> Json:
    return next(m for m in c.automaton(automaton)["modes"] if m["name"] == name)


# A claim, and a change of the core under which its certificate, true before, shows nothing: hashes are made to fit.
OTHER_SYSTEMS: dict[str, tuple[str, Callable[[Case], Any]]] = {
    "a longer write": ("exclusion", lambda c: _mode(c, "P", "Request").update(domain=["<=", ["var", "x"], "4"])),
    "no limit to the write": ("exclusion", lambda c: _mode(c, "P", "Request").update(domain=True)),
    "a shorter wait": ("exclusion", lambda c: _edge(c, "P", "enter").update(guard=[">", ["var", "x"], "1"])),
    "a wait that is no longer": ("exclusion", lambda c: _edge(c, "P", "enter").update(guard=[">=", ["var", "x"], "2"])),
    "the clock is not reset": ("exclusion", lambda c: _edge(c, "P", "set").update(resets=[])),
    "entered without asking": ("exclusion", lambda c: _sync(c, "F", "enter[2]").update(guard=True)),
    "entered by the number of another": (
        "exclusion", lambda c: _sync(c, "F", "enter[2]").update(guard=["==", ["var", "owner"], "1"])),
    "another's number written": (
        "exclusion", lambda c: _sync(c, "F", "set[3]").update(resets=[{"var": "owner", "to": "1"}])),
    "nothing written": ("exclusion", lambda c: _sync(c, "F", "set[1]").update(resets=[])),
    "an interaction more": ("exclusion", lambda c: c.system("F")["syncs"].append(
        {**_sync(c, "F", "enter[1]"), "name": "jump in", "guard": True})),
    "one process fires alone": ("exclusion", lambda c: c.system("F")["syncs"].remove(_sync(c, "F", "enter[3]"))),
    "one process starts inside": ("exclusion", lambda c: c.automaton("P")["init"].append(
        {"mode": "Critical", "where": True, "with": [{"var": "x", "to": "0"}]})),
    "no start": ("exclusion", lambda c: c.system("F")["init"][0].update(where=False)),
    "no start, and nothing listed": ("exclusion", lambda c: (
        c.system("F")["init"][0].update(where=False), c.states("exclusion").update(starts=[], states=[]))),
    "a part's clock set by the system": ("exclusion", lambda c: c.system("F")["init"][0]["with"].append(
        {"var": "p[1].x", "to": "1"})),
    "anyone may own at the start": ("safe_for_one", lambda c: c.system("F").update(init=[])),
    "one process is another automaton": ("exclusion", lambda c: (
        c.core["automata"].append({**copy.deepcopy(c.automaton("P")), "name": "Q"}),
        _edge(c, "Q", "enter").update(guard=True), c.system("F")["parts"][1].update(of="Q"))),
    "a claim that is not symmetric": ("exclusion", lambda c: c.claim("exclusion")["goals"][0].update(
        condition=["not", ["and", ["at", "p[3].Wait"], ["at", "p[1].Idle"]]])),
    "a stronger claim": ("exclusion", lambda c: c.claim("exclusion")["goals"][0].update(
        condition=["not", ["or", ["at", "p[1].Wait"], ["at", "p[2].Wait"], ["at", "p[3].Wait"]]])),
    "another kind of claim": ("exclusion", lambda c: c.claim("exclusion")["goals"][0].update(kind="reach", within="1")),
    "a longer horizon": ("soon", lambda c: c.claim("soon")["goals"][0].update(within="4")),
    "no horizon": ("soon", lambda c: c.claim("soon")["goals"][0].update(within=None)),
    "more jumps": ("few", lambda c: c.claim("few")["horizon"].update(jumps=4)),
    "no limit of jumps": ("few", lambda c: c.claim("few")["horizon"].update(jumps=None)),
    "a domain that ends": ("moves", lambda c: _mode(c, "P", "Wait").update(domain=["<=", ["var", "x"], "2"])),
    "an edge that is gone": ("moves", lambda c: _edge(c, "P", "set").update(guard=False)),
    "urgent no more": ("lit", lambda c: _edge(c, "Clock", "ring").update(urgent=False)),
    "urgent later": ("lit", lambda c: _edge(c, "Clock", "ring").update(guard=[">=", ["var", "t"], "3"])),
    "urgent with a partner who may not come": (
        "lit", lambda c: _sync(c, "B", "wake").update(edges=["c.ring", "b.on"], listeners=["a.on"])),
    "suppressed by something that is enabled": ("lit", lambda c: c.system("B")["priorities"].append(
        {"over": ["second", "wake"], "when": True})),
    "a reset beyond": ("lit", lambda c: _edge(c, "Clock", "again").update(resets=[
        {"var": "t", "low": "0", "high": "4"}])),
    "a listener less": ("all_join", lambda c: _sync(c, "B", "wake").update(listeners=["a.on"])),
    "a listener that may not": ("all_join", lambda c: _edge(c, "Lamp", "on").update(guard=["at", "Lit"])),
    "a priority less": ("in_order", lambda c: c.system("B")["priorities"].pop()),
    "a priority that rarely holds": (
        "in_order", lambda c: c.system("B")["priorities"][1].update(when=["<", ["var", "c.t"], "1"])),
    "a priority turned round": (
        "in_order", lambda c: c.system("B")["priorities"][1].update(over=["second", "first"])),
    "the run's guard": ("enters", lambda c: _edge(c, "P", "enter").update(guard=[">", ["var", "x"], "5"])),
    "the run's domain": ("enters", lambda c: _mode(c, "P", "Wait").update(domain=["<=", ["var", "x"], "3"])),
    "the run's sync": ("enters", lambda c: _sync(c, "F", "try[1]").update(guard=False)),
    "the run's start": ("enters", lambda c: c.automaton("P")["init"][0].update(mode="Wait")),
    "the run passes what is urgent": ("late", lambda c: _edge(c, "Clock", "again").update(urgent=True)),
    "the run ignores a priority": ("late", lambda c: (
        c.system("B")["syncs"].append({**_sync(c, "B", "second"), "name": "block", "edges": ["b.on"]}),
        c.system("B")["priorities"].append({"over": ["block", "wake"], "when": True}))),
    "the run leaves a listener out": ("dark", lambda c: _sync(c, "B", "wake").update(listeners=[])),
    "the run's end is not stuck": ("locked", lambda c: _edge(c, "Clock", "again").update(guard=True)),
    "the run's end is terminal": ("locked", lambda c: [
        m.update(terminal=True) for a in ("Clock", "Lamp") for m in c.automaton(a)["modes"]]),
    "too late for the claim": ("enters", lambda c: c.claim("enters")["goals"][0].update(within="3")),
    "too many jumps for the claim": ("enters", lambda c: c.claim("enters")["horizon"].update(jumps=2)),
    "assumed away": ("exclusion", lambda c: c.claim("exclusion").update(assume=[["<", "1", "0"]])),
    "inductive": ("exclusion", lambda c: c.claim("exclusion").update(inductive=True)),
    "a part of nothing": ("exclusion", lambda c: c.system("F")["parts"][0].update(of="Nothing")),
    "a part of itself": ("exclusion", lambda c: c.system("F")["parts"][0].update(of="F")),
    "priorities in a circle": ("in_order", lambda c: c.system("B")["priorities"].append(
        {"over": ["second", "jump"], "when": True})),
    "a rate of two": ("exclusion", lambda c: [
        m.update(flow=[{"var": "x", "rate": "2"}]) for m in c.automaton("P")["modes"]]),
    "a rate that is a range": ("exclusion", lambda c: [
        m.update(flow=[{"var": "x", "low": "1", "high": "2"}]) for m in c.automaton("P")["modes"]]),
}  # fmt: skip


@pytest.mark.parametrize("name", OTHER_SYSTEMS)
def test_a_certificate_about_another_system_is_refused(truth: Case, name: str) -> None:
    claim, change = OTHER_SYSTEMS[name]
    forged = copy.deepcopy(truth)
    change(forged)
    assert forged.core != truth.core
    try:
        forged.rehash()
    except FAULTS:
        return
    assert not forged.accepted(claim)


def _group(c: Case) -> Json:
    return c.states("exclusion")["symmetry"][0]


def _hints(c: Case) -> Iterator[Json]:
    for s in c.states("exclusion")["states"]:
        yield from s["next"]


SYMMETRIES: dict[str, Callable[[Case], Any]] = {
    "no group": lambda c: c.states("exclusion").update(symmetry=[]),
    "nobody is renamed": lambda c: [h.__setitem__(0, []) for h in _hints(c)],
    "everybody is shifted": lambda c: [h.__setitem__(0, [[1, 2, 0]]) for h in _hints(c)],
    "a renaming that loses one": lambda c: [h.__setitem__(0, [[0, 0, 2]]) for h in _hints(c)],
    "a renaming of too few": lambda c: [h.__setitem__(0, [[1, 0]]) for h in _hints(c)],
    "two groups of one": lambda c: c.states("exclusion")["symmetry"].append(copy.deepcopy(_group(c))),
    "the register does not name places": lambda c: _group(c).update(indexed=[]),
    "wrong names in the register": lambda c: _group(c).update(values=["2", "3", "1"]),
    "nobody is a place": lambda c: _group(c).update(values=["0", "2", "3"]),
    "a clock is left behind": lambda c: [m.remove(m[1]) for m in _group(c)["members"]],
    "a part is left behind": lambda c: [m.remove(m[0]) for m in _group(c)["members"]],
    "a member of no system": lambda c: _group(c)["members"][0].__setitem__(0, "q[1]"),
    "a member twice": lambda c: _group(c)["members"].__setitem__(1, _group(c)["members"][0]),
}


@pytest.mark.parametrize("name", SYMMETRIES)
def test_a_wrong_symmetry_is_refused(truth: Case, name: str) -> None:
    forged = copy.deepcopy(truth)
    SYMMETRIES[name](forged)
    assert not forged.accepted("exclusion")


def test_states_closed_up_to_a_symmetry_show_nothing_of_one_part(truth: Case) -> None:
    """The certificate of a claim about all parts, with its symmetry, under a claim about one of them."""
    forged = copy.deepcopy(truth)
    forged.certificates["safe_for_one"]["goals"][0]["states"] = truth.certificates["exclusion"]["goals"][0]["states"]
    assert not forged.accepted("safe_for_one")


def test_a_wider_state_needs_what_follows_it(truth: Case) -> None:
    """Any values of all clocks in one state: what follows is in no listed state."""
    for k, s in enumerate(truth.states("exclusion")["states"]):
        if "Request" in s["at"]:
            forged = copy.deepcopy(truth)
            n = 4
            forged.states("exclusion")["states"][k]["zone"] = [1 if i % (n + 1) == 0 else None for i in range(n * n)]
            assert not forged.accepted("exclusion"), s


def test_a_core_with_broken_systems_is_unreadable(truth: Case) -> None:
    for key in truth.system("F"):
        if key in ("constants", "vars", "lets", "init", "flow", "parts", "syncs", "priorities"):
            core = copy.deepcopy(truth.core)
            del next(s for s in core["systems"] if s["name"] == "F")[key]
            with pytest.raises(Unreadable):
                Core(core)
