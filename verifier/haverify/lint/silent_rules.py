"""HA511: inputs at which no rule of a fuzzy system fires."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._fuzzy import Point, UndecidedError, shown, somewhere, unfolded
from haverify.lint._registry import rule
from haverify.model.fuzzy import FuzzyController
from haverify.model.spec import Spec

if TYPE_CHECKING:
    from haverify.analyses.fuzzy_meaning import Meaning
    from haverify.analyses.regions import Truth


@rule("HA511")
def silent_rules(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """For each output that has rules; the witness has as many inputs inside terms as it can."""
    for system, meaning in unfolded(spec, facts):
        for output, _ in system.outputs:
            rules = meaning.systems.rules(system.name, output, None)
            try:
                point = _silence(facts, system, meaning, output) if rules else None
            except UndecidedError:
                continue
            if point is not None:
                many = f"all {len(rules)} rules for {output} are 0" if len(rules) > 1 else f"the rule for {output} is 0"
                yield Diagnostic(
                    "HA511",
                    f"{shown(meaning, point)}: {many}",
                    span=system.span,
                    notes=(f"there {system.name}.{output}(...) has no value",),
                    key=f"{system.name}: inputs at which no rule for {output} fires",
                )


def _silence(facts: Facts, system: FuzzyController, meaning: Meaning, output: str) -> Point | None:
    from haverify.analyses.fuzzy_systems import ZERO
    from haverify.analyses.regions import at_most, both, holds_at
    from haverify.analyses.regions_round import rounded
    from haverify.analyses.regions_sample import sample

    silent = at_most(meaning.systems.strength(system.name, output, None, meaning.at(system.name)), ZERO)
    found = somewhere(facts, "HA511", system, meaning, silent)
    if found is None:
        return None
    truth = silent
    full = {v: _is_full(meaning, system.name, v) for v in meaning.ranges}
    for free in _subsets(sorted(meaning.ranges)):
        wanted = both([*(full[v] for v in meaning.ranges if v not in free), silent])  # what is quick to try first
        better = sample(wanted, meaning.ranges)
        if better is not None:
            found, truth = better, wanted
            break
    return rounded(found, meaning.ranges, lambda p: holds_at(truth, p))


def _subsets(names: list[str]) -> Iterator[tuple[str, ...]]:
    for size in range(min(len(names), 3)):
        yield from combinations(names, size)


def _is_full(meaning: Meaning, system: str, name: str) -> Truth:
    """The input belongs fully to some term, or has none."""
    from haverify.analyses.fuzzy_systems import ONE, membership
    from haverify.analyses.regions import at_most, extreme

    terms = meaning.systems.roots(system)[name].terms
    x = meaning.at(system)[name]
    return at_most(ONE, extreme("max", [membership(t, x) for t in terms])) if terms else True
