"""JSON values kept between runs, by key, in a folder of the user; each with its digest, so that damage is absence."""

from __future__ import annotations

import hashlib
import json
import os
import time
from pathlib import Path
from typing import Any

_MOST = 256  # files of one shelf; the oldest go first


def folder() -> Path:
    """Where they are kept: `$HAVERIFY_CACHE`, else `haverify` in the user's cache folder."""
    if os.environ.get("HAVERIFY_CACHE"):
        return Path(os.environ["HAVERIFY_CACHE"])
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home and os.path.isabs(home) else Path.home() / ".cache") / "haverify"


def load(key: str, shelf: str = "") -> Any:
    """The JSON value kept under a key; None where there is none or the file is not as it was written."""
    try:
        digest, _, body = (folder() / shelf / f"{key}.json").read_bytes().partition(b"\n")
        return json.loads(body) if digest.decode("ascii") == hashlib.sha256(body).hexdigest() else None
    except (OSError, ValueError, RecursionError):
        return None


def store(key: str, value: Any, shelf: str = "") -> None:
    """Keep a JSON value, in one step; a folder that cannot be written keeps nothing, and that is no error."""
    body, path = canonical(value), folder() / shelf / f"{key}.json"
    beside = path.with_name(f".{key[:16]}.{os.getpid()}.{time.monotonic_ns()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with os.fdopen(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
            file.write(hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
        os.replace(beside, path)
        _forget_oldest(path.parent)
    except OSError:
        return


def canonical(value: Any) -> bytes:
    """The one way to write a JSON value."""
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode()


def _forget_oldest(where: Path) -> None:
    packs = sorted(where.glob("*.json"), key=lambda p: p.stat().st_mtime)
    for pack in packs[:-_MOST]:
        pack.unlink(missing_ok=True)
