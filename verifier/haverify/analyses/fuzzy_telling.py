"""What a point of the inputs of fuzzy systems looks like to people: values with units, and which rules fire."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.fuzzy_meaning import Meaning
from haverify.analyses.fuzzy_systems import Inputs
from haverify.analyses.regions import value_at
from haverify.maths.exact import people_text
from haverify.model.unit import ONE, Unit

MOST = 6


def quantity(q: Fraction, unit: Unit | None) -> str:
    """A number with its unit."""
    return people_text(q) if unit is None or unit is ONE else f"{people_text(q)} {unit.text}"


def told(meaning: Meaning, point: Mapping[str, Fraction]) -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Names with values; which rules fire, strongest first, in the claim's own system and in each that it applies."""
    values = tuple((v, quantity(q, meaning.units[v])) for v, q in sorted(point.items()))
    facts = []
    if meaning.on in meaning.systems.by_name and meaning.on and set(meaning.systems.roots(meaning.on)) <= set(point):
        facts.append(firing(meaning, meaning.on, meaning.at(meaning.on), point))
    facts += [_chosen(meaning, name, output, at, point) for name, output, at in meaning.applied]
    return values, tuple(dict.fromkeys(facts))


def _chosen(meaning: Meaning, name: str, output: str, at: Inputs, point: Mapping[str, Fraction]) -> str:
    """The value of an output for some inputs, and why."""
    roots = meaning.systems.roots(name)
    given = ", ".join(f"{v} = {quantity(value_at(n, point), roots[v].unit)}" for v, n in at.items())
    terms = meaning.systems.outputs(name)[output]
    found = [(-value_at(meaning.systems.strength(name, output, t, at), point), k) for k, t in enumerate(terms)]
    is_any = found and min(found)[0] < 0
    result = f"is {terms[min(found)[1]]}" if is_any else "has no value"
    return f"{name}.{output}({given}) {result}: {firing(meaning, name, at, point)}"


def firing(meaning: Meaning, name: str, at: Inputs, point: Mapping[str, Fraction]) -> str:
    """Which rules of a system fire for some inputs, and how strongly."""
    found = []
    for k, rule in enumerate(meaning.systems.system(name).rules):
        strength = value_at(meaning.systems.premise(name, rule.premise, at), point)
        if strength > 0:
            found.append((-strength, k, f"{rule.name or f'rule {k + 1}'} -> {rule.term} {people_text(strength)}"))
    if not found:
        return "no rule fires"
    shown = ", ".join(text for _, _, text in sorted(found)[:MOST])
    return shown + (f" and {len(found) - MOST} more" if len(found) > MOST else "")
