"""A half-open range of a source text, in Unicode code points."""

from __future__ import annotations

from haverify.text.record import record


@record
class Span:
    """The code points `start <= k < end` of the text of one file.

    `path` is the file as the user named it (a spec or a CSV table); lines and columns are computed
    by `Source` when a message is written, never stored.
    """

    path: str
    start: int
    end: int

    def to(self, other: Span) -> Span:
        """The smallest span that holds both; the spans lie in one file."""
        return Span(self.path, min(self.start, other.start), max(self.end, other.end))
