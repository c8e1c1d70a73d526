"""Proposals in the text of a spec: what its findings propose, and slips in the lines that a problem points at."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.evidence.verdict import Margin, Unknown
from haverify.repair.change import Change
from haverify.repair.effect import Effect
from haverify.repair.proposal import Proposal
from haverify.repair.suspects import claim_spans, finding_spans, model_spans
from haverify.repair.trial import Trials
from haverify.repair.written import written_changes
from haverify.text.record import holder, record
from haverify.text.span import Span

MOST_PER_PROBLEM = 150
MOST_SHOWN = 3

_CLASS = {"bounds": 0, "fix": 1, "strictness": 2, "bit": 3, "cells": 4}
"""A change that helps only at one point, or in one way, is better evidence than a number that may be many others."""

_GENTLE = ("HA204", "HA205", "HA304", "HA305", "HA401", "HA404", "HA602", "HA604", "HA606")
"""Findings that other numbers would silence without being righter: only their own fix and strictness are tried."""


@record
class _Try:
    change: Change
    effect: Effect

    def rank(self) -> tuple[int, int, int]:
        return (-self.effect.solved, _CLASS.get(self.change.kind, 5), -len(self.effect.better))


@holder
class TextSearch:
    """A search for changes in the spec's text; `hopeless` are problems that tables are to blame for."""

    trials: Trials
    hopeless: frozenset[str] = frozenset()
    was_cut: bool = False

    def search(self, findings: Sequence[str], claims: Sequence[str]) -> list[Proposal]:
        """A proposal for each problem that one change solves; a change that solves several is proposed once."""
        found: list[Proposal] = []
        solved: set[str] = set()
        for key in findings:
            if key not in solved:
                self._add(found, solved, self._of_finding(key))
        for name in claims:
            if name not in solved and name not in self.hopeless:
                self._add(found, solved, self._of_claim(name))
        return found

    def _add(self, found: list[Proposal], solved: set[str], proposal: Proposal | None) -> None:
        if proposal is not None:
            found.append(proposal)
            solved |= {*proposal.effect.findings, *proposal.effect.mended}

    def _of_finding(self, key: str) -> Proposal | None:
        d = self.trials.before.findings[key]
        candidates = list(self._proposed(d))
        for span in finding_spans(self.trials.before.text, d):
            candidates += [c for c in self._written(span) if c.kind == "strictness" or d.code not in _GENTLE]
        return _best([t for t in self._tried(candidates) if key in t.effect.findings])

    def _proposed(self, d: Diagnostic) -> Iterator[Change]:
        """What the finding itself proposes."""
        if d.fix is not None and d.fix.edits and d.fix.edits[0].span.path in self.trials.before.text.sources:
            kind = "bounds" if d.code == "HA201" else "fix"
            source = self.trials.before.text.sources[d.fix.edits[0].span.path]
            yield Change(kind, d.fix.edits, f"line {source.position(d.fix.edits[0].span.start)[0]}")

    def _of_claim(self, name: str) -> Proposal | None:
        before = self.trials.before
        claim = before.claims[name]
        own = [c for span in claim_spans(before.text, claim) for c in self._written(span)]
        model = [c for span in model_spans(before.text, claim) for c in self._written(span)]
        tried = [t for t in self._tried([*own, *model], name) if name in t.effect.mended]
        stated = {id(c) for c in own}
        return _best([t for t in tried if id(t.change) not in stated or self._is_tight(t.change, name)])

    def _written(self, span: Span) -> list[Change]:
        source = self.trials.before.text.sources.get(span.path)
        return written_changes(source, span) if source is not None else []

    def _tried(self, changes: Iterable[Change], name: str | None = None) -> list[_Try]:
        """The changes that help and make nothing worse; with `name`, those after which this claim is as expected."""
        found, seen = [], set[tuple[object, ...]]()
        for change in changes:
            if change.edits in seen:
                continue
            if len(seen) >= MOST_PER_PROBLEM:
                self.was_cut = True
                break
            seen.add(change.edits)
            effect = self._effect(change, name)
            if effect is not None and effect.helps and not effect.worse and not effect.come:
                found.append(_Try(change, effect))
        return found

    def _effect(self, change: Change, name: str | None) -> Effect | None:
        """The whole effect, asked for only where the claim in question comes out as expected."""
        if name is not None:
            alone = self.trials.before.edited(change.edits)
            if not alone.has_meaning or name not in alone.claims:
                return None
            alone.decide([name])
            if alone.broken(name) or alone.verdict(name) == "unknown":
                return None
        return self.trials.of(change)

    def _is_tight(self, change: Change, name: str) -> bool:
        """Whether a changed claim says about what is the case: any weaker claim would be true as well."""
        if change.kind in ("strictness", "bounds", "bit"):
            return True
        after = self.trials.before.edited(change.edits)
        after.decide([name])
        now, then = (s.evidence[name].verdict for s in (self.trials.before, after))
        if isinstance(now, Unknown) or isinstance(then, Unknown):
            return False
        return _margin(then.margin) * 4 <= -_margin(now.margin)


def _margin(margin: Margin | None) -> Fraction:
    return Fraction(0) if margin is None else margin.low


def _best(tried: Sequence[_Try]) -> Proposal | None:
    if not tried:
        return None
    best = min(t.rank() for t in tried)
    first, *others = sorted((t for t in tried if t.rank() == best), key=lambda t: t.change.order())
    equals = tuple(t.change for t in others)
    return Proposal(first.change, first.effect, (), equals[:MOST_SHOWN], max(0, len(equals) - MOST_SHOWN))
