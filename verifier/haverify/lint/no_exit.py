"""HA309: a mode without outgoing edge that is not marked `terminal`."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.hybrid import Mode
from haverify.model.spec import Spec
from haverify.text.span import Span


@rule("HA309")
def no_exit(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Automata without any edge are flows, where the question does not arise."""
    for automaton in spec.automata:
        sources = {e.source for e in automaton.edges}
        for mode in automaton.modes:
            if sources and mode.name not in sources and not mode.terminal:
                yield Diagnostic(
                    "HA309",
                    f"mode {mode.name} has no edge and is not marked `terminal`",
                    span=mode.span,
                    help="if runs may end here, write `terminal` in the mode",
                    fix=_fix(facts, mode),
                    key=f"{automaton.name}: mode {mode.name} has no edge",
                )


def _fix(facts: Facts, mode: Mode) -> Fix | None:
    """`terminal` right after the opening brace of the mode."""
    at = facts.text(mode.span).find("{")
    if mode.span is None or at < 0:
        return None
    place = mode.span.start + at + 1
    return Fix("mark the mode as terminal", (Edit(Span(mode.span.path, place, place), " terminal;"),), safe=True)
