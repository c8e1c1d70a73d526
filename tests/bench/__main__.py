"""`python -m tests.bench`: user + system CPU seconds of haverify and its children, and peak memory, as a table."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from tests.bench.generate import generate

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Cost:
    """What one call took."""

    cpu: float
    peak_mb: float
    code: int


def call(*arguments: str, cache: Path) -> Cost:
    """Run haverify once, in a process of its own so that the memory measured is that call's."""
    environment = {**os.environ, "HAVERIFY_CACHE": str(cache), "PYTHONPATH": f"{ROOT / 'verifier'}{os.pathsep}{ROOT}"}
    environment |= {"PYTHONPYCACHEPREFIX": str(cache / "bytecode"), "PYTHONDONTWRITEBYTECODE": ""}  # as when installed
    measured = [sys.executable, "-m", "tests.bench.measured", sys.executable, "-m", "haverify", *arguments]
    done = subprocess.run(measured, env=environment, cwd=ROOT, capture_output=True, text=True, check=False)
    cpu, peak, code = done.stdout.splitlines()[-1].split()
    return Cost(float(cpu), float(peak), int(code))


def report(what: str, costs: list[Cost], limit: float | None) -> None:
    cpu = median(c.cpu for c in costs)
    peak = max(c.peak_mb for c in costs)
    verdict = "" if limit is None else "within" if cpu < limit else "OVER"
    bound = "" if limit is None else f"{limit:g} s"
    print(f"{what:<46} {cpu:8.3f} s {bound:>7} {verdict:<7} {peak:7.1f} MB   exit {costs[0].code}", flush=True)


def short(work: Path) -> None:
    """The calls an author waits for: median of five, of what `KEPT` says."""
    cache, out = work / "cache", str(work / "report")
    call("check", "spec/gait.ha", "--report", out, cache=cache)  # bytecode is written once
    report("--help", [call("--help", cache=cache) for _ in range(5)], 0.1)
    for spec in sorted((ROOT / "spec").glob("*.ha")):
        name = f"spec/{spec.name}"
        report(f"lint {name}, anew", [call("lint", name, "--no-cache", cache=cache) for _ in range(5)], 0.3)
        call("lint", name, cache=cache)
        report(f"lint {name}, seen before", [call("lint", name, cache=cache) for _ in range(5)], 0.3)
    for spec in sorted((ROOT / "spec").glob("gait*.ha")):
        name = f"spec/{spec.name}"
        cold = [call("check", name, "--no-cache", "--report", out, cache=cache) for _ in range(5)]
        report(f"check {name}, cold", cold, 2)
        call("check", name, "--report", out, cache=cache)
        report(f"check {name}, warm", [call("check", name, "--report", out, cache=cache) for _ in range(5)], 0.5)


def large(work: Path) -> None:
    """200 modes x 50 outputs: 10,000 ranges, as 50 claims and as 10,000."""
    for as_family, what in ((True, "50 claims"), (False, "10,000 claims")):
        folder = work / what.replace(",", "").replace(" ", "-")
        folder.mkdir()
        path = str(generate(folder, as_family=as_family))
        report(f"200 modes x 50 outputs, {what}, lint", [call("lint", path, "--no-cache", cache=work / "cache")], None)
        arguments = ("check", path, "--no-cache", "--report", str(folder / "report"))
        report(f"200 modes x 50 outputs, {what}", [call(*arguments, cache=work / "cache")], 60)


KEPT = """\
cold, anew    without any cache
seen before   the rules' findings are kept from an earlier run; the spec is read and given its meaning again
warm          so are certificates and the page; hacheck checks every certificate again"""


def main() -> None:
    """Print the table; `short` or `large` as argument prints a half of it."""
    work = Path(tempfile.mkdtemp(prefix="haverify-bench-"))
    what = sys.argv[1:] or ["short", "large"]
    print(f"{'call':<46} {'user+sys':>10} {'limit':>7} {'':<7} {'peak':>10}")
    try:
        for name in what:
            {"short": short, "large": large}[name](work)
        print(KEPT)
    finally:
        shutil.rmtree(work, ignore_errors=True)


if __name__ == "__main__":
    main()
