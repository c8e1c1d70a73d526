"""How the conditions of an automaton with flows are read in a mode: what has to be defined, closed sets, `abs`."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.model.expression import FALSE, TRUE, Expr, nodes
from haverify.obligations.parts import NEGATED
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError, Scope
from haverify.text.record import record

Q = Fraction
CLOSED = {"<": "<=", ">": ">="}


@record
class Reading:
    """How conditions are read in a mode: negations inside of comparisons, these closed perhaps, truths unfolded."""

    mode: str
    scope: Scope
    is_closed: bool
    is_told: bool

    def inward(self, e: Expr, is_denied: bool = False) -> Expr:
        """The condition, or its negation, as the checker reads it."""
        if e.op == "not":
            return self.inward(e.children[0], not is_denied)
        if e.op == "implies":
            premise, conclusion = e.children
            return self.inward(Expr("or", (Expr("not", (premise,)), conclusion)), is_denied)
        if e.op in ("and", "or"):
            op = e.op if not is_denied else "or" if e.op == "and" else "and"
            return Expr(op, tuple(self.inward(c, is_denied) for c in e.children))
        if e.op == "let" and e.name in self.scope.lets:
            return self.inward(residual(self.scope.lets[e.name][1], Situation(self.mode)), is_denied)
        if e.op in ("true", "false"):
            return e if not is_denied else FALSE if e.op == "true" else TRUE
        if e.op not in NEGATED or self.scope.is_truth(e.children[0]):
            raise OutsideFragmentError(f"`{e.op}` as a truth value in a claim about a flow")
        op = NEGATED[e.op] if is_denied else e.op
        if self.is_closed:
            op = CLOSED.get(op, op)
        if self.is_closed and op == "!=":
            return TRUE
        held = self.spread(op, *e.children)
        defined = () if self.is_told else tuple(self.defined(e, set()))
        return Expr("and", (held, *defined)) if defined else held

    def defined(self, e: Expr, seen: set[str]) -> Iterator[Expr]:
        """The roots and logarithms that an expression reads are defined."""
        for n in nodes(e):
            if n.op in ("sqrt", "log"):
                yield Expr(">=" if n.op == "sqrt" else ">", (n.children[0], Expr("num", (Q(0),))))
            elif n.op == "let" and n.name in self.scope.lets and n.name not in seen:
                seen.add(n.name)
                yield from self.defined(self.scope.lets[n.name][1], seen)

    def spread(self, op: str, a: Expr, b: Expr) -> Expr:
        """A comparison, absolute values on its sides taken for the greater of two numbers."""
        low, high = (b, a) if op[0] == ">" else (a, b)
        if op in ("==", "!=") or "abs" not in (a.op, b.op):
            return Expr(op, (a, b))
        if any(e.op == "abs" and len(self.scope.cases(e.children[0])) > 1 for e in (a, b)):
            raise OutsideFragmentError("`abs` of what has cases of its own, in a claim about a flow")
        op = op.replace(">", "<")
        rows = [[Expr(op, (x, y)) for y in _either(high)] for x in _either(low)]
        alternatives = [row[0] if len(row) == 1 else Expr("or", tuple(row)) for row in rows]
        return alternatives[0] if len(rows) == 1 else Expr("and", tuple(alternatives))


def _either(e: Expr) -> tuple[Expr, ...]:
    return (e.children[0], Expr("neg", (e.children[0],))) if e.op == "abs" else (e,)
