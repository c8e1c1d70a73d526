"""How fast the slope towards the guards falls at least, where that depends on the state: within what heights allow."""

from __future__ import annotations

from fractions import Fraction
from math import inf, sqrt

from haverify.analyses.zeno.closing import SLACK, rounded_up, starts_in
from haverify.analyses.zeno.floats import Point, points, value
from haverify.analyses.zeno.sections import Section
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import compare
from haverify.obligations.induction import TIME, Induction

Q = Fraction
GROWN = 400
COARSE, FINE = Q(21, 20), Q(201, 200)


def bend_of(
    induction: Induction, section: Section, height: Polynomial, most: Fraction
) -> tuple[Fraction, Fraction | None] | None:
    """How fast the slope falls at least, and, where that depends on the state, how far from the guards states are."""
    if set(section.curve.variables) <= induction.params.keys():
        low = bounds(-section.curve, induction.params)[0]
        return (low, None) if low > 0 else None
    far = _far(induction, section, height, most)
    if far is None:
        return None
    near = _near(induction, section, far, most)
    worst = min((value(-section.curve, p, induction.functions) for p in near), default=-inf)
    return (-rounded_up(-Q(worst) * (1 - SLACK), 6), far) if inf > worst > 0 else None


def _near(induction: Induction, section: Section, far: Fraction, most: Fraction) -> list[Point]:
    """Points at most so far from the guards, with the speeds that the height allows."""
    speed = constant(rounded_up(Q(sqrt(most)), 9))
    told = [compare("==", variable(TIME)), compare("<=", section.distance - constant(far))]
    told += [compare("<=", p - speed) for p in (section.slope, -section.slope)]
    return list(points(induction.premises(*induction.common(section.mode), *told)))


def _far(induction: Induction, section: Section, height: Polynomial, most: Fraction) -> Fraction | None:
    """A distance that states with as much height do not reach, above those of the starts."""
    ((name, way),) = section.put.items()
    begun = [value(section.distance, p, induction.functions) for p in starts_in(induction, section.mode)]
    slope = float(section.distance.terms[((name, 1),)])
    still = dict.fromkeys((v.name for v in induction.automaton.vars), 0.0)
    still |= {n: float(low) for n, (low, _) in induction.params.items()}
    top = Q(max([*begun, sqrt(most) / 1000])) / FINE

    def is_above(distance: Q) -> bool:
        at = still | {name: value(way, still, induction.functions) + float(distance) / slope}
        return value(height, at, induction.functions) > float(most) * (1 + 1e-6)

    for step in (COARSE, FINE):
        steps = next((k for k in range(1, GROWN) if is_above(top * step**k)), None)
        if steps is None:
            return None
        top = top * step ** (steps - 1)
    return rounded_up(top * FINE, 4)
