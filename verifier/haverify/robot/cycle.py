"""One cycle of a clock-driven automaton: its modes in turn, each output a polynomial of the time since a mode began."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import islice
from types import MappingProxyType

from haverify.analyses.clock_model import ClockEdge, ClockModel, clock_model
from haverify.analyses.clocked import start_box
from haverify.analyses.motion import NOW, Motion, State
from haverify.maths.bernstein import Box, bounds
from haverify.maths.polynomial import Polynomial
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.formula import Formula, literals
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
_MOST = 200  # modes of a cycle


@record
class Piece:
    """A stay in a mode: `start` and `length` in s, outputs as coefficients of powers of the time since then.

    `shapes` are the coefficients as polynomials of the params that outputs read.
    """

    mode: str
    start: Q
    length: Q
    outputs: Mapping[str, tuple[Q, ...]]
    edge: str  # the one that ends it
    shapes: Mapping[str, tuple[Polynomial, ...]] = MappingProxyType({})

    def over(self, name: str, box: Box) -> list[tuple[Q, Q]]:
        """The ranges of an output's coefficients over values of params; at those followed, where the box is empty."""
        if not box:
            return [(c, c) for c in self.outputs[name]]
        return [bounds(p, box) for p in self.shapes[name]]


@record
class Cycle:
    """The modes until the first comes again. `params` are the values followed.

    `closes` tells whether the state does so too; `steady` that the modes' order and their clocks are the same for all
    values of the params. Then those that outputs read run through `box`, the others make the pace: between `slowest`
    and `fastest` times the one followed. Where it is not steady, `box` is empty and both are 1.
    """

    pieces: tuple[Piece, ...]
    params: Mapping[str, Q]
    closes: bool
    steady: bool
    slowest: Q
    fastest: Q
    box: Box
    pacer: str | None  # the param that the pace is a multiple of

    @property
    def pace_only(self) -> bool:
        """Whether params change how fast the cycle is run through and nothing else."""
        return self.steady and not self.box

    @property
    def length(self) -> Q:
        """Its duration (s)."""
        return self.pieces[-1].start + self.pieces[-1].length


def cycle_of(spec: Spec, automaton: HybridAutomaton, outputs: list[str]) -> Cycle:
    """One cycle with every param at its default (or in the middle of its range).

    Raises
    ------
    OutsideFragmentError    where the automaton is not driven by clocks, chooses, or ends
    """
    model = clock_model(spec, automaton)
    motion = Motion(model, _defaults(model, spec))
    first = _first(motion)
    pieces: list[Piece] = []
    state = first
    while len(pieces) < _MOST:
        piece, state = _piece(motion, state, outputs)
        pieces.append(piece)
        if state.mode == first.mode:
            closes = dict(state.values) == dict(first.values)
            box = _box(model, outputs)
            paces = (Q(1), Q(1))
            if box is not None and model.rho is not None:
                now = model.rho.value(motion.params)
                paces = (model.rho_range[0] / now, model.rho_range[1] / now)
            return Cycle(tuple(pieces), motion.params, closes, box is not None, *paces, box or {}, _pacer(model))
    raise OutsideFragmentError(f"no mode comes again within {_MOST}")


def _first(motion: Motion) -> State:
    """The only state to start from."""
    seen = [*islice(motion.starts(), 2)]
    if len(seen) > 1 or _is_open(motion.model):
        raise OutsideFragmentError("it starts in more than one state")
    if not seen:
        raise OutsideFragmentError("no state to start from is seen")
    return seen[0]


def _is_open(model: ClockModel) -> bool:
    """Whether an init line leaves a variable that it does not compute more than one value, be they seen or not."""
    for init in model.automaton.init:
        computed = {a.var for a in init.assigns if isinstance(a.to, Expr)}
        modes = range(len(model.automaton.modes)) if init.mode is None else [model.index[init.mode]]
        boxes = (start_box(model, init, index) or {} for index in modes)
        if any(x.low != x.high for box in boxes for v, x in box.items() if v not in computed):
            return True
    return False


