"""Robust reading of picture files with Pillow."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from physcore.errors import FileError

if TYPE_CHECKING:
    from PIL.Image import Image


@contextmanager
def opened(path: Path) -> Iterator[Image]:
    """Context manager that opens a picture.

    Raises:
        FileError: the picture cannot be read. All errors and warnings of Pillow are converted to this one.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with Image.open(path) as image:
                yield image
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from error
    except Exception as error:
        raise FileError(f"{path}: is damaged, or no picture: {error}") from error
