"""Read the images of a video file by their time stamps, with PyAV."""

from __future__ import annotations

import math
import threading
from bisect import bisect_right
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from inspector.language import tr, translate_core_sentence

if TYPE_CHECKING:
    from av import VideoFrame
    from av.container import InputContainer
    from av.video.stream import VideoStream

_NAMES = "mp4 m4v mov avi mkv webm mpg mpeg m2v mts m2ts ts wmv ogv 3gp"
SUFFIXES = frozenset(f".{name}" for name in _NAMES.split())
WANTS_PYAV = tr(
    "Videos need PyAV, which is not installed. Install it with "
    "pip install 'twist-inspector[video]'."
)

# Seconds by which an image may begin early. BVH files round their frame time and Matroska files
# round their time stamps, so images and frames that belong together differ slightly.
TOLERANCE = 0.0005
_FPS = 25.0  # assumed for a file without a frame rate
_KEPT_BYTES = 96_000_000  # memory for decoded images, so that steps back need no decoding
_SPARSE = "mpeg"  # a format with few time stamps, in which the time after a seek is a guess
_ORDERED = "avi"  # a format whose time stamps give only the order of decoding


class VideoError(Exception):
    """Raised if a video cannot be shown. The message is meant for the user."""


@dataclass(frozen=True)
class Picture:
    """An image that a video shows from `start` to `stop`, in seconds since the first image.

    Attributes
    ----------
    pixels
        Red, green and blue as uint8, (height, width, 3). The image is upright and has square
        pixels.
    """

    start: float
    stop: float
    pixels: NDArray[np.uint8]

    def covers(self, seconds: float) -> bool:
        """Return True if the video shows this image at the given time."""
        return self.start <= seconds + TOLERANCE < self.stop


def can_play() -> bool:
    """Return True if PyAV is installed."""
    return find_spec("av") is not None


