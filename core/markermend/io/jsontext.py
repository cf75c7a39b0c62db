"""Strict JSON as text, the same wherever the project writes it."""

import json
from collections.abc import Mapping
from typing import Any


def json_text(record: Mapping[str, Any]) -> str:
    """Give strict JSON in ASCII: no NaN, no infinity, no half of a character."""
    return f"{json.dumps(encodable(record), indent=1, allow_nan=False)}\n"


def encodable(value: Any) -> Any:
    """Replace what no UTF-8 can hold: bytes of a file's name that are no text."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, Mapping):
        return {key: encodable(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [encodable(one) for one in value]
    return value
