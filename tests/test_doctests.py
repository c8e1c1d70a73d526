"""The examples in docstrings are true."""

import doctest
import importlib
from pathlib import Path

import pytest

VERIFIER = Path(__file__).parents[1] / "verifier"
WITH_EXAMPLES = [
    ".".join(path.relative_to(VERIFIER).with_suffix("").parts)
    for path in sorted(VERIFIER.rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_in_docstrings_are_true(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0
    assert result.failed == 0
