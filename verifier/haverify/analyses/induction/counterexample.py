"""A state that an invariant allows and that leaves it, at an edge or by the flow; what a user sees of it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.induction.points import Point, satisfying
from haverify.maths.exact import significant
from haverify.maths.polynomial import Polynomial, constant
from haverify.obligations.formula import (
    Formula,
    Junction,
    Literal,
    compare,
    conjunction,
    disjunction,
    literal,
    literals,
    text,
)
from haverify.obligations.induction import Induction, Obligation
from haverify.obligations.premises import whole
from haverify.text.record import record

Q = Fraction
RANK = 3
TRIES = 1500


@record
class Leaving:
    """A state in a mode; `told` says in words what happens there."""

    mode: str
    point: Point
    told: str


def leaving(induction: Induction, ob: Obligation, formula: Formula) -> Leaving | None:
    """A state from which a part of an invariant fails, None where none was found. `formula`: of the part's mode."""
    names = _names(induction, ob)
    if ob.kind != "flow":
        point = satisfying(ob.premises, names, TRIES)
        return None if point is None else Leaving(ob.mode, point, _told_of(ob))
    inside = induction.premises(*(_strictly(f) for f in induction.common(ob.mode)))
    for p, strict in _boundaries(formula):
        slope = induction.derivative(p, ob.mode)
        told = inside.with_(*([] if strict else [formula]), compare("==", p), compare(">", slope))
        point = satisfying(told, names, TRIES)
        if point is not None:
            return Leaving(ob.mode, point, _derivatives(induction, ob.mode, p, strict, point))
    return None


def _strictly(f: Formula) -> Formula:
    """Inside of what a formula bounds, so that some time passes there."""
    if isinstance(f, Literal):
        return False if f.op == "==" else literal("<" if f.op == "<=" else f.op, f.polynomial)
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([_strictly(m) for m in f.members])
    return f


def _names(induction: Induction, ob: Obligation) -> list[str]:
    params = (n for n, (low, high) in induction.params.items() if low < high)
    chosen = {
        v for f in ob.premises.entries for leaf in literals(f) for v in leaf.polynomial.variables if v.endswith("'")
    }
    read = {
        v for f in (*ob.premises.entries, ob.kept or True) for leaf in literals(f) for v in leaf.polynomial.variables
    }
    if ob.kind == "flow":
        read |= {v for n, p in induction.field(ob.mode).items() if n != "time" for v in p.variables}
    timed = "time" in induction.functions.support(read)
    return [
        *(v.name for v in induction.automaton.vars),
        *params,
        *induction.inputs,
        *sorted(chosen),
        *(["time"] if timed else []),
    ]


def _boundaries(formula: Formula) -> Iterator[tuple[Polynomial, bool]]:
    """The polynomials whose growth from 0 may break the formula, and whether they must be below 0."""
    for leaf in literals(formula):
        p = whole(leaf.polynomial)
        if leaf.op in ("<", "<="):
            yield p, leaf.op == "<"
        elif leaf.op == "==":
            yield p, False
            yield -p, False


def _told_of(ob: Obligation) -> str:
    words = {
        "init": "a start that it excludes",
        "edge": f"the jump {ob.where} leads out of it",
        "use": "the claim is false",
    }
    return words[ob.kind]


def _derivatives(induction: Induction, mode: str, p: Polynomial, strict: bool, point: Point) -> str:
    """The literal at its bound, and the derivatives along the flow there."""
    values, found = {n: constant(q) for n, q in point.items()}, []
    q = p
    for k in range(1, RANK):
        q = induction.derivative(q, mode)
        at = induction.functions.substitute(q, values).constant
        if at is not None:
            found.append(f"{'first' if k == 1 else 'second'} derivative {significant(at)}")
    bound = text(Literal("<" if strict else "<=", p))
    slopes = ", ".join(found) or "its slope is above 0"
    return f"`{bound}` is at its bound, and its left side grows along the flow: {slopes}"


def state_text(induction: Induction, found: Leaving) -> str:
    """The state in the declared units."""
    a, spec = induction.automaton, induction.spec
    units = {v.name: v.unit for v in a.vars} | {p.name: p.unit for p in (*spec.params, *a.params)}
    units |= {n: i.unit for n, i in induction.inputs.items()}
    return ", ".join(f"{n} = {significant(q)}{_unit(units.get(n))}" for n, q in found.point.items())


def _unit(unit: object) -> str:
    return f" {unit}" if unit is not None and str(unit) != "1" else ""
