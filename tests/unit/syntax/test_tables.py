"""The committed tables are those of the grammar, and every rule of it can be built."""

import json

import pytest

from haverify.syntax import tables
from haverify.syntax.build import Builder
from haverify.syntax.language import language


def test_the_committed_tables_are_those_of_the_grammar() -> None:
    assert json.loads(tables.TABLES.read_text(encoding="utf-8")) == tables.generate()


def test_every_rule_has_a_builder() -> None:
    builder = Builder("a.ha", language())
    count = len(json.loads(tables.TABLES.read_text(encoding="utf-8"))["rules"])
    rules = [language().rules[-1 - place] for place in range(count)]
    needed = {rule.callback for rule in rules if not rule.spliced and not rule.passes}
    inlined = {"decl", "abody", "mbody", "sbody", "pline", "goal", "qname", "path", "state", "atom", "postfix", "expr"}
    assert sorted(name for name in needed - inlined if not hasattr(builder, name)) == []


def test_an_ambiguous_grammar_is_refused() -> None:
    with pytest.raises(ValueError, match=r"[Cc]onflict"):
        tables._compiled('start: "if" start | "if" start "else" start | "x"')
