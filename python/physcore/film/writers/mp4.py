"""Writer of MP4: H.264 video, encoded by the FFmpeg of imageio-ffmpeg."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Iterator
from itertools import chain, repeat
from pathlib import Path
from typing import IO, TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.storage.files import replacing

# Modules that run another program are imported on use: their import takes half as long as that of physcore.
if TYPE_CHECKING:
    import subprocess
    from fractions import Fraction

THREADS = 4
"""Number of threads of the encoder on any machine, because its output depends on it."""
ENCODER = (
    *("-c:v", "libx264", "-preset", "medium", "-crf", "16", "-tune", "animation", "-threads", str(THREADS)),
    *("-vf", "scale=out_color_matrix=bt709:flags=accurate_rnd+full_chroma_int,format=yuv420p"),
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
    *("-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart"),
)
"""Options of the encoder. Every player supports the result, and playback can start before the download ends."""
COMMENT = (b"moov", b"udta", b"meta", b"ilst", b"\xa9cmt", b"data")
"""Path of the comment through the boxes of a file."""


class Mp4Writer(Writer):
    """Video for slides, talks and the web; the smallest format for long films. Needs physcore[video]."""

    suffixes: ClassVar = (".mp4",)
    name: ClassVar = "an MP4"
    video: ClassVar = True
    fastest: ClassVar = 240.0
    longest: ClassVar = 3600.0

    @classmethod
    def missing(cls) -> str | None:
        """The instruction to install FFmpeg, if it is missing; otherwise None."""
        return None if _ffmpeg() else "an MP4 needs FFmpeg: pip install 'physcore[video]'; a .webp needs nothing"

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film. Odd sides are extended by one row or column, because the color channels have half the
        resolution.
        """
        import subprocess
        import tempfile

        frames = _repeated(job)
        first = next(frames)
        with (
            replacing(target) as file,
            tempfile.NamedTemporaryFile() as notes,
            tempfile.TemporaryFile() as complaints,
        ):
            notes.write(b";FFMETADATA1\ncomment=" + _escaped(job.provenance).encode() + b"\n")
            notes.flush()
            command = _command(first.shape[:2], job.rate, notes.name, file.name)
            with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=complaints, bufsize=0) as encoder:
                _feed(encoder, chain([first], frames))
            if encoder.returncode != 0:
                raise OSError(_cause(encoder.returncode, complaints))
        return self.written(job, target)

    @staticmethod
    def provenance(path: Path) -> str | None:
        """The comment of an MP4 file. Source: Apple, "QuickTime File Format", metadata; every box has a length and a
        kind.
        """
        content = path.read_bytes()
        start, end = 0, len(content)
        for wanted in COMMENT:
            for kind, first, last in _boxes(content, start, end):
                if kind == wanted:
                    start, end = first + (4 if kind == b"meta" else 0), last
                    break
            else:
                return None
        return content[start + 8 : end].decode()


def _ffmpeg() -> str:
    """The path of FFmpeg; empty if it is missing."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return ""


def _command(shape: tuple[int, ...], rate: float, notes: str, target: str) -> list[str]:
    """The command that encodes the raw frames from its standard input."""
    height, width = shape
    frames = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-framerate", str(exact(rate)))
    inputs = ("-f", "ffmetadata", "-i", notes, *frames, "-i", "pipe:0", "-map", "1:v", "-map_metadata", "0")
    return [_ffmpeg(), "-y", "-v", "error", *inputs, *ENCODER, "-f", "mp4", f"file:{target}"]


def exact(rate: float) -> Fraction:
    """The frame rate as a fraction with a small denominator."""
    from fractions import Fraction

    return Fraction(rate).limit_denominator(1_000_000)


def _feed(encoder: subprocess.Popen[bytes], frames: Iterable[NDArray[np.uint8]]) -> None:
    """Write all frames to the encoder; kill the encoder if this fails."""
    assert encoder.stdin is not None
    try:
        for pixels in frames:
            rest = pixels.reshape(-1).data
            while rest:  # A pipe may accept only a part of the data.
                rest = rest[encoder.stdin.write(rest) :]
        encoder.stdin.close()
    except BrokenPipeError:
        pass  # The encoder has ended, and `_cause` reads its message.
    except BaseException:
        encoder.kill()
        raise


def _cause(code: int, complaints: IO[bytes]) -> str:
    """The reason why the encoder ended, in one line."""
    import signal

    complaints.seek(0)
    ended = (signal.strsignal(-code) if code < 0 else None) or f"FFmpeg ended with {code}"
    lines = complaints.read().decode(errors="replace").strip().split("\n")
    return re.sub(r"^(\[.*?\] )*", "", lines[0].strip()) or ended


def _escaped(text: str) -> str:
    """Text escaped for FFmpeg's metadata files."""
    return "".join(f"\\{letter}" if letter in "=;#\\\n" else letter for letter in text)


def _repeated(job: FilmJob) -> Iterator[NDArray[np.uint8]]:
    """All frames at a constant rate; the held frame is repeated."""
    held, times = job.held(), 1 + round(job.repeat.hold * job.rate)
    for index, canvas in enumerate(job.frames()):
        yield from repeat(_even(canvas.pixels()), times if index == held else 1)


def _even(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The picture with even sides; the last row or column is repeated if necessary."""
    height, width, _ = pixels.shape
    if height % 2 == width % 2 == 0:
        return pixels
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


def _boxes(content: bytes, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """The kind, the start and the end of the content of each box."""
    while start + 8 <= end:
        length, kind = struct.unpack_from(">I4s", content, start)
        head = 8
        if length == 1:  # 64-bit length, for more than 4 GB
            length, head = struct.unpack_from(">Q", content, start + 8)[0], 16
        if length < head:
            return
        yield kind, start + head, start + length
        start += length
