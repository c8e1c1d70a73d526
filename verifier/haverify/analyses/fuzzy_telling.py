"""What a point of the inputs of fuzzy systems looks like to people: values with units, and which rules fire."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.fuzzy_meaning import Meaning
from haverify.analyses.regions import value_at
from haverify.maths.exact import people_text
from haverify.model.unit import ONE, Unit

MOST = 6


def quantity(q: Fraction, unit: Unit | None) -> str:
    """A number with its unit."""
    return people_text(q) if unit is None or unit is ONE else f"{people_text(q)} {unit.text}"


def told(meaning: Meaning, point: Mapping[str, Fraction]) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Names with values, and for each system that the claim speaks of which of its rules fire, strongest first."""
    values = tuple((v, quantity(q, meaning.units[v])) for v, q in sorted(point.items()))
    names = [meaning.on] if meaning.on in meaning.systems.by_name and meaning.on else []
    facts = [firing(meaning, n, point) for n in names if set(meaning.systems.roots(n)) <= set(point)]
    return values, tuple(facts)


def firing(meaning: Meaning, name: str, point: Mapping[str, Fraction]) -> str:
    """Which rules of a system fire at a point, and how strongly."""
    at = meaning.at(name)
    system = meaning.systems.system(name)
    found = []
    for k, rule in enumerate(system.rules):
        strength = value_at(meaning.systems.premise(name, rule.premise, at), point)
        if strength > 0:
            found.append((-strength, k, f"{rule_name(rule.name, k)} -> {rule.term} {people_text(strength)}"))
    if not found:
        return "no rule fires"
    shown = ", ".join(text for _, _, text in sorted(found)[:MOST])
    return shown + (f" and {len(found) - MOST} more" if len(found) > MOST else "")


def rule_name(name: str, place: int) -> str:
    """A rule's name, or its place in the list."""
    return name or f"rule {place + 1}"
