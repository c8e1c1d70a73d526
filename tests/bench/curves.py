"""`python -m tests.bench.curves`: what flowpipes cost as dimension, order and width of the set grow, as a table.

Dimension: a ring of states, each driven by the next and the product with the one before, in a box. Order and width:
Van der Pol's oscillator of tests/peers/nln. User CPU seconds of the analysis, median of three processes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).parents[2]
RUNS = 3
DIMENSIONS = (2, 4, 8, 12, 16, 20)
ORDERS = (4, 6, 8, 12, 16, 20)
WIDTHS = (0.125, 0.25, 0.5, 1.0)

Json = Any


def ring(n: int) -> str:
    """A spec of so many states."""
    states = "".join(f"  var x{i}\n" for i in range(n))
    inside = " and ".join(f"0.95 <= x{i} <= 1.05" for i in range(n))
    rates = "; ".join(f"x{i}' = 0.2 * x{(i + 1) % n} - x{i} + 0.1 * x{i} * x{(i - 1) % n}" for i in range(n))
    return (
        f'spec "ring" version "1.0" unitless\nautomaton Ring {{\n{states}  init Run where {inside}\n'
        f"  mode Run {{ flow {{ {rates} }} }}\n}}\nproperty p on Ring {{ within 5; always x0 <= 1.1 }}\n"
    )


def van_der_pol(order: int, share: float) -> str:
    """The benchmark problem with another order and a part of its starts."""
    text = (ROOT / "tests/peers/nln/van_der_pol.ha").read_text(encoding="utf-8")
    for low, high in (("1.25", "1.55"), ("2.35", "2.45")):
        middle, half = (float(low) + float(high)) / 2, (float(high) - float(low)) / 2 * share
        text = text.replace(f"{low} <= ", f"{middle - half:.6f} <= ").replace(f" <= {high}", f" <= {middle + half:.6f}")
    return text.replace("taylor(degree = 6, cuts = 2)", f"taylor(order = {order}, degree = 6)")


def measured(text: str) -> Json:
    """The verdict, the time, steps and boxes of a spec."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'verifier'}{os.pathsep}{ROOT}", "PYTHONDONTWRITEBYTECODE": ""}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.ha"
        path.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "tests.bench.decided", str(path)]
        found = [json.loads(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
                 for _ in range(RUNS)]  # fmt: skip
    return {**found[0], "cpu": median(f["claims"][0]["cpu"] for f in found)}


def rows() -> Iterator[tuple[str, Json]]:
    """What was changed, and what was measured."""
    for n in DIMENSIONS:
        yield f"dimension {n}", measured(ring(n))
    for order in ORDERS:
        yield f"order {order}", measured(van_der_pol(order, 0.5))
    for share in WIDTHS:
        yield f"width {share:g} of the benchmark's", measured(van_der_pol(8, share))


def main() -> None:
    """Print the table in Markdown."""
    print("| | verdict | user s | steps | boxes |\n|---|---|---|---|---|")
    for name, found in rows():
        verdict = found["claims"][0]["verdict"]
        print(f"| {name} | {verdict} | {found['cpu']:.3f} | {found['steps']} | {found['pieces']} |", flush=True)


if __name__ == "__main__":
    main()
