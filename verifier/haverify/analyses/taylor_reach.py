"""Claims about a flow, by validated flowpipes (Taylor models; docs/core.md section on flowpipes).

`always P` and `can reach P`, each within a time. A flowpipe encloses every run from a box: what holds along it holds on
every run. Where it does not, the box is split. One start whose own flowpipe certainly violates `P` for a while refutes.
Nothing is decided by a sampled run: the run that refutes is enclosed. Trust: `enclosed`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import floor
from typing import Any

from haverify.analyses.flow_model import Atom, Box, Condition, Every, FlowModel, flow_model
from haverify.analyses.flow_record import flow_json, halves, record_name
from haverify.analyses.taylor_options import tuned
from haverify.evidence.certificate import certificate, run_json, start_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.flowpipe import Stretch, flowpipe_json
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown, Verdict
from haverify.maths.interval import Interval
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import params_of
from haverify.obligations.obligation import hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Listing, Pair, Pipe, Segment, Settings, Tape, enclosed, flowpipe
from haverify.text.record import field as kept
from haverify.text.record import holder, record

Q = Fraction
Json = Any
METHOD = "taylor-reach"
PIECES = 512  # boxes looked at for one claim, at most
STEPS = 2000
WORK = 24_000  # steps of all of them together; one in more than `FEW` variables counts as several
FEW = 4
INSTANT = Q(1, 10**9)  # a horizon of 0 s is looked at for a little longer
LOOKS = 64  # a step is at most this part of the horizon, so that what is watched is seen that closely
UNLIMITED = (-1e300, 1e300)


@record
class Asked:
    """What has to hold at all instants from `first` to `last`, and what makes runs and starts admissible.

    Beyond `window`, the declared ranges, nothing is followed (LANGUAGE S4); outside `domain` there is no run; `start`
    is what an init line says beyond the boxes.
    """

    claim: Condition
    window: Condition
    domain: Condition
    start: Condition
    first: Q
    last: Q


@holder
class Question:
    """A goal on a flow, compiled: the field, and the quantities of the four conditions in their order.

    `shown` are the flowpipes to draw, with their boxes: those that decide, or how far the first one came.
    """

    model: FlowModel
    claim: Claim
    asked: Asked
    field: Listing
    watched: Listing
    atoms: list[Atom]
    limits: list[Pair]
    pieces: int = 0
    work: Q = Q(0)
    reached: Q | None = None
    trouble: str = ""
    shown: list[tuple[Box, Pipe]] = kept(default_factory=list)


def decide_flow(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json) -> Evidence:
    """What flowpipes show of a claim on an automaton that follows one flow.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of that kind
    """
    model = flow_model(spec, automaton, [g.condition for g in claim.goals])
    if claim.inductive or claim.using:
        raise OutsideFragmentError("invariants of flows need a proof of induction, which this version does not have")
    goals = [_decide(model, claim, goal) for goal in claim.goals]
    verdict = _combined([g[0] for g in goals])
    shown = next((g[4] for g in goals if g[0] is verdict), goals[0][4])
    parts = tuple(PartResult(i, "flow", model.mode.name, "", t, v, r) for i, (v, _, r, t, _) in enumerate(goals))
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, flowpipe=shown)
    known = hashes(spec, automaton, core)
    entries, cells = [], dict[str, Json]()
    for number, (goal, (_, entry, _, _, _)) in enumerate(zip(claim.goals, goals, strict=True)):
        digest = known.part(known.goal(claim, goal), "flow", model.mode.name, "")
        entries.append({**entry, "hash": digest} if entry else {})
        if "flow" in entry:
            name = entries[-1]["flow"] = record_name(claim.name, number)
            cells[name] = entry["flow"]
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    run = next((r for _, _, r, _, _ in goals if r is not None), None)
    made = certificate(claim.name, word, entries, None)
    return Evidence(verdict, parts, METHOD, made, cells, run=run, flowpipe=shown)


def _combined(verdicts: Sequence[Verdict]) -> Verdict:
    for kind in (Refuted, Unknown):
        found = next((v for v in verdicts if isinstance(v, kind)), None)
        if found is not None:
            return found
    margins = [v.margin for v in verdicts if isinstance(v, Proved) and v.margin is not None]
    return Proved(min(margins, key=lambda m: m.low, default=None))


def _decide(model: FlowModel, claim: Claim, goal: Goal) -> tuple[Verdict, Json, Run | None, str, Json]:
    """The verdict on one goal, its entry in the certificate, the run that shows it, the part in words, its drawing."""
    question = _question(model, claim, goal)
    return *_answered(question, goal), _drawing(question)


def _drawing(question: Question) -> Json:
    """The flowpipes to draw, None where there are none."""
    mode = question.model.mode.name
    stretches = []
    for box, pipe in question.shown:
        steps = [((s.start[0], s.end), _seen(question, s)) for s in pipe.segments]
        stretches.append(Stretch(mode, 0, [_pair(*ends) for ends in box], steps))
    return flowpipe_json(question.model.names, stretches) if stretches else None


def _seen(question: Question, s: Segment) -> list[Pair]:
    """The box of a step, cut where a variable was looked at more closely because the claim compares it."""
    box = list(s.states)
    for atom, (low, high) in zip(question.atoms, s.watched, strict=True):
        left, right = atom.quantity.children if atom.quantity.op == "-" else (atom.quantity, None)
        if left.op != "var" or (right is not None and right.op not in ("num", "scale", "const")):
            continue
        bound = 0.0 if right is None else float(question.model.values.number(right))
        v = question.model.names.index(left.name)
        box[v] = max(box[v][0], low + bound), min(box[v][1], high + bound)
    return box


def _answered(question: Question, goal: Goal) -> tuple[Verdict, Json, Run | None, str]:
    is_reach = goal.kind == "can_reach"
    start, run = _violating(question)
    if run is not None:
        text = "a run reaches it" if is_reach else "violated"
        given = {**dict(run.values), **dict(run.params), "time": Q(0)}
        point = tuple((given[n], given[n]) for n in question.model.names)
        entry = {"kind": "flow_run", "run": run_json(run), **_recorded(question, run.last, [point], [point])}
        return (Proved() if is_reach else Refuted(), entry, run, text)
    if start is None:
        return _without_start(question), {}, None, ""
    proof = _proved(question)
    if proof is None:
        return _undecided(question), {}, None, ""
    model, last = question.model, question.asked.last
    recorded = _recorded(question, last, model.boxes, list(proof))
    entry = {"kind": "flowpipe", "start": _start_json(model, start), **recorded}
    pipes = list(proof.values())
    if is_reach:
        return Refuted(), entry, None, "never reached"
    return Proved(_margin(question, pipes)), entry, None, "holds along every flowpipe"


def _recorded(question: Question, until: Q, boxes: Sequence[Box], pieces: Sequence[Box]) -> Json:
    """What the second checker needs to show the same, if it can be recorded."""
    is_point = all(low == high for low, high in pieces[0])
    settings = _settings(question, pieces[0], is_point)
    found = flow_json(question.model, question.field, max(until, INSTANT), boxes, pieces, settings)
    return {} if found is None else {"flow": found}


def _start_json(model: FlowModel, start: Sequence[Q]) -> Json:
    """An admissible start; params that nothing reads have any value in their range."""
    count = len(model.automaton.vars)
    params = {p.name: model.values.interval(p.range)[0] for p in params_of(model.spec, model.automaton)}
    known = {n: q for n, q in zip(model.names[count:], start[count:], strict=True) if n != "time"}
    return start_json(model.mode.name, dict(zip(model.names[:count], start[:count], strict=True)), {**params, **known})


def _without_start(question: Question) -> Unknown:
    if question.trouble:
        return Unknown("budget", f"the flow could not be followed from any start that was tried: {question.trouble}")
    return Unknown("vacuous", "no start was found that is certainly admissible")


def _undecided(question: Question) -> Unknown:
    at = question.reached
    reached = "" if at is None else f"shown up to t = {floor(at * 10**6) / 10**6:.6f} s"
    count = f"{question.pieces} flowpipes" if question.pieces > 1 else "a flowpipe"
    reason = f"{count} did not show it, and no run that violates it was found"
    reason += f"; the last one ended early: {question.trouble}" if question.trouble else ""
    return Unknown("budget", reason, reached, next_step="a smaller initial set or a shorter horizon")


def _question(model: FlowModel, claim: Claim, goal: Goal) -> Question:
    asked = _asked(model, claim, goal)
    variables = {n: i for i, n in enumerate(model.names)}
    flow = Tape(variables, model.definitions)
    rates = [flow.add(r) for r in model.rates]
    watch = Tape(variables, model.definitions)
    atoms = [a for c in (asked.claim, asked.window, asked.domain, asked.start) for a in _atoms(c)]
    outputs = [watch.add(a.quantity) for a in atoms]
    limits = _limits(asked.claim)
    limits += [UNLIMITED] * (len(atoms) - len(limits))
    for q in (asked.last, *(end for box in model.boxes for ends in box for end in ends)):
        enclosed(q)
    return Question(model, claim, asked, flow.listing(rates), watch.listing(outputs), atoms, limits)


def _asked(model: FlowModel, claim: Claim, goal: Goal) -> Asked:
    """The goal as a condition on a window of instants; `can reach` as its denial.

    Raises
    ------
    OutsideFragmentError    if the goal is of another kind, or has no horizon
    """
    if goal.kind not in ("always", "can_reach"):
        raise OutsideFragmentError(f"`{goal.kind.replace('_', ' ')}` about a flow that is not clock-driven")
    if claim.assume or model.spec.assumptions:
        raise OutsideFragmentError("assumptions beside a flow that is not clock-driven")
    ends = [model.values.number(e) for e in (claim.time, goal.within) if e is not None]
    first = Q(0)
    if goal.window is not None:
        first = max(first, model.values.number(goal.window[0]))
        ends.append(model.values.number(goal.window[1]))
    if not ends:
        raise OutsideFragmentError("a flow without a horizon; add `within T`")
    if min(ends) < first:
        raise OutsideFragmentError("the window holds no instant")
    e = goal.condition if goal.kind == "always" else Expr("not", (goal.condition,))
    start = Every(tuple(model.condition(r) for r in model.rest))
    window, domain = Every(tuple(_windows(model))), model.condition(model.mode.domain)
    return Asked(model.condition(e), window, domain, start, first, min(ends))


def _windows(model: FlowModel) -> Iterator[Condition]:
    """The declared ranges of the variables, as bounds."""
    for v in model.automaton.vars:
        if v.range is not None:
            low, high = (Expr("num", (q,)) for q in model.values.interval(v.range))
            yield Atom(Expr("-", (Expr("var", (v.name,)), low)), ">=")
            yield Atom(Expr("-", (Expr("var", (v.name,)), high)), "<=")


def _atoms(c: Condition) -> Iterator[Atom]:
    if isinstance(c, Atom):
        yield c
    elif not isinstance(c, bool):
        for member in c.members:
            yield from _atoms(member)


def _limits(c: Condition) -> list[Pair]:
    """Where a quantity needs no closer look: inside its bound."""
    wanted = {"<": (-1e300, 0.0), "<=": (-1e300, 0.0), ">": (0.0, 1e300), ">=": (0.0, 1e300)}
    return [wanted.get(a.op, UNLIMITED) for a in _atoms(c)]


def _truth(c: Condition, watched: Iterator[Pair]) -> bool | None:
    """Whether a condition holds for all values in the ranges (True), for none (False), or neither (None)."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        return _holds(c.op, *next(watched))
    found = [_truth(m, watched) for m in c.members]
    decisive = not isinstance(c, Every)
    if decisive in found:
        return decisive
    return None if None in found else not decisive


