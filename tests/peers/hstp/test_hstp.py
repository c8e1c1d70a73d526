"""Some of the problems: what is found for them is kept by simulated runs, and what is false is violated by some."""

import pytest
from tests.peers.hstp.__main__ import HERE
from tests.peers.hstp.simulated import system_of, violations

from haverify.analyses.synthesis.saturate import invent


@pytest.mark.parametrize("name", ["nl_026", "nl_062", "nl_139"])
def test_no_simulated_run_violates_what_is_proved(name: str) -> None:
    assert violations(HERE / f"{name}.ha", 200) == 0


@pytest.mark.parametrize("name", ["nl_054", "nl_134"])
def test_a_false_problem_is_violated_and_not_proved(name: str) -> None:
    path = HERE / f"{name}.ha"
    assert violations(path, 60) > 0
    assert invent(system_of(path), 2.0) is None


def test_powers_and_cases_are_understood() -> None:
    """A start bounded by a twentieth power: the cut that is needed is a first integral."""
    cuts = invent(system_of(HERE / "nl_026.ha"), 20.0)
    assert cuts is not None
    assert all(c.rule["rule"] == "darboux" for c in cuts)
