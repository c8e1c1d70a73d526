"""The JSON schema of `report.json`, made from the classes of `report.py`.

`python -m haverify.report.schema > docs/report.schema.json` writes the committed copy.
"""

from __future__ import annotations

import json
from typing import Any

from haverify.report.report import SCHEMA, Report


def schema() -> dict[str, Any]:
    """The schema (JSON Schema 2020-12)."""
    import msgspec

    made = msgspec.json.schema(Report)
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": SCHEMA, "title": SCHEMA}
    return {**head, **made}


def text() -> str:
    """The schema as committed."""
    return json.dumps(schema(), indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    print(text(), end="")
