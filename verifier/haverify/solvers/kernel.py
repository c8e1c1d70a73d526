"""Expressions as tapes of the kernel, and flowpipes of the field that a tape describes.

Constants enter as enclosures of their exact values. What the kernel has no operation for is outside the fragment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify import _kernel
from haverify.maths.interval import Interval
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record

Operation = tuple[str, int, int]
Pair = tuple[float, float]
Listing = tuple[list[Operation], list[Pair], list[int]]
# A condition, the operator before its members: `all`, `any` with their number, `true`, `false`, or a comparison with
# zero and the position of its quantity.
Words = list[tuple[str, int]]
Comparisons = list[tuple[int, str]]
# Target, urgent, guard, reset, choices, quantities of the landing, the claim on these.
EdgeListing = tuple[int, bool, Comparisons, Listing, int, Listing, Words]
# Field, ranges of inputs (variables of the field after those of the state), watched quantities, domain, what else holds
# on runs that are judged, a condition without which they end, claim, window, edges.
ModeListing = tuple[Listing, list[Pair], Listing, Comparisons, Comparisons, Words, Words, Words, list[EdgeListing]]

INPUT = "input: "

_PLAIN = {"+": "add", "-": "sub", "*": "mul", "/": "div"}
_FUNCTIONS = {"sqrt": "sqrt", "exp": "exp", "log": "log", "neg": "neg"}
_HIGHEST_POWER = 64
_LARGEST = 2**1023


@holder
class Tape:
    """Operations over numbered variables; equal subexpressions are one operation.

    `variables` gives `var`, `param` and `time` nodes their numbers (by name, `time` for the last), `definitions` what
    `let` and `const` nodes stand for.
    """

    variables: Mapping[str, int]
    definitions: Mapping[tuple[str, str], Expr]
    operations: list[Operation] = field(default_factory=list)
    constants: list[Pair] = field(default_factory=list)
    _known: dict[Operation | Expr, int] = field(default_factory=dict)

    def listing(self, outputs: Sequence[int]) -> Listing:
        """The tape as the kernel takes it."""
        return self.operations, self.constants, list(outputs)

    def add(self, e: Expr) -> int:
        """The position of an expression's value."""
        if e not in self._known:
            self._known[e] = self._added(e)
        return self._known[e]

    def _added(self, e: Expr) -> int:
        if e.op in ("var", "param"):
            return self._variable(e.name, f"`{e.name}`")
        if e.op == "input":
            return self._input(e.name)
        if e.op == "time":
            return self._variable("time", "`time`")
        if e.op in ("let", "const"):
            definition = self.definitions.get((e.op, e.name))
            if definition is None:
                raise OutsideFragmentError(f"`{e.name}` is no single number")
            return self.add(definition)
        if e.op in ("num", "pi"):
            return self._constant(_exact(e))
        return self._operation(e)

    def _operation(self, e: Expr) -> int:
        if e.op == "scale":
            q, k, inner = e.args
            return self._push("mul", self._constant(_scale(q, k)), self.add(_expression(inner)))
        if e.op == "^":
            return self._power(e)
        if e.op in _PLAIN:
            return self._chain(_PLAIN[e.op], [self.add(c) for c in e.children])
        if e.op in _FUNCTIONS:
            return self._push(_FUNCTIONS[e.op], self.add(e.children[0]), 0)
        if e.op in ("sin", "cos", "tan"):
            return self._wave(e)
        raise OutsideFragmentError(f"`{e.op}` in a flow or in a claim about one")

    def _chain(self, name: str, operands: list[int]) -> int:
        result = operands[0]
        for operand in operands[1:]:
            result = self._push(name, result, operand)
        return result

    def _power(self, e: Expr) -> int:
        base, exponent = e.children
        if exponent.op != "num" or Fraction(str(exponent.args[0])).denominator != 1:
            raise OutsideFragmentError("a power whose exponent is no integer")
        n = int(Fraction(str(exponent.args[0])))
        if abs(n) > _HIGHEST_POWER:
            raise OutsideFragmentError(f"a power above {_HIGHEST_POWER}")
        if n == 0:
            return self._constant(Interval.at(1))
        result = self._repeated(self.add(base), abs(n))
        return result if n > 0 else self._push("div", self._constant(Interval.at(1)), result)

    def _repeated(self, base: int, n: int) -> int:
        """A power by squaring, so that even powers are squares."""
        if n == 1:
            return base
        half = self._repeated(base, n // 2)
        square = self._push("mul", half, half)
        return square if n % 2 == 0 else self._push("mul", square, base)

    def _wave(self, e: Expr) -> int:
        argument = self.add(e.children[0])
        sine = self._known.get(("sin", argument, 0))
        if sine is None:
            sine = self._push("sin", argument, 0)
            self._push("cos", argument, 0)
        if e.op == "tan":
            return self._push("div", sine, sine + 1)
        return sine if e.op == "sin" else sine + 1

    def _variable(self, name: str, shown: str) -> int:
        if name not in self.variables:
            raise OutsideFragmentError(f"{shown} is no real variable of the flow")
        return self._push("variable", self.variables[name], 0)

    def _input(self, name: str) -> int:
        if INPUT + name not in self.variables:
            raise OutsideFragmentError(f"the input `{name}` outside of the right sides of flows")
        return self._variable(INPUT + name, f"`{name}`")

    def _constant(self, value: Interval) -> int:
        pair = (value.low, value.high)
        if pair not in self.constants:
            self.constants.append(pair)
        return self._push("constant", self.constants.index(pair), 0)

    def _push(self, name: str, a: int, b: int) -> int:
        operation = (name, a, b)
        if operation not in self._known:
            self._known[operation] = len(self.operations)
            self.operations.append(operation)
        return self._known[operation]


def _expression(a: object) -> Expr:
    assert isinstance(a, Expr), "the last argument of a scale is an expression"
    return a


def _exact(e: Expr) -> Interval:
    if e.op == "pi":
        return _pi()
    return enclosed(Fraction(str(e.args[0])))


def enclosed(q: Fraction) -> Interval:
    """The least interval around a number.

    Raises
    ------
    OutsideFragmentError    if it is beyond the largest float
    """
    if abs(q) > _LARGEST:
        raise OutsideFragmentError("a number beyond the largest float, 1.8e308")
    return Interval.at(q)


def _pi() -> Interval:
    return Interval.at(1).atan() * 4


def _scale(q: object, k: object) -> Interval:
    return enclosed(Fraction(str(q))) * _pi() ** int(str(k))


@record
class Segment:
    """One step of a flowpipe: the instants from `start` on for `length`, all states, the watched quantities."""

    start: Pair
    length: float
    states: list[Pair]
    watched: list[Pair]

    @property
    def end(self) -> float:
        """No instant of the step is after it."""
        return (Interval(*self.start) + self.length).high


@record
class Pipe:
    """A flowpipe: its steps, why it ended before the horizon (empty if it did not), the states at the horizon."""

    segments: list[Segment]
    trouble: str
    last: list[Pair]


@record
class Settings:
    """How finely to compute: orders in time and in the set, error aimed at, lengths and number of steps."""

    order: int
    degree: int
    tolerance: float
    first: float
    longest: float
    least: float
    steps: int
    depth: int


def flowpipe(
    flow: Listing, box: Sequence[Pair], horizon: Interval, watched: Listing, limits: Sequence[Pair], settings: Settings
) -> Pipe:
    """The flowpipe of `x' = f(x)` from a box until a horizon, with the ranges of watched quantities along it.

    Raises
    ------
    Fault               if the floating-point unit does not round to nearest, or the call is malformed

    Soundness           every solution from the box lies in `states` of each step at its instants
    """
    s = settings
    rows, trouble, last = _kernel.flowpipe(
        flow, list(box), (horizon.low, horizon.high), watched, list(limits), (s.order, s.degree, s.steps, s.depth),
        (s.tolerance, s.first, s.longest, s.least),
    )  # fmt: skip
    return Pipe([Segment(*row) for row in rows], trouble, last)


Step = tuple[float, list[list[list[float]]]]  # length; by variable and power of time the coefficients of the monomials


@record
class Judgement:
    """What is known of a claim: it holds (fails) wherever it is asked; instants at which all runs meet (violate) it."""

    holds: bool
    fails: bool
    met: Pair | None
    violated: Pair | None


@record
class Jump:
    """The jump that begins a stretch: edge (as the mode lists them), instants, states before and after, the claim."""

    edge: int
    time: Pair
    before: list[Pair]
    after: list[Pair]
    claim: Judgement


@record
class Stage:
    """One step of a stretch: instants, states, watched quantities, the claim, whether the window is certainly kept.

    Where not `stays`, runs may end because of what their domain says beside comparisons that all hold.
    """

    time: Pair
    states: list[Pair]
    watched: list[Pair]
    claim: Judgement
    keeps_window: bool
    stays: bool


@record
class Stretch:
    """Flow in one mode between jumps. `parent` is the number of the stretch it comes from.

    It is certain if all the runs it encloses exist. `end` is `horizon`, `answered`, `jumped`, `left` (runs may have
    left the domain without a jump), `cut` (its set goes on in two stretches), `passed` (all states are among those from
    which runs are followed elsewhere), `jumps` (beyond the budget), or a reason.
    `last` are the states at the horizon, where they are known better than by the last step.
    """

    parent: int | None
    mode: int
    jumps: int
    is_certain: bool
    jump: Jump | None
    stages: list[Stage]
    end: str
    last: list[Pair]


@record
class Budget:
    """How many jumps a run, stretches an analysis, cuts a path may have."""

    jumps: int
    stretches: int
    cuts: int


Tree = _kernel.Tree
Where = tuple[int, list[Pair], list[tuple[int, str]]]


def halt(is_halted: bool) -> None:
    """Ask all flowpipes of this process to give up, or let them go on again."""
    _kernel.halt(is_halted)


def grown(
    modes: Sequence[ModeListing], start: Where, horizon: float, until: str, settings: Settings, budget: Budget
) -> Tree:
    """The tree of stretches that encloses all runs from a box in a mode, up to a horizon, kept in the kernel.

    `start` is a mode, a box, and comparisons of watched quantities with zero that hold there exactly. `until` is
    `horizon`, `met` or `violated`: where the following of a stretch may stop; or `passed`: where nothing depends on
    time, it also stops where runs go on as others do, and sets after jumps may be widened.

    Raises
    ------
    Fault               if the floating-point unit does not round to nearest, or the call is malformed

    Soundness           every run is in one path of the tree as long as the path goes on
    """
    s = settings
    return _kernel.reach(
        modes, start, horizon, until, (s.order, s.degree, s.steps, s.depth), (s.tolerance, s.first, s.longest, s.least),
        (budget.jumps, budget.stretches, budget.cuts),
    )  # fmt: skip


def reach(
    modes: Sequence[ModeListing], start: Where, horizon: float, until: str, settings: Settings, budget: Budget
) -> list[Stretch]:
    """The stretches of that tree, with the claim judged on them."""
    return stretches(grown(modes, start, horizon, until, settings, budget))


def stretches(tree: Tree) -> list[Stretch]:
    """The stretches of a tree, with the claim judged that it was grown for."""
    return [_stretch(*row) for row in tree.rows()]


def judged(
    tree: Tree, modes: Sequence[ModeListing], known: list[tuple[int, str]], is_middle: bool = False
) -> list[Stretch]:
    """The stretches of a tree with another claim on the same automaton; none of what is judged may refute.

    `known` are comparisons that hold exactly where runs start; in the middle, only the runs from there are looked at.

    Raises
    ------
    Fault               if the modes differ in more than their claims
    """
    return [_stretch(*row) for row in tree.judged(list(modes), known, is_middle)]


@record
class RecordedStretch:
    """The polynomials of a stretch: its parent, mode, the edge that led to it, how it ends, its steps.

    Each step has the exponents of its monomials beside its length and coefficients.
    """

    parent: int | None
    mode: int
    edge: int | None
    end: str
    steps: list[tuple[list[list[int]], Step]]


def recorded(tree: Tree) -> list[RecordedStretch]:
    """The polynomials of a tree, for a second checker."""
    return [RecordedStretch(*row) for row in tree.records()]


def units(series: list[list[list[float]]], length: float, bits: int) -> list[list[list[int]]]:
    """Polynomials in time and the set with coefficients in units of `2^-bits`, and time in units of `length`.

    By variable and power of time from the first on, without zeros at the ends.

    Raises
    ------
    Fault               if a coefficient has more than 18 digits
    """
    return _kernel.units(series, length, bits)


def _stretch(
    parent: int | None,
    mode: int,
    jumps: int,
    certain: bool,
    jump: _kernel.JumpRow | None,
    stages: list[_kernel.StepRow],
    end: str,
    last: list[Pair],
) -> Stretch:
    made = None if jump is None else Jump(jump[0], jump[1], jump[2], jump[3], Judgement(*jump[4]))
    passed = [Stage(t, x, watched, Judgement(*claim), kept, stay) for t, x, watched, claim, kept, stay in stages]
    return Stretch(parent, mode, jumps, certain, made, passed, end, last)


@record
class Fineness:
    """How finely to enclose a motion: order of the polynomials, halvings on a path, stretches of time at all."""

    order: int = 2
    depth: int = 16
    stretches: int = 20_000


def along(
    positions: Listing, readout: Listing, derivatives: int, time: Pair, widths: Sequence[float], fineness: Fineness
) -> list[tuple[float, float, list[Pair] | None]]:
    """Enclose quantities of a motion over stretches of time, which are halved until all are as narrow as `widths`.

    `positions` are functions of variable 0, the time; variable `d * n + i` of `readout` is the `d`-th derivative of the
    `i`-th of these `n`. A stretch has None where some quantity has no enclosure.
    """
    f = fineness
    return _kernel.along(positions, readout, derivatives, time, list(widths), (f.order, f.depth, f.stretches))
