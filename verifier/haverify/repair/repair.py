"""The smallest changes that make a spec plausible: sought in its tables first, then in its text, each one tried."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

from haverify.diagnostics.codes import is_error
from haverify.diagnostics.diagnostic import Edit
from haverify.evidence.verdict import Refuted
from haverify.repair.bound_repairs import bound_repairs
from haverify.repair.choice import Hopeless
from haverify.repair.effect import Effect, effect
from haverify.repair.proposal import Outcome, Proposal
from haverify.repair.subject import Subject, hash_edits
from haverify.repair.table_repairs import table_repairs
from haverify.repair.text_search import TextSearch
from haverify.repair.trial import Trials
from haverify.report.gate import expected
from haverify.text.record import record


def repair(
    before: Subject, accepted: Collection[str], only: str | None = None, has_time: Callable[[], bool] = lambda: True
) -> Outcome:
    """Proposals for what is wrong in a spec that is read and linted and has a meaning.

    `accepted` are the keys of findings that are on record with a reason. Those about the text stay as they are; those
    that table cells explain do not: what was copied wrongly is wrong, whatever is known of it. With `only`, what one
    claim (or family) speaks of is looked at, and nothing else. The search in the text ends where `has_time` says no.
    """
    before.decide(before.claims)
    trials, asked = (
        Trials(before),
        _Asked(frozenset(before.findings) - frozenset(accepted), frozenset(before.findings), only),
    )
    proposals, hopeless = table_repairs(trials, only)
    if only is None:
        proposals += bound_repairs(trials, {n for p in proposals for n, _ in p.change.numbers})
    state = (trials.after([p.change for p in proposals]) if proposals else None) or before
    search = TextSearch(trials, has_time=has_time)
    proposals += search.search(
        [k for k in asked.findings(state) if k in before.findings], _unblamed(state, asked.claims(state), hopeless)
    )
    state, together, kept = _together(trials, proposals)
    remarks = [*_remarks(state, asked), *(["there are more changes than were tried"] if search.was_cut else [])]
    edits = _edits(kept)
    return Outcome(
        tuple(kept), together, (*edits, *hash_edits(before.text, list(edits))),
        tuple(asked.left(state, hopeless)), tuple(remarks),
    )  # fmt: skip


@record
class _Asked:
    """What is to be mended: findings of the spec as written that nobody accepted, claims that are not as expected."""

    open: frozenset[str]
    known: frozenset[str]
    only: str | None

    def findings(self, subject: Subject) -> list[str]:
        """Those that are there, also where the same is said of other values now."""
        moved = {k.split(":")[0] for k in self.open if k not in subject.findings}
        there = [k for k in subject.findings if k in self.open or (k not in self.known and k.split(":")[0] in moved)]
        return there if self.only is None else []

    def claims(self, subject: Subject) -> list[str]:
        return [n for n in subject.claims if self.is_about(n) and subject.broken(n)]

    def is_about(self, claim: str) -> bool:
        return self.only is None or self.only in (claim, claim.split("[")[0])

    def left(self, subject: Subject, hopeless: Iterable[Hopeless]) -> Iterator[str]:
        """The problems of a subject, in words."""
        broken = self.claims(subject)
        for h in hopeless:
            if not any(t.limit is not None and t.limit.is_firm and t.limit.claim in broken for t in h.troubles):
                continue
            lines = ", ".join(f"{path}:{row}" for path, row in h.lines)
            speaking = {t.limit.claim if t.limit else "" for t in h.troubles}
            doubt = f"; or {speaking.pop()}, which alone speaks against it, is wrong" if len(speaking) == 1 else ""
            yield f"{lines}: no single change of a cell makes the row fit{doubt}"
        yield from (f"finding {k}" for k in self.findings(subject) if is_error(subject.findings[k]))
        yield from (f"{n}: violated in {'; '.join(subject.broken(n))}" for n in broken)


def _unblamed(subject: Subject, claims: Iterable[str], hopeless: Iterable[Hopeless]) -> list[str]:
    """The claims that rows are not to blame for: rows beyond repair against which more than one claim speaks."""
    rows: set[tuple[str, str]] = set()
    for h in hopeless:
        if len({t.limit.claim if t.limit else "" for t in h.troubles}) > 1:
            rows |= {(mode, output) for t in h.troubles for _, mode, output in t.keys}
    return [n for n in claims if not _all_in(subject, n, rows)]


def _all_in(subject: Subject, name: str, rows: set[tuple[str, str]]) -> bool:
    """Whether all violated parts of a claim are about these rows, in a mode or at an edge."""
    parts = [p for p in subject.evidence[name].parts if isinstance(p.verdict, Refuted)]
    return bool(parts) and all(any((m, p.output) in rows for m in p.where.split(" -> ")) for p in parts)


def _edits(proposals: Iterable[Proposal]) -> tuple[Edit, ...]:
    return tuple(e for p in proposals for e in p.change.edits)


def _together(trials: Trials, proposals: list[Proposal]) -> tuple[Subject, Effect | None, list[Proposal]]:
    """The proposals that go together, in order of place, and what they do together.

    One that touches a place a second time, or undoes what those before it mend, is left out.
    """
    kept: list[Proposal] = []
    state = trials.before
    for added in (proposals, *([p] for p in proposals)):
        if len(kept) < len(proposals):
            after = _joined(trials, [*kept, *added])
            kept, state = ([*kept, *added], after) if after is not None else (kept, state)
    return state, effect(trials.before, state) if kept else None, sorted(kept, key=_place)


def _joined(trials: Trials, proposals: Sequence[Proposal]) -> Subject | None:
    """The subject after all proposals, None where one touches a place again or undoes what another mends."""
    edits = _edits(proposals)
    if any(_meet(a, b) for k, a in enumerate(edits) for b in edits[:k]):
        return None
    after = trials.after([p.change for p in proposals]) if edits else None
    mended = [n for p in proposals for n in p.effect.mended]
    return after if after is not None and not any(after.broken(n) for n in mended if n in after.claims) else None


def _meet(a: Edit, b: Edit) -> bool:
    return a.span.path == b.span.path and a.span.start < b.span.end and b.span.start < a.span.end


def _place(p: Proposal) -> tuple[str, int]:
    first = p.change.edits[0].span
    return (first.path, first.start)


def _remarks(subject: Subject, asked: _Asked) -> Iterator[str]:
    names = [n for n, c in subject.claims.items() if asked.is_about(n) and expected(c) != "unknown"]
    open_ = [n for n in names if subject.verdict(n) == "unknown"]
    if open_:
        shown = ", ".join(open_[:3]) + (", ..." if len(open_) > 3 else "")
        yield f"undecided, so no change was sought: {shown}"
    warnings = [k for k in asked.findings(subject) if not is_error(subject.findings[k])]
    if warnings:
        yield f"warnings that no small change removes: {len(warnings)}; `haverify lint` shows them"
