"""Where the entries of a TOML file stand: the standard reader gives values without places."""

from __future__ import annotations

import re
import tomllib
from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.text.record import field, holder
from haverify.text.source import Source
from haverify.text.span import Span

Q = Fraction
_TABLE = re.compile(r"^\s*\[\[?\s*([A-Za-z0-9_.-]+)\s*\]?\]")
_ENTRY = re.compile(r"""^\s*(?:"([^"]*)"|([A-Za-z0-9_-]+))\s*=\s*(.*?)\s*$""")
_PLACE = re.compile(r"line (\d+), column (\d+)")


@holder
class Entries:
    """A TOML file: its values, with decimals read exactly, and its findings; `at` finds the place of an entry."""

    source: Source
    values: dict[str, Any] = field(default_factory=dict)
    found: list[Diagnostic] = field(default_factory=list)
    _places: dict[tuple[str, int, str], Span] = field(default_factory=dict)

    def at(self, table: str, key: str = "", number: int = 0) -> Span:
        """The line of a key of a table (the `number`-th of its name), or the nearest place above it."""
        for place in ((table, number, key), (table, number, "")):
            if place in self._places:
                return self._places[place]
        return Span(self.source.path, 0, len(self.source.line(1)))

    def wrong(self, code: str, message: str, table: str, key: str = "", number: int = 0, help: str = "") -> None:
        """Add a finding about an entry."""
        self.found.append(Diagnostic(code, message, self.at(table, key, number), help=help or None))


def read_toml(source: Source) -> Entries:
    """A TOML file, with a finding where it is none."""
    read = Entries(source)
    try:
        read.values = tomllib.loads(source.text, parse_float=_exact)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as e:
        m = _PLACE.search(str(e))
        line = int(m[1]) if m else 1
        start = _start(source.text, line)
        end = start + max(len(source.line(line)), 1)
        read.found.append(Diagnostic("HA001", f"this is no TOML: {e}", Span(source.path, start, end)))
        return read
    _locate(read)
    return read


def _exact(text: str) -> Q | float:
    """A decimal as the rational it is; `nan` and `inf` stay floats, and are no numbers to any reader here."""
    if (
        text.lstrip("+-") in ("nan", "inf")
        or len(text) > 200
        or not -400 < int(text.lower().partition("e")[2] or 0) < 400
    ):
        return float("nan")
    return Q(text.replace("_", ""))


def _start(text: str, line: int) -> int:
    at = 0
    for _ in range(line - 1):
        at = text.find("\n", at) + 1
    return at


def _locate(read: Entries) -> None:
    table, counts, at = ("", 0), dict[str, int](), 0
    for line in read.source.text.split("\n"):
        where = Span(read.source.path, at + len(line) - len(line.lstrip()), at + len(line.rstrip()))
        if m := _TABLE.match(line):
            counts[m[1]] = counts.get(m[1], -1) + 1
            table = (m[1], counts[m[1]])
            read._places[(*table, "")] = where
        elif m := _ENTRY.match(line):
            read._places[(*table, m[1] or m[2])] = where
        at += len(line) + 1
