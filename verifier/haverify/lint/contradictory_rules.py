"""HA512: rules of a fuzzy system with equal premises and different conclusions."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._fuzzy import normal, rule_name
from haverify.lint._registry import rule
from haverify.model.fuzzy import FuzzyController, FuzzyRule
from haverify.model.spec import Spec


@rule("HA512")
def contradictory_rules(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Premises count as equal up to the order of their parts; whatever the inputs are, both rules are as strong."""
    for system in spec.fuzzy:
        first: dict[object, FuzzyRule] = {}
        for r in system.rules:
            before = first.setdefault((r.output, normal(r.premise)), r)
            if before.term != r.term:
                yield _finding(system, before, r)


def _finding(system: FuzzyController, a: FuzzyRule, b: FuzzyRule) -> Diagnostic:
    names = f"{rule_name(system, a)} and {rule_name(system, b)}"
    terms = f"`{a.term}` and `{b.term}`"
    equal = _premises(system, a) == _premises(system, b)
    told = f"{terms} are always equally strong" if equal else f"they conclude {terms}"
    return Diagnostic(
        "HA512",
        f"{names} have the same premise; {told}",
        span=b.span,
        labels=(Label(a.span, "the same premise"),) if a.span else (),
        key=f"{system.name}: {names} conclude {terms} from the same premise",
    )


def _premises(system: FuzzyController, like: FuzzyRule) -> set[object]:
    return {normal(r.premise) for r in system.rules if (r.output, r.term) == (like.output, like.term)}
