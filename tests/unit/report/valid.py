"""Reports held against the published schemas."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import xmlschema

SCHEMAS = Path(__file__).parent / "schemas"


@cache
def _sarif() -> Any:
    schema = json.loads((SCHEMAS / "sarif-2.1.0-rtm.5.json").read_text(encoding="utf-8"))
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    return kind(schema, format_checker=kind.FORMAT_CHECKER)


@cache
def _junit() -> xmlschema.XMLSchema:
    return xmlschema.XMLSchema(SCHEMAS / "junit-10.xsd")


def valid_sarif(text: str) -> dict[str, Any]:
    """The run of a SARIF log that fits the schema."""
    log = json.loads(text)
    errors = [f"{list(e.absolute_path)}: {e.message}" for e in _sarif().iter_errors(log)]
    assert not errors, errors[:5]
    (run,) = log["runs"]
    return run


def valid_junit(text: str) -> Any:
    """The root element of a JUnit file that fits the schema."""
    from xml.etree import ElementTree

    root = ElementTree.fromstring(text)
    errors = [str(e.reason) for e in _junit().iter_errors(root)]
    assert not errors, errors[:5]
    return root
