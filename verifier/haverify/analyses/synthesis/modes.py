"""Invariants of several modes: the greatest part of many candidates that starts, flows and jumps keep; then barriers.

A candidate that a part fails to show is dropped, until what is left of all modes holds together (the way of "Houdini").
Where that does not imply the goal, a barrier is sought that is a polynomial for each mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from time import process_time

from haverify.analyses.synthesis.candidates import fits, leaves, says_nothing
from haverify.analyses.synthesis.guesses import guesses
from haverify.analyses.synthesis.joint import SHAPES, joint_barrier
from haverify.analyses.synthesis.keep import boundary, keep
from haverify.analyses.synthesis.reached import frame_of, reached
from haverify.analyses.synthesis.samples import Samples
from haverify.analyses.synthesis.search import MEDIUM
from haverify.analyses.synthesis.system import Cut, Hybrid, Jump
from haverify.analyses.synthesis.used import used
from haverify.maths.polynomial import Monomial, Polynomial
from haverify.obligations.formula import Literal, literal, negation, variables
from haverify.obligations.premises import Premises, primitive
from haverify.solvers.positivity.levels import AFFINE, MONOMIALS, NUMBERS, PAIRS, PRODUCTS, SQUARES, Level
from haverify.solvers.positivity.refute import Effort, is_absurd, refute
from haverify.text.record import holder, replace

QUICK: tuple[Level, ...] = (NUMBERS, MONOMIALS)
THOROUGH: tuple[Level, ...] = (NUMBERS, MONOMIALS, AFFINE, SQUARES, PAIRS, PRODUCTS)
EACH = 2.0  # seconds for one question
PRUNING = 4.0  # seconds for leaving out what is not needed
Kept = dict[str, list[Literal]]
Read = set[tuple[str, Literal]]


@holder
class Modes:
    """The candidates that are left, and what was shown at all starts."""

    hybrid: Hybrid
    samples: dict[str, Samples]
    until: float
    kept: Kept
    levels: tuple[Level, ...]

    def is_over(self) -> bool:
        """Whether the time is up."""
        return process_time() > self.until

    def effort(self, levels: tuple[Level, ...] | None = None) -> Effort:
        """The levels for one question."""
        return Effort(levels or self.levels, min(self.until, process_time() + EACH))

    def premises(self, mode: str) -> Premises:
        """What holds in a mode, with the candidates that are left."""
        return self.hybrid.systems[mode].common.with_(*self.kept[mode])


def invent_modes(hybrid: Hybrid, seconds: float) -> dict[str, list[Cut]] | None:
    """Cuts for each mode that are kept together and imply the goal everywhere; None if not found."""
    hybrid = _without_time(hybrid)
    search = Modes(hybrid, reached(hybrid), process_time() + seconds, {}, QUICK)
    if any(leaves(s.goal, search.samples[m]) for m, s in hybrid.systems.items()):
        return None
    candidates = {m: guesses(s, search.samples[m], hybrid, m) for m, s in hybrid.systems.items()}
    for levels in (QUICK, THOROUGH):
        search.levels = levels
        search.kept = {m: _at_starts(search, m, found) for m, found in candidates.items()}
        _settle(search)
        if _implies(search) is not None:
            return _cuts(_smaller(search))
        if search.is_over():
            return None
    return _with_barrier(search)


def _without_time(hybrid: Hybrid) -> Hybrid:
    """Without the clock of the run, if nothing but the starts reads it."""
    systems = hybrid.systems.values()
    entries = [e for s in systems for e in (*s.common.entries, s.goal)] + [
        e for j in hybrid.jumps for e in j.known.entries
    ]
    read = {v for e in entries for v in variables(e)} | {
        v for s in systems for p in s.field.values() for v in p.variables
    }
    if "time" in read | {v for j in hybrid.jumps for p in j.landing.values() for v in p.variables}:
        return hybrid
    kept = {m: replace(s, field={v: p for v, p in s.field.items() if v != "time"}) for m, s in hybrid.systems.items()}
    return Hybrid(kept, hybrid.jumps)


def _with_barrier(search: Modes) -> dict[str, list[Cut]] | None:
    """Tries barriers beside what is kept."""
    before, frame = search.kept, frame_of(search.samples)
    for shape in SHAPES:
        found = None if search.is_over() else joint_barrier(search.hybrid, before, frame, shape, 10.0)
        if found is None:
            continue
        search.kept = {m: [*before[m], *_below(found[m])] for m in before}
        if all(_below(p) == _at_starts(search, m, _below(p)) for m, p in found.items()):
            _settle(search)
            if _implies(search) is not None:
                return _cuts(_smaller(search))
    return None


def _below(p: Polynomial) -> list[Literal]:
    q = primitive(literal("<=", p))
    return [q] if isinstance(q, Literal) else []


def _at_starts(search: Modes, mode: str, found: Sequence[Literal]) -> list[Literal]:
    """Those that hold in all samples and were shown at all starts."""
    system, samples = search.hybrid.systems[mode], search.samples[mode]
    kept = []
    for q in dict.fromkeys(found):
        says = is_absurd(system.common.with_(negation(q)).entries) or says_nothing(q, samples)
        if not says and (not len(samples.states) or fits(q, samples)) and _begins(search, mode, q):
            kept.append(q)
    return kept


def _begins(search: Modes, mode: str, q: Literal) -> bool:
    """Whether the literal was shown at all starts of the mode."""
    starts = search.hybrid.systems[mode].starts
    return all(refute(s.with_(negation(q)), search.effort(MEDIUM)) is not None for s in starts)


def _settle(search: Modes) -> None:
    """Drops what a jump or a flow is not shown to keep, until nothing is dropped."""
    is_settled = False
    while not is_settled and not search.is_over():
        before = {m: list(found) for m, found in search.kept.items()}
        for jump in search.hybrid.jumps:
            search.kept[jump.target] = [q for q in search.kept[jump.target] if _lands(search, jump, q) is not None]
        for mode in search.kept:
            search.kept[mode] = [q for cut in _flow(search, mode) for q in cut.literals]
        is_settled = all(set(before[m]) == set(search.kept[m]) for m in before)


def _lands(search: Modes, jump: Jump, q: Literal) -> set[Literal] | None:
    """What is read to show a literal about the state after a jump: those like it, or all; None if it is not shown."""
    after = literal(q.op, jump.known.functions.substitute(q.polynomial, jump.landing))
    kept = search.kept[jump.source]
    for given in dict.fromkeys((tuple(o for o in kept if _shape(o) == _shape(q)), tuple(kept))):
        known = jump.known.with_(*given, negation(after))
        proof = refute(known, search.effort())
        if proof is not None:
            return used(proof, known)
    return None


def _shape(q: Literal) -> frozenset[Monomial]:
    """The monomials that are not constant."""
    return frozenset(m for m in q.polynomial.whole if m)


def _flow(search: Modes, mode: str) -> list[Cut]:
    """What the flow keeps of the candidates: one by one under those before, then the rest together."""
    system, found = search.hybrid.systems[mode], list[Cut]()
    known, rest = system.common, list(search.kept[mode])
    grew = True
    while grew:
        grew = False
        for q in list(rest):
            rule = keep(known, [q], system.field, search.effort(QUICK if len(rest) > 12 else None))
            if rule is not None:
                found.append(Cut((q,), rule))
                known = known.with_(q)
                rest.remove(q)
                grew = True
    rest = _together(search, known, rest, system.field)
    rule = keep(known, rest, system.field, search.effort()) if rest else None
    return [*found, Cut(tuple(rest), rule)] if rule is not None else found


def _together(search: Modes, known: Premises, rest: list[Literal], field: dict[str, Polynomial]) -> list[Literal]:
    """The greatest part that is strictly entered at each side."""
    rest = [q for q in rest if q.op in ("<", "<=")]
    while rest and not search.is_over():
        kept = [q for k, q in enumerate(rest) if refute(boundary(known, rest, k, field), search.effort()) is not None]
        if len(kept) == len(rest):
            return rest
        rest = kept
    return []


def _implies(search: Modes) -> Read | None:
    """What is read to show that what is left implies the goal in every mode; None where it does not."""
    found = Read()
    for m, system in search.hybrid.systems.items():
        known = search.premises(m).with_(negation(system.goal))
        proof = refute(known, search.effort(THOROUGH))
        if proof is None:
            return None
        found |= {(m, q) for q in used(proof, known) if q in search.kept[m]}
    return found


def _smaller(search: Modes) -> Modes:
    """What the goal rests on, if that is kept by itself; else all."""
    before, needed, todo = search.kept, Read(), _implies(search) or Read()
    flows = {m: _flow(search, m) for m in before}
    while todo - needed and not search.is_over():
        mode, q = min(todo - needed, key=str)
        needed.add((mode, q))
        todo |= {(mode, o) for o in _flow_reads(search, mode, flows[mode], q)}
        for jump in search.hybrid.jumps:
            if jump.target == mode:
                todo |= {(jump.source, o) for o in _lands(search, jump, q) or () if o in before[jump.source]}
    search.kept = {m: [q for q in found if (m, q) in needed] for m, found in before.items()}
    if not all(_stands(search, m, THOROUGH) for m in before):
        search.kept = before
    until, search.until = search.until, min(search.until, process_time() + PRUNING)
    for mode in before:
        _thin(search, mode)
    search.until = until
    return search


def _thin(search: Modes, mode: str) -> None:
    """Leaves out literals of a mode, many at once and then fewer, as long as the rest stands."""
    size = len(search.kept[mode])
    while size:
        for first in reversed(range(0, len(search.kept[mode]), size)):
            before = search.kept[mode]
            search.kept[mode] = before[:first] + before[first + size :]
            if search.is_over() or not _stands(search, mode, QUICK):
                search.kept[mode] = before
        size //= 2


def _stands(search: Modes, mode: str, levels: tuple[Level, ...]) -> bool:
    """Whether what is left in a mode, and where jumps lead from it, is kept, and implies the goal there."""
    system, known = search.hybrid.systems[mode], search.premises(mode)
    if refute(known.with_(negation(system.goal)), search.effort(levels)) is None:
        return False
    if sum(len(cut.literals) for cut in _flow(search, mode)) < len(search.kept[mode]):
        return False
    linked = [j for j in search.hybrid.jumps if mode in (j.source, j.target)]
    return all(_lands(search, j, q) is not None for j in linked for q in search.kept[j.target])


def _flow_reads(search: Modes, mode: str, flow: Sequence[Cut], q: Literal) -> set[Literal]:
    """The literals of a mode that its flow needs to keep one of them."""
    known = search.hybrid.systems[mode].common
    for cut in flow:
        if q in cut.literals:
            return (set(cut.literals) | used(cut.rule, known)) & set(search.kept[mode])
        known = known.with_(*cut.literals)
    return set()


def _cuts(search: Modes) -> dict[str, list[Cut]]:
    search.until = process_time() + 10.0
    return {m: _flow(search, m) for m in search.kept}
