"""HA205: a strict bound in a domain, which `LANGUAGE S6` reads as closed."""

from __future__ import annotations

import re
from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Mode
from haverify.model.spec import Spec
from haverify.text.span import Span


@rule("HA205")
def strict_domain(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """One finding for each domain; modes whose neighbours share the boundary contain it both."""
    for automaton in spec.automata:
        for mode in automaton.modes:
            strict = [e for e in nodes(mode.domain) if e.op in ("<", ">") and e.span is not None]
            if strict and not any(e.op == "not" for e in nodes(mode.domain)):
                yield _finding(facts, mode, strict)


def _finding(facts: Facts, mode: Mode, strict: list[Expr]) -> Diagnostic:
    texts = [facts.text(e.span) for e in strict]
    edits = [edit for e in strict if (edit := _closed(facts, e)) is not None]
    shown = ", ".join(f"`{t}`" for t in texts if t) or "a strict bound"
    return Diagnostic(
        "HA205",
        f"mode {mode.name}: a domain is closed; {shown} is read with its bound included",
        span=_span(strict),
        help="write `<=` for `<` and `>=` for `>` to say what is meant",
        fix=Fix("close the bounds", tuple(edits), safe=True) if len(edits) == len(strict) else None,
        key=f"strict bound in the domain of mode {mode.name}",
    )


def _span(strict: list[Expr]) -> Span | None:
    spans = [e.span for e in strict if e.span]
    return spans[0].to(spans[-1]) if spans else None


def _closed(facts: Facts, comparison: Expr) -> Edit | None:
    """The operator between the two sides of a comparison, made closed."""
    first, second = sorted((c.span for c in comparison.children if c.span), key=lambda s: s.start) or (None, None)
    if first is None or second is None:
        return None
    between = Span(first.path, first.end, second.start)
    found = re.search(r"[<>](?!=)", facts.text(between))
    if found is None:
        return None
    at = between.start + found.start()
    return Edit(Span(between.path, at, at + 1), found[0] + "=")
