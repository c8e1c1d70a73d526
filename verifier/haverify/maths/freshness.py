"""Was the kernel built from the sources that lie beside it?

The crate's `build.rs` embeds a hash of the sources it compiled. In a checkout the same hash is computed here; an
installed wheel has no sources, and then there is nothing to compare.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from haverify.errors import ToolError

CRATE = Path(__file__).parents[2] / "kernel"


def source_hash(crate: Path) -> str | None:
    """SHA-256 over each source's path, length and content, sorted by path; None without sources."""
    if not (crate / "Cargo.toml").is_file():
        return None
    named = [crate / name for name in ("Cargo.toml", "Cargo.lock", "build.rs")]
    digest = hashlib.sha256()
    for path in sorted([*named, *(crate / "src").rglob("*.rs")], key=lambda path: path.relative_to(crate).as_posix()):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(crate).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def require_fresh(built_from: str, crate: Path = CRATE) -> None:
    """Raise `ToolError` if `crate` holds other sources than those the kernel was built from."""
    present = source_hash(crate)
    if present is not None and present != built_from:
        raise ToolError("the kernel was built from other sources than those in verifier/kernel: run `make`")
