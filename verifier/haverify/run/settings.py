"""Settings of a project: `haverify.toml`, or `[tool.haverify]` in `pyproject.toml`; the command line overrides them."""

from __future__ import annotations

import os
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

from haverify.errors import UsageError
from haverify.text.record import record

GRADES = ("checked", "enclosed", "solver")
FORMATS = ("text", "json", "sarif", "junit", "github")


@record
class Settings:
    """What a project may set; None where it does not."""

    budget: str | None = None
    jobs: int | None = None
    format: str | None = None
    report: str | None = None
    cache: bool | None = None
    lock: str | None = None
    grade: str | None = None


# without one of these a `pyproject.toml` has no table `tool.haverify`, and is not worth reading as TOML
_MAY_SET = re.compile(
    r"""tool["'\s]*\.\s*["']?haverify|^\s*\[\s*["']?tool["']?\s*\]|^\s*["']?tool["']?\s*=""", re.MULTILINE
)

_TYPES = {"jobs": int, "cache": bool}
_CHOICES = {"format": FORMATS, "grade": GRADES}


def settings(start: Path) -> Settings:
    """The settings that hold in a folder: those of the nearest file at or above it that has any.

    Raises
    ------
    UsageError      for a file that cannot be read, an unknown key or a value of another type
    """
    folder = start.resolve()
    for at in (folder, *folder.parents):
        for name in ("haverify.toml", "pyproject.toml"):
            table = _table(at / name)
            if table is not None:
                return _checked(table, os.path.relpath(at / name))
    return Settings()


def _table(path: Path) -> Any:
    try:
        if not path.is_file():
            return None
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, PermissionError):
        return None
    except (OSError, UnicodeDecodeError) as e:
        raise UsageError(f"{os.path.relpath(path)}: {e}") from e
    if path.name == "pyproject.toml" and not _MAY_SET.search(text):
        return None
    import tomllib

    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as e:
        raise UsageError(f"{os.path.relpath(path)}: {e}") from e
    if path.name == "haverify.toml":
        return content
    tool = content.get("tool")
    return tool.get("haverify") if isinstance(tool, dict) else None


def _checked(table: Any, shown: str) -> Settings:
    known = list(Settings.__annotations__)
    if not isinstance(table, dict):
        raise UsageError(f"{shown}: [tool.haverify] is no table")
    for key, value in table.items():
        if key not in known:
            raise UsageError(f"{shown}: no setting '{key}'; there are {', '.join(known)}")
        wanted = _TYPES.get(key, str)
        if type(value) is not wanted:
            raise UsageError(f"{shown}: '{key}' is {value!r}, expected {_WORDS[wanted]}")
        if key in _CHOICES and value not in _CHOICES[key]:
            raise UsageError(f"{shown}: '{key}' is '{value}'; there are {', '.join(_CHOICES[key])}")
    return Settings(**table)


_WORDS: dict[type, str] = {int: "a whole number", bool: "true or false", str: "a text in quotes"}
_SECONDS = {"ms": Fraction(1, 1000), "s": Fraction(1), "min": Fraction(60), "h": Fraction(3600)}


def duration(text: str) -> Fraction:
    """`60s`, `500 ms`, `2min`, `1h` or a plain number of seconds, in seconds.

    Raises
    ------
    UsageError      for anything else, and for 0
    """
    m = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*(ms|s|min|h)?\s*", text)
    seconds = Fraction(m[1]) * _SECONDS[m[2] or "s"] if m else Fraction(0)
    if seconds <= 0:
        raise UsageError(f"'{text}' is no duration; write for example 60s, 500ms or 2min")
    return seconds
