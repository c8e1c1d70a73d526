"""`hacheck` as a child process: once for a report folder, with nothing of haverify in it."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from haverify.errors import ToolError
from haverify.evidence.grant import Answer

_START = "import sys; sys.path.insert(0, sys.argv.pop(1)); from hacheck.__main__ import main; sys.exit(main())"


def command(folder: Path | None, *options: str) -> list[str]:
    """The call of the checker: isolated, without site packages, so it starts fast and reads nothing else."""
    spec = find_spec("hacheck")
    if spec is None or spec.origin is None:
        raise ToolError("the checker `hacheck` is not installed beside haverify: install the whole wheel")
    place = str(Path(spec.origin).parents[1])
    return [sys.executable, "-I", "-S", "-c", _START, place, *([str(folder)] if folder else []), *options]


def ask(folder: Path, base: Path) -> dict[str, Answer]:
    """What `hacheck` answers for each certificate in a folder, by claim; tables are found from `base`.

    Raises
    ------
    ToolError       if the checker cannot be run or its answer cannot be read
    """
    done = subprocess.run(
        command(folder, "--json", "--no-report", "--inputs", str(base)), capture_output=True, check=False
    )
    try:
        said = json.loads(done.stdout)
        if said["inputs"]["outcome"] != "accepted":
            refused = Answer("refused", str(said["inputs"]["reason"]))
            return dict.fromkeys(said["claims"], refused)
        return {name: _answer(entry) for name, entry in said["claims"].items() if entry["outcome"] != "absent"}
    except (ValueError, KeyError, TypeError, AttributeError) as e:
        last = [str(e), *done.stderr.decode(errors="replace").strip().splitlines()][-1]
        raise ToolError(f"hacheck gave no answer (exit code {done.returncode}): {last}") from e


def _answer(entry: Any) -> Answer:
    word = entry["outcome"]
    if word not in ("accepted", "refused", "beyond"):
        raise ValueError(f"no such answer: {word!r}")
    return Answer(word, str(entry.get("reason") or ""))
