"""Claims about automata with flows and jumps, by the tree of stretches that encloses all their runs.

`always P`, `can reach P` and `reach P within T`. What holds on every stretch holds on every run. Where it does not, the
box of starts is split. A start whose own stretches certainly exist and certainly violate `P` refutes. Trust: `enclosed`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from math import floor
from typing import Any

from haverify.analyses.flow_model import Atom, Box, Condition, Every, Some, condition
from haverify.analyses.hybrid_model import (
    HybridModel,
    Judged,
    ModeListing,
    Start,
    hybrid_model,
    landing_condition,
    listings,
)
from haverify.evidence.certificate import certificate, run_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run, Step
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown, Verdict
from haverify.maths.interval import Interval
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.obligation import hashes
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Budget, Pair, Settings, Stretch, reach
from haverify.text.record import holder, record

Q = Fraction
Json = Any
METHOD = "taylor-reach"
PIECES = 128  # boxes looked at for one claim, at most
STEPS = 4000
STRETCHES = 400
CUTS = 6
MOST_JUMPS = 200
LOOKS = 32  # a step is at most this part of the horizon
INSTANT = Q(1, 10**9)
TIME = Expr("time")


@record
class Asked:
    """A goal as one condition on instants from `first` to `last`; `jumps` is the budget, or a bound of the claim."""

    kind: str
    condition: Expr
    first: Q
    last: Q
    jumps: int
    jumps_bound: bool


@holder
class Question:
    """A goal compiled for the kernel."""

    model: HybridModel
    asked: Asked
    modes: list[ModeListing]
    # For each mode, the comparisons of the claim: quantity, sign, position among what is watched.
    compared: list[list[tuple[Expr, str, int]]]
    reached: float | None = None
    trouble: str = ""
    pieces: int = 0


def decide_hybrid(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json) -> Evidence:
    """What enclosures of all runs show of a claim on an automaton with flows and jumps.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of that kind
    """
    if claim.inductive or claim.using or claim.kind == "invariant":
        raise OutsideFragmentError("invariants of flows need a proof of induction, which flowpipes are not")
    if claim.assume or spec.assumptions:
        raise OutsideFragmentError("assumptions beside a flow that is not clock-driven")
    model = hybrid_model(spec, automaton, [g.condition for g in claim.goals])
    answers = [_decide(_question(model, claim, goal)) for goal in claim.goals]
    verdict = _combined([a.verdict for a in answers])
    parts = tuple(
        PartResult(i, "flow", model.modes[model.starts[0].mode].name, "", a.text, a.verdict, a.run)
        for i, a in enumerate(answers)
    )
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD)
    known = hashes(spec, automaton, core)
    entries = []
    for goal, answer in zip(claim.goals, answers, strict=True):
        digest = known.part(known.goal(claim, goal), "flow", parts[0].where, "")
        entries.append({**answer.entry, "hash": digest} if answer.entry else {})
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    run = next((a.run for a in answers if a.run is not None), None)
    return Evidence(verdict, parts, METHOD, certificate(claim.name, word, entries, None), run=run)


@record
class Answer:
    """The verdict on one goal, the part in words, its entry in the certificate, the run that shows it."""

    verdict: Verdict
    text: str = ""
    entry: Json = None
    run: Run | None = None


def _combined(verdicts: Sequence[Verdict]) -> Verdict:
    for kind in (Refuted, Unknown):
        found = next((v for v in verdicts if isinstance(v, kind)), None)
        if found is not None:
            return found
    margins = [v.margin for v in verdicts if isinstance(v, Proved) and v.margin is not None]
    return Proved(min(margins, key=lambda m: m.low, default=None))


def _question(model: HybridModel, claim: Claim, goal: Goal) -> Question:
    asked = _asked(model, claim, goal)
    judged = _judged(model, asked)
    compared: list[list[tuple[Expr, str, int]]] = []
    return Question(model, asked, listings(model, judged, compared), compared)


def _asked(model: HybridModel, claim: Claim, goal: Goal) -> Asked:
    """The goal as a condition on a window of instants.

    Raises
    ------
    OutsideFragmentError    if the goal is of another kind, or has no horizon
    """
    if goal.kind not in ("always", "can_reach", "reach"):
        raise OutsideFragmentError(f"`{goal.kind.replace('_', ' ')}` about a flow that is not clock-driven")
    ends = [model.values.number(e) for e in (claim.time, goal.within) if e is not None]
    first = Q(0)
    if goal.window is not None:
        first = max(first, model.values.number(goal.window[0]))
        ends.append(model.values.number(goal.window[1]))
    if not ends:
        raise OutsideFragmentError("a flow without a horizon; add `within T`")
    if min(ends) < first:
        raise OutsideFragmentError("the window holds no instant")
    _fit_for_ends(model, goal, first)
    jumps = MOST_JUMPS if claim.jumps is None else claim.jumps
    return Asked(goal.kind, goal.condition, first, min(ends), jumps, claim.jumps is not None)


def _fit_for_ends(model: HybridModel, goal: Goal, first: Q) -> None:
    """A run that ends in a terminal mode stays as it is: what speaks of time may become true (or false) later.

    Raises
    ------
    OutsideFragmentError    if the claim may depend on that
    """
    if any(m.terminal for m in model.modes) and (
        goal.kind == "reach" or first > 0 or any(n.op == "time" for n in nodes(goal.condition))
    ):
        raise OutsideFragmentError("a run may end in a terminal mode, and the claim speaks of later instants")


def _judged(model: HybridModel, asked: Asked) -> Judged:
    """What the kernel judges: `always` and the denial of `can reach` outside the instants not asked for as well."""
    is_denied = asked.kind == "can_reach"

    def timed(c: Condition) -> Condition:
        after = Atom(Expr("-", (TIME, Expr("num", (asked.last,)))), ">")
        if asked.kind == "reach":
            return Every((c, Atom(after.quantity, "<=")))
        before = Atom(Expr("-", (TIME, Expr("num", (asked.first,)))), "<")
        return Some((c, after, before) if asked.first > 0 else (c, after))

    dwelling = []
    for mode, known in zip(model.modes, model.definitions, strict=True):
        dwelling.append(timed(condition(residual(asked.condition, Situation(mode.name)), known, is_denied)))
    landing = [timed(landing_condition(model, e, asked.condition, is_denied)) for e in model.automaton.edges]
    return Judged(tuple(dwelling), tuple(landing), Every(tuple(_window(model))))


def _window(model: HybridModel) -> Iterator[Condition]:
    """The declared ranges of the variables, as bounds."""
    for v in model.automaton.vars:
        if v.range is not None:
            low, high = (Expr("num", (q,)) for q in model.values.interval(v.range))
            yield Atom(Expr("-", (Expr("var", (v.name,)), low)), ">=")
            yield Atom(Expr("-", (Expr("var", (v.name,)), high)), "<=")


def _decide(question: Question) -> Answer:
    """The verdict on one goal."""
    kind = question.asked.kind
    has_start, run = _by_a_run(question)
    if run is not None:
        entry = {"kind": "flow_run", "run": run_json(run)}
        if kind == "can_reach":
            return Answer(Proved(), "a run reaches it", entry, run)
        return Answer(Refuted(), "violated" if kind == "always" else "never met", entry, run)
    if not has_start:
        return Answer(Unknown("vacuous", "no start was found that is certainly admissible"))
    proof = _proved(question)
    if proof is None:
        return Answer(_undecided(question))
    entry = {"kind": "flowpipe", "pieces": len(proof)}
    if kind == "can_reach":
        return Answer(Refuted(), "never reached", entry)
    text = "holds along every flowpipe" if kind == "always" else "met along every flowpipe"
    return Answer(Proved(_margin(question, proof)), text, entry)


def _undecided(question: Question) -> Unknown:
    at = question.reached
    reached = "" if at is None else f"shown up to t = {floor(at * 10**6) / 10**6:.6f} s"
    why = f" ({question.trouble})" if question.trouble else ""
    reason = f"{question.pieces} sets of starts did not show it{why}, and no run that decides it was found"
    return Unknown("budget", reason, reached, next_step="a smaller initial set or a shorter horizon")


def _follow(question: Question, start: Start, box: Box, until: str) -> list[Stretch]:
    sides = [_pair(low, high) for low, high in box]
    horizon = Interval.at(max(question.asked.last, INSTANT)).high
    asked = question.asked
    budget = Budget(asked.jumps, STRETCHES, CUTS)
    known = _known(question, start, box)
    return reach(question.modes, (start.mode, sides, known), horizon, until, _settings(question, box), budget)


def _known(question: Question, start: Start, box: Box) -> list[tuple[int, str]]:
    """The comparisons that the claim makes in a mode and that hold on a box of starts exactly."""
    model = question.model
    sides = dict(zip(model.names, box, strict=True))
    found = []
    for quantity, op, place in question.compared[start.mode]:
        ends = _exact(quantity, sides, model.definitions[start.mode])
        if ends is not None and ((op == "<=" and ends[1] <= 0) or (op == ">=" and ends[0] >= 0)):
            found.append((place, op))
    return found


def _exact(e: Expr, sides: Mapping[str, tuple[Q, Q]], known: Mapping[tuple[str, str], Expr]) -> tuple[Q, Q] | None:
    """The exact range of a sum of multiples of variables over a box, by interval arithmetic; None for other forms."""
    if e.op == "num":
        return Q(str(e.args[0])), Q(str(e.args[0]))
    if e.op in ("var", "param"):
        return sides.get(e.name)
    if e.op in ("let", "const"):
        inner = known.get((e.op, e.name))
        return None if inner is None else _exact(inner, sides, known)
    if e.op not in ("+", "-", "neg"):
        return None
    ends = [_exact(c, sides, known) for c in e.children]
    if any(x is None for x in ends):
        return None
    first, *rest = (x for x in ends if x is not None)
    if e.op == "neg":
        return -first[1], -first[0]
    low, high = first
    for x in rest:
        low, high = (low + x[0], high + x[1]) if e.op == "+" else (low - x[1], high - x[0])
    return low, high


def _pair(low: Q, high: Q) -> Pair:
    x = Interval.between(low, high)
    return x.low, x.high


def _settings(question: Question, box: Box) -> Settings:
    """Few variables can afford a high degree; the error aimed at follows the size of the state."""
    wide = sum(low < high for low, high in box)
    degree = 1 if wide == 0 else 5 if wide <= 2 else 4 if wide <= 3 else 3 if wide <= 4 else 2
    size = max([float(abs(end)) for ends in box for end in ends], default=1.0) or 1.0
    horizon = float(max(question.asked.last, INSTANT))
    tolerance = 1e-7 * min(max(size, 1e-6), 1e6)
    return Settings(8, degree, tolerance, min(horizon, 0.02), horizon / LOOKS, horizon * 1e-9, STEPS, 4)


def _proved(question: Question) -> list[list[Stretch]] | None:
    """Trees from pieces that cover all starts and show the goal; None if too many are needed."""
    waiting = [(s, s.box) for s in question.model.starts]
    until = "met" if question.asked.kind == "reach" else "horizon"
    found: list[list[Stretch]] = []
    while waiting:
        start, box = waiting.pop()
        if question.pieces >= PIECES:
            return None
        question.pieces += 1
        tree = _follow(question, start, box, until)
        trouble = next((s for s in tree if not _shows(question, s)), None)
        if trouble is None:
            found.append(tree)
            continue
        _note(question, trouble)
        halves = _halved(box)
        if halves is None or trouble.end == "jumps":
            return None
        waiting += [(start, half) for half in halves]
    return found


def _shows(question: Question, s: Stretch) -> bool:
    """Whether a stretch leaves nothing open that its successors do not settle."""
    if question.asked.kind == "reach":
        return _is_met(s) or s.end in ("jumped", "cut")
    held = all(g.claim.holds and g.keeps_window for g in s.stages) and (s.jump is None or s.jump.claim.holds)
    return held and s.end in ("horizon", "jumped", "left", "cut")


def _is_met(s: Stretch) -> bool:
    return (s.jump is not None and s.jump.claim.met is not None) or any(
        g.claim.met is not None and g.keeps_window for g in s.stages
    )


def _note(question: Question, s: Stretch) -> None:
    """How far it was shown, and what was in the way."""
    open_at = next((g for g in s.stages if not (g.claim.holds and g.keeps_window)), None)
    last = open_at or (s.stages[-1] if s.stages else None)
    question.reached = max(last.time[0] if last is not None else s.jump.time[0] if s.jump is not None else 0.0, 0.0)
    if s.end == "jumps":
        question.trouble = f"a run may jump more than {question.asked.jumps} times"
    elif s.end not in ("horizon", "jumped", "cut", "left"):
        question.trouble = s.end
    elif open_at is not None and not open_at.keeps_window:
        question.trouble = "a run may leave the declared ranges"


def _halved(box: Box) -> list[Box] | None:
    """The box cut in two across its widest side; None if it is a point."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    if widths[v] == 0:
        return None
    low, high = box[v]
    middle = (low + high) / 2
    return [(*box[:v], (middle, high), *box[v + 1 :]), (*box[:v], (low, middle), *box[v + 1 :])]


