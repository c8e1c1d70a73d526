"""An automaton that stays in one mode and follows its flow there, as the flowpipe analyses see it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Init, Mode, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record

Q = Fraction
Box = tuple[tuple[Q, Q], ...]

COMPARISONS = {"<", "<=", ">", ">=", "==", "!="}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


@record
class Atom:
    """`quantity op 0`."""

    quantity: Expr
    op: str


@record
class Every:
    """All of them hold."""

    members: tuple[Condition, ...]


@record
class Some:
    """At least one of them holds."""

    members: tuple[Condition, ...]


Condition = Atom | Every | Some | bool


@holder
class FlowModel:
    """One mode with its flow: names of the state (variables, params that matter, `time` if read), rates, start boxes.

    `rest` holds what an init line says beyond bounds of single variables: the boxes allow more than it.
    """

    spec: Spec
    automaton: HybridAutomaton
    mode: Mode
    values: Values
    names: tuple[str, ...]
    rates: tuple[Expr, ...]
    boxes: tuple[Box, ...]
    rest: tuple[Expr, ...]
    definitions: dict[tuple[str, str], Expr] = field(default_factory=dict)

    def condition(self, e: Expr) -> Condition:
        """A truth-valued expression in this mode as conditions on quantities."""
        return condition(residual(e, Situation(self.mode.name)), self.definitions)


def flow_model(spec: Spec, automaton: HybridAutomaton, asked: Sequence[Expr]) -> FlowModel:
    """The automaton, if every run stays in one mode, with all that it and the conditions `asked` read.

    Raises
    ------
    OutsideFragmentError    if it may jump, starts in several modes, has inputs, inclusions or discrete variables
    """
    mode = _only_mode(automaton)
    if mode.terminal:
        raise OutsideFragmentError("a terminal mode, in which a run may end, with a flow that is not clock-driven")
    if spec.inputs or automaton.inputs:
        raise OutsideFragmentError("inputs: flowpipes of this version have none")
    if any(v.type != "real" for v in automaton.vars):
        raise OutsideFragmentError("discrete variables beside a flow that is not clock-driven")
    values = values_of(spec, automaton)
    known = definitions(automaton, mode, values)
    read = _read(automaton, mode, known, asked)
    params = [p for p in params_of(spec, automaton) if ("param", p.name) in read]
    clock = ["time"] if ("time", "") in read else []
    names = (*(v.name for v in automaton.vars), *(p.name for p in params), *clock)
    zero, one = Expr("num", (Q(0),)), Expr("num", (Q(1),))
    rates = (*(rate(mode, v.name) for v in automaton.vars), *(zero for _ in params), *(one for _ in clock))
    unknown = [*(values.interval(p.range) for p in params), *((Q(0), Q(0)) for _ in clock)]
    boxes, rest = [], list[Expr]()
    for init in automaton.init:
        bounded, more = start_box(automaton, mode, init, values)
        boxes.append((*bounded, *unknown))
        rest += more
    return FlowModel(spec, automaton, mode, values, names, rates, tuple(boxes), tuple(rest), known)


def _read(
    automaton: HybridAutomaton, mode: Mode, definitions: dict[tuple[str, str], Expr], asked: Sequence[Expr]
) -> set[tuple[str, str]]:
    """What the flow, the starts, the domain and some conditions read, directly or through lets and constants."""
    starts = [e for i in automaton.init for e in (i.where, *(a.to for a in i.assigns if isinstance(a.to, Expr)))]
    waiting = [*asked, mode.domain, *starts, *(line.rate for line in mode.flow if isinstance(line.rate, Expr))]
    found = set[tuple[str, str]]()
    while waiting:
        for n in nodes(waiting.pop()):
            key = (n.op, str(n.args[0]) if n.op in ("param", "let", "const") else "")
            if n.op in ("param", "time", "let", "const") and key not in found:
                found.add(key)
                waiting += [definitions[key]] if key in definitions else []
    return found


def _only_mode(automaton: HybridAutomaton) -> Mode:
    started = {i.mode for i in automaton.init}
    modes = [m for m in automaton.modes if m.name in started or None in started]
    if len(modes) != 1:
        raise OutsideFragmentError("flows that start in several modes")
    if any(e.source == modes[0].name for e in automaton.edges):
        raise OutsideFragmentError("flows with jumps: flowpipes of this version stay in one mode")
    return modes[0]


def rate(mode: Mode, name: str) -> Expr:
    """The right side of a variable's flow in a mode."""
    found = next(line.rate for line in mode.flow if line.var == name)
    if isinstance(found, Range):
        raise OutsideFragmentError("differential inclusions: flowpipes of this version follow single fields")
    return found