def _defaults(model: ClockModel, spec: Spec) -> dict[str, Q]:
    given = {p.name: p.default for p in (*spec.params, *model.automaton.params)}
    found = {}
    for name, (low, high) in model.params.items():
        default = given.get(name)
        found[name] = (low + high) / 2 if default is None else model.values.number(default)
    return found


def _piece(motion: Motion, state: State, outputs: list[str]) -> tuple[Piece, State]:
    model, mode = motion.model, motion.model.automaton.modes[state.mode]
    stay = motion.stay(state, None)
    if stay is None or not stay[1]:
        raise OutsideFragmentError(f"mode {mode.name} is not left")
    dwell = stay[0]
    followed = motion.replaced(state)
    scope = model.scope(state.mode)
    moved, shapes = {}, {}
    for name in outputs:
        cases = scope.let(name)
        case = cases[0]
        divisor = case.denominator.constant
        if len(cases) > 1 or case.condition is not True or divisor is None:
            raise OutsideFragmentError(f"`{name}` in mode {mode.name} is no polynomial")
        shape = case.numerator.scaled(1 / divisor).substitute(followed)
        shapes[name] = tuple(shape.coefficients(NOW))
        p = shape.fix(motion.params)
        moved[name] = tuple(p.univariate()) if p.variables else (p.constant or Q(0),)
        if set(p.variables) - {NOW}:
            raise OutsideFragmentError(f"`{name}` in mode {mode.name} reads `{p.variables[0]}`")
    edge, following = _left(motion, state, dwell)
    return Piece(mode.name, state.time, dwell, moved, edge.name, shapes), following


def _left(motion: Motion, state: State, dwell: Q) -> tuple[ClockEdge, State]:
    """The edge taken after a dwell and the state it leads to, where there is but one way to go."""
    model, name = motion.model, motion.model.automaton.modes[state.mode].name
    ways: list[tuple[ClockEdge, State]] = []
    for k in model.leaving[state.mode]:
        due = motion.due(state, k, dwell)
        if due is None:
            continue
        if due < dwell:
            raise OutsideFragmentError(f"mode {name} may be left at any of several instants")
        edge = model.edge(k)
        if chosen := next((v for v, r in edge.resets.items() if r.is_set and r.low != r.high), None):
            raise OutsideFragmentError(f"edge {edge.name} chooses a value of `{chosen}`")
        ways += [(edge, after) for after, _ in motion.outcomes(motion.at(state, dwell), edge)]
    if not ways:
        raise OutsideFragmentError(f"no edge is taken from mode {name}")
    edge, following = ways[0]
    if other := next((e for e, s in ways if (s.mode, s.values) != (following.mode, following.values)), None):
        raise OutsideFragmentError(f"mode {name} may be left by edge {edge.name} and by edge {other.name}")
    return edge, following


def _box(model: ClockModel, outputs: list[str]) -> Box | None:
    """The ranges of the params that outputs read; None where a param changes more than the pace and the outputs."""
    names = set(model.params)
    formulas: list[Formula] = [model.mode(i).domain for i in range(len(model.automaton.modes))]
    formulas += [model.edge(k).guard for k in range(len(model.automaton.edges))]
    read = {v for f in formulas for member in literals(f) for v in member.polynomial.variables}
    for k in range(len(model.automaton.edges)):
        for r in model.edge(k).resets.values():
            read |= {*r.low.variables, *r.high.variables}
    for init in model.automaton.init:
        said = [init.where, *(a.to for a in init.assigns if isinstance(a.to, Expr))]
        read |= {node.name for e in said for node in nodes(e) if node.op == "param"}
    lets = [case for i in range(len(model.automaton.modes)) for name in outputs for case in model.scope(i).let(name)]
    shaping = {v for case in lets for v in case.numerator.variables} & names
    if model.rho is None or read & names or shaping & set(model.rho.variables):
        return None
    return {name: model.params[name] for name in sorted(shaping)}


def _pacer(model: ClockModel) -> str | None:
    if model.rho is None or len(model.rho.terms) != 1 or model.rho.total_degree() != 1:
        return None
    return model.rho.variables[0]
