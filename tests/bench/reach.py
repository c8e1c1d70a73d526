"""`python -m tests.bench.reach [NAME...]`: reachability problems of tests/peers/nln, beside what peers needed.

The time is user CPU of the analysis calls for all claims of the spec, median of five processes. A problem that is not
decided is printed as it is: `unknown`, and no factor.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from math import prod
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests" / "peers" / "nln"
RUNS = 5
LIMIT_S = 120  # of one process: what takes longer is reported as not finished

Json = Any


def measured(spec: str) -> list[Json]:
    """What `tests.bench.decided` says, in processes of its own; less often where it takes long."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'verifier'}{os.pathsep}{ROOT}", "PYTHONDONTWRITEBYTECODE": ""}
    command = [sys.executable, "-m", "tests.bench.decided", str(FOLDER / spec)]
    found: list[Json] = []
    while len(found) < RUNS and sum(_total(f) for f in found) < LIMIT_S / 5:
        try:
            done = subprocess.run(command, env=environment, capture_output=True, check=True, timeout=LIMIT_S)
        except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
            return found
        found.append(json.loads(done.stdout))
    return found


def _total(found: Json) -> float:
    return sum(float(c["cpu"]) for c in found["claims"])


def figures(measures: Sequence[str], last: Json) -> list[float] | None:
    """The figures of a problem from the box at the end, or those of its jumps; None where there is none."""
    if last is None or not measures:
        return None
    widths = {name: high - low for name, (low, high) in last.items()}
    volume = 1.0
    for width in widths.values():
        volume *= width

    def width(name: str) -> float | None:
        """The width of a state, or the sum or product of those of two or more."""
        if "*" in name:
            return prod(widths[n] for n in name.split("*"))
        return sum(widths[n] for n in name.split("+")) if "+" in name else widths.get(name)

    found = [volume if m == "volume" else width(m.split(" ", 1)[1]) for m in measures]
    return [f for f in found if f is not None] if None not in found else None


def shown(values: Sequence[float] | None) -> str:
    """Figures in three digits."""
    return "-" if values is None else " / ".join(f"{v:.3g}" for v in values)


def compared(peer: Json, cpu: float, own: Sequence[float] | None, is_decided: bool) -> str:
    """How much faster than a peer, and whether no wider."""
    if not is_decided:
        return "-"
    factor = f"{peer['cpu_s'] / cpu:.3g} x"
    if not peer["figures"] or own is None:
        return factor
    is_wider = any(o > p * 1.005 for o, p in zip(own, peer["figures"], strict=True))  # peers' figures are rounded
    return f"{factor}, {'wider' if is_wider else 'no wider'}"


def report(instance: Json) -> None:
    """The lines of one problem: own, then those of the peers."""
    name, found = instance["spec"].removesuffix(".ha"), measured(instance["spec"])
    if not found:
        line(name, "haverify", "-", f"failed, or > {LIMIT_S} s")
    else:
        _own(name, instance, found)
    is_decided = bool(found) and all(c["verdict"] != "unknown" for c in found[0]["claims"])
    cpu = median(map(_total, found)) if found else 0.0
    own = figures(instance["measures"], found[0]["last"]) if found else None
    for peer in instance["peers"]:
        verdict = {True: "proved", False: "not proved", None: "end only"}[peer["proves"]]
        factor = compared(peer, cpu, own, is_decided)
        line("", peer["tool"], f"{peer['cpu_s']:g}", verdict, shown(peer["figures"]), "", "", factor)


def _own(name: str, instance: Json, found: list[Json]) -> None:
    one = found[0]
    verdicts = [c["verdict"] for c in one["claims"]]
    said = ", ".join(f"{verdicts.count(w)} {w}" for w in dict.fromkeys(verdicts))
    wide = shown(figures(instance["measures"], one["last"]))
    work = f"{one['steps']} steps, {one['pieces']} boxes" if one["steps"] else ""
    start, peak = median(f["start"] for f in found), max(f["peak_mb"] for f in found)
    line(name, "haverify", f"{median(map(_total, found)):.3f}", said, wide, f"{start:.2f}", f"{peak:.0f}", work)
    for c in one["claims"] if len(one["claims"]) > 1 else []:
        each = median(next(x["cpu"] for x in f["claims"] if x["name"] == c["name"]) for f in found)
        line("", f"  {c['name']}", f"{each:.3f}", c["verdict"])
    if instance["floor"]:
        line("", "  sampled runs", "", "", shown(instance["floor"]))


def line(*cells: str) -> None:
    """One line of the table: problem, tool, time, verdict, figures at the end, start-up, memory, remarks."""
    name, tool, cpu, verdict, wide, start, peak, more = (*cells, *[""] * (8 - len(cells)))
    print(f"{name:<24} {tool:<25} {cpu:>8}  {verdict:<20} {wide:<16} {start:>5} {peak:>5}  {more}".rstrip(), flush=True)


def main() -> None:
    """Print the table; with names as arguments, of these specs alone."""
    instances = json.loads((FOLDER / "peers.json").read_text(encoding="utf-8"))["instances"]
    wanted = sys.argv[1:]
    line("problem", "tool", "user s", "verdict", "at the end", "start", "MB", "work; how much faster than a peer")
    for instance in instances:
        if not wanted or instance["spec"].removesuffix(".ha") in wanted:
            report(instance)


if __name__ == "__main__":
    main()
