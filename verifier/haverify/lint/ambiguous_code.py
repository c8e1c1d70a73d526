"""HA506: one code with two names. (Two codes with one name leave an enumeration without meaning: see its reading.)"""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.spec import Spec


@rule("HA506")
def ambiguous_code(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Codes that are written, and positions where nothing is written, if something is."""
    for enum in (e for e in spec.enums if any(e.codes)):
        from haverify.elaborate.cells import codes

        named: dict[str, list[str]] = {}
        for value, bits in codes(enum).items():
            named.setdefault(bits, []).append(value)
        for bits, values in named.items():
            if len(values) > 1:
                yield Diagnostic(
                    "HA506",
                    f"{enum.name}: code {bits} has two names, {' and '.join(values)}",
                    span=enum.span,
                    notes=("cells made of this enumeration have no certain name: claims about them are not decided",),
                )
