"""What code raises when it cannot go on; what a spec's author should see is data (`Diagnostic`) instead."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from haverify.diagnostics.diagnostic import Diagnostic


class SpecError(Exception):
    """The spec is wrong, and the caller insisted on a model; `diagnostics` says what is wrong and where."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__("\n".join(f"{finding.code}: {finding.message}" for finding in self.diagnostics))


class UnsupportedError(Exception):
    """Outside what an analysis handles; the message names the fragment and what would do."""


class ToolError(Exception):
    """A tool is missing or broken; the message says what to install or run."""


class SoundnessError(Exception):
    """An assumption of haverify itself is broken, or a certificate was refused: the run stops."""


class UsageError(Exception):
    """The call or its configuration cannot be understood; the message says what to write instead. Exit code 2."""
