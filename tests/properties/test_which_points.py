"""`for which`: what is refuted along whole boxes for other goals than bounds, and at points of boxes left open."""

from __future__ import annotations

import copy
import json
import random
from fractions import Fraction
from math import exp
from pathlib import Path
from typing import Any

import pytest
from tests.forgeries.test_invariant_forgeries import FAULTS
from tests.properties.test_which_boxes import sides, spec_of

from hacheck.core import Core
from hacheck.obligations import Setting, established
from hacheck.rational import Meter
from haverify.analyses.portfolio import decide
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.core import canonical, to_core
from haverify.model.spec import Spec
from haverify.report.assemble import Assembler
from haverify.report.figures.maps import of_pieces
from haverify.report.gate import judge

Q = Fraction
Json = Any
RISE = """spec "Rise" version "1.0" unitless
param p in [0, 2]
param q in [0, 2]
automaton A {
  var x
  init M with x := 0
  mode M { flow { x' = p * q - x } }
}
property met on A { for which p in [1, 2]; for which q in [1, 1]; reach x >= 1 within 1 }
property missed on A { for which p in [0, 1]; reach x >= 2 within 1 }
property two on A { for which p in [0, 1]; for which q in [0, 1]; within 1; always x <= 1; always x >= 0.1 }
property signal on A { for which p in [0, 1]; stl eventually[0, 1] x >= 2 }
"""
# Up for 1, down for 1: x is at most 1, and the first `at(Down)` is at 1.
SAW = """spec "Saw" version "1.0" unitless
param p in [0, 8]
param q in [1, 2]
automaton C {
  var x
  var c
  init Up with { x := 0; c := 0 }
  mode Up { domain c <= 1; flow { x' = 1; c' = 1 }; urgent edge turn: -> Down when c >= 1 do c := 0 }
  mode Down { domain c <= 1; flow { x' = -1; c' = 1 }; urgent edge back: -> Up when c >= 1 do c := 0 }
}
property waits on C {
  for which p in [0, 8]
  for which q in [1, 2]
  stl (x <= p / 8) until[0, 2] at(Down)
  expect refuted
}
property alone on C { for which p in [6, 8]; stl globally[0, 2] (x >= p / 8 implies eventually[0, 1] x <= 0.1) }
"""


def decided(folder: Path, text: str, name: str) -> tuple[Spec, Evidence]:
    spec = spec_of(folder, text)
    claim = next(c for c in spec.claims if c.name == name)
    return spec, decide(spec, claim)


def test_boxes_in_which_a_goal_is_never_met_agree_with_the_closed_form(tmp_path: Path) -> None:
    _, found = decided(tmp_path, RISE, "met")
    chance, kinds = random.Random(5), {type(p.verdict) for p in found.parts}
    assert isinstance(found.verdict, Refuted) and {Proved, Refuted} <= kinds
    for part in (p for p in found.parts if p.kind == "piece"):
        (p0, p1), (q0, _) = sides(part.where)
        for _ in range(20):
            end = chance.uniform(float(p0), float(p1)) * float(q0) * (1 - exp(-1))
            assert not (isinstance(part.verdict, Proved) and end < 0.9999)
            assert not (isinstance(part.verdict, Refuted) and end > 1.0001)


@pytest.mark.parametrize("name", ["missed", "two", "signal"])
def test_what_no_value_satisfies_is_refuted_for_the_whole_box(tmp_path: Path, name: str) -> None:
    _, found = decided(tmp_path, RISE, name)
    assert [(p.kind, type(p.verdict)) for p in found.parts] == [("piece", Refuted)]


@pytest.fixture(scope="module")
def saw(tmp_path_factory: pytest.TempPathFactory) -> tuple[Spec, Evidence]:
    return decided(tmp_path_factory.mktemp("saw"), SAW, "waits")


def accepted(spec: Spec, found: Evidence, made: Json) -> list[tuple[str, str]]:
    """What the second checker takes from a certificate: the verdict of each piece and point."""
    Meter.left = 200_000_000
    core = Core(json.loads(canonical(to_core(spec))))
    cells = json.loads(canonical(found.cells))

    def setting(automaton: Json, rounding: bool) -> Setting:
        return Setting(core, automaton, rounding, cells.__getitem__, core.claims.__getitem__)

    _, _, parts = established(core, core.claims[made["claim"]], made, setting)
    return [(where, word) for where, _, word in parts]


def points(tree: Json) -> list[Json]:
    """The entries of a tree that are about points."""
    if not isinstance(tree, list):
        return []
    return [tree] if tree[0] == "at" else points(tree[3]) + points(tree[4])


def test_a_run_at_a_point_refutes_what_no_box_shows(saw: tuple[Spec, Evidence]) -> None:
    spec, found = saw
    told = [p for p in found.parts if p.kind == "point"]
    assert isinstance(found.verdict, Refuted) and told
    assert all(isinstance(p.verdict, Refuted) and p.run is not None for p in told)
    assert all(Q(p.where.split(",")[0].removeprefix("p = ")) < 8 for p in told)
    assert all(isinstance(p.verdict, Unknown) for p in found.parts if p.kind == "piece")
    made = json.loads(canonical(found.certificate))
    assert accepted(spec, found, made) == [
        (p.where, "refuted" if p.kind == "point" else "unknown") for p in found.parts
    ]


def test_files_of_pieces_are_named_wherever_a_certificate_names_them(tmp_path: Path) -> None:
    spec, found = decided(tmp_path, SAW, "alone")
    words = [word for _, word in accepted(spec, found, json.loads(canonical(found.certificate)))]
    assert "refuted" in words and len(words) == len(found.parts)


def changes(tree: Json) -> dict[str, Json]:
    """Trees that say of points what is not so."""
    made: dict[str, Json] = {}

    def with_(name: str, at: Json, leaf: Json, *more: Json) -> None:
        copied = copy.deepcopy(tree)
        points(copied)[0][1:] = [at, leaf, *more]
        made[name] = copied

    _, at, leaf = points(tree)[0]
    with_("a point outside of its piece", {**at, "p": "8"}, leaf)
    with_("another point, where the run is none", {**at, "q": str(Q(at["q"]) + Q(1, 1000))}, leaf)
    with_("no value for a param", {"p": at["p"]}, leaf)
    with_("a value of what is not asked for", {**at, "r": "0"}, leaf)
    with_("nothing shown", at, None)
    with_("no refutation", at, {**leaf, "verdict": "proved"})
    with_("an inner tree", at, ["at", at, leaf])
    with_("more than a point", at, leaf, leaf)
    return made


def test_what_is_said_of_points_falsely_is_refused(saw: tuple[Spec, Evidence]) -> None:
    spec, found = saw
    made = json.loads(canonical(found.certificate))
    for name, tree in changes(made["boxes"]).items():
        with pytest.raises(FAULTS):
            accepted(spec, found, {**made, "boxes": tree})
            pytest.fail(name)
    with pytest.raises(FAULTS):
        accepted(spec, found, {**made, "verdict": "proved"})
    whole = points(made["boxes"])[0][2]  # a run at a point is none for all of a box
    with pytest.raises(FAULTS):
        accepted(spec, found, {**made, "boxes": whole})


def test_points_are_dots_on_the_map(saw: tuple[Spec, Evidence]) -> None:
    spec, found = saw
    told = Assembler(spec, {}).claim(spec.claims[0], found, judge(spec.claims[0], found, None), None, (0.0, 0.0))
    count = sum(p.kind == "point" for p in found.parts)
    drawn = of_pieces(told).svg
    assert drawn.count('class="piece refuted point"') == count + 1 and f"refuted at {count} points" in drawn
