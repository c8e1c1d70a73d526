"""HA513: rules of a fuzzy system that never make a difference."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._fuzzy import UndecidedError, rule_name, somewhere, unfolded
from haverify.lint._registry import rule
from haverify.model.fuzzy import FuzzyController, FuzzyRule
from haverify.model.spec import Spec

if TYPE_CHECKING:
    from haverify.analyses.fuzzy_meaning import Meaning


@rule("HA513")
def idle_rule(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """A rule that is nowhere stronger than the others of its conclusion; of two equal ones the later is idle."""
    for system, meaning in unfolded(spec, facts):
        idle: list[FuzzyRule] = []
        found = []
        for r in reversed(system.rules):
            others = [o for o in system.rules if (o.output, o.term) == (r.output, r.term) and o is not r]
            others = [o for o in others if all(o is not i for i in idle)]
            try:
                exceeded = _exceeds(facts, system, meaning, r, others)
            except UndecidedError:
                break
            if not exceeded:
                idle.append(r)
                found.append(_finding(facts, system, meaning, r, others))
        yield from reversed(found)


def _exceeds(facts: Facts, system: FuzzyController, meaning: Meaning, r: FuzzyRule, others: list[FuzzyRule]) -> bool:
    """Is the rule somewhere stronger than all of the others?"""
    from haverify.analyses.fuzzy_systems import ZERO
    from haverify.analyses.regions import at_most, extreme

    at = meaning.at(system.name)
    degree = meaning.systems.premise(system.name, r.premise, at)
    rest = extreme("max", [meaning.systems.premise(system.name, o.premise, at) for o in others] or [ZERO])
    return somewhere(facts, "HA513", system, meaning, at_most(rest, degree, True)) is not None


def _finding(
    facts: Facts, system: FuzzyController, meaning: Meaning, r: FuzzyRule, others: list[FuzzyRule]
) -> Diagnostic:
    name = rule_name(system, r)
    if not _exceeds(facts, system, meaning, r, []):
        told = f"{name} of {system.name} never fires"
    else:
        single = next((o for o in others if others == [o] or not _exceeds(facts, system, meaning, r, [o])), None)
        rest = rule_name(system, single) if single else f"the other rules for `{r.term}`"
        told = f"{name} never exceeds {rest} for any input; it has no effect"
    return Diagnostic("HA513", told, span=r.span, key=f"{system.name}: {name} has no effect")
