"""Lint rules: found by folder, run in order, one message per cause."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.model.spec import Spec
from haverify.text.record import replace
from haverify.text.source import Source
from haverify.text.span import Span

Rule = Callable[[Spec, Facts], Iterable[Diagnostic]]

_RULES: dict[str, Rule] = {}

_NAMED = 3  # followers of a finding that are named in its note


def rule(code: str) -> Callable[[Rule], Rule]:
    """Register a function as the rule for `code`. A rule reads a spec and yields findings; it changes nothing."""

    def register(function: Rule) -> Rule:
        _RULES[code] = function
        return function

    return register


@cache
def rules() -> Mapping[str, Rule]:
    """All rules by code: every module of this folder whose name has no underscore in front is imported."""
    for file in sorted(os.listdir(os.path.dirname(__file__))):
        if file.endswith(".py") and not file.startswith("_"):
            import_module(f"haverify.lint.{file[:-3]}")
    return dict(sorted(_RULES.items()))


def run_lint(spec: Spec, sources: Mapping[str, Source]) -> list[Diagnostic]:
    """The findings of all rules: in order of code, then of place; those of one place and code merged into one.

    `sources` are the texts that spans refer to, by path; they serve the wording and the fixes only.
    """
    facts = Facts(spec, sources)
    found = [d for code, check in rules().items() for d in _checked(code, check, spec, facts)]
    return sorted(_merged([*found, *facts.undecided]), key=_place)


def _checked(code: str, check: Rule, spec: Spec, facts: Facts) -> list[Diagnostic]:
    try:
        return list(check(spec, facts))
    except RecursionError:
        return [Diagnostic("HA900", f"{code}: an expression is nested too deeply for this check")]


def _place(d: Diagnostic) -> tuple[str, str, int, int, str]:
    at = d.span or Span("", -1, -1)
    return (d.code, at.path, at.start, at.end, d.message)


def _merged(found: Iterable[Diagnostic]) -> Iterator[Diagnostic]:
    """One finding for each code and place: copies of one text (a family, a copied automaton) share a cause."""
    groups: dict[object, list[Diagnostic]] = {}
    for d in found:
        groups.setdefault((d.code, d.span) if d.span else (d.code, d.message), []).append(d)
    for first, *rest in groups.values():
        others = list(dict.fromkeys(d.key or d.message for d in rest if d.message != first.message))
        yield replace(first, notes=(*first.notes, _also(others))) if others else first


def _also(messages: list[str]) -> str:
    """The short forms of the findings merged into another."""
    named = "; ".join(messages[:_NAMED])
    more = len(messages) - _NAMED
    return f"also: {named}" + (f"; and {more} more" if more > 0 else "")
