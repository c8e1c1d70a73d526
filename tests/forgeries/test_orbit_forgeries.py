"""Certificates of periodic orbits that are damaged: hacheck shows none of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from hacheck.core import Core
from hacheck.obligations import Question, Setting, established
from hacheck.rational import Refused
from haverify.analyses.orbits.decide import decide_cycle
from haverify.model.core import canonical, to_core
from haverify.run.examine import read

Json = Any
# The unit circle, with r' = K r (r^2 - 1) and one turn in 2 pi: its multiplier is exp(4 pi K).
CIRCLE = """automaton A {
  var x; var y
  init M where x == 1 and y == 0
  mode M { flow { x' = -y + K * x * (x^2 + y^2 - 1); y' = x + K * y * (x^2 + y^2 - 1) } }
}"""
FALLS, RISES = CIRCLE.replace("K", "-1/4"), CIRCLE.replace("K", "1/10")
VAN_DER_POL = """automaton A {
  var x; var y
  init M where x == 2 and y == 0
  mode M { flow { x' = y; y' = (1 - x^2) * y - x } }
}"""
BRUSSELATOR = """automaton A {
  var x; var y
  init M where x == 1 and y == 3
  mode M { flow { x' = 1 + x^2 * y - 4 * x; y' = 3 * x - x^2 * y } }
}"""
PLAIN = "cycle through y == 0 and 0.99 <= x <= 1.01 within 7"
Damage = Callable[[Json, Json, Json], None]  # core, certificate, files


@cache
def made(automaton: str, claim: str) -> str:
    """The core, certificate and records of a claim, as text."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.ha"
        path.write_text(f'spec "S" version "1.0" unitless\n{automaton}\nproperty p on A {{ {claim} }}\n')
        spec = read(str(path))[0]
    assert spec is not None
    core = to_core(spec)
    found = decide_cycle(spec, spec.automata[0], spec.claims[0], core)
    assert found.certificate is not None and found.cells, found.verdict
    return json.dumps([json.loads(canonical(v)) for v in (core, found.certificate, dict(found.cells))])


def shown(core: Json, certificate: Json, files: Json) -> str:
    """The verdict that hacheck finds established."""
    known = Core(core)
    setting = Setting(known, known.data["automata"][0], False, files.__getitem__)
    return established(known, known.data["claims"][0], certificate, lambda *_: setting)[0]


def entry_of(certificate: Json) -> Json:
    return certificate["goals"][0]


def with_entry(**changed: Json) -> Damage:
    return lambda core, certificate, files: entry_of(certificate).update(changed)


def without(name: str) -> Damage:
    return lambda core, certificate, files: entry_of(certificate).pop(name)


def on_steps(change: Callable[[list[Json]], None], word: str = "flow") -> Damage:
    def damage(core: Json, certificate: Json, files: Json) -> None:
        node = files[entry_of(certificate)[word]]["starts"][0]["pieces"]
        while "split" in node:
            node = node["low"]
        change(node["steps"])

    return damage


def on_file(change: Callable[[Json], None], word: str = "flow") -> Damage:
    return lambda core, certificate, files: change(files[entry_of(certificate)[word]])


def on_core(change: Callable[[Json], None]) -> Damage:
    return lambda core, certificate, files: change(core)


def on_automaton(change: Callable[[Json], None]) -> Damage:
    return on_core(lambda core: change(core["automata"][0]))


def slower(a: Json) -> None:
    a["modes"][0]["flow"][0]["rate"] = ["*", "1/2", a["modes"][0]["flow"][0]["rate"]]


def one_half_twice(file: Json) -> None:
    node = file["starts"][0]["pieces"]
    file["starts"][0]["pieces"] = {"split": "x", "low": node, "high": node}


def shifted(steps: list[Json]) -> None:
    steps[3]["x"][1][0][0] += 1 << 36


def longer(steps: list[Json]) -> None:
    steps[2]["h"] += 1 << 38


def newton_instead(core: Json, certificate: Json, files: Json) -> None:
    entry_of(certificate).pop("factor")
    entry_of(certificate).update(back=[["-1"]])


def plus_nothing(e: Json) -> Damage:
    """A term that is zero, and reads what is outside of what can be shown."""
    return on_automaton(lambda a: a["modes"][0]["flow"][0].update(rate=["+", a["modes"][0]["flow"][0]["rate"], e]))