def _holds(op: str, low: float, high: float) -> bool | None:
    if op in (">", ">=", "!="):
        swapped = {">": "<=", ">=": "<", "!=": "=="}[op]
        inner = _holds(swapped, low, high)
        return None if inner is None else not inner
    if op == "==":
        return True if low == high == 0 else False if low > 0 or high < 0 else None
    if op == "<":
        return True if high < 0 else False if low >= 0 else None
    return True if high <= 0 else False if low > 0 else None


def _pipe(question: Question, box: Box, settings: Settings) -> Pipe:
    horizon = Interval.at(max(question.asked.last, INSTANT))
    started = [_pair(low, high) for low, high in box]
    return flowpipe(question.field, started, horizon, question.watched, question.limits, settings)


def _pair(low: Q, high: Q) -> Pair:
    x = Interval.between(low, high)
    return x.low, x.high


def _settings(question: Question, box: Box, is_point: bool) -> Settings:
    """Few variables can afford a high degree; the error aimed at follows the size of the state."""
    wide = sum(low < high for low, high in box)
    degree = 1 if is_point else 5 if wide <= 2 else 3 if wide <= 4 else 2
    size = max([float(abs(end)) for ends in box for end in ends], default=1.0) or 1.0
    horizon = float(max(question.asked.last, INSTANT))
    tolerance = 1e-7 * min(max(size, 1e-6), 1e6)
    settings = Settings(8, degree, tolerance, min(horizon, 0.02), horizon / LOOKS, horizon * 1e-7, STEPS, 4)
    return tuned(settings, question.claim, wide)


