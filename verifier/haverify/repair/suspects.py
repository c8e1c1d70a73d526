"""The stretches of text that a problem points at."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.model.claim import Claim
from haverify.repair.subject import Text
from haverify.syntax import tree as t
from haverify.text.span import Span


def finding_spans(text: Text, d: Diagnostic) -> list[Span]:
    """The places of a finding that stand in a spec: rules and conditions, not declarations as a whole."""
    specs = {tree.path for tree in text.trees}
    spans = [s for s in (d.span, *(label.span for label in d.labels)) if s is not None and s.path in specs]
    return list(dict.fromkeys(_line(text, s) for s in spans))


def _line(text: Text, span: Span) -> Span:
    """A span that is only a name, widened to the end of its line."""
    source = text.sources[span.path]
    if not source.at(span).replace("_", "").isalnum():
        return span
    end = source.text.find("\n", span.end)
    return Span(span.path, span.start, end if end >= 0 else len(source.text))


def claim_spans(text: Text, claim: Claim, goals: Collection[int]) -> list[Span]:
    """The goals of these numbers (none: all) of a claim and what it assumes, as written."""
    name = claim.name.split("[")[0]
    for tree in text.trees:
        for item in tree.items:
            body = item.body
            if isinstance(body, t.Property) and body.declared.name == name:
                stated = [line.span for line in body.lines if isinstance(line.body, t.Goal)]
                others = [line.span for line in body.lines if isinstance(line.body, t.Assume | t.Horizon)]
                return [g for k, g in enumerate(stated) if not goals or k in goals] + others
            if isinstance(body, t.Invariant) and body.declared.name == name:
                return [item.span]
    return []


_MODELS = (t.Automaton, t.System, t.Cellular, t.Relation, t.Fuzzy)


def model_spans(text: Text, claim: Claim) -> list[Span]:
    """What a claim is about, with that which it is made from or put together of, and the spec's own numbers."""
    found: list[Span] = []
    wanted = {(claim.on or "").rsplit("_", 1)[-1], claim.on or ""} - {""}
    bodies = [item.body for tree in text.trees for item in tree.items]
    for body in reversed(bodies):  # what is made of something stands behind it
        if isinstance(body, t.Instance) and body.name in wanted:
            wanted |= set(_names(body.base))
            found.append(body.span)
        elif isinstance(body, t.System) and body.name in wanted:
            parts = [m.body for m in body.members if isinstance(m.body, t.Part)]
            wanted |= {name for part in parts for name in _names(part.base)}
    found += [b.span for b in bodies if isinstance(b, _MODELS) and b.name in wanted]
    return found + [b.span for b in bodies if isinstance(b, t.Const | t.Param)]


def _names(e: t.Expr) -> Iterator[str]:
    if isinstance(e, t.Name):
        yield e.id
    elif isinstance(e, t.Binary):
        yield from _names(e.left)
        yield from _names(e.right)
