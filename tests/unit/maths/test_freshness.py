"""A kernel built from other sources than those present is refused."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from haverify import _kernel
from haverify.errors import ToolError
from haverify.maths.freshness import CRATE, require_fresh, source_hash


@pytest.fixture
def crate(tmp_path: Path) -> Path:
    """A copy of the kernel's sources."""
    return Path(shutil.copytree(CRATE, tmp_path / "kernel", ignore=shutil.ignore_patterns("target")))


def test_the_sources_it_was_built_from_are_accepted(crate: Path) -> None:
    require_fresh(_kernel.source_hash(), crate)


@pytest.mark.parametrize("name", ["src/interval.rs", "src/lib.rs", "Cargo.toml", "Cargo.lock", "build.rs"])
def test_one_changed_byte_is_refused(crate: Path, name: str) -> None:
    content = bytearray((crate / name).read_bytes())
    content[len(content) // 2] ^= 1
    (crate / name).write_bytes(content)
    with pytest.raises(ToolError, match="run `make`"):
        require_fresh(_kernel.source_hash(), crate)


def test_a_file_more_a_file_less_or_a_file_renamed_is_refused(crate: Path) -> None:
    (crate / "src" / "extra.rs").write_text("")
    assert source_hash(crate) != _kernel.source_hash()
    (crate / "src" / "extra.rs").unlink()
    (crate / "src" / "ratio.rs").rename(crate / "src" / "quotient.rs")
    assert source_hash(crate) != _kernel.source_hash()
    (crate / "src" / "quotient.rs").unlink()
    assert source_hash(crate) != _kernel.source_hash()


def test_files_that_do_not_go_into_the_kernel_do_not_matter(crate: Path) -> None:
    (crate / "src" / "notes.txt").write_text("not compiled")
    assert source_hash(crate) == _kernel.source_hash()


def test_an_installed_wheel_without_sources_is_accepted(tmp_path: Path) -> None:
    assert source_hash(tmp_path / "kernel") is None
    require_fresh("whatever", tmp_path / "kernel")


def test_the_door_refuses_a_stale_kernel_on_import(crate: Path) -> None:
    """The whole package copied beside an edited crate: importing the intervals fails, with what to do."""
    shutil.copytree(CRATE.parent / "haverify", crate.parent / "haverify", ignore=shutil.ignore_patterns("__pycache__"))
    source = crate / "src" / "rounding.rs"
    source.write_bytes(source.read_bytes() + b"\n")
    script = f"import sys; sys.path.insert(0, {str(crate.parent)!r}); import haverify.maths.interval"
    run = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=False)
    assert run.returncode != 0
    assert "ToolError" in run.stderr and "run `make`" in run.stderr
