"""The text of a file with its line index and its hash."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property

from haverify.text.record import field, record
from haverify.text.span import Span


@record
class Source:
    """A file as read: `path` as shown to users, decoded `text` (no BOM, `\\n` line ends), its bytes as they are."""

    path: str
    text: str
    raw: bytes = field(default=b"", repr=False)

    @classmethod
    def of_text(cls, path: str, text: str) -> Source:
        """A source that is not on disk; its hash is that of the UTF-8 text."""
        return cls(path, text, text.encode())

    @cached_property
    def sha256(self) -> str:
        """The hash of the bytes; only some commands ask for it, and its library is slow to load."""
        import hashlib

        return hashlib.sha256(self.raw).hexdigest()

    @cached_property
    def _line_starts(self) -> list[int]:
        starts = [0]
        at = self.text.find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = self.text.find("\n", at + 1)
        return starts

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of a code point, both counted from 1."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of line `number` (from 1) without its line end; empty past the last line."""
        if not 1 <= number <= len(self._line_starts):
            return ""
        start = self._line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]

    def at(self, span: Span) -> str:
        """The text of a span."""
        return self.text[span.start : span.end]
