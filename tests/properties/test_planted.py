"""Invariants that were planted are found; what is false is never shown."""

import pytest
from tests.properties.planted import accepted, false_one, true_one

from haverify.analyses.synthesis.saturate import invent


@pytest.mark.parametrize("seed", range(6))
def test_what_is_true_is_found_and_accepted(seed: int) -> None:
    system = true_one(seed)
    cuts = invent(system, 20.0)
    assert cuts is not None
    assert accepted(system, cuts)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_false_is_not_found(seed: int) -> None:
    assert invent(false_one(seed), 0.5) is None
