"""Scenes: dictionaries, files and keyword arguments."""

import datetime
import json
import os
import pathlib
import re
from collections.abc import Mapping
from typing import Any, TypeAlias

from terravox._arrays import is_masked

SceneLike: TypeAlias = Mapping[str, Any] | str | os.PathLike[str] | None
"""Sections with their fields, {"camera": {"look": "bled"}}, or the path of a scene file."""


_NAME = re.compile(r"[a-z][a-z0-9_]*")


def _value(value: Any) -> str:
    if isinstance(value, datetime.date):
        return json.dumps(value.isoformat())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(one) for one in value) + "]"
    # numpy would take a masked value for 0.
    if is_masked(value):
        raise TypeError("a scene with a masked value; allowed: values without a mask")
    if isinstance(value, (int, float)) or hasattr(value, "__float__"):
        return repr(value.item() if hasattr(value, "item") else value)
    raise TypeError(
        f"a scene with {value!r}; allowed: text, numbers, True, False, and lists of them"
    )


def toml_of(scene: SceneLike) -> str:
    """Return a scene as the text of a scene file."""
    if scene is None:
        return ""
    if not isinstance(scene, Mapping):
        return pathlib.Path(scene).read_text(encoding="utf-8")
    lines = []
    for section, fields in scene.items():
        if not isinstance(section, str) or not _NAME.fullmatch(section):
            raise TypeError(f"a scene with {section!r}; allowed: names of sections")
        if not isinstance(fields, Mapping):
            raise TypeError(
                f"a scene with {section!r} = {fields!r}; allowed: sections, which are dictionaries"
            )
        lines.append(f"[{section}]")
        for name, value in fields.items():
            if not isinstance(name, str) or not _NAME.fullmatch(name):
                raise TypeError(f"a scene with {section}.{name!r}; allowed: names of fields")
            lines.append(f"{name} = {_value(value)}")
    return "\n".join(lines) + "\n"


def field_text(value: Any) -> str:
    """Return a value as text, as on the command line."""
    if value is None:
        raise TypeError("a field that is None; allowed: text, numbers, True, False, dates, lists")
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (list, tuple)):
        return ",".join(field_text(one) for one in value)
    return str(value)


def field_list(fields: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return fields by their paths, {"sun.date": "2026-06-21"}, as the core takes them."""
    return [(path, field_text(value)) for path, value in fields.items()]
