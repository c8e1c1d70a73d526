"""User-facing problems as data: a code, a place, values, a next step."""

from __future__ import annotations

from enum import Enum

from haverify.text.record import field, record
from haverify.text.span import Span


class Severity(Enum):
    """How much a finding matters; `VERDICT` findings only explain a verdict."""

    ERROR = "error"
    WARNING = "warning"
    INFORMATION = "information"
    VERDICT = "verdict"


@record
class Label:
    """A second place of a finding and what it has to say there."""

    span: Span
    text: str = ""


@record
class Edit:
    """Replace the text of `span` by `text`."""

    span: Span
    text: str


@record
class Fix:
    """Edits that remove the finding; `safe` ones are applied by `--fix`, others by `--unsafe-fixes`."""

    description: str
    edits: tuple[Edit, ...]
    safe: bool = False


@record
class Diagnostic:
    """A finding.

    `code` is in the catalogue (`codes.py`). `message` is one line that names the things of the spec and
    gives values with units. `span` is the primary place, with `label` written under its carets; `labels`
    are further places; `notes` are whole lines; `help` can be pasted. `key` identifies the finding in
    `haverify.lock` independent of line numbers (default: the message).
    """

    code: str
    message: str
    span: Span | None = None
    label: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: str | None = None
    fix: Fix | None = None
    key: str = ""
    severity: Severity | None = field(default=None)  # None: the catalogue's