def definitions(automaton: HybridAutomaton, mode: Mode, values: Values) -> dict[tuple[str, str], Expr]:
    """What lets and constants stand for in a mode."""
    found = {("let", o.name): residual(o.expr, Situation(mode.name)) for o in (*automaton.lets, *mode.lets)}
    constants = {("const", n): c.value for n, c in values.constants.items() if isinstance(c.value, Expr)}
    return {**found, **constants}


def start_box(
    automaton: HybridAutomaton, mode: Mode, init: Init, values: Values
) -> tuple[list[tuple[Q, Q]], list[Expr]]:
    """The least box that the bounds on single variables give, and the conjuncts that say more."""
    bounds: dict[str, tuple[Q | None, Q | None]] = {v.name: (None, None) for v in automaton.vars}
    for assign in init.assigns:
        to = assign.to
        bounds[assign.var] = values.interval(to) if isinstance(to, Range) else (values.number(to),) * 2
    bounding = (*members(init.where), *members(mode.domain))
    more = [e for e in bounding if not _bounded(e, bounds, values)]
    declared = {v.name: v.range for v in automaton.vars}
    box = []
    for name, (low, high) in bounds.items():
        wide = declared[name]
        first, last = values.interval(wide) if wide is not None else (None, None)
        low, high = first if low is None else low, last if high is None else high
        if low is None or high is None:
            raise OutsideFragmentError(f"the start leaves `{name}` without a bound")
        if low > high:
            raise OutsideFragmentError(f"no start: `{name}` would have to lie between {low} and {high}")
        box.append((low, high))
    return box, more


def members(e: Expr) -> Iterator[Expr]:
    """The conjuncts of a condition."""
    if e.op == "and":
        for c in e.children:
            yield from members(c)
    elif e.op != "true":
        yield e


def _bounded(e: Expr, bounds: dict[str, tuple[Q | None, Q | None]], values: Values) -> bool:
    """Whether a conjunct is a bound on one variable; the bound is noted (strict ones as if they were closed)."""
    if e.op not in COMPARISONS or e.op == "!=":
        return False
    left, right = e.children
    op = e.op
    if left.op not in ("var", "abs"):
        left, right, op = right, left, MIRRORED[op]
    if left.op == "abs" and op in ("<", "<="):
        inner, minus = left.children[0], Expr("neg", (right,))
        above = _bounded(Expr(op, (inner, right)), bounds, values)
        below = _bounded(Expr(MIRRORED[op], (inner, minus)), bounds, values)
        return above and below
    if left.op != "var":
        return False
    try:
        bound = values.number(right)
    except OutsideFragmentError:
        return False
    low, high = bounds[left.name]
    if op in (">", ">=", "=="):
        low = bound if low is None else max(low, bound)
    if op in ("<", "<=", "=="):
        high = bound if high is None else min(high, bound)
    bounds[left.name] = low, high
    return op in ("<=", ">=", "==")


def condition(e: Expr, definitions: dict[tuple[str, str], Expr], is_denied: bool = False) -> Condition:
    """A truth-valued expression (or its denial) as comparisons of quantities with zero.

    Raises
    ------
    OutsideFragmentError    if it holds what is no comparison of numbers
    """
    if e.op in ("true", "false"):
        return (e.op == "true") is not is_denied
    if e.op == "not":
        return condition(e.children[0], definitions, not is_denied)
    if e.op in ("let", "const") and (e.op, e.name) in definitions:
        return condition(definitions[e.op, e.name], definitions, is_denied)
    if e.op == "implies":
        premise, conclusion = e.children
        parts = (condition(premise, definitions, not is_denied), condition(conclusion, definitions, is_denied))
        return Every(parts) if is_denied else Some(parts)
    if e.op in ("and", "or"):
        members = tuple(condition(c, definitions, is_denied) for c in e.children)
        return Every(members) if (e.op == "and") is not is_denied else Some(members)
    if e.op in COMPARISONS:
        return _compared(e.children[0], e.children[1], NEGATED[e.op] if is_denied else e.op)
    raise OutsideFragmentError(f"`{e.op}` in a claim about a flow")


def _compared(left: Expr, right: Expr, op: str) -> Condition:
    """A comparison, a magnitude on one side split into its cases."""
    if (left.op != "abs" and right.op == "abs") or left.op == "num":
        left, right, op = right, left, MIRRORED[op]
    if left.op == "abs":
        inner = left.children[0]
        minus = Expr("neg", (inner,))
        if op in ("<", "<="):
            return Every((_compared(inner, right, op), _compared(minus, right, op)))
        if op in (">", ">="):
            return Some((_compared(inner, right, op), _compared(minus, right, op)))
    return Atom(left if right == Expr("num", (Q(0),)) else Expr("-", (left, right)), op)
