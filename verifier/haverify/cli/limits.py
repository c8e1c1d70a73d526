"""What options may be: a number within limits, a drawing that is SVG."""

from __future__ import annotations

from haverify.errors import UsageError

LAST_SEED = 2**31 - 1  # with what is added to it for further runs, what every generator takes


def within(option: str, value: float, least: int, most: int) -> None:
    """Refuse a number outside of its limits.

    Raises
    ------
    UsageError      that says the limits
    """
    if not least <= value <= most:
        raise UsageError(f"{option} {value}: a number from {least} to {most}")


def require_svg(path: str) -> None:
    """Refuse a name under which a drawing would be taken for another format.

    Raises
    ------
    UsageError      that says what is drawn
    """
    if not path.lower().endswith(".svg"):
        raise UsageError(f"{path}: drawings are SVG: --plot PATH.svg")
