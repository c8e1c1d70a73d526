"""Specs as texts: elaborated without a file, with the findings and the places they point at."""

from __future__ import annotations

from collections.abc import Mapping

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.model.spec import Spec
from haverify.syntax.parse import parse
from haverify.text.source import Source

HEAD = 'spec "t" version "1.0"\n'


def read(text: str, data: Mapping[str, str] | None = None) -> tuple[Spec, list[Diagnostic], dict[str, Source]]:
    """The model of a text (without its first line) and what is found about it; `data` are its data files."""
    if not text.startswith("spec "):
        text = HEAD + text
    sources = {"a.ha": Source.of_text("a.ha", text)}
    tables = {}
    for name, content in (data or {}).items():
        sources[name] = tables["a.ha", name] = Source.of_text(name, content)
    tree, syntax = parse(sources["a.ha"])
    assert syntax == []
    spec, found = elaborate(tree, Files(sources, {}, tables))
    assert spec is not None
    return spec, found, sources


def healthy(text: str, data: Mapping[str, str] | None = None) -> Spec:
    """The model of a text about which nothing is found but what is never read."""
    spec, found, _ = read(text, data)
    assert [(d.code, d.message) for d in found if d.code != "HA005"] == []
    return spec


def marked(text: str, data: Mapping[str, str] | None = None) -> tuple[str, list[tuple[str, str]]]:
    """What the text has between « and », and (code, text pointed at) of each finding on the text without the marks."""
    start, end = text.index("«"), text.index("»")
    inside = text[start + 1 : end]
    _, found, sources = read(text.replace("«", "").replace("»", ""), data)
    return inside, [(d.code, sources[d.span.path].at(d.span)) for d in found if d.span is not None]
