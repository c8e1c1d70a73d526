"""`report.json` read again, as a report of this version or not at all."""

from __future__ import annotations

from pathlib import Path

from haverify.errors import UsageError
from haverify.report.report import SCHEMA, Report

_MOST = 400_000_000


def read_report(path: Path) -> Report:
    """The report in a file, or in the `report.json` of a folder.

    Raises
    ------
    UsageError      if there is none, or it does not fit the schema; keys beyond the schema are ignored
    """
    file = path / "report.json" if path.is_dir() else path
    try:
        if not file.is_file():
            raise UsageError(f"{file}: there is no such report")
        if file.stat().st_size > _MOST:
            raise UsageError(f"{file}: too large for a report")
        raw = file.read_bytes()
    except OSError as e:
        raise UsageError(f"{file}: {e.strerror}") from e
    return _decoded(raw, file)


def _decoded(raw: bytes, file: Path) -> Report:
    import msgspec

    try:
        schema = msgspec.json.decode(raw)
        schema = schema.get("schema") if isinstance(schema, dict) else None
        if schema != SCHEMA:
            raise UsageError(f"{file}: no report of schema {SCHEMA}")
        return msgspec.json.decode(raw, type=Report)
    except msgspec.ValidationError as e:
        raise UsageError(f"{file}: does not fit {SCHEMA}: {e}") from e
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as e:
        raise UsageError(f"{file}: no JSON: {e}") from e
