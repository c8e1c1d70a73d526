"""A time to go for impacts: the speed at the guard loses a share at each jump, and what comes after it is a sum.

In a mode with the distance d from its guards let `d'' <= -bend`, and let E be a height: not growing along the flow, and
the square of the speed `-d'` where d is 0. Then `d' / bend + weight sqrt(E)` falls at least as fast as time passes; no
jump raises it if the weights are those of the geometric sum. With `L = end - time - d' / bend` the formulas are
`L >= 0` and `weight^2 E <= L^2`, which hold no roots.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import inf, sqrt
from typing import TypeVar

from haverify.analyses.induction.refute import Effort, refute
from haverify.analyses.zeno.bends import bend_of
from haverify.analyses.zeno.closing import SLACKS, Closing, Last, above, rounded_up, starts_in
from haverify.analyses.zeno.floats import value
from haverify.analyses.zeno.roots import Lemma, Term, below, squares
from haverify.analyses.zeno.sections import Section, kept_share, on, section_of, square_of
from haverify.analyses.zeno.weights import weights_of
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr
from haverify.obligations.formula import Formula, compare, conjunction, negation
from haverify.obligations.induction import TIME, Induction
from haverify.obligations.premises import whole
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
T = TypeVar("T")
Shares = dict[int, tuple[Polynomial, Fraction]]  # for edges: what is kept of the speed, and the greatest size of it
ETA = Q(1, 10**5)  # seconds: room for heights that are compared by enclosures of functions


@record
class Impact:
    """What a mode contributes: its height, the most of it, and whether its bend was read off states (then `far`)."""

    section: Section
    height: Polynomial
    most: Fraction
    bend: Fraction
    far: Fraction | None
    weight: Fraction


def impacts(induction: Induction) -> Iterator[Closing]:
    """Formulas for an automaton whose every cycle of jumps takes speed at surfaces, for ends that may do."""
    sections = {m.name: s for m in induction.automaton.modes if (s := section_of(induction, m.name)) is not None}
    shares = _shares(induction, sections)
    heights = _known({m: _height(induction, s) for m, s in sections.items()}) if shares else {}
    if shares is None or not heights:
        return
    for slack in SLACKS:
        found = _impacts(induction, sections, heights, shares, slack)
        end = None if found is None else above(_latest(induction, found), slack)
        if found is not None and end is not None:
            yield _closing(induction, found, shares, end)


def _known(found: dict[str, T | None]) -> dict[str, T]:
    """What was found, if it was for all."""
    known = {m: x for m, x in found.items() if x is not None}
    return known if len(known) == len(found) else {}


def _impacts(
    induction: Induction, sections: dict[str, Section], heights: dict[str, Polynomial], shares: Shares, slack: Fraction
) -> dict[str, Impact] | None:
    """What each mode contributes."""
    mosts = _mosts(induction, heights, shares, slack)
    bends = _known({m: bend_of(induction, s, heights[m], mosts[m]) for m, s in sections.items()}) if mosts else {}
    weights = _weights(induction, bends, shares) if bends else None
    if mosts is None or weights is None:
        return None
    return {m: Impact(s, heights[m], mosts[m], *bends[m], weights[m]) for m, s in sections.items()}


def _weights(
    induction: Induction, bends: dict[str, tuple[Fraction, Fraction | None]], shares: Shares
) -> dict[str, Fraction] | None:
    least = {m: b for m, (b, _) in bends.items()}
    return weights_of(induction.automaton.edges, least, {k: q for k, (_, q) in shares.items()})


def _shares(induction: Induction, sections: dict[str, Section]) -> Shares | None:
    """For each edge between modes that have sections the share of speed kept, and the greatest size of it."""
    found = {}
    for k, e in enumerate(induction.automaton.edges):
        if e.target not in sections:
            continue
        if e.source not in sections:
            return None
        share = kept_share(induction, k, sections[e.source], sections[e.target])
        if share is None or not set(share.variables) <= induction.params.keys():
            return None
        found[k] = share, max(map(abs, bounds(share, induction.params)))
    return found or None


def _height(induction: Induction, section: Section) -> Polynomial | None:
    """A quantity that the flow does not raise, the square of the speed at the guards."""
    mode, slope = section.mode, section.slope
    common = induction.premises(*induction.common(mode))
    for p in _heights(induction, section):
        scale = square_of(on(section, p, induction), slope)
        if scale is None or scale <= 0:
            continue
        height = p.scaled(1 / scale)
        growth = compare(">", induction.derivative(height, mode))
        if refute(common.with_(growth), Effort(16, 8)) is not None:
            return height
    return None


def _heights(induction: Induction, section: Section) -> Iterator[Polynomial]:
    moving = induction.field(section.mode).keys()
    if not set(induction.functions.support(section.curve.variables)) & moving:
        yield section.slope**2 - (section.curve * section.distance).scaled(Q(2))
    still = {v: constant(0) for v in section.slope.variables if v in moving}
    at_rest = on(section, induction.functions.substitute(section.curve, still), induction)
    if at_rest.constant is not None:
        yield section.slope**2 - section.distance.scaled(2 * at_rest.constant)
    scope = induction.scope(section.mode)
    for let in (*induction.automaton.lets, *induction.mode(section.mode).lets):
        try:
            cases = scope.cases(variable_of(let.name)) if let.type == "real" else []
        except OutsideFragmentError:
            continue
        if len(cases) == 1 and cases[0].denominator.constant:
            p = cases[0].numerator.scaled(1 / cases[0].denominator.constant)
            yield p - on(section, induction.functions.substitute(p, still), induction)


def variable_of(name: str) -> Expr:
    """The expression that reads a derived output."""
    return Expr("let", (name,))


def _mosts(
    induction: Induction, heights: dict[str, Polynomial], shares: Shares, slack: Fraction
) -> dict[str, Fraction] | None:
    """The greatest height in each mode: at a start, or what jumps leave of others'."""
    starts = {m: [value(h, p, induction.functions) for p in starts_in(induction, m)] for m, h in heights.items()}
    mosts = _known({m: above(max(xs, default=0.0), slack) for m, xs in starts.items()})
    if not any(starts.values()):
        return None
    for _ in range(len(heights) + 1):
        before = dict(mosts)
        for k, (_, share) in shares.items():
            e = induction.automaton.edges[k]
            mosts[e.target] = max(mosts[e.target], share**2 * mosts[e.source])
        if mosts == before:
            return mosts
    return None


