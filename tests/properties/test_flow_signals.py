"""Formulas of several temporal operators along flows, against the exact analysis of clocks.

A variable that nothing reads and no clock drives keeps a machine from that analysis, and changes none of its runs.
Numbers of atoms are moved off the grid of the jumps too: on it steps cannot tell before from after.
"""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.properties.clocked import text
from tests.properties.test_clocked_laws import spec_from
from tests.properties.test_signals import cases

from haverify.analyses import clocked, signals
from haverify.analyses.hybrid import formulas, question
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted

NUMBER = re.compile(r"((?:x|y|time) (?:<=|<|>=|>|==) )(\d+|\(\d+ / \d+\))")


@pytest.fixture(autouse=True, scope="module")
def short_searches():
    """Few pieces and shares: what is found is judged, not how far it looks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signals, "LEAVES", 4)
        patch.setattr(signals, "AT_FIRST", 60)
        patch.setattr(signals, "FURTHER", 40)
        patch.setattr(clocked, "MOST_TIMED", 120)
        patch.setattr(formulas, "PIECES", 4)
        patch.setattr(question, "STRETCHES", 60)
        yield


def flowing(content):
    """The machine with a variable whose rate is no number."""
    content = content.replace("automaton A {", "automaton A {\n  var z", 1).replace("with { ", "with { z := 1; ", 1)
    return content.replace("flow { ", "flow { z' = -z * z; ")


@settings(max_examples=6, deadline=None, derandomize=True)
@given(cases(), st.sampled_from(["0", "1/7", "2/7"]))
def test_flowpipes_and_clocks_never_disagree(case, off):
    machine, asked, _ = case
    formulas_asked = [f[0] for f in asked if len(re.findall("globally|eventually|until", f[0])) > 1][:2]
    moved = [NUMBER.sub(lambda m: f"{m.group(1)}({m.group(2)} + {off})", f) for f in formulas_asked]
    content = text(machine, [f"stl {f}" for f in moved])
    exact = decide_all(spec_from(content, len(moved)))
    enclosed = decide_all(spec_from(flowing(content), len(moved)))
    for name, found in exact.items():
        verdicts = {type(found.verdict), type(enclosed[name].verdict)}
        assert verdicts != {Proved, Refuted}, (name, flowing(content))


MACHINE = """spec "may" version "1.0" unitless
param k in [0.9, 1.1]
automaton A {
  var x
  var z
  init M with { x := 0; z := 1 }
  mode M { domain x <= 1.5; flow { x' = k; z' = -z * z }; edge again: -> M when x >= 1 do x := 0 }
}
"""


def decided(formula):
    return decide_all(spec_from(MACHINE + f"property c on A {{ stl {formula} }}\n", 1))["c"].verdict


@pytest.mark.parametrize(
    ("formula", "verdict"),
    [
        ("globally[0, 0.5] eventually[0, 1.7] jump(again)", Proved),
        ("globally[0, 0.2] eventually[0, 1] jump(again)", Refuted),
        ("globally[0, 0.4] (x <= 1.2 until[0, 1.2] x >= 0.9)", Proved),
        ("globally[0, 1] (jump(again) implies x <= 0.1 and eventually[0, 0.9] x >= 0.6)", Proved),
    ],
)
def test_jumps_that_may_wait(formula, verdict):
    assert isinstance(decided(formula), verdict)


def test_what_is_left_out_of_a_tree_counts(monkeypatch):
    """Early jumps fill the tree; the runs that wait until 1.5 are among those that are left."""
    monkeypatch.setattr(question, "STRETCHES", 12)
    monkeypatch.setattr(formulas, "PIECES", 1)
    assert not isinstance(decided("eventually[0, 0.7] eventually[0.5, 0.6] jump(again)"), Proved)