class VideoReader:
    """A reader for the first video stream of a file. It is thread-safe.

    Attributes
    ----------
    width, height
        The size of an upright image with square pixels.
    fps
        The average number of images per second.
    duration
        The length in seconds according to the header, or 0 if it is unknown.
    end
        The time at which the last image ends, in seconds since the first image. It is infinite
        until the last image has been read.
    seeks
        The number of times that the reader has jumped to a different position in the file.
    """

    def __init__(self, path: Path) -> None:
        """Open a file and decode its first image. Raises VideoError on failure."""
        if not can_play():
            raise VideoError(WANTS_PYAV)
        self.path = path
        self.end = math.inf
        self.seeks = 0
        self._lock = threading.Lock()
        self._origin = 0.0
        self._gap = 1.0  # longest time between two key frames so far, in seconds
        # Times and decoded images, in order
        self._passed: deque[tuple[float, VideoFrame]] = deque()
        self._container: InputContainer
        self._stream: VideoStream
        self._coming: Iterator[VideoFrame]
        self._rewind()
        first = self._passed[0][1]
        aspect = float(self._stream.sample_aspect_ratio or 1)
        self._turns = round(first.rotation / 90) % 4
        width, height = max(1, round(first.width * aspect)), first.height
        self.width, self.height = (height, width) if self._turns % 2 else (width, height)
        self.duration = (self._container.duration or 0) / 1e6

    def place(self, seconds: float) -> int:
        """Return −1 for a time before the video begins, +1 after its end, and 0 in between.

        The end is known only after the last image has been read.
        """
        at = seconds + TOLERANCE
        return -1 if at < 0.0 else int(at >= self.end)

    def picture(self, seconds: float, width: int, height: int) -> Picture | None:
        """Return the image at a time, or None outside the video.

        The image is scaled down to at most `width` × `height` pixels. `seconds` is the time since
        the first image. Raises VideoError if reading fails.
        """
        import av

        try:
            return self._picture(seconds, width, height)
        except av.FFmpegError as error:
            why = translate_core_sentence(str(error.strerror))
            message = tr("{path}: the video could not be read ({why}).", path=self.path, why=why)
            raise VideoError(message) from None

    def _picture(self, seconds: float, width: int, height: int) -> Picture | None:
        with self._lock:
            if self.place(seconds) != 0:
                return None
            at = seconds + TOLERANCE
            known = self._passed[-1][0] + (math.inf if self._sparse else self._gap)
            if not self._passed[0][0] <= at < known:
                self._seek(at)
            while self._passed[-1][0] <= at and self._decode():
                pass
            if self.place(seconds) != 0:
                return None
            k = bisect_right(self._passed, at, key=lambda passed: passed[0]) - 1
            start, frame = self._passed[k]
            stop = self._passed[k + 1][0] if k + 1 < len(self._passed) else self.end
            return Picture(start, stop, self._pixels(frame, width, height))

    def close(self) -> None:
        """Close the file. No image can be read after this."""
        with self._lock:
            self.end = -math.inf
            self._passed.clear()
            self._container.close()

    # -- seeking and decoding -----------------------------------------------------------------

    def _seek(self, at: float) -> None:
        """Seek to the last key frame at or before a time, and decode it."""
        import av

        self.seeks += 1
        back = 0.0
        while at - back > 0.0 and not self._sparse:
            target = at - back + self._origin
            try:
                self._container.seek(int(target / self._time_base), stream=self._stream)
                self._restart()
                while self._decode() and not self._passed[-1][1].key_frame:
                    self._passed.clear()  # images before the first key frame are incomplete
            except av.FFmpegError:
                break
            if self._passed and self._passed[0][0] <= at:
                return
            back = max(1.0, 2.0 * back)  # some formats seek to a later position than requested
        self._container.close()
        self._rewind()

    def _rewind(self) -> None:
        """Open the file again, and decode its first image."""
        import av

        try:
            self._container = av.open(str(self.path.absolute()), metadata_errors="replace")
            if not self._container.streams.video:
                message = tr("{path}: this file has no video stream.", path=self.path)
                raise VideoError(message)
            self._stream = self._container.streams.video[0]
            self._stream.thread_type = "AUTO"
            self._time_base = float(self._stream.time_base or 1)
            self.fps = float(self._stream.average_rate or self._stream.guessed_rate or _FPS)
            self._step = 1.0 / self.fps
            self._sparse = self._container.format.name == _SPARSE
            self._ordered = self._container.format.name == _ORDERED
            self._restart()
            self._origin = 0.0
            if not self._decode():
                message = tr("{path}: no frame of this video can be decoded.", path=self.path)
                raise VideoError(message)
        except FileNotFoundError:
            name, folder = self.path.name, self.path.parent
            message = tr("The video {name} is no longer in {folder}.", name=name, folder=folder)
            raise VideoError(message) from None
        except (av.FFmpegError, OSError) as error:
            why = (
                translate_core_sentence(error.strerror)
                if error.strerror
                else tr("the file is not a video")
            )
            message = tr(
                "{path}: this file cannot be played as a video ({why}).", path=self.path, why=why
            )
            raise VideoError(message) from None
        start, frame = self._passed.pop()
        self._origin, self._key = start, 0.0
        self._passed.append((0.0, frame))

    def _restart(self) -> None:
        self._coming = _decoded(self._container, self._stream)
        self._passed.clear()
        self._key = math.nan  # time of the last key frame since the restart

    def _decode(self) -> bool:
        """Append the next image to `_passed`. Return False at the end of the video."""
        last = self._passed[-1][0] if self._passed else -math.inf
        while True:
            frame = next(self._coming, None)
            if frame is None:
                if self._passed:
                    self.end = last + self._step
                return False
            stamp = frame.dts if self._ordered else frame.pts
            if stamp is None:  # a stream without time stamps: use its frame rate
                start = last + self._step if self._passed else 0.0
            else:
                start = stamp * self._time_base - self._origin
            if start > last:  # in a damaged stream, time may go back
                break
        if frame.key_frame:
            if start - self._key > self._gap:  # False while `_key` is NaN
                self._gap = start - self._key
            self._key = start
        self._passed.append((start, frame))
        most = max(2, _KEPT_BYTES // (2 * frame.width * frame.height))
        while len(self._passed) > most:
            self._passed.popleft()
        return True

    def _pixels(self, frame: VideoFrame, width: int, height: int) -> NDArray[np.uint8]:
        scale = min(1.0, width / self.width, height / self.height)
        size = [max(1, round(scale * n)) for n in (self.width, self.height)]
        if self._turns % 2:
            size.reverse()
        small = frame.reformat(width=size[0], height=size[1], format="rgb24", interpolation="AREA")
        return np.ascontiguousarray(np.rot90(small.to_ndarray(), self._turns))


def _decoded(container: InputContainer, stream: VideoStream) -> Iterator[VideoFrame]:
    """Yield the decoded images in display order, except damaged images."""
    import av

    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
            if packet is None:
                return
            yield from packet.decode()
        except av.error.InvalidDataError:
            continue
        except (av.error.EOFError, IndexError):  # a damaged file can gain a stream while reading
            return