def _latest(induction: Induction, found: dict[str, Impact]) -> float:
    """The latest end that starts give, about."""
    latest = -inf
    for m, i in found.items():
        for p in starts_in(induction, m):
            height = max(value(i.height, p, induction.functions), 0.0)
            go = value(i.section.slope, p, induction.functions) / float(i.bend) + float(i.weight) * sqrt(height)
            latest = max(latest, go)
    return latest


def _closing(induction: Induction, found: dict[str, Impact], shares: Shares, end: Fraction) -> Closing:
    formulas: dict[str, Formula] = {m.name: induction.aim(m.name) for m in induction.automaton.modes}
    lemmas: dict[str, list[Lemma]] = {m: [] for m in formulas}
    last: dict[str, Last] = {}
    for m, i in found.items():
        left = _left(i, end)
        before = conjunction([*_bent(induction, i), compare(">=", left)])
        square = compare("<=", i.height.scaled(i.weight**2) - left * left)
        formulas[m], last[m] = conjunction([before, square]), _last(induction, i, before, square, left)
        room = ETA if induction.functions.known else Q(0)
        size = left + constant(room)
        lemmas[m] = [
            Lemma(compare("<=", i.section.slope**2 - i.height - constant((room / i.weight) ** 2))),
            Lemma(compare("<=", (i.section.speed**2).scaled(i.weight**2) - size * size)),
            Lemma(compare(">=", size)),
            below(i.section.speed.scaled(i.weight), size),
            _over(i, size, end + room),
            _place(i),
        ]
    landing = {k: list(_after(induction, k, found, shares[k], end)) for k in shares}
    point = tuple(dict.fromkeys(_zero(p) for i in found.values() for p in (i.section.distance, i.section.slope)))
    return Closing(formulas, lemmas, landing, end, _cycle_share(induction, shares), last, point)


def _over(i: Impact, size: Polynomial, end: Fraction) -> Lemma:
    """That no instant is after the end: between the time that is left and what the speed needs, one is at most it."""
    part = 1 / (i.bend * i.weight)
    enough = compare("<=", i.section.speed.scaled(i.weight) - size)
    terms: tuple[Term, ...] = ((1 - part, [compare(">=", size)]), (part, [enough]))
    return Lemma(compare("<=", variable(TIME) - constant(end)), terms=terms)


def _place(i: Impact) -> Lemma:
    """That what the height has without the speed is at most the most."""
    terms: tuple[Term, ...] = ((Q(1), [compare("<=", i.height - constant(i.most))]), (i.section.slope, []))
    return Lemma(compare("<=", i.height - i.section.slope**2 - constant(i.most)), terms=terms)


