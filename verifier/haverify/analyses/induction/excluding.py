"""A conjunct that excludes a state from which an invariant fails, and makes it inductive."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction

from haverify.analyses.induction.boxes import bounded
from haverify.analyses.induction.points import Point, certainly
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, Literal, compare, conjunction, literals, negation
from haverify.obligations.induction import Induction, Invariant
from haverify.obligations.premises import Premises, members, primitive

Q = Fraction
IsProved = Callable[[Invariant, bool], bool]
DEGREE = 2
MOST_NAMES = 4
MOST = 24  # candidates that are tried


def excluding(
    induction: Induction, formulas: Invariant, mode: str, point: Point, is_proved: IsProved
) -> Mapping[str, Formula] | None:
    """What to add, by mode, that is false at a point, and with which the formulas are an invariant."""
    tried = 0
    said = ({mode: f} for f in _said(induction, mode))
    rounds: list[tuple[bool, Iterable[Mapping[str, Formula]]]] = [(False, _plain(induction, mode)), (True, said)]
    for deep, candidates in (*rounds, (True, _found(induction, formulas))):
        for added in candidates:
            here = added.get(mode, True)
            if not certainly(negation(here), point, induction.functions):
                continue
            tried += 1
            if tried > MOST:
                return None
            both = {m: conjunction([f, added.get(m, True)]) for m, f in formulas.items()}
            if is_proved(both, deep):
                return added
    return None


def _plain(induction: Induction, mode: str) -> Iterator[Mapping[str, Formula]]:
    """What the starts say of the mode alone, bounds and signs of variables, then what the starts say of every mode."""
    said = {m: list(_said(induction, m)) for m in (x.name for x in induction.automaton.modes)}
    yield from ({mode: f} for f in said[mode])
    yield from ({mode: f} for f in _bounds(induction, mode))
    yield from ({mode: f} for f in _integrals(induction, mode))
    yield {m: conjunction(found) for m, found in said.items() if found}


def _starts(induction: Induction, mode: str) -> list[Premises]:
    return [induction.premises(*induction.starts(line, m)) for line, m, _ in induction.lines() if m == mode]


def _said(induction: Induction, mode: str) -> Iterator[Formula]:
    """The conditions of a mode's init lines, where it has one line: the formula that all its starts satisfy."""
    lines = _starts(induction, mode)
    for f in lines[0].entries if len(lines) == 1 else ():
        if all("time" not in q.polynomial.variables for q in literals(f)):
            yield from members(primitive(f), is_and=True)


def _bounds(induction: Induction, mode: str) -> Iterator[Formula]:
    """Bounds of variables: those of the starts, and 0."""
    boxes = [bounded(told.entries) or {} for told in _starts(induction, mode)]
    for v in (x.name for x in induction.automaton.vars if x.type == "real"):
        ends = [b[v] for b in boxes if v in b]
        known = len(ends) == len(boxes) and ends
        highs = {max(high for _, high in ends), Q(0)} if known else {Q(0)}
        lows = {min(low for low, _ in ends), Q(0)} if known else {Q(0)}
        yield from (compare("<=", variable(v) - constant(q)) for q in sorted(highs))
        yield from (compare(">=", variable(v) - constant(q)) for q in sorted(lows))


def _integrals(induction: Induction, mode: str) -> Iterator[Formula]:
    """What is constant along the flow, bounded by what it is at the starts."""
    from haverify.analyses.synthesis.integrals import first_integrals
    from haverify.maths.bernstein import bounds

    field = induction.field(mode)
    names = tuple(v.name for v in induction.automaton.vars if v.type == "real")
    boxes = [bounded(told.entries) or {} for told in _starts(induction, mode)]
    if induction.functions.known or len(names) > MOST_NAMES or not boxes:
        return
    for p in first_integrals(field, names, DEGREE):
        if all(set(p.variables) <= b.keys() for b in boxes):
            ends = [bounds(p, b) for b in boxes]
            yield from _between(p, min(low for low, _ in ends), max(high for _, high in ends))


def _between(p: Polynomial, low: Q, high: Q) -> Iterator[Formula]:
    yield primitive(compare("<=", p - constant(high)))
    yield primitive(compare(">=", p - constant(low)))


def _found(induction: Induction, formulas: Invariant) -> Iterator[Mapping[str, Formula]]:
    """An invariant that was searched for: its literals one by one, then all of them."""
    from haverify.analyses.induction.invented import applies, invent

    found = invent(induction, 5.0) if applies(induction) else None
    for mode, formula in ({} if found is None else found.formulas).items():
        wanted = set(members(primitive(formulas[mode]), is_and=True))
        cuts = [f for f in members(formula, is_and=True) if isinstance(f, Literal) and f not in wanted]
        yield from ({mode: f} for f in cuts)
        yield {mode: conjunction(cuts)}
