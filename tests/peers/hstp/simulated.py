"""Runs of a problem simulated in floats: how many leave the goal by more than the simulation can be off."""

from __future__ import annotations

from pathlib import Path

import numpy

from haverify.analyses.induction.invented import system_of as system_of_mode
from haverify.analyses.synthesis.samples import holds, sample
from haverify.analyses.synthesis.system import System
from haverify.elaborate.elaborate import elaborate
from haverify.obligations.induction import Induction
from haverify.run.load import load

STEPS = 400
SLACK = 1e-4


def system_of(path: Path) -> System:
    """The flow, the starts and the goal of the one claim of a problem."""
    loaded, _ = load(path)
    assert loaded is not None
    spec, _ = elaborate(loaded.tree, loaded.files)
    assert spec is not None
    claim = spec.claims[0]
    automaton = next(a for a in spec.automata if a.name == claim.on)
    asked = Induction(spec, automaton, claim, claim.goals[0])
    asked.check()
    (mode,) = automaton.modes
    return system_of_mode(asked, mode.name)


def violations(path: Path, count: int) -> int:
    """States on up to `count` runs where the goal fails, even if it is read with some slack."""
    system = system_of(path)
    drawn = sample(system, count, STEPS)
    states = drawn.states[numpy.abs(drawn.states).max(axis=1, initial=0) < 1e5]
    return int((~holds(system.goal, states, drawn.names, SLACK)).sum())
