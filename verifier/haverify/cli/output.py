"""Texts to standard output: colours only for a terminal that wants them."""

from __future__ import annotations

import os
import sys


def wants_colour() -> bool:
    """Whether standard output is a terminal and NO_COLOR is not set."""
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def put(text: str) -> None:
    """Print a text that brings its own line ends; what the terminal's encoding lacks is written as escapes."""
    encoding = sys.stdout.encoding or "utf-8"
    sys.stdout.write(text.encode(encoding, "backslashreplace").decode(encoding))


def codes(text: str | None) -> tuple[str, ...]:
    """The prefixes in `HA2,HA303`."""
    return tuple(part.strip().upper() for part in (text or "").split(",") if part.strip())
