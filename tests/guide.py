"""The chapters of the guide as a reader uses them: their files written, their specs checked, their commands run."""

from __future__ import annotations

import re
import shlex
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from haverify.evidence.verdict import Trust
from haverify.run.pipeline import Options, Outcome, check

DOCS = Path(__file__).parents[1] / "docs"
_BLOCK = re.compile(r"^```(\w+)(?: +(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_GAP = "[...]"


class Block(NamedTuple):
    """A fenced block: its kind, the file name after it if there is one, its text."""

    kind: str
    name: str
    text: str


class Command(NamedTuple):
    """A line after `$ ` of a `console` block, in words, and the lines printed below it."""

    words: list[str]
    printed: str


def blocks(chapter: str) -> list[Block]:
    """The fenced blocks of a chapter of `docs`, in order."""
    return [Block(*found) for found in _BLOCK.findall((DOCS / chapter).read_text(encoding="utf-8"))]


def specs(chapter: str) -> list[str]:
    """Its specs."""
    return [b.text for b in blocks(chapter) if b.kind == "ha"]


def commands(text: str) -> list[Command]:
    """The commands of a `console` block."""
    parts = re.split(r"^\$ (.*)\n", text, flags=re.MULTILINE)[1:]
    return [Command(shlex.split(line), out) for line, out in zip(parts[::2], parts[1::2], strict=True)]


def written(chapter: str, folder: Path) -> None:
    """All blocks that name a file, as files of a folder."""
    for block in blocks(chapter):
        if block.name:
            (folder / block.name).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.name).write_text(block.text, encoding="utf-8")


def agrees(shown: str, printed: str) -> bool:
    """Is it what was printed? `[...]` stands for anything, and spaces at the ends of lines for nothing."""
    pieces = [re.escape(p) for p in _tidied(shown).split(_GAP)]
    return re.fullmatch(".*".join(pieces), _tidied(printed), re.DOTALL) is not None


def _tidied(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def decided(spec: str, folder: Path) -> Outcome:
    """What `haverify check` comes to for a spec."""
    path = folder / "page.ha"
    path.write_text(spec, encoding="utf-8")
    return check(str(path), Options(None, Fraction(60), 1, None, False, None, Trust.ENCLOSED))
