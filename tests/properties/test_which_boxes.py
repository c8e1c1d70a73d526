"""`for which` of several params along flows: shares and places of boxes against a closed form, and against points."""

from __future__ import annotations

import random
from fractions import Fraction
from math import exp, pi, sqrt
from pathlib import Path
from typing import Any

import pytest

from haverify.analyses.portfolio import decide
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.spec import Spec
from haverify.report.assemble import Assembler
from haverify.report.figures.maps import of_pieces
from haverify.report.gate import judge, proved_share
from haverify.run.examine import read

Q = Fraction
SWING = """spec "Swing" version "1.0" unitless
param k in [1, 2]
param d in [0, 1]
automaton A {
  var x in [-5, 5]
  var v in [-5, 5]
  init M where 1 <= x <= 1.001 with v := 0
  mode M { flow { x' = v; v' = -k * x - d * v } }
}
property low on A {
  within 5
  for which k in [1, 2]
  for which d in [0, 1]
  always x >= -0.6
  expect refuted share >= 0.5
}
"""


def spec_of(folder: Path, text: str) -> Spec:
    (folder / "which.ha").write_text(text, encoding="utf-8")
    spec, _, found = read(str(folder / "which.ha"))
    assert spec is not None, found
    return spec


@pytest.fixture(scope="module")
def decided(tmp_path_factory: pytest.TempPathFactory) -> tuple[Spec, Evidence]:
    spec = spec_of(tmp_path_factory.mktemp("which"), SWING)
    return spec, decide(spec, spec.claims[0])


def sides(where: str) -> list[tuple[Q, Q]]:
    pairs = [s.split(" in [")[1].rstrip("]").split(", ") for s in where.replace("], ", "]; ").split("; ")]
    return [(Q(a), Q(b)) for a, b in pairs]


def lowest(k: float, d: float) -> float:
    """The first minimum of the damped oscillation from 1, in closed form (it comes before 5 for these params)."""
    zeta = d / (2 * sqrt(k))
    return -exp(-pi * zeta / sqrt(1 - zeta * zeta))


def test_each_box_says_what_the_closed_form_says_at_points_of_it(decided: tuple[Spec, Evidence]) -> None:
    _, found = decided
    chance = random.Random(3)
    for p in found.parts:
        (k0, k1), (d0, d1) = sides(p.where)
        for _ in range(20):
            at = lowest(chance.uniform(float(k0), float(k1)), chance.uniform(float(d0), float(d1)))
            assert not (isinstance(p.verdict, Proved) and at < -0.6001)
            assert not (isinstance(p.verdict, Refuted) and at > -0.599)


def test_boxes_fill_the_whole_and_most_of_it_is_decided(decided: tuple[Spec, Evidence]) -> None:
    spec, found = decided
    volumes: dict[Any, Q] = {Proved: Q(0), Refuted: Q(0), Unknown: Q(0)}
    for p in found.parts:
        (k0, k1), (d0, d1) = sides(p.where)
        volumes[type(p.verdict)] += (k1 - k0) * (d1 - d0)
    assert sum(volumes.values()) == 1 and volumes[Unknown] < Q(1, 8)
    # The curve lowest(k, d) = -0.6 is d = 0.3210 sqrt(k): below it lies 0.3914 of the box.
    assert volumes[Refuted] < Q(392, 1000) and volumes[Proved] < Q(609, 1000)
    assert proved_share(found) == volumes[Proved] > Q(1, 2)
    assert isinstance(found.verdict, Refuted) and not judge(spec.claims[0], found, None).problems


def test_where_it_holds_everywhere_it_is_proved_and_nowhere_refuted(tmp_path: Path) -> None:
    low = SWING.replace("-0.6", "-1.1").replace("expect refuted share >= 0.5", "expect proved share == 1")
    spec = spec_of(tmp_path, low)
    found = decide(spec, spec.claims[0])
    assert (
        isinstance(found.verdict, Proved) and len(found.parts) == 1 and not judge(spec.claims[0], found, None).problems
    )
    spec = spec_of(tmp_path, SWING.replace("-0.6", "0.5"))
    found = decide(spec, spec.claims[0])
    assert [type(p.verdict) for p in found.parts] == [Refuted] and proved_share(found) == 0
    assert judge(spec.claims[0], found, None).problems


def test_the_map_shows_each_box_and_the_shares(decided: tuple[Spec, Evidence]) -> None:
    spec, found = decided
    told = Assembler(spec, {}).claim(spec.claims[0], found, judge(spec.claims[0], found, None), None, (0.0, 0.0))
    drawn = of_pieces(told).svg
    kinds = [type(p.verdict) for p in found.parts]
    for kind, name in ((Proved, "piece proved"), (Refuted, "piece refuted"), (Unknown, "piece")):
        assert drawn.count(f'class="{name}"') == kinds.count(kind) + 1  # and one in the legend
    share = proved_share(found)
    assert share is not None and f"proved: {float(100 * share):.3g} %" in drawn
