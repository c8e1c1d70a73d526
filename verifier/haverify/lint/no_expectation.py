"""HA607: a claim that does not say which verdict it expects."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.spec import Spec


@rule("HA607")
def no_expectation(spec: Spec, _facts: Facts) -> Iterator[Diagnostic]:
    """Without `expect` a claim must be proved; with it a change of the verdict in either direction is noticed."""
    for claim in spec.claims:
        if claim.expect is None:
            yield Diagnostic(
                "HA607",
                f"{claim.kind} {claim.name} has no `expect`",
                span=claim.span,
                help="add the verdict it should have: `expect proved`, `expect refuted` or `expect unknown`",
                key=f"{claim.name} has no expect",
            )
