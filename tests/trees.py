"""What two trees have in common when only the layout of their texts differs."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path
from typing import Any

from haverify.syntax.parse import parse
from haverify.syntax.tree import Tree
from haverify.text.source import Source
from haverify.text.span import Span

SAMPLES = {
    path.stem: path.read_text(encoding="utf-8") for path in sorted((Path(__file__).parent / "samples").glob("*.ha"))
}


def bare(node: Any) -> Any:
    """A node without its spans, as nested tuples."""
    if isinstance(node, Span):
        return None
    if isinstance(node, tuple):
        return tuple(bare(part) for part in node)
    if dataclasses.is_dataclass(node):
        return (type(node).__name__, *(bare(getattr(node, field.name)) for field in dataclasses.fields(node)))
    return node


def comments(tree: Tree) -> Counter[str]:
    """The comments of a file, wherever they stand."""
    return Counter(text for text, _ in tree.comments)


def healthy(text: str) -> Tree:
    """The tree of a text without errors."""
    tree, findings = parse(Source.of_text("a.ha", text))
    assert [(finding.message, finding.span) for finding in findings] == []
    return tree
