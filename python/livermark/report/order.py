"""The order of bodies on the page, in every section: livers with lesions, other livers, other bodies, and beams last."""
from __future__ import annotations

from typing import Sequence

_LIVER = ("parenchyma",)  # region of every liver, of an image as of the generator


def _starts(name: str, word: str) -> bool:
    return name.lower().startswith(word)


def rank(body: str, regions: Sequence[str] = ()) -> int:
    """Small comes first. regions: names, where its files say them; else the name of the body has to say what it is."""
    if _starts(body, "beam"):
        return 3
    is_liver = any(region in _LIVER for region in regions) or _starts(body, "liver")
    has_lesions = len(regions) > 1 or "tumour" in body.lower()
    return (0 if has_lesions else 1) if is_liver else 2


def place(body: str, regions: Sequence[str] = ()) -> tuple[int, str]:
    """What bodies are sorted by."""
    return rank(body, regions), body