def _zero(p: Polynomial) -> Formula:
    """That a polynomial is 0, its first coefficient above 0."""
    q = whole(p)
    return compare("==", q if q.whole[min(q.whole)] > 0 else -q)


def _last(induction: Induction, i: Impact, before: Formula, square: Formula, left: Polynomial) -> Last:
    """Why the flow keeps the square: its slope is a sum of what is not above 0."""
    mode = i.section.mode
    fall = compare("<=", induction.derivative(i.height, mode))
    bent = i.section.curve + constant(i.bend)
    terms: list[Term] = [(i.weight**2, [fall])] if fall is not True else []
    if bent.constant is None:
        terms.append((2 / i.bend, [compare(">=", left), compare("<=", bent)]))
    elif bent.constant:
        terms.append((-2 * bent.constant / i.bend, [compare(">=", left)]))
    return Last(before, square, tuple(terms))


def _bent(induction: Induction, i: Impact) -> Iterator[Formula]:
    """What keeps states where the slope falls fast enough."""
    section = i.section
    most = compare("<=", i.height - constant(i.most))
    yield most
    fall = compare("<=", induction.derivative(i.height, section.mode))
    if fall is not True:
        yield fall
    bent = compare("<=", section.curve + constant(i.bend))
    if i.far is None:
        if bent is not True:
            yield bent
        return
    yield compare("<=", i.height - section.slope**2 - constant(i.most))
    yield compare("<=", section.distance - constant(i.far))
    common = induction.premises(*induction.common(section.mode), most)
    speed = constant(rounded_up(Q(sqrt(i.most)), 9))
    for bound in (compare("<=", p - speed) for p in (section.slope, -section.slope)):
        if refute(common.with_(negation(bound)), Effort(16, 8)) is not None:
            yield bound
    yield bent


def _left(i: Impact, end: Fraction) -> Polynomial:
    """The time that is left after the flight up."""
    return constant(end) - variable(TIME) - i.section.slope.scaled(1 / i.bend)


def _after(
    induction: Induction, k: int, found: dict[str, Impact], share: tuple[Polynomial, Fraction], end: Fraction
) -> Iterator[Lemma]:
    """Lemmas about an edge: the speed before is not more than its weight allows, the one after is a share of it."""
    edge = induction.automaton.edges[k]
    before, after = found[edge.source], found[edge.target]
    landing = induction.landing(k)
    new = induction.functions.substitute(after.section.slope, landing)
    speed, left = before.section.speed.scaled(before.weight), _left(before, end)
    yield Lemma(compare("<=", speed * speed - left * left))
    yield below(speed, left)
    yield from _less(new, before, share)
    size = induction.functions.substitute(_left(after, end), landing)
    weighed = new.scaled(after.weight)
    for p in (weighed, -weighed):
        yield Lemma(compare("<=", p - size))
    yield squares(weighed, size)


def _less(new: Polynomial, before: Impact, share: tuple[Polynomial, Fraction]) -> Iterator[Lemma]:
    """That the speed after an edge is at most a share of that before, and so are the squares."""
    speed, most = before.section.speed, share[1]
    part = speed.scaled(most)
    yield Lemma(compare(">=", speed))
    for p, kept in ((new, share[0]), (-new, -share[0])):
        bound = compare("<=", kept - constant(most))
        yield Lemma(bound)
        terms: tuple[Term, ...] = ((Q(1), [bound, compare(">=", speed)]),) if bound is not True else ()
        yield Lemma(compare("<=", p - part), terms=terms)
    yield squares(new, part)
    yield Lemma(compare("<=", speed * speed - constant(before.most)))
    lost, known = compare("<=", new * new - part * part), compare("<=", speed * speed - constant(before.most))
    enough: tuple[Term, ...] = ((most**2, [known]),) + (((Q(1), [lost]),) if lost is not True else ())
    yield Lemma(compare("<=", new * new - constant(most**2 * before.most)), terms=enough)


def _cycle_share(induction: Induction, shares: Shares) -> Fraction | None:
    """The greatest share of a cycle: of one edge, or of two that lead back and forth."""
    edges = induction.automaton.edges
    own: list[Fraction] = [s for k, (_, s) in shares.items() if edges[k].source == edges[k].target]
    pairs: list[Fraction] = [s * t for k, (_, s) in shares.items() for j, (_, t) in shares.items()
             if edges[k].source == edges[j].target != edges[k].target == edges[j].source]  # fmt: skip
    return max([*own, *pairs], default=None)
