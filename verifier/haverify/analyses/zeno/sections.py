"""Where a mode is left: a quantity that is at least 0 in its domain and 0 at all its guards, with its slopes."""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.induction.keep import divided
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Literal
from haverify.obligations.induction import Induction
from haverify.obligations.premises import Premises, whole
from haverify.text.record import record

Q = Fraction


@record
class Section:
    """A mode with its distance from the guards, how fast that grows, and how fast that does.

    `distance` has no constant factor of its own choice: it is primitive. `put` solves `distance == 0` for a name.
    """

    mode: str
    distance: Polynomial
    slope: Polynomial
    curve: Polynomial
    put: dict[str, Polynomial]

    @property
    def speed(self) -> Polynomial:
        """How fast the guard comes nearer."""
        return -self.slope


def section_of(induction: Induction, mode: str) -> Section | None:
    """The section of a mode that has edges; None where its guards are no single surface that bounds its domain."""
    edges = [k for k, e in enumerate(induction.automaton.edges) if e.source == mode]
    if not edges:
        return None
    inside = induction.premises(*induction.common(mode)).entries
    known = [-f.polynomial for f in inside if isinstance(f, Literal) and f.op == "<="]
    met = [_at_zero(induction.premises(*induction.jump(k))) for k in edges]
    for p in (p for p in known if all(p in zero for zero in met)):
        slope = induction.derivative(p, mode)
        put = _solved(p, induction)
        if slope.constant is None and put is not None:
            return Section(mode, p, slope, induction.derivative(slope, mode), put)
    return None


def _at_zero(premises: Premises) -> set[Polynomial]:
    """Polynomials that a jump has at 0: from an equation, or from two inequalities."""
    literals = [f for f in premises.entries if isinstance(f, Literal)]
    below = {f.polynomial for f in literals if f.op == "<="}
    equal = {f.polynomial for f in literals if f.op == "=="}
    return {p for p in below if -p in below} | equal | {-p for p in equal}


def _solved(p: Polynomial, induction: Induction) -> dict[str, Polynomial] | None:
    """A name as a combination of others where the polynomial is 0; the polynomial is linear."""
    if p.total_degree() != 1 or any(v in induction.functions.known for v in p.variables):
        return None
    moving = [v.name for v in induction.automaton.vars if v.name in p.variables]
    if not moving:
        return None
    v = moving[0]
    c = p.terms[((v, 1),)]
    return {v: (p - Polynomial({((v, 1),): 1}).scaled(c)).scaled(-1 / c)}


def on(section: Section, p: Polynomial, induction: Induction) -> Polynomial:
    """A polynomial where the section's distance is 0."""
    return induction.functions.substitute(p, section.put)


def kept_share(induction: Induction, k: int, source: Section, target: Section) -> Polynomial | None:
    """The speed right after an edge, away from the next section, as a share of that right before it; a polynomial."""
    landing = induction.landing(k)
    distance = induction.functions.substitute(target.distance, landing)
    after = on(source, induction.functions.substitute(target.slope, landing), induction)
    before = on(source, source.speed, induction)
    if on(source, distance, induction).whole or not before.whole:
        return None
    return divided(after, before)


def square_of(p: Polynomial, q: Polynomial) -> Fraction | None:
    """The number c with `p == c q^2`, if there is one."""
    c = divided(p, whole(q) ** 2)
    return c.constant * _content(q) if c is not None and c.constant is not None else None


def _content(q: Polynomial) -> Fraction:
    """The square of what `whole(q)` is multiplied by to be q, inverted."""
    m = next(iter(q.whole))
    return (whole(q).terms[m] / q.terms[m]) ** 2
