"""What is left of a condition in one mode or at one edge (docs/core.md section 4), still as an expression."""

from __future__ import annotations

from haverify.model.expression import FALSE, TRUE, Expr, rebuild
from haverify.text.record import record


@record
class Situation:
    """An instant: dwelling in `mode`, or just after edge `edge` led from `source` to `mode`."""

    mode: str
    source: str | None = None
    edge: str | None = None

    @property
    def is_landing(self) -> bool:
        """Whether a jump has just been made."""
        return self.source is not None


def residual(e: Expr, at: Situation) -> Expr:
    """`e` with `at`, `jump`, `jumped` (and, when dwelling, `pre`) decided and truth constants folded."""
    if e.op in ("num", "var", "let", "const", "param", "true", "false"):
        return e
    if e.op == "at":
        return _truth(e.name == at.mode)
    if e.op == "jump":
        return _truth(at.is_landing and e.name == at.edge)
    if e.op == "jumped":
        return _truth(at.is_landing)
    if e.op == "pre":
        return _before(e, at)
    if e.op in ("and", "or"):
        return _junction(e, at)
    if e.op == "implies":
        return _implication(e, at)
    if e.op == "not":
        inner = residual(e.children[0], at)
        return _truth(inner.op == "false") if inner.op in ("true", "false") else Expr("not", (inner,), e.unit, e.span)
    if e.op == "if":
        return _choice(e, at)
    return rebuild(e, lambda c: residual(c, at))


def _before(e: Expr, at: Situation) -> Expr:
    (inner,) = e.children
    if not at.is_landing:
        return residual(inner, at)
    folded = residual(inner, Situation(str(at.source)))
    return folded if folded.op in ("true", "false") else Expr("pre", (folded,), e.unit, e.span)


def _junction(e: Expr, at: Situation) -> Expr:
    decisive, neutral = ("false", "true") if e.op == "and" else ("true", "false")
    kept: list[Expr] = []
    for c in e.children:
        folded = residual(c, at)
        if folded.op == decisive:
            return folded
        if folded.op != neutral:
            kept.append(folded)
    if not kept:
        return _truth(neutral == "true")
    return kept[0] if len(kept) == 1 else Expr(e.op, tuple(kept), e.unit, e.span)


def _implication(e: Expr, at: Situation) -> Expr:
    premise, conclusion = e.children
    premise = residual(premise, at)
    if premise.op == "false":
        return TRUE
    conclusion = residual(conclusion, at)
    if premise.op == "true" or conclusion.op == "true":
        return conclusion
    if conclusion.op == "false":
        return Expr("not", (premise,), e.unit, e.span)
    return Expr("implies", (premise, conclusion), e.unit, e.span)


def _choice(e: Expr, at: Situation) -> Expr:
    condition, yes, no = e.children
    condition = residual(condition, at)
    if condition.op in ("true", "false"):
        return residual(yes if condition.op == "true" else no, at)
    return Expr("if", (condition, residual(yes, at), residual(no, at)), e.unit, e.span)


def _truth(value: bool) -> Expr:
    return TRUE if value else FALSE
