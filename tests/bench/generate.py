"""A large spec: many modes on one clock, many outputs, coefficients in a CSV table, a range claim for each pair."""

from __future__ import annotations

import sys
from pathlib import Path

MODES, OUTPUTS = 200, 50


def generate(folder: Path, modes: int = MODES, outputs: int = OUTPUTS, as_family: bool = True) -> Path:
    """Write `large.ha` and its tables; all claims are true.

    With `as_family`, one property per output speaks of all modes; else there is a property for each mode and output.
    """
    names = [f"M{k}" for k in range(modes)]
    for j in range(outputs):
        rows = [f"M{k},{_coefficients(k, j)}" for k in range(modes)]
        (folder / f"t{j}.csv").write_text("\n".join(["phase,p1,p2,p3", *rows]) + "\n", encoding="utf-8")
    lines = ['spec "Large" version "1.0"', f"enum Phase {{ {', '.join(names)} }}"]
    for j in range(outputs):
        lines.append(f'table T{j} from "t{j}.csv" {{ key phase: Phase; poly p1..p3 descending in x: s -> deg }}')
    path = folder / ("large.ha" if as_family else "large_each.ha")
    path.write_text("\n".join([*lines, *_automaton(names, outputs), *_claims(names, outputs, as_family)]) + "\n")
    return path


def _coefficients(k: int, j: int) -> str:
    """A parabola with its vertex in the middle of slot k: its values there lie in 0 .. 1 deg."""
    middle = (2 * k + 1) / 200
    bend = 100 + j
    return f"{bend},{-2 * bend * middle:.6f},{bend * middle * middle + 0.5:.6f}"


def _automaton(names: list[str], outputs: int) -> list[str]:
    slots = [f"    {name} until {k + 1}0 ms" for k, name in enumerate(names[:-1])]
    last = f"    {names[-1]} until {len(names)}0 ms then {names[0]} do x := 0 s"
    return [
        "automaton Large {",
        f"  var x: s in [0 s, {len(names)}0 ms]",
        *(f"  let y{j}: deg = T{j}[phase](x)" for j in range(outputs)),
        f"  init {names[0]} with x := 0 s",
        "  mode Run for phase in Phase { flow { x' = 1 } }",
        "  schedule on x from 0 s {",
        *slots,
        last,
        "  }",
        "}",
    ]


def _claims(names: list[str], outputs: int, as_family: bool) -> list[str]:
    if as_family:
        return [f"property r{j} on Large {{ always 0 deg <= y{j} <= 1 deg; expect proved }}" for j in range(outputs)]
    return [
        f"property r{j}_{name} on Large {{ always at({name}) implies 0 deg <= y{j} <= 1 deg; expect proved }}"
        for j in range(outputs)
        for name in names
    ]


if __name__ == "__main__":
    print(generate(Path(sys.argv[1]), as_family=len(sys.argv) < 3))
