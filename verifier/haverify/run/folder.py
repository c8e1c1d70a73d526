"""A report folder: written beside its place, and moved there when it is complete."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from haverify.errors import UsageError


class ReportFolder:
    """Files are added under `path`, beside the target; `finish` puts the folder in its place, `drop` removes it."""

    def __init__(self, target: Path) -> None:
        """Prepare to replace `target`, which must be absent, empty or an older report."""
        if target.exists() and not _is_report(target):
            raise UsageError(f"{target}: is there already and is no report folder; name another one with --report")
        self.target = target
        self._made: set[str] = set()
        self._files: set[str] = set()
        self.path = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            shutil.rmtree(self.path, ignore_errors=True)
            self.path.mkdir(parents=True)
        except OSError as e:
            raise UsageError(f"{target}: no report can be written there: {e.strerror}") from e

    def add(self, name: str, text: str) -> None:
        """Write a file of the report, `name` with `/` between folders."""
        file = f"{self.path}/{name}"
        within = os.path.dirname(file)
        if within not in self._made:
            os.makedirs(within, exist_ok=True)
            self._made.add(within)
        rest = memoryview(text.encode())
        out = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        try:
            while rest:
                rest = rest[os.write(out, rest) :]
        finally:
            os.close(out)
        self._files.add(name)

    def remove(self, name: str) -> None:
        """Take a file out again, where it was added."""
        if name in self._files:
            (self.path / name).unlink(missing_ok=True)
            self._files.remove(name)

    def finish(self) -> None:
        """Put the folder in its place; what was there is removed after that."""
        old = self.target.with_name(f".{self.target.name}.{os.getpid()}.old")
        if self.target.exists():
            self.target.rename(old)
        self.path.rename(self.target)
        shutil.rmtree(old, ignore_errors=True)

    def drop(self) -> None:
        """Remove what was written."""
        shutil.rmtree(self.path, ignore_errors=True)


def _is_report(folder: Path) -> bool:
    return folder.is_dir() and ((folder / "report.json").is_file() or not any(folder.iterdir()))


def certificate_file(claim: str) -> str:
    """The path of a claim's certificate in a report folder: `[` and `]` of its name are written `(` and `)`."""
    return f"certificates/{claim.replace('[', '(').replace(']', ')')}.json"


def flowpipe_file(claim: str) -> str:
    """The path of a claim's flowpipe, for its figures, in a report folder."""
    return f"flowpipes/{claim.replace('[', '(').replace(']', ')')}.json"


def obligation_file(claim: str) -> str:
    """The path of a claim's obligations in a report folder."""
    return f"obligations/{claim.replace('[', '(').replace(']', ')')}.txt"
