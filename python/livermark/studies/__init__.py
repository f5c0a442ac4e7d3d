"""Studies whose statistics numpy and OpenTURNS compute; the commands of the program start them, and read their answers as TOML."""
from __future__ import annotations

import json
from typing import Any


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml_value, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml_value(part)}" for key, part in value.items()) + " }"
    return repr(value)


def to_toml(answer: dict[str, Any], tables: str) -> str:
    """Of texts, numbers, lists and small tables of them; and below a key, named `tables`, of a list of such tables."""
    plain = "".join(f"{key} = {_toml_value(value)}\n" for key, value in answer.items() if key != tables)
    return plain + "".join(f"[[{tables}]]\n" + to_toml(table, "") for table in answer.get(tables, []))
