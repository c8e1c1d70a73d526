"""Specs as texts, linted by all rules."""

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.lint._registry import run_lint
from haverify.syntax.parse import parse
from haverify.text.source import Source

HEADER = 'spec "Test" version "1.0"\n'


@dataclass(frozen=True)
class Linted:
    """The findings of one text, and the text."""

    source: Source
    found: list[Diagnostic]

    def of(self, code: str) -> list[Diagnostic]:
        """The findings with a code."""
        return [d for d in self.found if d.code == code]

    def at(self, code: str) -> str:
        """The text of the primary place of the only finding with a code."""
        (d,) = self.of(code)
        assert d.span is not None
        return self.source.at(d.span)

    def fixed(self, code: str) -> str:
        """The text with the fix of the only finding with a code applied."""
        (d,) = self.of(code)
        assert d.fix is not None
        text = self.source.text
        for e in sorted(d.fix.edits, key=lambda e: -e.span.start):
            text = text[: e.span.start] + e.text + text[e.span.end :]
        return text


def lint_text(text: str) -> Linted:
    """The findings of the rules about a text without errors in names, types or units."""
    source = Source.of_text("test.ha", text if text.startswith("spec ") else HEADER + text)
    tree, found = parse(source)
    assert not found, found
    spec, found = elaborate(tree, Files({source.path: source}))
    assert spec is not None
    assert not [d for d in found if d.code != "HA005"], found
    return Linted(source, run_lint(spec, {source.path: source}))


@pytest.fixture
def lint() -> Callable[[str], Linted]:
    return lint_text
