"""A start whose own stretches certainly exist and certainly decide the goal: a run that refutes, or is reached."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, takewhile

from haverify.analyses.hybrid.conditions import Definitions, Every, closed, condition, is_true, members
from haverify.analyses.hybrid.conserved import conserved
from haverify.analyses.hybrid.goal import judged_of
from haverify.analyses.hybrid.inputs import choices
from haverify.analyses.hybrid.listing import Watched, listings
from haverify.analyses.hybrid.model import HybridModel, Start
from haverify.analyses.hybrid.question import Piece, Question, exact_range, follow, sides
from haverify.analyses.hybrid.starts import Box, points
from haverify.evidence.run import Passage, Run, Step
from haverify.model.expression import Expr
from haverify.obligations.constants import params_of
from haverify.obligations.residual import Situation, residual
from haverify.solvers.kernel import Budget, ModeListing, Pair, Settings, Stretch, Tape, Words, reach
from haverify.text.record import replace

Q = Fraction

Point = tuple[Start, tuple[Q, ...]]
Hurried = frozenset[tuple[int, int]]
TRUE: Words = [("true", 0)]
FEW = 3  # starts from which edges are hurried
MOST_WAITING = 6  # edges that are hurried one by one


def admissible(question: Question) -> Point | None:
    """A start that is certainly admissible."""
    tried = ((s, p) for s in question.model.starts for p in points(s.box))
    return next(((s, p) for s, p in tried if _is_admissible(question, s, p)), None)


def admissible_points(question: Question) -> list[Point]:
    """The middles and corners of starts that are certainly admissible."""
    return [(s, p) for s in question.model.starts for p in points(s.box) if _is_admissible(question, s, p)]


def by_a_run(question: Question) -> tuple[Point | None, Run | None]:
    """A start that is certainly admissible; a run that certainly decides the goal, from a middle or a corner."""
    model = question.model
    tried = admissible_points(question)
    open_ones = list(_not_ruled_out(question, tried)) if len(tried) > 1 else tried
    for hurried in hurries(question.modes):
        for chosen in choices(model):
            modes = hasty(listings(model, question.judged, chosen=chosen) if chosen else question.modes, hurried)
            driven = replace(question, modes=modes, driven=chosen)
            for start, point in open_ones[:FEW] if hurried else open_ones:
                run = _run_from(driven, start, point)
                if run is not None:
                    question.shown, question.hurried = driven.shown, bool(hurried)
                    return (start, point), run
    return (tried[0] if tried else None), None


def hurries(modes: Sequence[ModeListing]) -> Iterator[Hurried]:
    """Edges to take as soon as they may be: none that may wait; one of them; all.

    A run that takes an edge at the first instant of a closed guard is a run like any other (LANGUAGE S10).
    """
    waiting = [
        (m, k)
        for m, (*_, edges) in enumerate(modes)
        for k, (_, is_urgent, guard, *_) in enumerate(edges)
        if not is_urgent and guard and all(op in ("<=", ">=", "==") for _, op in guard)
    ]
    yield frozenset()
    if len(waiting) <= MOST_WAITING:
        yield from (frozenset({edge}) for edge in waiting)
    if len(waiting) > 1:
        yield frozenset(waiting)


def hasty(modes: Sequence[ModeListing], hurried: Hurried) -> list[ModeListing]:
    """The automaton where some edges are urgent: its runs are some of those that there are."""
    return [
        (*mode[:-1], [(e[0], e[1] or (m, k) in hurried, *e[2:]) for k, e in enumerate(mode[-1])])
        for m, mode in enumerate(modes)
    ]


def _not_ruled_out(question: Question, tried: Sequence[Point]) -> Iterator[Point]:
    """The starts of which what flows and jumps keep does not show that no run from there decides the goal."""
    laws = None if question.model.open else conserved(question.model)
    for start, point in tried:
        alone = None if laws is None else laws.alone(replace(start, box=tuple((q, q) for q in point)))
        judged = judged_of(question.model, question.asked, alone)
        if not all(is_true(c) for c in (*judged.dwelling, *judged.landing.values())):
            yield start, point


def by_all(question: Question) -> Run | None:
    """A run from the middle of the only start, all runs from there violating the goal at one instant."""
    (start,) = question.model.starts
    tree = follow(question, start, start.box, "violated")
    found = _violating(question, start, [(low + high) / 2 for low, high in start.box], tree)
    if found is not None:
        question.shown = [Piece(start, start.box, tree)]
    return found


def violated_by_all(question: Question, start: Start, box: Box) -> Run | None:
    """A run from the middle of a box, all runs from there violating the goal after the same certain jumps."""
    tree = follow(question, start, box, "violated")
    point = [(low + high) / 2 for low, high in box]
    number: int | None = 0
    while number is not None and tree[number].is_certain:
        found = _violating_in(question, start, point, tree, number)
        if found is not None:
            return found
        number = _only_next(tree, number) if _is_followed(tree, number) else None
    return None


def never_met_by_all(question: Question, start: Start, box: Box) -> Run | None:
    """A run from the middle of a box, all runs from there going past the bound without ever meeting the goal."""
    tree = follow(question, start, box, "met")
    point = [(low + high) / 2 for low, high in box]
    number: int | None = 0
    while number is not None and _certainly_fails(tree[number]):
        if tree[number].end == "horizon" and all(t.parent != number for t in tree):
            last = tree[number].stages[-1].time
            return _run(question, start, point, tree, number, last, is_landing=False)
        number = _only_next(tree, number)
    return None


def _only_next(tree: Sequence[Stretch], number: int) -> int | None:
    """The stretch that all runs of one jump to; None where they part, or are cut."""
    following = [i for i, t in enumerate(tree) if t.parent == number]
    return following[0] if len(following) == 1 and tree[following[0]].jump is not None else None


def _certainly_fails(s: Stretch) -> bool:
    """Whether all runs of a stretch exist, stay in the declared ranges and never meet the goal."""
    landed = s.jump is None or s.jump.claim.fails
    return s.is_certain and landed and all(g.claim.fails and g.keeps_window for g in s.stages)


def _is_admissible(question: Question, start: Start, point: Sequence[Q]) -> bool:
    """Whether a start is certainly one."""
    return certainly_admissible(question, start, tuple((q, q) for q in point))


def certainly_admissible(question: Question, start: Start, box: Box) -> bool:
    """Whether all of a box are starts: the init line and the domain hold there.

    The conditions are judged along a field that is zero, so that nothing moves.
    """
    model = question.model
    known, mode = model.definitions[start.mode], model.modes[start.mode]
    at = Situation(model.places[start.mode].mode)
    ends = dict(zip(model.names, box, strict=True))
    conditions = [
        condition(e, known) for r in start.rest for e in members(residual(r, at)) if not _holds_exactly(e, ends, known)
    ]
    inside = (e for e in members(residual(mode.domain, at)) if not _holds_exactly(e, ends, known, is_closed=True))
    conditions += [closed(condition(e, known)) for e in inside]
    conditions += question.judged.assumed[start.mode]
    if all(c is True for c in conditions):
        return True
    variables = {n: i for i, n in enumerate(model.names)}
    watched = Watched(Tape(variables, known))
    words = watched.words(Every(tuple(conditions)))
    still = Tape(variables, known)
    zero = still.add(Expr("num", (Q(0),)))
    field = still.listing([zero] * len(model.names))
    listing: ModeListing = (field, [], watched.listing(), [], [], TRUE, words, TRUE, [])
    settings = Settings(1, 1, 1e-9, 1e-3, 1e-3, 1e-9, 10, 0)
    (stretch,) = reach([listing], (0, sides(box), []), 1e-3, "horizon", settings, Budget(0, 1, 0))
    return bool(stretch.stages) and all(g.claim.holds for g in stretch.stages)


def _holds_exactly(e: Expr, ends: Mapping[str, tuple[Q, Q]], known: Definitions, is_closed: bool = False) -> bool:
    """Whether a comparison of sums holds in all of a box, by exact arithmetic: at a border enclosures cannot tell."""
    op = {"<": "<=", ">": ">="}.get(e.op, e.op) if is_closed else e.op
    if op not in ("<", "<=", ">", ">=", "=="):
        return False
    apart = exact_range(Expr("-", e.children), ends, known)
    if apart is None:
        return False
    low, high = apart
    return {"<": high < 0, "<=": high <= 0, ">": low > 0, ">=": low >= 0, "==": low == high == 0}[op]


def _run_from(question: Question, start: Start, point: Sequence[Q]) -> Run | None:
    """The run from a start, if it certainly violates what has to hold, or never meets it."""
    box = tuple((q, q) for q in point)
    is_reach = question.asked.kind == "reach"
    tree = follow(question, start, box, "met" if is_reach else "violated")
    question.points.setdefault((start.mode, box), tree)
    found = _never_met(question, start, point, tree) if is_reach else _violating(question, start, point, tree)
    if found is not None:
        question.shown = [Piece(start, box, tree)]
    return found


def _violating(question: Question, start: Start, point: Sequence[Q], tree: Sequence[Stretch]) -> Run | None:
    """The run up to where it certainly violates what has to hold."""
    for number, s in enumerate(tree):
        if _is_followed(tree, s.parent):
            found = _violating_in(question, start, point, tree, number)
            if found is not None:
                return found
    return None


def _violating_in(
    question: Question, start: Start, point: Sequence[Q], tree: Sequence[Stretch], number: int
) -> Run | None:
    """The run up to where a stretch certainly violates what has to hold."""
    s = tree[number]
    when = s.jump.claim.violated if s.jump is not None else None
    if when is not None:
        return _run(question, start, point, tree, number, when, is_landing=True)
    for g in takewhile(lambda g: g.keeps_window or g.claim.violated is not None, s.stages):
        if g.claim.violated is not None:
            return _run(question, start, point, tree, number, g.claim.violated, is_landing=False)
    return None


def _is_followed(tree: Sequence[Stretch], number: int | None) -> bool:
    """Whether runs stay in the declared ranges to the end of a stretch: they are followed no farther (S4)."""
    while number is not None:
        if not all(g.keeps_window for g in tree[number].stages):
            return False
        number = tree[number].parent
    return True


def run_through(question: Question, start: Start, point: Sequence[Q], tree: Sequence[Stretch], number: int) -> Run:
    """The run to the last step of a stretch."""
    return _run(question, start, point, tree, number, tree[number].stages[-1].time, is_landing=False)


def _never_met(question: Question, start: Start, point: Sequence[Q], tree: Sequence[Stretch]) -> Run | None:
    """The run along certain stretches that never meets the goal: it goes past the bound, or is stuck before (S20)."""
    open_ones = [0]
    while open_ones:
        number = open_ones.pop()
        s = tree[number]
        if not _certainly_fails(s):
            continue
        if s.end == "horizon" or _is_stuck(question, tree, number):
            return _run(question, start, point, tree, number, s.stages[-1].time, is_landing=False)
        if s.end == "jumped":
            open_ones += [i for i, t in reversed(list(enumerate(tree))) if t.parent == number and t.is_certain]
    return None


def _is_stuck(question: Question, tree: Sequence[Stretch], number: int) -> bool:
    """Whether the run of a certain stretch leaves its domain where no edge is possible; inputs might keep it inside."""
    s, model = tree[number], question.model
    is_free = bool(question.driven or model.assumed) or any(m.terminal for m in model.modes)
    is_free |= question.asked.to_the_end  # S21: it only keeps a signal's claim from being proved
    return s.end == "left" and bool(s.stages) and not is_free and all(t.parent != number for t in tree)


def _run(
    question: Question,
    start: Start,
    point: Sequence[Q],
    tree: Sequence[Stretch],
    number: int,
    when: Pair,
    is_landing: bool,
) -> Run:
    """The run down to a stretch of the tree; its dwells are numbers inside their enclosures."""
    model = question.model
    path = [number]
    while (parent := tree[path[0]].parent) is not None:
        path.insert(0, parent)
    steps, now = [], Q(0)
    for before, after in pairwise(path):
        jump = tree[after].jump
        if jump is None:
            continue
        edge = model.origins[model.edges[tree[before].mode][jump.edge]]
        if edge is None:
            continue
        instant = _simplest(*jump.time)
        steps.append(Step(max(instant - now, Q(0)), edge))
        now = instant
    is_landing = is_landing and _is_jump(model, tree, number)
    at = Q(0) if is_landing else max(_simplest(max(when[0], float(now)), when[1]) - now, Q(0))
    count = len(model.automaton.vars)
    values = _ordered(model, dict(zip(model.names[:count], point[:count], strict=True)), start.mode)
    chosen = {n: low for n, (low, _) in question.driven.items()}
    params = tuple({**params_at(model, point), **chosen}.items())
    passages = _passages(model, tree, path, values)
    end = _passage(model, tree[number], None, when, _states_at(tree[number], when, is_landing))
    return Run(model.places[start.mode].mode, values, params, tuple(steps), at, (*passages, end))


def params_at(model: HybridModel, point: Sequence[Q]) -> dict[str, Q]:
    """The params at a start; those that nothing reads have any value in their range."""
    count = len(model.automaton.vars)
    unread = {p.name: model.values.interval(p.range)[0] for p in params_of(model.spec, model.automaton)}
    return {**unread, **dict(zip(model.names[count:-1], point[count:-1], strict=True))}


def _passages(
    model: HybridModel, tree: Sequence[Stretch], path: Sequence[int], values: Sequence[tuple[str, Q]]
) -> Iterator[Passage]:
    """The start and the landings on the way to a stretch."""
    reals = [v.name for v in model.automaton.vars]
    first = [(float(q), float(q)) for n, q in values if n in reals]
    yield _passage(model, tree[path[0]], None, (0.0, 0.0), first)
    for before, after in pairwise(path):
        jump = tree[after].jump
        if jump is not None and _is_jump(model, tree, after):
            edge = model.automaton.edges[model.edges[tree[before].mode][jump.edge]].name
            yield _passage(model, tree[after], edge, jump.time, jump.after)


def _passage(model: HybridModel, s: Stretch, edge: str | None, time: Pair, states: Sequence[Pair]) -> Passage:
    names = [v.name for v in model.automaton.vars]
    known = dict(zip(names, states, strict=False)) | {n: (float(q), float(q)) for n, q in model.discrete(s.mode)}
    ends = tuple((v, *known[v]) for v in model.variables if v in known)
    return Passage(model.places[s.mode].mode, edge, (max(time[0], 0.0), time[1]), ends)


def _is_jump(model: HybridModel, tree: Sequence[Stretch], number: int) -> bool:
    """Whether a stretch begins with a jump of the automaton: no change of side, no cut."""
    s = tree[number]
    if s.jump is None or s.parent is None:
        return False
    return model.origins[model.edges[tree[s.parent].mode][s.jump.edge]] is not None


def _ordered(model: HybridModel, reals: Mapping[str, Q], mode: int) -> tuple[tuple[str, Q], ...]:
    """The values of all variables as declared."""
    known = {**reals, **dict(model.discrete(mode))}
    return tuple((v, known[v]) for v in model.variables)


def _states_at(s: Stretch, when: Pair, is_landing: bool) -> Sequence[Pair]:
    """The states in the step with some instants; right after the jump for a landing."""
    if s.jump is not None and (is_landing or not s.stages):
        return s.jump.after
    return next((g.states for g in s.stages if g.time[0] <= when[0] and when[1] <= g.time[1]), s.stages[-1].states)


def _simplest(low: float, high: float) -> Q:
    """The number of fewest decimal places between two."""
    places = 0
    while True:
        scale = 10**places
        candidate = Q(-((-Q(low) * scale) // 1), scale)
        if candidate <= Q(high) or places > 400:
            return candidate
        places += 1