def _by_a_run(question: Question) -> tuple[bool, Run | None]:
    """Whether a start is certainly admissible; a run that certainly decides the goal, from a middle or a corner."""
    has_start = False
    for start in question.model.starts:
        for point in _points(start.box):
            if not _is_admissible(question, start, point):
                continue
            has_start = True
            run = _run_from(question, start, point)
            if run is not None:
                return True, run
    return has_start, None


def _points(box: Box) -> Iterator[tuple[Q, ...]]:
    yield tuple((low + high) / 2 for low, high in box)
    wide = [ends if ends[0] < ends[1] else ends[:1] for ends in box]
    if 0 < sum(len(w) > 1 for w in wide) <= 4:
        yield from product(*wide)


def _is_admissible(question: Question, start: Start, point: Sequence[Q]) -> bool:
    """Whether a start is certainly one: the init line and the domain hold there.

    The conditions are judged along a field that is zero, so that nothing moves.
    """
    model = question.model
    known, mode = model.definitions[start.mode], model.modes[start.mode]
    at = Situation(mode.name)
    conditions = [condition(residual(e, at), known) for e in start.rest]
    conditions += [_closed(condition(residual(mode.domain, at), known))]
    from haverify.analyses.hybrid_model import Watched
    from haverify.solvers.kernel import Tape

    variables = {n: i for i, n in enumerate(model.names)}
    watched = Watched(Tape(variables, known))
    words = watched.words(Every(tuple(conditions)))
    still = Tape(variables, known)
    zero = still.add(Expr("num", (Q(0),)))
    listing = (still.listing([zero] * len(model.names)), watched.listing(), [], words, [("true", 0)], [])
    settings = Settings(1, 1, 1e-9, 1e-3, 1e-3, 1e-9, 10, 0)
    sides = [_pair(q, q) for q in point]
    (stretch,) = reach([listing], (0, sides, []), 1e-3, "horizon", settings, Budget(0, 1, 0))
    return bool(stretch.stages) and all(g.claim.holds for g in stretch.stages)


