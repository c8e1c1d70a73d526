"""Proposals in the text of a spec: what its findings propose, and slips in the lines that problems point at."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction

from haverify.diagnostics.codes import severity
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.evidence.verdict import Refuted, Unknown
from haverify.maths.exact import parse_decimal
from haverify.repair.cells import cells_by_line, slips_of
from haverify.repair.change import Change
from haverify.repair.effect import Effect
from haverify.repair.proposal import Proposal
from haverify.repair.reads import stated
from haverify.repair.subject import Subject
from haverify.repair.suspects import claim_spans, finding_spans, model_spans
from haverify.repair.trial import Trials
from haverify.repair.written import written_changes
from haverify.text.record import field, holder, record
from haverify.text.span import Span

MOST_WORK = 2_000_000  # code points read in trials
MOST_SHOWN = 3

_CLASS = {"bounds": 0, "fix": 1, "strictness": 2, "bit": 3}
_COINCIDENT, _ANY = 4, 5
"""A change that helps only at one point, or in one way, is better evidence than a number that may be many others; of
numbers those are likelier that the spec has elsewhere too."""

_GENTLE = (
    *("HA204", "HA205", "HA212", "HA213", "HA304", "HA305", "HA401", "HA510", "HA511", "HA512", "HA513"),
    *("HA514", "HA602", "HA604", "HA606"),
)
"""Findings that other numbers would silence without being righter: only their own fix and strictness are tried."""

_FAR = 4  # so many times as far from what is written, a number is less likely

_NUMERAL = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?", re.ASCII)
_UNIT = re.compile(r"[ \t]*([A-Za-z%][\w/^*%]*)", re.ASCII)
_IN_CLAIM, _IN_MODEL = Fraction(1, 4), Fraction(1)
"""Which share of the old violation the new margin may have, where a claim is changed and where the model is."""


@record
class _Candidate:
    """A change to try; for the sake of `claim`, where it has one, whose new margin may have a `share` of the old."""

    change: Change
    claim: str | None = None
    share: Fraction = _IN_MODEL


@record
class _Try:
    change: Change
    solves: frozenset[str]
    effect: Effect
    is_known: bool  # the new number stands elsewhere in the spec

    def rank(self, left: frozenset[str]) -> tuple[int, int, int]:
        other = _COINCIDENT if self.is_known else _ANY
        return (
            -len(self.solves & left),
            _CLASS.get(self.change.kind, other),
            -len(self.solves | {*self.effect.better}),
        )


@holder
class TextSearch:
    """A search for changes in a spec's text, likelier places first, until nothing is left or the work is done."""

    trials: Trials
    tried: list[_Try] = field(default_factory=list)
    seen: set[object] = field(default_factory=set)
    has_time: Callable[[], bool] = lambda: True
    was_cut: bool = False

    def search(self, findings: Sequence[str], claims: Sequence[str]) -> list[Proposal]:
        """The fewest changes that solve most; those that do as well are said with each."""
        problems = frozenset([*findings, *claims])
        proposals: list[Proposal] = []
        left = problems
        for stage in self._stages(findings, claims):
            if not left:
                break
            self._try_all(stage)
            proposals, left = self._chosen(problems)
        return proposals

    def _stages(self, findings: Sequence[str], claims: Sequence[str]) -> Iterator[Iterator[_Candidate]]:
        """What findings propose; places of errors, of warnings; what claims say; cells they read; their models."""
        found = [self.trials.before.findings[k] for k in findings]
        yield (_Candidate(c) for d in found for c in self._proposed(d))
        for wanted in (Severity.ERROR, Severity.WARNING):
            yield (_Candidate(c) for d in found if severity(d) is wanted for c in self._of_finding(d))
        yield (_Candidate(c, n, _IN_CLAIM) for n in claims for c in self._of_spans(self._goals(n)))
        yield (_Candidate(c, n, _IN_CLAIM) for n in claims for c in self._of_cells(n))
        before = self.trials.before
        about = {n: model_spans(before.text, before.claims[n]) for n in claims}
        yield (_Candidate(c, n) for n, spans in about.items() for c in self._of_spans(spans))

    def _proposed(self, d: Diagnostic) -> Iterator[Change]:
        sources = self.trials.before.text.sources
        if d.fix is not None and d.fix.edits and d.fix.edits[0].span.path in sources:
            first = d.fix.edits[0].span
            line = sources[first.path].position(first.start)[0]
            yield Change("bounds" if d.code == "HA201" else "fix", d.fix.edits, f"line {line}")

    def _of_finding(self, d: Diagnostic) -> Iterator[Change]:
        changes = self._of_spans(finding_spans(self.trials.before.text, d))
        return (c for c in changes if c.kind == "strictness" or d.code not in _GENTLE)

    def _of_cells(self, name: str) -> Iterator[Change]:
        """Slips in cells that a claim states or its automaton moves by: numbers as in the text, kept in a table."""
        before = self.trials.before
        assert before.spec is not None
        wanted = stated(before.spec, before.claims[name])
        places = (p for line in cells_by_line(before.spec).values() for p in line)
        for place in places:
            if any(c.constant in wanted for c in place):
                yield from slips_of(place, before.text.sources)

    def _goals(self, name: str) -> list[Span]:
        before = self.trials.before
        goals = {p.goal for p in before.evidence[name].parts if isinstance(p.verdict, Refuted)}
        return claim_spans(before.text, before.claims[name], goals)

    def _of_spans(self, spans: Iterable[Span]) -> Iterator[Change]:
        for span in spans:
            source = self.trials.before.text.sources.get(span.path)
            yield from written_changes(source, span) if source is not None else ()

    # ---- trials ------------------------------------------------------------------

    def _try_all(self, candidates: Iterable[_Candidate]) -> None:
        """Try what was not tried yet, as long as there is work left."""
        before = self.trials.before
        size = sum(len(before.text.sources[tree.path].text) for tree in before.text.trees)
        for c in candidates:
            known = any(t.change.edits == c.change.edits for t in self.tried)
            if known or (c.change.edits, c.claim) in self.seen:
                continue
            if (len(self.seen) + 1) * size > MOST_WORK or not self.has_time():
                self.was_cut = True
                return
            self.seen.add((c.change.edits, c.claim))
            self._try(c)

    def _try(self, c: _Candidate) -> None:
        """Keep a change that solves something and makes nothing worse."""
        if not self._is_worth_it(c):
            return
        effect = self.trials.of(c.change)
        if effect is not None and effect.solved and not effect.worse and not effect.come:
            solves = frozenset((*effect.findings, *effect.mended))
            self.tried.append(_Try(c.change, solves, effect, self._is_known(c.change)))

    def _is_worth_it(self, c: _Candidate) -> bool:
        """A first look, before all claims are decided: the claim in question alone, or the findings."""
        before, after = self.trials.before, self.trials.before.edited(c.change.edits)
        if not after.has_meaning:
            return False
        if c.claim is None:
            after.lint()
            return after.has_meaning and len(before.findings) > len(after.findings)
        if c.claim not in after.claims:
            return False
        after.decide([c.claim])
        if not after.is_expected(c.claim):
            return False
        return c.change.kind in _CLASS or self._is_tight(after, c, c.claim)

    def _is_tight(self, after: Subject, c: _Candidate, name: str) -> bool:
        """Whether a claim says about what is then the case: far off the mark, a number makes it true by accident.

        A bound of the claim itself moves by the violation and a share of it at most.
        """
        now, then = (s.evidence[name].verdict for s in (self.trials.before, after))
        if isinstance(now, Unknown) or isinstance(then, Unknown):
            return False
        if now.margin is None or then.margin is None:
            return True
        if c.share == _IN_CLAIM and self._unit(c.change) == now.margin.unit:
            return self._distance(c.change) <= -now.margin.low * (1 + c.share)
        return then.margin.low <= -now.margin.low * c.share

    def _unit(self, change: Change) -> str:
        """The unit of a changed number: what stands behind it, in a table that of its column."""
        first = change.edits[0].span
        if change.numbers and self.trials.before.spec is not None:
            units = {k.name: k.unit for k in self.trials.before.spec.constants}
            return str(units.get(change.numbers[0][0]) or "")
        found = _UNIT.match(self.trials.before.text.sources[first.path].text, first.end)
        return found[1] if found else ""

    def _is_known(self, change: Change) -> bool:
        """Whether the new number stands elsewhere in the file, and is one that does not stand everywhere."""
        first = change.edits[0]
        value = parse_decimal(first.text)
        if value is None or abs(value) in (0, 1):
            return False
        text = self.trials.before.text.sources[first.span.path].text
        rest = text[: first.span.start] + " " + text[first.span.end :]
        return any(parse_decimal(m) == value for m in _NUMERAL.findall(rest))

    def _distance(self, change: Change) -> Fraction:
        """How far a changed number is from the one as written; 0 for other changes."""
        first = change.edits[0]
        old = parse_decimal(self.trials.before.text.sources[first.span.path].at(first.span))
        new = parse_decimal(first.text)
        return abs(new - old) if old is not None and new is not None and len(change.edits) == 1 else Fraction(0)

    # ---- choice ------------------------------------------------------------------

    def _chosen(self, problems: frozenset[str]) -> tuple[list[Proposal], frozenset[str]]:
        """Changes that solve the problems, those first that solve most of what is left, and what they leave."""
        found, left = list[Proposal](), problems
        while helpful := [t for t in self.tried if t.solves & left]:
            ranks = {id(t): t.rank(left) for t in helpful}
            best = min(ranks.values())
            tied = [t for t in helpful if ranks[id(t)] == best]
            near = min(self._distance(t.change) for t in tied) * _FAR
            first, *others = sorted(tied, key=lambda t: (self._distance(t.change) > near, t.change.order()))
            equals = [t.change for t in others if t.solves == first.solves]
            found.append(Proposal(first.change, first.effect, (), tuple(equals[:MOST_SHOWN]), len(equals[MOST_SHOWN:])))
            left -= first.solves
        return found, left
