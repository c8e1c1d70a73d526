"""A turn that comes to a border by its radius, chains of resets of random lengths: verdicts of closed forms."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.shared import Trees
from haverify.analyses.portfolio import contexts_of
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read

CIRCLE = """
spec "circle" version "1.0" unitless
automaton A {{
  var x
  var y
  init Go where x == 0 and {low} <= y <= {high}
  mode Go {{ flow {{ x' = y; y' = -x }}; urgent edge hit: -> Hit when x >= 1 do y := 0.5 }}
  mode Hit {{ flow {{ x' = -y; y' = 0 }} }}
}}
property never_hits on A {{ within 3; never at(Hit) }}
property hits on A {{ reach at(Hit) within 3 }}
property may_hit on A {{ can reach at(Hit) within 3 }}
property bounded on A {{ within 3; always x <= 1.01 }}
"""


def verdicts(text: str, at: Path) -> dict[str, object]:
    """What flowpipes say of the claims of a spec."""
    path = at / "spec.ha"
    path.write_text(text)
    spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    context = contexts_of(spec).get("A")
    assert context is not None
    trees = Trees()
    return {c.name: decide_flow(spec, context.automaton, c, context.core, trees=trees).verdict for c in spec.claims}


@settings(max_examples=4, deadline=None)
@given(low=st.integers(50, 85) | st.integers(103, 129), width=st.integers(1, 10))
def test_a_turn_hits_if_its_radius_is_one(tmp_path_factory: pytest.TempPathFactory, low: int, width: int) -> None:
    found = verdicts(CIRCLE.format(low=low / 100, high=(low + width) / 100), tmp_path_factory.mktemp("circle"))
    truth = {"never_hits": low < 100, "hits": low > 100, "may_hit": low > 100, "bounded": True}
    assert all(isinstance(v, Proved if truth[n] else Refuted) for n, v in found.items()), found


def test_some_of_a_set_hit(tmp_path: Path) -> None:
    text = CIRCLE[: CIRCLE.index("property bounded")] + "property bounded on A {{ within 3; always x <= 1.1 }}"
    found = verdicts(text.format(low=0.9, high=1.1), tmp_path)
    assert isinstance(found["never_hits"], Refuted)
    assert isinstance(found["hits"], Refuted)
    assert isinstance(found["may_hit"], Proved)
    assert not isinstance(found["bounded"], Refuted)


def chain(lifts: list[int]) -> str:
    """Modes that hand a run on at once, each adding tenths to y; the last one takes time."""
    modes = [
        f"  mode M{k} {{ flow {{ x' = 1 + sin(y) / 9; y' = 0 }}; "
        f"urgent edge e{k}: -> M{k + 1} when {f'y >= {k}' if k else 'x >= 1'} do y := y + {10 + lift} / 10 }}"
        for k, lift in enumerate(lifts)
    ]
    n, top = len(lifts), sum(10 + lift for lift in lifts)
    return "\n".join([
        'spec "chain" version "1.0" unitless', "automaton A {", "  var x", "  var y",
        "  init M0 where 0 <= x <= 0.1 and y == 0",
        *modes, f"  mode M{n} {{ flow {{ x' = -x; y' = -y }} }}", "}",
        f"property arrives on A {{ reach at(M{n}) within 1.2 }}",
        f"property is_lifted on A {{ within 2; always jump(e{n - 1}) implies y >= {top} / 10 - 0.01 and x <= 1.001 }}",
        f"property is_too_high on A {{ within 2; always y <= {top - 1} / 10 }}",
        "property dwells on A { can reach at(M1) and not jumped within 2 }",
    ])  # fmt: skip


@settings(max_examples=5, deadline=None)
@given(lifts=st.lists(st.integers(1, 9), min_size=2, max_size=6))
def test_chains_take_no_time(tmp_path_factory: pytest.TempPathFactory, lifts: list[int]) -> None:
    found = verdicts(chain(lifts), tmp_path_factory.mktemp("chain"))
    assert isinstance(found["arrives"], Proved)
    assert isinstance(found["is_lifted"], Proved)
    assert isinstance(found["is_too_high"], Refuted)
    assert isinstance(found["dwells"], Refuted)
