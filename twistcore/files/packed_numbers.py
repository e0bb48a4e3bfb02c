"""Encode arrays of numbers for the JSON data of web pages."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

_KINDS = {"f4": "<f4", "u2": "<u2", "i2": "<i2", "u1": "u1", "u4": "<u4"}


def encode_base64_array(values: Any, kind: str) -> dict[str, str]:
    """Encode an array as little-endian numbers in base64.

    `kind` is the type of the numbers, such as 'f4' (see _KINDS).
    """
    data = np.ascontiguousarray(values, dtype=_KINDS[kind]).tobytes()
    return {"kind": kind, "data": base64.b64encode(data).decode("ascii")}
