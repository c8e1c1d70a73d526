"""The state of a search for cuts: what was shown so far, what is still open, and the time that is left."""

from __future__ import annotations

from collections.abc import Sequence
from time import process_time

from haverify.analyses.synthesis.candidates import fits, says_nothing
from haverify.analyses.synthesis.keep import keep
from haverify.analyses.synthesis.samples import Samples
from haverify.analyses.synthesis.system import Cut, System
from haverify.analyses.synthesis.used import used
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Literal, negation, variables
from haverify.obligations.premises import Premises, whole
from haverify.solvers.positivity.levels import (
    AFFINE,
    HIGHER,
    MONOMIALS,
    NUMBERS,
    PAIRS,
    PRODUCTS,
    SQUARES,
    Level,
)
from haverify.solvers.positivity.refute import Effort, is_absurd, refute
from haverify.text.record import field, holder

CHEAP: tuple[Level, ...] = (NUMBERS, MONOMIALS)
MEDIUM: tuple[Level, ...] = (NUMBERS, AFFINE, SQUARES, PAIRS)
DEAR: tuple[Level, ...] = (NUMBERS, AFFINE, SQUARES, PAIRS, HIGHER, PRODUCTS)


@holder
class Search:
    """The cuts so far, and the time that is left."""

    system: System
    samples: Samples
    until: float
    cuts: list[Cut]
    tried: set[object]
    found: list[Polynomial]
    open: list[Formula]
    needed: set[Literal] = field(default_factory=set)

    def effort(self, levels: tuple[Level, ...], seconds: float) -> Effort:
        """Levels within so many seconds, and within the time that is left."""
        return Effort(levels, min(self.until, process_time() + seconds))

    def premises(self) -> Premises:
        """What holds at all times, and the cuts."""
        return self.system.common.with_(*(q for c in self.cuts for q in c.literals))

    def is_over(self) -> bool:
        """Whether the time is up."""
        return process_time() > self.until

    def attempt(self, cut: Sequence[Literal], levels: tuple[Level, ...]) -> bool:
        """Adds the conjunction as a cut if it holds at the starts and is kept."""
        cut = [Literal(q.op, whole(q.polynomial)) for q in cut]
        key = (tuple(cut), levels, len(self.cuts))
        if key in self.tried or self.is_over():
            return False
        self.tried.add(key)
        premises = self.premises()
        if not all(self.is_relevant(q) and fits(q, self.samples) for q in cut):
            return False
        if all(is_absurd(premises.with_(negation(q)).entries) or says_nothing(q, self.samples) for q in cut):
            return False
        rule = keep(premises, cut, self.system.field, self.effort(levels, 4))
        if rule is None or not all(self.starts_with(q) for q in cut):
            return False
        self.cuts.append(Cut(tuple(cut), rule))
        return True

    def starts_with(self, q: Literal) -> bool:
        """Whether the literal was shown at all starts."""
        key = ("start", q)
        if key in self.tried:
            return True
        effort = self.effort(MEDIUM, 4)
        done = all(refute(s.with_(negation(q)), effort) is not None for s in self.system.starts)
        if done:
            self.tried.add(key)
        return done

    def is_done(self, levels: tuple[Level, ...]) -> bool:
        """Whether domain and cuts imply the goal; what they imply of it need not be asked again."""
        premises = self.premises()
        for part in list(self.open):
            known = premises.with_(part)
            proof = refute(known, self.effort(levels, 6))
            if proof is not None:
                self.open.remove(part)
                self.needed |= used(proof, known)
        return not self.open

    def is_relevant(self, q: Literal) -> bool:
        """Whether the literal says something of names that unsafe states are still linked with."""
        return not self.linked(self.open).isdisjoint(q.polynomial.variables)

    def linked(self, parts: Sequence[Formula]) -> set[str]:
        """The names that unsafe states are linked with."""
        return linked_names(self.system, parts)


def linked_names(system: System, parts: Sequence[Formula]) -> set[str]:
    """The names of formulas, of the rates of these, and of what starts and domain say of them."""
    names = {v for part in parts for v in variables(part)}
    domain = {v for e in system.common.entries for v in variables(e)}
    names |= {v for v, p in system.field.items() if p.constant and v in domain and v != "time"}  # clocks that end runs
    entries = [variables(e) for p in (system.common, *system.starts) for e in p.entries]
    entries += [{v, *p.variables} for v, p in system.field.items()]
    for _ in entries:
        more = {v for e in entries if e & names for v in e}
        if more <= names:
            break
        names |= more
    return names
