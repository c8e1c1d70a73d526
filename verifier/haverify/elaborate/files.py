"""What a spec refers to, already read: elaboration itself opens no file."""

from __future__ import annotations

from collections.abc import Mapping

from haverify.syntax.tree import Tree
from haverify.text.record import field, record
from haverify.text.source import Source


@record
class Files:
    """Imported specs and data files by `(path of the referring spec, path as written there)`, texts by path shown.

    What could not be read is absent and was reported by the reader.
    """

    sources: Mapping[str, Source] = field(default_factory=dict)
    trees: Mapping[tuple[str, str], Tree] = field(default_factory=dict)
    data: Mapping[tuple[str, str], Source] = field(default_factory=dict)
