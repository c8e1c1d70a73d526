"""Which errors without meaning concern nothing but the claims and automata in whose text they stand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.syntax import tree as t
from haverify.text.span import Span

_OF_ALL = ("HA001", "HA003", "HA004", "HA006")  # what was not read may have said anything; a name may mean either


def is_confined(spec: Spec, found: Iterable[Diagnostic], trees: Sequence[t.Tree]) -> bool:
    """Whether every error without meaning stands in a claim or an automaton that the model therefore lacks.

    The elaboration leaves out an element with an error and whatever depends on it; so what is in the model then is as
    its author wrote it. An error in anything else (an assumption, a param, a table) might concern every claim.
    """
    return all(_is_in_lost_item(spec, d, trees) for d in found if is_meaningless(d))


def _is_in_lost_item(spec: Spec, d: Diagnostic, trees: Sequence[t.Tree]) -> bool:
    if d.code in _OF_ALL or d.span is None:
        return False
    at = d.span
    items = [
        i
        for tree in trees
        for i in tree.items
        if i.span.path == at.path and i.span.start <= at.start and at.end <= i.span.end
    ]
    return len(items) == 1 and _is_lost(spec, items[0])


def _is_lost(spec: Spec, item: t.Item) -> bool:
    """Whether nothing of an item is in the model; only claims and automata may be missing without harm."""
    kept: Sequence[Claim | HybridAutomaton]
    if isinstance(item.body, (t.Property, t.Invariant)):
        kept = spec.claims
    elif isinstance(item.body, t.Automaton):
        kept = spec.automata
    else:
        return False
    spans = [e.span for e in kept]
    return not any(s is not None and s.path == item.span.path and _meets(s, item.span) for s in spans)


def _meets(a: Span, b: Span) -> bool:
    return a.start < b.end and b.start < a.end