def _closed(c: Condition) -> Condition:
    """The condition as a domain is read: bounds closed, `!=` left out."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        return True if c.op == "!=" else Atom(c.quantity, {"<": "<=", ">": ">="}.get(c.op, c.op))
    members = tuple(_closed(m) for m in c.members)
    return Every(members) if isinstance(c, Every) else Some(members)


def _run_from(question: Question, start: Start, point: Sequence[Q]) -> Run | None:
    """The run from a start, if it certainly violates what has to hold, or never meets it."""
    box = tuple((q, q) for q in point)
    if question.asked.kind == "reach":
        return _never_met(question, start, point, _follow(question, start, box, "met"))
    tree = _follow(question, start, box, "violated")
    for number, s in enumerate(tree):
        when = s.jump.claim.violated if s.jump is not None else None
        if when is not None:
            return _run(question, start, point, tree, number, when, is_landing=True)
        for g in s.stages:
            if g.claim.violated is not None:
                return _run(question, start, point, tree, number, g.claim.violated, is_landing=False)
    return None


def _never_met(question: Question, start: Start, point: Sequence[Q], tree: Sequence[Stretch]) -> Run | None:
    """The run along certain stretches that goes past the bound without ever meeting the goal."""
    number = 0
    while True:
        s = tree[number]
        landed = s.jump is None or s.jump.claim.fails
        if not (s.is_certain and landed and all(g.claim.fails and g.keeps_window for g in s.stages)):
            return None
        if s.end == "horizon":
            last = s.stages[-1].time
            return _run(question, start, point, tree, number, last, is_landing=False)
        following = [i for i, t in enumerate(tree) if t.parent == number]
        number = next((i for i in following if tree[i].is_certain), -1)
        if s.end != "jumped" or number < 0:
            return None


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
    for before, after in zip(path, path[1:], strict=False):
        jump = tree[after].jump
        if jump is None:
            continue
        instant = _simplest(*jump.time)
        steps.append(Step(max(instant - now, Q(0)), model.edges[tree[before].mode][jump.edge]))
        now = instant
    at = Q(0) if is_landing else max(_simplest(max(when[0], float(now)), when[1]) - now, Q(0))
    count = len(model.automaton.vars)
    values = tuple(zip(model.names[:count], point[:count], strict=True))
    params = tuple(zip(model.names[count:-1], point[count:-1], strict=True))
    return Run(model.modes[start.mode].name, values, params, tuple(steps), at)


def _simplest(low: float, high: float) -> Q:
    """The number of fewest decimal places between two."""
    places = 0
    while True:
        scale = 10**places
        candidate = Q(-((-Q(low) * scale) // 1), scale)
        if candidate <= Q(high) or places > 400:
            return candidate
        places += 1


def _margin(question: Question, proof: Sequence[Sequence[Stretch]]) -> Margin | None:
    """For one bound in all modes: at least how far all enclosures stay from it."""
    asked = question.asked.condition
    if question.asked.kind != "always" or asked.op not in ("<", "<=", ">", ">=") or question.asked.first > 0:
        return None
    unit = asked.children[0].unit
    if unit is None or any(n.op in ("abs", "jump", "jumped", "pre", "at") for n in nodes(asked)):
        return None
    sign = 1 if _is_lower_bound(question) else -1
    stages = [g for tree in proof for s in tree for g in s.stages if g.time[0] <= question.asked.last]
    place = _claimed(question)
    ends = [(Q(g.watched[place][0 if sign > 0 else 1]) * sign, g.time[0]) for g in stages if g.watched]
    if not ends:
        return None
    low, at = min(ends)
    return Margin(low, low, str(unit), f"t = {max(at, 0.0):.6g} s")


def _is_lower_bound(question: Question) -> bool:
    return _claim_atom(question)[0] in (">", ">=")


def _claimed(question: Question) -> int:
    return _claim_atom(question)[1]


def _claim_atom(question: Question) -> tuple[str, int]:
    """The first comparison in what the first mode judges: the claim's own."""
    claim = question.modes[0][3]
    return next((word, place) for word, place in claim if word not in ("all", "any", "true", "false"))
