"""HA501: cells for which a cellular automaton has no rule."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._finite import KEYED, listed, reader_name, tables, world_of
from haverify.lint._registry import rule
from haverify.model.spec import Spec


@rule("HA501")
def partial_rules(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """One finding for each automaton; a formula that has no value for a cell leaves it without a next one too."""
    for automaton, steps in tables(spec, facts):
        missing = [c for c, step in steps.items() if not step.results]
        if missing:
            what = "no value of next() for" if automaton.formula is not None else "no rule for"
            named = [reader_name(world_of(spec, facts), c) for c in missing]
            yield Diagnostic(
                "HA501",
                f"{automaton.name} is not total: {what} {listed(named)}",
                span=automaton.span,
                label=f"{len(missing)} of {len(steps)} cells lead nowhere",
                key=f"{automaton.name} is not total: {listed([bits for _, bits in missing], KEYED)}",
            )
