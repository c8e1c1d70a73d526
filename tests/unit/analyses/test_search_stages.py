"""Stages of the search for invariants: bounds at a glance, weighed squares; runs aimed at a violation."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time

from tests.unit.elaborate.texts import read

from haverify.analyses.induction.brackets import bracketed
from haverify.analyses.induction.invented import system_of
from haverify.analyses.synthesis.aimed import aimed
from haverify.analyses.synthesis.glances import glances
from haverify.analyses.synthesis.samples import sample
from haverify.analyses.synthesis.search import CHEAP, MEDIUM, Search
from haverify.analyses.synthesis.weighed import weighed
from haverify.obligations.formula import negation
from haverify.obligations.induction import Induction

DRAIN = """
automaton Drain {
  var a in [0, 20]
  var b in [0, 20]
  init Run where 1 <= a <= 2 and 1 <= b <= 2
  mode Run { domain 0 <= a <= 10 and 0 <= b <= 10; flow { a' = b - a^3; b' = -a * b - b^3 } }
}
property safe on Drain { always b <= 3 }
"""
CLOCKED = """
automaton Lift {
  var x
  var v
  var t
  init Run where x == 0 and v == 1 and t == 0
  mode Run { domain t <= 1; flow { x' = v; v' = 1 / 2 + t / 4; t' = 1 } }
}
property safe on Lift { always v <= 3 }
"""
LORENZ = """
automaton Lorenz {
  var x
  var y
  var z
  init Run where (x + 29/2)^2 + (y + 29/2)^2 + (z - 25/2)^2 <= 1/4
  mode Run { flow { x' = 10 * (y - x); y' = x * (28 - z) - y; z' = x * y - 8/3 * z } }
}
property safe on Lorenz { always (x + 33/2)^2 + (y + 29/2)^2 + (z - 5/2)^2 > 1/4 }
"""
AIMED = """
automaton Car {
  var x
  var v
  var a
  var k
  init Run where x == -20 and v == 0 and k^2 == 2
  mode Run { flow { x' = v; v' = a - k * v; a' = 0; k' = 0 } }
}
property safe on Car { always x < 0 or v > 3 }
"""


def searching(text: str, stage: Callable[[Search], None]) -> Search:
    """What a stage leaves of a goal."""
    system = system_of(induction_of(text), "Run")
    search = Search(system, sample(system), process_time() + 20, [], set(), [], [negation(system.goal)])
    stage(search)
    return search


def induction_of(text: str) -> Induction:
    spec, _, _ = read(f'spec "Stage" version "1.0" unitless\n{text}')
    found = Induction(spec, spec.automata[0], spec.claims[0], spec.claims[0].goals[0])
    found.check()
    return found


def test_what_only_falls_is_bounded_at_a_glance() -> None:
    assert searching(DRAIN, glances).is_done(CHEAP)


def test_what_a_clock_bounds_is_bounded_at_a_glance() -> None:
    assert searching(CLOCKED, glances).is_done(CHEAP)


def test_squares_are_weighed_for_a_rate_of_the_flow() -> None:
    """As `(x^2 - 20 z)' = -8/3 (x^2 - 20 z) - 52/3 x^2`: such forms are kept at rates of the flow alone."""
    search = searching(LORENZ, weighed)
    assert search.is_done(MEDIUM)
    assert [c.rule["rule"] for c in search.cuts] == ["growth"]


def test_a_free_value_is_found_that_violates_the_goal() -> None:
    induction = induction_of(AIMED)
    near, when = next(aimed(system_of(induction, "Run")))
    assert when > 0
    (line, mode, _), *_ = induction.lines()
    told = induction.premises(*induction.starts(line, mode))
    start = next(bracketed(told, [*(v.name for v in induction.automaton.vars), "time"], near, mode))
    low, high = start.roots["k"]
    assert (low * low - 2) * (high * high - 2) < 0
    assert start.point["x"] == -20
