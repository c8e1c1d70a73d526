"""Claims as formulas over runs for the simulator: time and truth over quantities that hold where positive."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes, number, operands
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import values_of
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.approximate import approximate
from haverify.simulate.model import Landing, Observation
from haverify.solvers.runs import FormulaWords
from haverify.text.record import field, holder, record

Seconds = Callable[[Expr], Fraction]

TEMPORAL = frozenset({"globally", "eventually", "until"})
BEYOND = number(Fraction(10) ** 300)  # of a truth value: how far it is from its opposite
FAR = number(Fraction(10) ** 9)  # s, beyond every run


@record
class AskedOfRuns:
    """A goal as the kernel judges it, how far it looks (s), how many jumps, and what runs have to observe.

    `assumed` says of a run that it keeps the assumptions; none if there are none.
    """

    words: FormulaWords
    assumed: FormulaWords
    horizon: float
    jumps: int | None
    observed: tuple[Observation, ...]
    landings: tuple[Landing, ...]


def asked_of_runs(spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, until: float) -> AskedOfRuns:
    """What a goal asks of each run; `until` (s) is the horizon of a goal that states none.

    Raises
    ------
    OutsideFragmentError    if it asks something else than `always`, `reach` or `stl` do
    """
    values = values_of(spec, automaton)

    def seconds(e: Expr) -> Fraction:
        return approximate(values, e)

    if goal.kind == "stl":
        whole = goal.condition
    elif goal.kind in ("always", "reach"):
        ends = [seconds(e) for e in (claim.time, goal.within) if e is not None]
        first = Fraction(0)
        if goal.window is not None:
            first = seconds(goal.window[0])
            ends.append(seconds(goal.window[1]))
        last = min(ends, default=Fraction(until))
        word = "globally" if goal.kind == "always" else "eventually"
        whole = Expr(word, (number(first), number(last), goal.condition))
    else:
        raise OutsideFragmentError(f"`{goal.kind.replace('_', ' ')}` is not refuted by one run")
    taken = _Taken(automaton, seconds)
    kept = tuple(Expr("globally", (number(0), FAR, a)) for a in (*spec.assumptions, *claim.assume))
    assumed = taken.formula(Expr("and", kept)) if kept else []
    words = taken.formula(Expr("or", (*(Expr("not", (k,)) for k in kept), whole)) if kept else whole)
    observed = tuple(Observation(tuple(taken.at_stay(a, m.name) for a in taken.atoms)) for m in automaton.modes)
    landings = tuple(taken.landings()) if any(n.op in ("jump", "jumped") for a in taken.atoms for n in nodes(a)) else ()
    return AskedOfRuns(words, assumed, float(horizon_of(whole, seconds)), claim.jumps, observed, landings)


def horizon_of(e: Expr, seconds: Seconds) -> Fraction:
    """How long after the start a formula still looks (s)."""
    if e.op in TEMPORAL:
        return Fraction(seconds(e.children[1])) + max(horizon_of(c, seconds) for c in e.children[2:])
    return max((horizon_of(c, seconds) for c in operands(e)), default=Fraction(0))


@holder
class _Taken:
    """A formula being taken apart into comparisons and truths of instants."""

    automaton: HybridAutomaton
    seconds: Seconds
    atoms: list[Expr] = field(default_factory=list)

    def formula(self, e: Expr) -> FormulaWords:
        if e.op in TEMPORAL:
            return self._temporal(e)
        if e.op in ("and", "or"):
            return [(e.op, len(e.children), 0.0, 0.0), *(w for c in e.children for w in self.formula(c))]
        if e.op == "not":
            return [("not", 1, 0.0, 0.0), *self.formula(e.children[0])]
        if e.op == "implies":
            premise, conclusion = e.children
            return [("or", 2, 0.0, 0.0), ("not", 1, 0.0, 0.0), *self.formula(premise), *self.formula(conclusion)]
        if any(n.op in TEMPORAL for n in nodes(e)):
            raise OutsideFragmentError(f"`{e.op}` around a temporal operator")
        if e not in self.atoms:
            self.atoms.append(e)
        return [("atom", self.atoms.index(e), 0.0, 0.0)]

    def _temporal(self, e: Expr) -> FormulaWords:
        if any(n.op == "until" for c in e.children[2:] for n in nodes(c)):
            raise OutsideFragmentError("`until` inside another temporal operator")
        low, high = (float(self.seconds(c)) for c in e.children[:2])
        if low < 0 or high < low:
            raise OutsideFragmentError(f"the window [{low} s, {high} s] of `{e.op}` has no instant, or looks back")
        return [(e.op, len(e.children) - 2, low, high), *(w for c in e.children[2:] for w in self.formula(c))]

    def at_stay(self, atom: Expr, mode: str) -> Expr:
        """The quantity of an atom while a run stays in a mode."""
        return margin(residual(atom, Situation(mode)))

    def landings(self) -> list[Landing]:
        """The quantities right after each edge."""
        found = []
        for e in self.automaton.edges:
            at = Situation(e.target, e.source, e.name)
            found.append(Landing(tuple(margin(residual(a, at)) for a in self.atoms)))
        return found


def margin(e: Expr) -> Expr:
    """The quantity that is positive where a condition of an instant holds, and says by how much."""
    if e.op in ("true", "false"):
        return BEYOND if e.op == "true" else Expr("neg", (BEYOND,))
    if e.op == "not":
        return Expr("neg", (margin(e.children[0]),))
    if e.op in ("and", "or"):
        return Expr("min" if e.op == "and" else "max", tuple(margin(c) for c in e.children))
    if e.op == "implies":
        premise, conclusion = (margin(c) for c in e.children)
        return Expr("max", (Expr("neg", (premise,)), conclusion))
    if e.op in ("<", "<=", ">", ">="):
        left, right = e.children
        return Expr("-", (right, left) if e.op in ("<", "<=") else (left, right))
    if e.op in ("==", "!="):
        distance = Expr("abs", (Expr("-", e.children),))
        return distance if e.op == "!=" else Expr("neg", (distance,))
    if e.op in ("var", "let", "const", "if"):
        return Expr("if", (e, BEYOND, Expr("neg", (BEYOND,))))
    raise OutsideFragmentError(f"`{e.op}` in a formula over simulated runs")
