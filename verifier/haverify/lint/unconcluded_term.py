"""HA514: terms of a fuzzy output that no rule concludes."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.spec import Spec


@rule("HA514")
def unconcluded_term(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Such a term is 0 for every input."""
    for system in spec.fuzzy:
        for output, terms in system.outputs:
            concluded = {r.term for r in system.rules if r.output == output}
            missing = [t for t in terms if t not in concluded]
            if missing:
                named = " or ".join(f"`{t}`" for t in missing)
                yield Diagnostic(
                    "HA514",
                    f"the rules of {system.name} never conclude {named} of {output}",
                    span=system.span,
                    key=f"{system.name}: no rule concludes {', '.join(missing)}",
                )
