"""`haverify doctor`: versions, the kernel's rounding tested against exact numbers, the checker started."""

from __future__ import annotations

import argparse
import platform
import subprocess
from collections.abc import Callable
from fractions import Fraction
from importlib import metadata

from haverify.errors import SoundnessError, ToolError
from haverify.report.version import LANGUAGE, VERSION
from haverify.run.kept import folder


def run(_: argparse.Namespace) -> int:
    """Print what is installed and whether it works; exit code 4 when something does not."""
    print(f"haverify {VERSION}, language {LANGUAGE}, Python {platform.python_version()}, {platform.machine()}")
    for name in ("lark", "msgspec", "networkx", "z3-solver"):
        print(f"  {name} {_version(name)}")
    print(f"  cache in {folder()}")
    results = [_try("kernel rounds outwards", _rounding), _try("hacheck starts", _checker)]
    return 0 if all(results) else 4


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "is not installed"


def _try(what: str, test: Callable[[], None]) -> bool:
    try:
        test()
    except (ToolError, SoundnessError) as e:
        print(f"  {what}: NO: {e}")
        return False
    print(f"  {what}: yes")
    return True


def _rounding() -> None:
    """Sums, products and quotients of thirds, tenths and large numbers lie strictly inside their enclosures."""
    from haverify.maths.interval import Interval

    for a, b in (
        (Fraction(1, 3), Fraction(1, 10)),
        (Fraction(10) ** 30 + 1, Fraction(1, 7)),
        (Fraction(-2, 3), Fraction(9)),
    ):
        x, y = Interval.at(a), Interval.at(b)
        for name, got, exact in (("+", x + y, a + b), ("-", x - y, a - b), ("*", x * y, a * b), ("/", x / y, a / b)):
            low, high = got.exactly()
            if not low <= exact <= high:
                raise SoundnessError(f"{a} {name} {b} lies outside its enclosure")


def _checker() -> None:
    from haverify.run.recheck import command

    done = subprocess.run(command(None), capture_output=True, check=False)
    if b"usage" not in done.stderr:
        raise ToolError(f"hacheck does not answer (exit code {done.returncode})")
