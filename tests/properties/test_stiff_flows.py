"""A stiff reaction in other words: states exchanged, time and states scaled. Its enclosures meet, and are narrow."""

from __future__ import annotations

from pathlib import Path

import pytest

from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import follow, question_of
from haverify.run.examine import read

TEXT = """
spec "reaction" version "1.0" unitless
automaton A {{
{variables}
  init Run where {start}
  mode Run {{ flow {{ {rates} }} }}
}}
property p on A {{ within {end}; always {first} >= -1; method taylor(order = 16, tolerance = 1e-13) }}
"""
END = 5


def ends(order: str, pace: int, size: int, path: Path) -> dict[str, tuple[float, float]]:
    """Where x, y and z lie at the end, in the units of the plain reaction."""
    beta, gamma = f"{1000}", f"{100000}"
    x, y, z = (f"({v} / {size})" for v in "xyz")
    made, back, fast = f"0.4 * {x}", f"{beta} * {y} * {z}", f"{gamma} * {y}^2"
    rates = {"x": f"-{made} + {back}", "y": f"{made} - {back} - {fast}", "z": fast}
    values = {"x": 1, "y": 0, "z": 0}
    text = TEXT.format(
        variables="\n".join(f"  var {v}" for v in order),
        start=" and ".join(f"{v} == {values[v] * size}" for v in order),
        rates="; ".join(f"{v}' = {pace * size} * ({rates[v]})" for v in order),
        end=f"{END / pace:g}", first=order[0],
    )  # fmt: skip
    path.write_text(text, encoding="utf-8")
    spec, found, _ = read(str(path))
    assert spec is not None, found
    (claim,) = spec.claims
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    (start,) = model.starts
    (stretch,) = follow(question_of(model, claim, claim.goals[0]), start, start.box, "horizon")
    assert stretch.end == "horizon"
    assert len(stretch.stages) < 150
    return {v: (low / size, high / size) for v, (low, high) in zip(order, stretch.last, strict=False)}


@pytest.mark.parametrize(("order", "pace", "size"), [("zxy", 1, 1), ("xyz", 5, 1), ("xyz", 1, 8), ("yzx", 2, 3)])
def test_the_same_reaction_ends_in_the_same_place(order: str, pace: int, size: int, tmp_path: Path) -> None:
    plain, other = ends("xyz", 1, 1, tmp_path / "a.ha"), ends(order, pace, size, tmp_path / "b.ha")
    for v in "xyz":
        (a, b), (c, d) = plain[v], other[v]
        assert max(a, c) <= min(b, d) + 1e-16
        assert max(b - a, d - c) < 1e-10
    assert sum(low for low, _ in other.values()) <= 1 + 1e-15
    assert sum(high for _, high in other.values()) >= 1 - 1e-15
