"""One cycle of a clock-driven automaton: its modes in turn, each output a polynomial of the time since a mode began."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.clock_model import ClockModel, clock_model
from haverify.analyses.motion import NOW, Motion, State
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.formula import Formula, literals
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
_MOST = 200  # modes of a cycle


@record
class Piece:
    """A stay in a mode: `start` and `length` in s, outputs as coefficients of powers of the time since then."""

    mode: str
    start: Q
    length: Q
    outputs: Mapping[str, tuple[Q, ...]]
    edge: str  # the one that ends it


@record
class Cycle:
    """The modes until the first comes again. `params` are the values followed.

    `closes` tells whether the state does so too; `pace_only` that params change how fast the cycle is run through and
    nothing else, so that what is true of every posture is true for all their values; then `fastest` is the greatest
    pace over all values as a multiple of the one followed.
    """

    pieces: tuple[Piece, ...]
    params: Mapping[str, Q]
    closes: bool
    pace_only: bool
    fastest: Q

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
    first = next(motion.starts(), None)
    if first is None:
        raise OutsideFragmentError("no state to start from is seen")
    pieces: list[Piece] = []
    state = first
    while len(pieces) < _MOST:
        piece, state = _piece(motion, state, outputs)
        pieces.append(piece)
        if state.mode == first.mode:
            closes = dict(state.values) == dict(first.values)
            pace_only = _pace_only(model, outputs)
            fastest = model.rho_range[1] / model.rho.value(motion.params) if pace_only and model.rho else Q(1)
            return Cycle(tuple(pieces), motion.params, closes, pace_only, fastest)
    raise OutsideFragmentError(f"no mode comes again within {_MOST}")


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
    after = motion.at(state, dwell)
    followed = motion.replaced(state)
    scope = model.scope(state.mode)
    moved = {}
    for name in outputs:
        cases = scope.let(name)
        case = cases[0]
        divisor = case.denominator.constant
        if len(cases) > 1 or case.condition is not True or divisor is None:
            raise OutsideFragmentError(f"`{name}` in mode {mode.name} is no polynomial")
        p = case.numerator.scaled(1 / divisor).fix(motion.params).substitute(followed)
        moved[name] = tuple(p.univariate()) if p.variables else (p.constant or Q(0),)
        if set(p.variables) - {NOW}:
            raise OutsideFragmentError(f"`{name}` in mode {mode.name} reads `{p.variables[0]}`")
    for k in model.leaving[state.mode]:
        if motion.due(state, k, dwell) is not None:
            for following, _ in motion.outcomes(after, model.edge(k)):
                return Piece(mode.name, state.time, dwell, moved, model.edge(k).name), following
    raise OutsideFragmentError(f"no edge is taken from mode {mode.name}")


def _pace_only(model: ClockModel, outputs: list[str]) -> bool:
    """Whether params are read by rates alone."""
    names = set(model.params)
    formulas: list[Formula] = [model.mode(i).domain for i in range(len(model.automaton.modes))]
    formulas += [model.edge(k).guard for k in range(len(model.automaton.edges))]
    read = {v for f in formulas for member in literals(f) for v in member.polynomial.variables}
    for i in range(len(model.automaton.modes)):
        for name in outputs:
            for case in model.scope(i).let(name):
                read |= set(case.numerator.variables)
    for k in range(len(model.automaton.edges)):
        for r in model.edge(k).resets.values():
            read |= {*r.low.variables, *r.high.variables}
    return not read & names and model.rho is not None
