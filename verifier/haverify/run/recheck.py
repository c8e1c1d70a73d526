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


def ask(folder: Path) -> dict[str, Answer]:
    """What `hacheck` answers for each certificate in a folder, by claim.

    Raises
    ------
    ToolError       if the checker cannot be run or its answer cannot be read
    """
    done = subprocess.run(command(folder, "--json", "--no-report"), capture_output=True, check=False)
    try:
        return {entry["claim"]: _answer(entry) for entry in json.loads(done.stdout)["claims"]}
    except (ValueError, KeyError, TypeError) as e:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise ToolError(f"hacheck gave no answer (exit code {done.returncode}): {said[-1] if said else e}") from e


def _answer(entry: Any) -> Answer:
    word = entry["answer"]
    if word not in ("accepted", "refused", "beyond"):
        raise ValueError(f"no such answer: {word!r}")
    return Answer(word, str(entry.get("reason") or ""))
