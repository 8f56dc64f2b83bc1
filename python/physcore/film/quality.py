"""The effort for the quality of pictures."""

from __future__ import annotations

from typing import Literal, get_args

Quality = Literal["fast", "high"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)
SAMPLES: dict[Quality, int] = {"fast": 1, "high": 2}
"""Samples per pixel along each side, in 3D."""
