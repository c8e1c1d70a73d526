"""Searches: known violations of models after the literature are found within few runs, and certified."""

from pathlib import Path

import pytest

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.certify import certified
from haverify.simulate.falsify import searched, subject

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
