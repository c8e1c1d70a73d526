"""Differential saturation: prove cuts one after the other, from cheap to dear, until domain and cuts imply the goal.

Parts of the goal about quantities that nothing links are searched one by one, each in a system of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import process_time

from haverify.analyses.synthesis.bounded import boxes, decreasing, integrals, rounds, traps
from haverify.analyses.synthesis.candidates import leaves
from haverify.analyses.synthesis.glances import glances
from haverify.analyses.synthesis.keep import keep
from haverify.analyses.synthesis.samples import Samples, sample
from haverify.analyses.synthesis.search import CHEAP, DEAR, MEDIUM, Search, linked_names
from haverify.analyses.synthesis.separated import FIRST, LATER, barriers
from haverify.analyses.synthesis.signed import constants, equations, goal_itself, higher, signs
from haverify.analyses.synthesis.system import Cut, System
from haverify.analyses.synthesis.used import used
from haverify.analyses.synthesis.weighed import weighed
from haverify.obligations.formula import Formula, Literal, conjunction, negation, variables
from haverify.obligations.premises import Premises, members
from haverify.solvers.positivity.levels import Level
from haverify.solvers.positivity.powers import lowered
from haverify.text.record import replace

SHARE = 0.6  # of the time that is left, for a block that is not the last


def invent(system: System, seconds: float) -> list[Cut] | None:
    """Cuts that, with the common premises, imply the goal, each kept under those before it; None if not found."""
    until = process_time() + seconds
    blocks = _blocks(system)
    found: list[Cut] = []
    for k, (names, goal) in enumerate(blocks):
        left = (until - process_time()) * (1.0 if k == len(blocks) - 1 else SHARE)
        cuts = _cuts(_restricted(system, names, goal), left)
        if cuts is None:
            return None
        found += [c for c in cuts if c.literals not in [f.literals for f in found]]
    return pruned(system, found)


def _blocks(system: System) -> list[tuple[set[str], list[Formula]]]:
    """The parts of the goal by the names that they are linked with."""
    found: list[tuple[set[str], list[Formula]]] = []
    for part in members(system.goal, is_and=True):
        names = linked_names(system, [part])
        known = next((parts for other, parts in found if other == names), None)
        if known is None:
            found.append((names, [part]))
        else:
            known.append(part)
    return sorted(found, key=lambda b: len(b[0]))


def _restricted(system: System, names: set[str], goal: Sequence[Formula]) -> System:
    """What speaks of these names alone; bounds in place of high powers, which is a guess where they were rounded."""

    def about(p: Premises) -> Premises:
        kept = [e for e in p.entries if variables(e) <= names]
        return Premises(p.functions).with_(*(q for e in kept for q in (lowered(e) if isinstance(e, Literal) else [e])))

    field = {v: p for v, p in system.field.items() if v in names}
    starts = tuple(about(s) for s in system.starts)
    return replace(system, common=about(system.common), starts=starts, goal=conjunction(goal), field=field)


def _cuts(system: System, seconds: float) -> list[Cut] | None:
    unsafe = [negation(g) for g in members(system.goal, is_and=True)]
    search = Search(system, sample(system), process_time() + seconds, [], set(), [], unsafe)
    if leaves(system.goal, search.samples):
        return None
    end = search.until
    for stage, levels, share in STAGES:
        search.until = min(end, process_time() + share * seconds)
        stage(search)
        search.until = end
        if search.is_done(levels):
            return search.cuts
        if search.is_over():
            return None
    return None


def pruned(system: System, cuts: Sequence[Cut]) -> list[Cut] | None:
    """The cuts that the goal rests on, their rules found anew in the whole system; None where that fails."""
    unsafe = [negation(g) for g in members(system.goal, is_and=True)]
    whole = _again(system, cuts, unsafe)
    if whole is None:
        return None
    needed, kept = set(whole.needed), list[Cut]()
    for k in reversed(range(len(whole.cuts))):
        cut = whole.cuts[k]
        if needed & set(cut.literals):
            kept.insert(0, cut)
            needed |= used(cut.rule, system.common.with_(*(q for c in whole.cuts[:k] for q in c.literals)))
    again = _again(system, kept, unsafe)
    return whole.cuts if again is None else again.cuts


def _again(system: System, cuts: Sequence[Cut], unsafe: Sequence[Formula]) -> Search | None:
    """The search that has these cuts and nothing left open."""
    until = process_time() + LAST_SECONDS
    search = Search(system, Samples((), (), (), []), until, [], set(), [], list(unsafe))
    for cut in cuts:
        rule = keep(search.premises(), cut.literals, system.field, search.effort(DEAR, 4))
        if rule is None:
            return None
        search.cuts.append(Cut(cut.literals, rule))
    return search if search.is_done(DEAR) else None


LAST_SECONDS = 15.0
STAGES: tuple[tuple[Callable[[Search], None], tuple[Level, ...], float], ...] = (
    (equations, CHEAP, 0.1),  # and the greatest share of the time
    (constants, CHEAP, 0.1),
    (goal_itself, CHEAP, 0.1),
    (glances, CHEAP, 0.1),
    (integrals, MEDIUM, 0.2),
    (rounds, MEDIUM, 0.1),
    (signs, MEDIUM, 0.25),
    (boxes, MEDIUM, 0.2),
    (decreasing, MEDIUM, 0.15),
    (weighed, MEDIUM, 0.1),
    (traps, MEDIUM, 0.1),
    (higher, MEDIUM, 0.2),
    (lambda s: barriers(s, FIRST), DEAR, 0.4),
    (lambda s: signs(s, MEDIUM), DEAR, 0.3),
    (lambda s: boxes(s, MEDIUM), DEAR, 0.3),
    (lambda s: barriers(s, LATER), DEAR, 1.0),
)
