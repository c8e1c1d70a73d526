"""Searches: known violations of models after the literature are found within few runs, and certified."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.certify import certified
from haverify.simulate.falsify import searched, subject
from haverify.simulate.search import Point, least

MODELS = Path(__file__).parents[2] / "peers" / "falsify"


@pytest.mark.parametrize(
    ("name", "claim", "is_certain"),
    [
        ("transmission", "at1", True),
        ("transmission", "at2", True),
        ("transmission", "at6", False),
        ("navigation", "inside", True),
        ("cars", "apart", False),
        ("fuel_control", "settled", False),
    ],
)
def test_a_known_violation_is_found(name: str, claim: str, is_certain: bool) -> None:
    read, _ = load(str(MODELS / f"{name}.ha"))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    asked = next(c for c in spec.claims if c.name == claim)
    one = subject(spec, spec.automata[0], asked, asked.goals[0], 10.0, "earliest", 0)
    found, again = (searched(one, 200, 0) for _ in range(2))
    assert found.is_violated and found.run is not None
    assert (found.margin, found.runs) == (again.margin, again.runs)
    if is_certain:
        assert certified(found.run, asked, asked.goals[0]).run is not None


def test_corners_where_all_are_extreme_are_looked_at_and_the_budget_is_kept() -> None:
    looked: list[Point] = []

    def values(points: Sequence[Point]) -> list[float]:
        looked.extend(points)
        return [-sum(p) for p in points]

    found, runs = least(values, 12, 300, 0, -20.0)
    assert (0.5, *[1.0] * 11) in looked and (0.5, *[0.0] * 11) in looked
    assert runs == len(looked) == 300
    assert found is not None and found.value <= -11.5