def _truths(question: Question, s: Segment) -> tuple[bool | None, bool | None, bool | None, bool | None]:
    """Claim, window, domain and start condition at the instants of a step."""
    watched = iter(s.watched)
    asked = question.asked
    claim = _truth(asked.claim, watched)
    window = _truth(asked.window, watched)
    return claim, window, _truth(asked.domain, watched), _truth(asked.start, watched)


def _open(question: Question, pipe: Pipe) -> Segment | None:
    """The first step at whose instants it is not shown that the claim holds and the window is kept."""
    for s in pipe.segments:
        claim, window, _, _ = _truths(question, s)
        is_asked = s.end >= question.asked.first and s.start[0] <= question.asked.last
        if window is not True or (is_asked and claim is not True):
            return s
    return None


def _proved(question: Question) -> dict[Box, Pipe] | None:
    """Flowpipes from pieces that cover all starts, along which the condition holds; None if too many are needed."""
    waiting = list(question.model.boxes)
    found: dict[Box, Pipe] = {}
    while waiting:
        box = waiting.pop()
        if question.pieces >= PIECES or question.work >= WORK:
            return None
        question.pieces += 1
        pipe = _pipe(question, box, _settings(question, box, is_point=False))
        question.work += len(pipe.segments) * max(Q(1), Q(len(box), FEW) ** 2)
        question.shown = question.shown or [(box, pipe)]
        undecided = _open(question, pipe)
        if undecided is None and not pipe.trouble:
            found[box] = pipe
            continue
        _note(question, pipe, undecided)
        if all(low == high for low, high in box):
            return None
        waiting += halves(box)[:0:-1]
    question.shown = list(found.items())
    return found


