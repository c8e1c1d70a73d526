"""HA503: a rule that is written twice."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.cellular import Rule
from haverify.model.spec import Spec


@rule("HA503")
def repeated_rule(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """One finding for each repetition; of a relation, for each pair that is listed again."""
    for automaton in spec.cellular:
        seen: dict[tuple[str, str], Rule] = {}
        for line in automaton.rules:
            first = seen.setdefault((line.left, line.right), line)
            if first is not line:
                yield _finding(automaton.name, f"rule 0b{line.left} -> 0b{line.right}", line, first)
    for relation in spec.relations:
        listed: dict[tuple[str, str], Rule] = {}
        for pair, span in zip(relation.pairs, relation.spans, strict=True):
            line = Rule(*pair, span)
            first = listed.setdefault(pair, line)
            if first is not line:
                yield _finding(relation.name, f"pair {pair[0]} -> {pair[1]}", line, first)


def _finding(name: str, what: str, line: Rule, first: Rule) -> Diagnostic:
    fix = Fix("remove the repetition", (Edit(line.span, ""),), safe=True) if line.span else None
    labels = (Label(first.span, "first written here"),) if first.span else ()
    return Diagnostic("HA503", f"{name}: {what} is repeated", span=line.span, labels=labels, fix=fix)
