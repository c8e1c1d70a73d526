"""A claim is false where one admissible start violates it at once, or by a run that a flowpipe encloses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from random import Random
from typing import Any

from haverify.analyses.induction.brackets import Bracketed, bracketed
from haverify.analyses.induction.points import TRIES, Point, certainly, exactly, farthest, satisfying
from haverify.analyses.induction.runs import compiled, violated, walk
from haverify.analyses.synthesis.samples import branches, inside
from haverify.analyses.synthesis.starts import exact_points
from haverify.evidence.run import Run
from haverify.maths.polynomial import Polynomial
from haverify.model.expression import TRUE, Expr
from haverify.model.hybrid import Assign, Init, Param, Range
from haverify.obligations.formula import Formula, negation
from haverify.obligations.induction import Induction
from haverify.obligations.premises import Premises
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Q = Fraction
Json = Any
STARTS = 12
STEPS = 600
SPANS = (Q(5), Q(60))  # how long runs are followed where the claim says nothing
TRIED = 4


@record
class Start:
    """An admissible start, and jumps that are made there at once: edges, and the values chosen by their resets."""

    mode: str
    point: Point
    jumps: tuple[tuple[int, tuple[tuple[str, Q], ...]], ...] = ()


def names_of(induction: Induction) -> list[str]:
    """Variables and params that are not one number."""
    return [
        *(v.name for v in induction.automaton.vars),
        *(n for n, (low, high) in induction.params.items() if low < high),
        *induction.inputs,
    ]


@record
class Exact:
    """An admissible start with values that are no rationals: polynomials in pi and functions of numbers."""

    mode: str
    point: dict[str, Polynomial]


Admissible = Start | Exact | Bracketed


def admissible(induction: Induction) -> Admissible | None:
    """An admissible start, None where none was found."""
    found = next(starts(induction, more=False), None)
    if found is not None:
        return found
    names = [*names_of(induction), "time"]
    for line, mode, _ in induction.lines():
        windows = [f for v in induction.automaton.vars for f in induction.window(v.name)]
        told = induction.premises(*induction.common(mode), *induction.starts(line, mode), *windows)
        point = exactly(told, names)
        if point is not None:
            return Exact(mode, point)
        between = _between_numbers(induction, told, names, mode)
        if between is not None:
            return between
    return None


def _between_numbers(induction: Induction, told: Premises, names: list[str], mode: str) -> Bracketed | None:
    """A start with variables that only brackets can tell."""
    variables = {v.name for v in induction.automaton.vars if v.type == "real"}
    for literals in branches(told.entries) if not told.functions.known else ():
        for near in inside(literals, names, TRIED):
            for found in bracketed(told, names, dict(zip(names, map(float, near), strict=True)), mode):
                if found.roots.keys() <= variables:
                    return found
    return None


def starts(induction: Induction, more: bool = True) -> Iterator[Start]:
    """Admissible starts: for each init line one that satisfies it, and (`more`) others around."""
    names = [*names_of(induction), "time"]
    for line, mode, _ in induction.lines():
        windows = [f for v in induction.automaton.vars for f in induction.window(v.name)]
        told = induction.premises(*induction.common(mode), *induction.starts(line, mode), *windows)
        first = satisfying(told, names)
        if first is not None:
            yield from (Start(mode, p) for p in (_around(told, first) if more else [first]))
            if more and not told.functions.known:
                yield from (Start(mode, p) for p in exact_points(told.entries, names))


def _around(told: Premises, first: Point) -> Iterator[Point]:
    """The point, and those reached from it in random directions as far as the conditions hold."""
    yield first
    random = Random(1)
    here, count = first, 0
    for _ in range(STARTS * 3):
        way = {n: Q(random.randint(-8, 8), 8) for n in first}
        length = Q(4)
        for _ in range(9):
            there = {n: q + (way[n] * length if n != "time" else 0) for n, q in here.items()}
            if all(certainly(f, there, told.functions) for f in told.entries):
                yield there
                count += 1
                here = there if count % 3 else first
                break
            length /= 2
        if count >= STARTS:
            return


def at_once(induction: Induction, tries: int = TRIES) -> Start | None:
    """An admissible start that violates the goal there and then, where the goal speaks of the start."""
    for way in (w for w in ways(induction) if w.edge is None):
        found = satisfying(way.told.with_(way.wrong), way.names(induction), tries)
        if found is not None:
            return way.start(found)
    return None


@record
class Way:
    """What an admissible start satisfies that may make a jump (`edge`) at once, and what violates the goal then."""

    mode: str
    edge: int | None
    told: Premises
    wrong: Formula

    def start(self, point: Point) -> Start:
        """The start at a point."""
        chosen = tuple((n[:-1], q) for n, q in point.items() if n.endswith("'"))
        state = {n: q for n, q in point.items() if not n.endswith("'")}
        return Start(self.mode, state, () if self.edge is None else ((self.edge, chosen),))

    def names(self, induction: Induction) -> list[str]:
        """What a point has to give a value to."""
        resets = induction.automaton.edges[self.edge].resets if self.edge is not None else ()
        return [*names_of(induction), "time", *(f"{a.var}'" for a in resets if isinstance(a.to, Range))]


def ways(induction: Induction) -> Iterator[Way]:
    """Starts that may violate the goal, and those that may after one jump, where the goal speaks of the start."""
    window, most = induction.goal.window, induction.claim.jumps
    if window is not None and induction.values.number(window[0]) > 0:
        return
    denial = Expr("not", (induction.condition,))  # where a divisor is 0 nothing is violated
    windows = [f for v in induction.automaton.vars for f in induction.window(v.name)]
    for line, mode, _ in induction.lines():
        told = induction.premises(*induction.common(mode), *induction.starts(line, mode), *windows)
        yield Way(mode, None, told, induction.formula(denial, mode))
        for k, edge in enumerate(induction.automaton.edges):
            if edge.source == mode and most != 0 and not induction.inputs:
                guard = induction.formula(edge.guard, mode, is_told=True)  # as written, also where the edge is urgent
                after = [induction.after(f, k) for f in windows]
                wrong = induction.after(induction.formula(denial, edge.target), k)
                yield Way(mode, k, told.with_(guard, *induction.jump(k), *after), wrong)


def by_jump(induction: Induction) -> Start | None:
    """An admissible start from which one jump, made at once, violates the goal."""
    for way in (w for w in ways(induction) if w.edge is not None):
        names = way.names(induction)
        found = satisfying(way.told.with_(way.wrong), names, 200) or _at_border(induction, way, names)
        if found is not None:
            return way.start(found)
    return None


def _at_border(induction: Induction, way: Way, names: list[str]) -> Point | None:
    """A start that is as far out as it may be, and violates the goal."""
    first = satisfying(way.told, names, 200)
    found = farthest(way.told, first, names) if first is not None else ()
    return next((p for p in found if certainly(way.wrong, p, induction.functions)), None)


def by_run(induction: Induction) -> Run | None:
    """A run inside of one mode whose flowpipe certainly violates the goal."""
    if induction.inputs or induction.using or induction.claim.assume or induction.spec.assumptions:
        return None
    tried = 0
    for span in (induction.limit,) if induction.limit is not None else SPANS:
        try:
            suspects = sorted(_suspects(induction, span), key=lambda s: s[1])
        except OverflowError:  # numbers that floats do not hold
            return None
        for start, time in suspects:
            tried += 1
            found = _enclosed(induction, start, Q(time).limit_denominator(1000) * Q(11, 10) + Q(1, 100))
            if found is not None:
                return found
            if tried >= TRIED:
                return None
    return None


def _suspects(induction: Induction, span: Q) -> list[tuple[Start, float]]:
    """Starts whose runs, in floats, violate the goal inside of the domain, and when."""
    names = [*names_of(induction), "time"]
    found = []
    for start in starts(induction):
        if any(e.urgent and e.source == start.mode for e in induction.automaton.edges):
            continue
        fields, functions = induction.field(start.mode), induction.functions
        rates = [compiled(fields[n], names, functions) if n in fields else lambda _: 0.0 for n in names]
        wrong = violated(negation(induction.aim(start.mode)), names, functions)
        outside = violated(negation(induction.premises(*induction.common(start.mode)).conjunction()), names, functions)
        for _, point in walk(rates, [start.point[n] for n in names], float(span), STEPS):
            if outside(point):
                break
            if wrong(point):
                found.append((start, point[-1]))
                break
    return found


def _enclosed(induction: Induction, start: Start, span: Q) -> Run | None:
    """The run from a start up to its violation, if a flowpipe shows it."""
    from haverify.analyses.hybrid.model import hybrid_model
    from haverify.analyses.hybrid.question import question_of
    from haverify.analyses.hybrid.runs import by_a_run

    spec, automaton, claim = alone(induction, start.mode, {n: (q, q) for n, q in start.point.items()}, span)
    try:
        goal = claim.goals[0]
        model = hybrid_model(spec, automaton, [goal.condition])
        _, run = by_a_run(question_of(model, claim, goal))
    except OutsideFragmentError:
        return None
    if run is None:
        return None
    values = tuple((v.name, start.point[v.name]) for v in induction.automaton.vars)
    params = tuple((n, start.point.get(n, low)) for n, (low, _) in induction.params.items())
    return Run(start.mode, values, params, (), run.last)


def alone(induction: Induction, mode: str, ends: Mapping[str, tuple[Q, Q]], span: Q) -> Any:
    """Spec, automaton and claim with a mode and starts in it alone; its edges are not urgent, so a run may stay.

    A claim without a horizon speaks of the first `span` seconds.
    """

    def given(name: str) -> Range:
        low, high = ends.get(name, induction.params.get(name, (Q(0), Q(0))))
        return Range(Expr("num", (low,)), Expr("num", (high,)))

    def fixed(params: tuple[Param, ...]) -> tuple[Param, ...]:
        lows = {p.name: ends.get(p.name, induction.params[p.name])[0] for p in params}
        return tuple(replace(p, range=Range(*[Expr("num", (lows[p.name],))] * 2)) for p in params)

    a = induction.automaton
    assigns = tuple(Assign(v.name, given(v.name)) for v in a.vars)
    only = replace(induction.mode(mode), terminal=False)
    automaton = replace(a, modes=(only,), edges=(), init=(Init(mode, TRUE, assigns),), params=fixed(a.params))
    claim = replace(induction.claim, goals=(induction.goal,))
    claim = claim if induction.limit is not None else replace(claim, time=Expr("num", (span,)))
    return replace(induction.spec, params=fixed(induction.spec.params)), automaton, claim
