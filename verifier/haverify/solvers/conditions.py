"""Decide whether conditions can hold together, exactly.

Linear conditions are decided by elimination, those of one unknown by Sturm sequences, both here; z3 is asked only
for the rest. A condition falls apart into groups that share no unknown, each decided by the cheapest of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import prod

from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Range
from haverify.solvers import univariate
from haverify.solvers.answer import Answer, Contradiction, Holds, Undecided
from haverify.solvers.closure import closure
from haverify.solvers.frame import Frame, Scope
from haverify.solvers.linear import Infeasible, Row, TooLarge, solve
from haverify.solvers.literals import INVERSE, PI, QUOTIENT, STAND_IN, Case, Literal, TooManyCasesError, both, cases
from haverify.text.record import field, holder, record

MAX_CHOICES = 256
MAX_VALUES = 16
MAX_UNKNOWNS = 24
PI_LOW = Fraction(314159265358979323846, 10**20)
PI_HIGH = Fraction(314159265358979323847, 10**20)


@record
class Condition:
    """`expr` (or its negation) as read in `frame`; `closed` reads the expression as a domain (`LANGUAGE S6`)."""

    expr: Expr
    frame: Frame
    holds: bool = True
    closed: bool = False


def decide(conditions: Sequence[Condition], extra: Sequence[Literal] = ()) -> Answer:
    """Whether the conditions hold together for some values of the variables, params and inputs within their ranges.

    Soundness       `Contradiction` is exact. `Holds` with `is_exact` is exact: the point can be checked by hand.
    """
    never = next((q for q in extra if _is_false(q)), None)
    if never is not None:
        return Contradiction((never.origin,) if never.origin is not None else ())
    try:
        found = [tuple(extra)]
        for c in conditions:
            found = both(found, cases(closure(c.expr, c.frame) if c.closed else c.expr, c.frame, c.holds))
        scope = conditions[0].frame.scope
        found = both(found, _ranges(scope, {n for case in found for q in case for n in q.poly.variables}))
        answer = _first([case for f in found for case in _discrete(f, scope)])
        return answer if _is_whole(answer, scope) else Undecided("a counter would have to be a fraction")
    except TooManyCasesError:
        return Undecided("the condition has too many cases")


def _is_false(q: Literal) -> bool:
    """Whether a literal compares numbers alone, and wrongly."""
    value = q.poly.constant
    return value is not None and not {"==": value == 0, "!=": value != 0, "<=": value <= 0, "<": value < 0}[q.relation]


def _first(found: list[Case]) -> Answer:
    """The answer for a disjunction."""
    open_reason, weak, core = "", None, dict[Expr, None]()
    for case in found:
        answer = _decide_case(case)
        if isinstance(answer, Holds) and answer.is_exact:
            return answer
        if isinstance(answer, Holds):
            weak = weak or answer
        elif isinstance(answer, Undecided):
            open_reason = open_reason or answer.reason
        else:
            core.update(dict.fromkeys(answer.core))
    if weak is not None:
        return weak
    return Undecided(open_reason) if open_reason else Contradiction(tuple(core))


# ---- ranges and discrete values -------------------------------------------------


def _ranges(scope: Scope, names: set[str]) -> list[Case]:
    """What is known of the params and inputs mentioned: their ranges and the top-level assumptions about them."""
    frame = Frame(scope)
    found: list[Case] = [()]
    relevant = names & (scope.params.keys() | scope.inputs.keys())
    if "time" in names:
        found = [(Literal(-variable("time"), "<="),)]
    for name in sorted(relevant):
        declared = scope.params[name] if name in scope.params else scope.inputs[name]
        op = "param" if name in scope.params else "input"
        if declared.range is not None:
            found = both(found, cases(_within(Expr(op, (name,)), declared.range), frame))
    for assumption in scope.spec.assumptions:
        if _mentions_only(assumption, relevant):
            found = both(found, cases(assumption, frame))
    return found


def _within(e: Expr, bounds: Range) -> Expr:
    return Expr("and", (Expr("<=", (bounds.low, e), span=e.span), Expr("<=", (e, bounds.high), span=e.span)))


def _mentions_only(e: Expr, names: set[str]) -> bool:
    mentioned = {n.name for n in nodes(e) if n.op in ("param", "input", "var", "let", "at", "jump")}
    return bool(mentioned) and mentioned <= names


def _discrete(case: Case, scope: Scope) -> list[Case]:
    """The cases for each value of the enumeration and truth variables that occur; long counters stay."""
    names = sorted({n for q in case for n in q.poly.variables} & scope.vars.keys())
    choices = [(n, v) for n in names if (v := scope.values(scope.vars[n].type)) is not None]
    short = [(n, v) for n, v in choices if len(v) <= MAX_VALUES]
    if prod(len(v) for _, v in short) > MAX_CHOICES:
        raise TooManyCasesError
    case += tuple(q for n, v in choices if len(v) > MAX_VALUES for q in _between(n, v[0], v[-1]))
    combinations = product(*(values for _, values in short))
    return [case + tuple(_equal(n, v) for (n, _), v in zip(short, chosen, strict=True)) for chosen in combinations]


def _between(name: str, low: Fraction, high: Fraction) -> Case:
    return Literal(constant(low) - variable(name), "<="), Literal(variable(name) - constant(high), "<=")


def _is_whole(answer: Answer, scope: Scope) -> bool:
    """Whether each counter at the point found has a value that counters have."""
    if not isinstance(answer, Holds):
        return True
    counters = (n for n in answer.point if n in scope.vars and scope.vars[n].type != "real")
    return all(answer.point[n].denominator == 1 for n in counters)


def _equal(name: str, value: Fraction) -> Literal:
    return Literal(variable(name) - constant(value), "==")


# ---- one conjunction ------------------------------------------------------------


@holder
class _Rows:
    """Literals in progress, each with the numbers of the literals it follows from, and what was eliminated."""

    rows: list[Row]
    eliminated: list[tuple[str, Polynomial]] = field(default_factory=list)


def _decide_case(case: Case) -> Answer:
    split = _without_unequal(case)
    if len(split) != 1:
        return _first(split) if split else Contradiction(_origins(case, frozenset(range(len(case)))))
    case = tuple(_without_inverse(q) for q in split[0])
    if any(PI in q.poly.variables for q in case):
        return _with_pi(case)
    if len({v for q in case for v in q.poly.variables}) > MAX_UNKNOWNS:
        return Undecided("the condition has too many unknowns")
    state = _substituted([Row(q.poly, q.relation, frozenset([k])) for k, q in enumerate(case)])
    point: dict[str, Fraction] = {}
    reasons: list[str] = []
    for group in _groups(state.rows):
        answer = _decide_group(group)
        if isinstance(answer, Infeasible):
            return Contradiction(_origins(case, answer.core))
        if isinstance(answer, Undecided):
            reasons.append(answer.reason)
        else:
            point |= answer
    if reasons:
        return Undecided(reasons[0])
    return _found(case, point, state.eliminated)


def _found(case: Case, point: dict[str, Fraction], eliminated: list[tuple[str, Polynomial]]) -> Holds:
    for name, poly in reversed(eliminated):
        point[name] = poly.value({n: point.setdefault(n, Fraction(0)) for n in poly.variables})
    is_exact = not any(n.startswith(STAND_IN) for q in case for n in q.poly.variables)
    shown = {n: v for n, v in point.items() if not n.startswith((STAND_IN, QUOTIENT))}
    return Holds(shown, is_exact)


def _origins(case: Case, core: frozenset[int]) -> tuple[Expr, ...]:
    return tuple(dict.fromkeys(q.origin for k in sorted(core) if (q := case[k]).origin is not None))


def _without_unequal(case: Case) -> list[Case]:
    """The conjunction without `!=`, each split into below and above."""
    found: list[Case] = [()]
    for q in case:
        if q.relation == "!=" and (value := q.poly.constant) is not None:
            sides: list[Case] = [()] if value else []
        elif q.relation == "!=":
            sides = [(Literal(q.poly, "<", q.origin),), (Literal(-q.poly, "<", q.origin),)]
        else:
            sides = [(q,)]
        found = both(found, sides)
    return found


def _without_inverse(q: Literal) -> Literal:
    """The same literal multiplied by the power of pi that clears `1/pi`; pi is positive."""
    most = q.poly.degree(INVERSE)
    if not most:
        return q
    parts = q.poly.coefficients(INVERSE)
    cleared = total(p * variable(PI) ** (most - k) for k, p in enumerate(parts))
    return Literal(cleared, q.relation, q.origin)


def _with_pi(case: Case) -> Answer:
    """The answer for every pi in a tiny interval: where both ends agree in a linear system, so does pi itself."""
    answers = []
    for bound in (PI_LOW, PI_HIGH):
        at_bound = {PI: bound}
        answers.append(_decide_case(tuple(Literal(q.poly.fix(at_bound), q.relation, q.origin) for q in case)))
    first, second = answers
    for answer in answers:
        if isinstance(answer, Undecided):
            return answer
    if isinstance(first, Holds) and isinstance(second, Holds):
        return Holds(first.point, first.is_exact and second.is_exact and _is_linear_beside_pi(case))
    if isinstance(first, Contradiction) and isinstance(second, Contradiction):
        free = _decide_case(tuple(_renamed(q) for q in case) + _pi_bounds())
        return free if isinstance(free, Contradiction) else Undecided("the answer hangs on digits of pi")
    return Undecided("the answer hangs on digits of pi")


def _is_linear_beside_pi(case: Case) -> bool:
    return all(sum(p for n, p in m if n != PI) <= 1 for q in case for m in q.poly.whole)


_FREE_PI = STAND_IN + PI


def _renamed(q: Literal) -> Literal:
    return Literal(q.poly.substitute({PI: variable(_FREE_PI)}), q.relation, q.origin)


def _pi_bounds() -> Case:
    pi = variable(_FREE_PI)
    return Literal(constant(PI_LOW) - pi, "<"), Literal(pi - constant(PI_HIGH), "<")


def _substituted(rows: list[Row]) -> _Rows:
    """The rows with each unknown that an equation gives linearly replaced throughout."""
    state = _Rows(rows)
    while (found := _solvable(state.rows)) is not None:
        row, name = found
        c = row.poly.terms[((name, 1),)]
        value = variable(name) - row.poly.scaled(1 / c)
        state.eliminated.append((name, value))
        state.rows = [_replaced(r, name, value, row.origins) for r in state.rows if r is not row]
    return state


def _solvable(rows: list[Row]) -> tuple[Row, str] | None:
    """An equation and an unknown that occurs in it once, with a constant factor."""
    for row in rows:
        if row.relation != "==":
            continue
        for m in sorted(row.poly.whole):
            if len(m) == 1 and m[0][1] == 1 and sum(m[0][0] in dict(n) for n in row.poly.whole) == 1:
                return row, m[0][0]
    return None


def _replaced(row: Row, name: str, value: Polynomial, origins: frozenset[int]) -> Row:
    if name not in row.poly.variables:
        return row
    return Row(row.poly.substitute({name: value}), row.relation, row.origins | origins)


def _groups(rows: list[Row]) -> list[list[Row]]:
    """The rows in groups that share no unknown; rows without unknowns are groups of their own."""
    groups: list[tuple[set[str], list[Row]]] = []
    for row in rows:
        names = set(row.poly.variables)
        touched = [g for g in groups if g[0] & names]
        merged = (names.union(*(g[0] for g in touched)), [r for g in touched for r in g[1]] + [row])
        groups = [g for g in groups if not any(g is t for t in touched)] + [merged]
    return [g[1] for g in groups]


def _decide_group(rows: list[Row]) -> dict[str, Fraction] | Infeasible | Undecided:
    names = {v for r in rows for v in r.poly.variables}
    if all(r.poly.total_degree() <= 1 for r in rows):
        answer = solve(rows)
        return Undecided("too many linear conditions") if isinstance(answer, TooLarge) else answer
    if len(names) == 1:
        return univariate.solve(rows, names.pop())
    return _nonlinear(rows, names)


def _nonlinear(rows: list[Row], names: set[str]) -> dict[str, Fraction] | Infeasible | Undecided:
    linear = [r for r in rows if r.poly.total_degree() <= 1]
    answer = solve(linear) if linear else {}
    if isinstance(answer, Infeasible):
        return answer
    guess = _guess(rows, sorted(names))
    if guess is not None:
        return guess
    if any(n.startswith(STAND_IN) for n in names):
        return Undecided("the condition is no polynomial one")
    from haverify.solvers import z3

    return z3.solve(rows)


def _guess(rows: list[Row], names: list[str]) -> dict[str, Fraction] | None:
    """A solution among simple points: each unknown 0 or at one of its own bounds."""
    candidates = [[Fraction(0), *_bounds(rows, n)][:4] for n in names]
    if prod(len(c) for c in candidates) > MAX_CHOICES:
        return None
    for values in product(*candidates):
        point = dict(zip(names, values, strict=True))
        if all(_is_met(r, point) for r in rows):
            return point
    return None


def _bounds(rows: list[Row], name: str) -> list[Fraction]:
    only = [r.poly.univariate() for r in rows if r.poly.variables == (name,) and r.poly.total_degree() == 1]
    return sorted({-p[0] / p[1] for p in only} - {Fraction(0)})


def _is_met(row: Row, point: dict[str, Fraction]) -> bool:
    value = row.poly.value(point)
    return value == 0 if row.relation == "==" else value < 0 or (value == 0 and row.relation == "<=")
