"""HA202: a domain, guard, init or assumption that nothing satisfies."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import Formula, formulas
from haverify.lint._fuzzy import speaks_of_fuzzy
from haverify.lint._registry import rule
from haverify.lint.empty_interval import empty_bounds
from haverify.model.expression import Expr
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition


@rule("HA202")
def contradiction(_spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Conditions with backwards bounds are HA201 and not repeated here."""
    for formula in formulas(facts):
        if speaks_of_fuzzy(formula.expr):
            continue
        if formula.kind != "claim" and formula.expr.op != "true" and not any(True for _ in empty_bounds(formula)):
            core = contradiction_in(facts, formula)
            if core is not None:
                yield _finding(facts, formula, core)


def contradiction_in(facts: Facts, formula: Formula) -> tuple[Expr, ...] | None:
    """The parts of a condition that cannot hold together, None where it can hold or that is not known."""
    condition = Condition(formula.expr, formula.frame, closed=formula.kind == "domain")
    answer = facts.decide("HA202", formula.place, formula.expr.span, [condition])
    return answer.core if isinstance(answer, Contradiction) else None


def _finding(facts: Facts, formula: Formula, core: tuple[Expr, ...]) -> Diagnostic:
    texts = [f"`{facts.text(e.span)}`" for e in core if facts.text(e.span)]
    rest = tuple(Label(e.span) for e in core[:-1] if e.span)
    reason = f": {' and '.join(texts)} contradict each other" if len(texts) > 1 else ""
    return Diagnostic(
        "HA202",
        f"{formula.place} can never hold{reason}",
        span=(core[-1].span if core else None) or formula.expr.span,
        labels=rest,
        notes=("a domain is read as closed: `<` as `<=`",) if formula.kind == "domain" else (),
        key=f"{formula.place} can never hold",
    )