ANYWHERE: dict[str, Damage] = {
    "another hash": with_entry(hash="0" * 64),
    "no record": without("flow"),
    "another variable of the section": with_entry(section=["x", "1"]),
    "another value of the section": with_entry(section=["y", "1/100"]),
    "a section of nothing": with_entry(section=["z", "0"]),
    "a section in no mode": with_entry(mode="N"),
    "a section around another state": with_entry(centre={"x": "11/10"}),
    "a section around no state": with_entry(centre={}),
    "a section that is wider": with_entry(basis=[["1/4"]]),
    "a section of one state": with_entry(basis=[["0"]]),
    "a section without directions": with_entry(basis=[]),
    "a period that is too narrow": with_entry(period=["6.28318530717", "6.28318530718"]),
    "a period that is another": with_entry(period=["3", "4"]),
    "a period from below zero": with_entry(period=["-1", "7"]),
    "a period that is longer than claimed": with_entry(period=["6", "8"]),
    "a record of another automaton": on_file(lambda f: f.update(automaton="B")),
    "a set of derivatives": on_file(lambda f: f.update(set=["x'x"])),
    "no pieces": on_file(lambda f: f.update(starts=[])),
    "a step too few": on_steps(lambda s: s.pop(4)),
    "no last step": on_steps(lambda s: s.pop()),
    "no steps": on_steps(lambda s: s.clear()),
    "a changed coefficient": on_steps(shifted),
    "a longer step": on_steps(longer),
    "the other verdict": lambda core, certificate, files: certificate.update(verdict="refuted"),
    "a changed claim": on_core(lambda c: c["claims"][0]["goals"][0].update(within="6")),
    "a changed flow": on_automaton(slower),
}  # fmt: skip
OF_NEWTON: dict[str, Damage] = {
    "no preconditioner": without("back"),
    "a preconditioner of zeros": with_entry(back=[["0"]]),
    "a preconditioner of the other sign": with_entry(back=[["-2/5"]]),
    "a preconditioner that is no matrix": with_entry(back=[]),
    "a section beside the orbit": with_entry(centre={"x": "1001/1000"}),
    "a claim that it attracts": on_core(lambda c: c["claims"][0]["goals"][0].update(attracting=True)),
}
OF_CONTRACTIONS: dict[str, Damage] = {
    "an understated factor": with_entry(factor="1/100"),
    "a factor of one": with_entry(factor="1"),
    "a factor below zero": with_entry(factor="-1/2"),
    "a section that is left": with_entry(centre={"x": "1002/1000"}, basis=[["1/1000"]]),
    "no shares": with_entry(shares=[]),
    "a larger section at last": with_entry(shares=["2"]),
    "sections without laps in between": with_entry(shares=["2", "1"]),
    "a share below zero": with_entry(shares=["-1"]),
    "no basin": without("basin"),
    "the laps as a basin": lambda core, certificate, files: entry_of(certificate).update(
        basin=entry_of(certificate)["flow"]
    ),
    "a basin of one half, twice": on_file(one_half_twice, "basin"),
    "a basin with a step too few": on_steps(lambda s: s.pop(), "basin"),
    "a fixed point without a contraction": newton_instead,
    "laps of pieces": on_file(one_half_twice),  # which need not be parts of one continuous map
}  # fmt: skip
# What the hash forbids, were it not there.
OF_CORES: dict[str, Damage] = {
    "a wider section": on_core(
        lambda c: c["claims"][0]["goals"][0].update(
            condition=["and", ["==", ["var", "y"], "0"], [">=", ["var", "x"], "1/2"], ["<=", ["var", "x"], "2"]]
        )
    ),
    "a section without a bound": on_core(
        lambda c: c["claims"][0]["goals"][0].update(condition=["==", ["var", "y"], "0"])
    ),
    "a section that is false": on_core(lambda c: c["claims"][0]["goals"][0].update(condition=False)),
    "a section of jumps": on_core(lambda c: c["claims"][0]["goals"][0].update(condition=["jumped"])),
    "too short a time": on_core(lambda c: c["claims"][0]["goals"][0].update(within="6")),
    "a horizon": on_core(lambda c: c["claims"][0]["horizon"].update(jumps=0)),
    "another flow": on_automaton(slower),
    "a domain that ends laps": on_automaton(lambda a: a["modes"][0].update(domain=[">=", ["var", "x"], "0"])),
    "a declared range that is left": on_automaton(lambda a: a["vars"][0].update(low="-1/2", high="2")),
    "a terminal mode": on_automaton(lambda a: a["modes"][0].update(terminal=True)),
    "a flow that reads the time": plus_nothing(["*", "0", ["time"]]),
    "a flow with a corner": plus_nothing(["*", "0", ["abs", ["var", "y"]]]),
}  # fmt: skip


@pytest.mark.parametrize(
    ("automaton", "claim"),
    [(RISES, PLAIN), (FALLS, f"{PLAIN} attracting"),
     (VAN_DER_POL, "cycle through y == 0 and 2 <= x <= 2.02 within 7 attracting"),
     (BRUSSELATOR, "cycle through x == 1 and 3 <= y <= 6 within 8")],
)  # fmt: skip
def test_what_is_proved_is_shown(automaton: str, claim: str) -> None:
    assert shown(*json.loads(made(automaton, claim))) == "proved"


@pytest.mark.parametrize("name", [*ANYWHERE, *OF_NEWTON])
def test_damaged_fixed_points_are_not_shown(name: str) -> None:
    refused(RISES, PLAIN, {**ANYWHERE, **OF_NEWTON}[name])


@pytest.mark.parametrize("name", [*OF_CONTRACTIONS, "a changed coefficient", "no last step"])
def test_damaged_contractions_are_not_shown(name: str) -> None:
    refused(FALLS, f"{PLAIN} attracting", {**ANYWHERE, **OF_CONTRACTIONS}[name])


@pytest.mark.parametrize("name", OF_CORES)
def test_other_models_are_not_shown_even_without_hashes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Question, "same", lambda *_: None)
    refused(FALLS, f"{PLAIN} attracting", OF_CORES[name])


def refused(automaton: str, claim: str, damage: Damage) -> None:
    core, certificate, files = json.loads(made(automaton, claim))
    before = deepcopy((core, certificate, files))
    damage(core, certificate, files)
    assert (core, certificate, files) != before
    with pytest.raises((Refused, KeyError, IndexError, TypeError, ValueError)):
        shown(core, certificate, files)
