"""The one layout of a spec: `parse(format(t))` is `t` up to spans, and no comment is lost."""

from __future__ import annotations

import re
from bisect import bisect_left

from haverify.syntax.expressions import print_expr
from haverify.syntax.lines import Line, item_line
from haverify.syntax.tree import Tree
from haverify.syntax.wrap import wrap
from haverify.text.source import Source

__all__ = ["format", "print_expr"]

STEP = "  "
LONGEST_BLOCK = 100  # columns of a block on one line
BLANK_LINE = re.compile(r"\n[ \t\r]*\n")


def format(tree: Tree, source: Source) -> str:  # noqa: A001 - what the command is called, too
    """The text of a tree without syntax errors, in the one layout; `source` is the text it was parsed from."""
    lines = [item_line(item) for item in tree.items]
    layout = _Layout(tree, source)
    layout.block(lines, 0, len(source.text), "")
    return "\n".join(layout.out) + "\n"


class _Layout:
    """Writes lines to `out` and puts the comments where they were."""

    def __init__(self, tree: Tree, source: Source) -> None:
        self._text = source.text
        self._comments = tree.comments
        self._starts = [span.start for _, span in tree.comments]
        self.out: list[str] = []

    def block(self, lines: list[Line], start: int, end: int, indent: str) -> None:
        """The lines between two offsets, with the comments between and after them."""
        before, fresh = start, True
        for line in lines:
            before, fresh = self._loose(before, line.span.start, indent, fresh)
            self._blank(before, line.span.start, fresh)
            self._line(line, indent)
            before, fresh = line.span.end, False
        self._loose(before, end, indent, fresh)

    def _between(self, start: int, end: int) -> list[tuple[str, int, int]]:
        first, last = bisect_left(self._starts, start), bisect_left(self._starts, end)
        return [(text, span.start, span.end) for text, span in self._comments[first:last]]

    def _blank(self, before: int, start: int, fresh: bool) -> None:
        if not fresh and BLANK_LINE.search(self._text, before, start):
            self.out.append("")

    def _loose(self, before: int, end: int, indent: str, fresh: bool) -> tuple[int, bool]:
        """The comments between two lines; the first may stand behind the line above."""
        for text, start, stop in self._between(before, end):
            if not fresh and "\n" not in self._text[before:start]:
                self.out[-1] += f"  {text}"
            else:
                self._blank(before, start, fresh)
                self.out.append(indent + text)
            before, fresh = stop, False
        return before, fresh

    def _line(self, line: Line, indent: str) -> None:
        opening = self._opening(line)
        self.out += [indent + text for text, _, _ in self._between(line.span.start, opening)]
        for text in line.above:
            self.out += [indent + text] if text.startswith("///") else wrap(text, indent)
        flat = self._flat(line)
        if line.inner is None:
            self.out += wrap(line.head, indent)
        elif flat is not None and len(indent + flat) <= LONGEST_BLOCK:
            self.out.append(indent + flat)
        else:
            self.out += wrap(line.head + " {", indent)
            self.block(list(line.inner), opening, line.span.end, indent + STEP)
            self.out.append(indent + "}")

    def _opening(self, line: Line) -> int:
        """Where the block of a line begins; the end of a line without a block."""
        if line.inner is None:
            return line.span.end
        stop = line.inner[0].span.start if line.inner else line.span.end
        at = line.span.start
        for _, start, end in self._between(line.span.start, stop):
            brace = self._brace(at, start)
            if brace >= 0:
                return brace + 1
            at = end
        return self._brace(at, stop) + 1

    def _brace(self, start: int, end: int) -> int:
        return self._text.rfind("{", start, end)

    def _flat(self, line: Line) -> str | None:
        """A line with its block on one line, if its author wrote it on one line."""
        if line.inner is None:
            return line.head
        if "\n" in self._text[self._opening(line) : line.span.end]:
            return None
        inner = [self._flat(part) if not part.above else None for part in line.inner]
        texts = [text for text in inner if text is not None]
        if len(texts) < len(inner):
            return None
        return f"{line.head} {{ {line.separator.join(texts)} }}" if texts else f"{line.head} {{ }}"
