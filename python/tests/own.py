"""Callables that stand for a researcher's models."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import kinfold

CABINET = Path(__file__).parents[2] / "examples" / "cabinet"


def generator(photo: kinfold.Photo) -> Path:
    if photo.png[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG")
    return CABINET / "mesh.glb"


def speaker(photo: kinfold.Photo, views: list[kinfold.View]) -> dict[str, Any]:
    if len(views) != 8 or views[0].name != "front" or views[0].png[:4] != b"\x89PNG":
        raise ValueError("other views")
    document: dict[str, Any] = json.loads((CABINET / "condition.json").read_text())
    return document