def _note(question: Question, pipe: Pipe, undecided: Segment | None) -> None:
    """How far it was shown: the least over the pieces that are open now."""
    end = undecided.start[0] if undecided is not None else pipe.segments[-1].end if pipe.segments else 0.0
    question.reached, question.trouble = Q(end), pipe.trouble


def _violating(question: Question) -> tuple[tuple[Q, ...] | None, Run | None]:
    """A start that is certainly admissible; a run that certainly violates the claim, from a middle or a corner."""
    start = None
    for box in question.model.boxes:
        for point in _points(box):
            is_admissible, at = _violated_at(question, point)
            start = point if start is None and is_admissible else start
            if at is not None:
                return point, _run(question.model, point, at)
    return start, None


def _points(box: Box) -> Iterator[tuple[Q, ...]]:
    yield tuple((low + high) / 2 for low, high in box)
    wide = [ends if ends[0] < ends[1] else ends[:1] for ends in box]
    if sum(len(w) > 1 for w in wide) <= 4:
        yield from product(*wide)


def _violated_at(question: Question, point: Sequence[Q]) -> tuple[bool, Q | None]:
    """Whether a start is certainly admissible, and an instant at which its run certainly violates the claim."""
    box = tuple((q, q) for q in point)
    pipe = _pipe(question, box, _settings(question, box, is_point=True))
    first, last = question.asked.first, question.asked.last
    for number, s in enumerate(pipe.segments):
        claim, window, domain, start = _truths(question, s)
        if window is not True or domain is not True or (number == 0 and start is not True):
            return number > 0, None
        low, high = max(Q(s.start[1]), first), min(Q(s.start[0]) + Q(s.length), last)
        if low <= high and claim is False:
            question.shown = [(box, pipe)]
            return True, _simplest(low, high)
    if not pipe.segments:
        question.trouble = pipe.trouble
    return bool(pipe.segments), None


def violating_from(model: FlowModel, claim: Claim, goal: Goal, point: Sequence[Q]) -> Q | None:
    """An instant at which the run from a point (in the order of the model's names) certainly violates an `always` goal.

    Raises
    ------
    OutsideFragmentError    if the goal is none that flowpipes speak of
    """
    return _violated_at(_question(model, claim, goal), point)[1]


def _simplest(low: Q, high: Q) -> Q:
    """The number of fewest decimal places between two."""
    places = 0
    while True:
        scale = 10**places
        candidate = Q(-((-low * scale) // 1), scale)
        if candidate <= high:
            return candidate
        places += 1


def _run(model: FlowModel, point: Sequence[Q], at: Q) -> Run:
    start = _start_json(model, point)
    values, params = ({n: Q(q) for n, q in start[key].items()} for key in ("values", "params"))
    return Run(model.mode.name, tuple(values.items()), tuple(params.items()), (), at)


def _margin(question: Question, proof: Sequence[Pipe]) -> Margin | None:
    """For one bound: at least how far the flowpipes stay from it, and how near one run comes."""
    if not isinstance(question.asked.claim, Atom) or question.asked.claim.op in ("==", "!="):
        return None
    atom = question.asked.claim
    unit = atom.quantity.children[0].unit if atom.quantity.op == "-" else None
    if unit is None:
        return None
    start = tuple((q, q) for q in next(_points(question.model.boxes[0])))
    run = _pipe(question, start, _settings(question, start, is_point=True))
    is_above = atom.op in (">", ">=")
    low, at = min(_distances(question, proof, is_above, 0 if is_above else 1))
    high, _ = min(_distances(question, [run], is_above, 1 if is_above else 0))
    return Margin(low, max(low, high), str(unit), f"t = {at:.6g} s")


def _distances(question: Question, pipes: Sequence[Pipe], is_above: bool, end: int) -> Iterator[tuple[Q, float]]:
    """For each step that the claim speaks of, an end of the watched range as a distance to the bound."""
    for s in (s for pipe in pipes for s in pipe.segments):
        if s.end >= question.asked.first and s.start[0] <= question.asked.last:
            value = Q(s.watched[0][end])
            yield (value if is_above else -value), s.start[0]
