"""Pictures of a video file by time. PyAV decodes; the time stamps decide, never a frame rate."""

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

from inspector.language import of_core, tr

if TYPE_CHECKING:
    from av import VideoFrame
    from av.container import InputContainer
    from av.video.stream import VideoStream

_NAMES = "mp4 m4v mov avi mkv webm mpg mpeg m2v mts m2ts ts wmv ogv 3gp"
SUFFIXES = frozenset(f".{name}" for name in _NAMES.split())
WANTS_PYAV = tr(
    "Videos are read with PyAV, which is not installed: install the extra 'video' "
    "(pip install 'twist-inspector[video]')."
)

# A frame counts as begun this much early, in seconds: a BVH rounds its frame time and Matroska its
# time stamps, so that a frame of the one and of the other that belong together miss by a little.
TOLERANCE = 0.0005
_FPS = 25.0  # of a file that does not say
_KEPT_BYTES = 96_000_000  # decoded frames that are kept, so that steps back need no decoding
_SPARSE = "mpeg"  # a format that stamps few frames: after a seek the time is a guess
_ORDERED = "avi"  # a format that knows only the order of decoding, in which frames come out


class VideoError(Exception):
    """A sentence about a video that cannot be shown."""


@dataclass(frozen=True)
class Picture:
    """What a video shows from `start` until `stop`, seconds since its first frame.

    pixels: red, green, blue, uint8, (height, width, 3), upright and with square pixels.
    """

    start: float
    stop: float
    pixels: NDArray[np.uint8]

    def covers(self, seconds: float) -> bool:
        """Whether this is the picture of a time."""
        return self.start <= seconds + TOLERANCE < self.stop


def can_play() -> bool:
    """Whether PyAV is installed."""
    return find_spec("av") is not None


class VideoReader:
    """The first video stream of a file. Threads that read it wait for each other.

    width, height: of an upright picture with square pixels; fps: frames per second on average;
    duration: seconds as the file's header says, 0 if it does not; end: where the last frame ends,
    seconds since the first one began, infinite until it has been reached; seeks: how often decoding
    did not simply go on.
    """

    def __init__(self, path: Path) -> None:
        """Open a file and decode its first frame; VideoError if that cannot be done."""
        if not can_play():
            raise VideoError(WANTS_PYAV)
        self.path = path
        self.end = math.inf
        self.seeks = 0
        self._lock = threading.Lock()
        self._origin = 0.0
        self._gap = 1.0  # the longest distance seen between two key frames, seconds
        self._passed: deque[tuple[float, VideoFrame]] = deque()  # decoded without a hole, in order
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
        """−1 for a time before the video's start, +1 after its end, 0 in between.

        After its end: only once the end has been reached.
        """
        at = seconds + TOLERANCE
        return -1 if at < 0.0 else int(at >= self.end)

    def picture(self, seconds: float, width: int, height: int) -> Picture | None:
        """What is shown at a time, in `width` × `height` pixels at most; None before and after.

        seconds: since the video's first frame. Raises VideoError if the file cannot be read on.
        """
        import av

        try:
            return self._picture(seconds, width, height)
        except av.FFmpegError as error:
            why = of_core(str(error.strerror))
            told = tr("{path}: the video cannot be read on ({why}).", path=self.path, why=why)
            raise VideoError(told) from None

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
        """Let the file go; from then on there is no picture."""
        with self._lock:
            self.end = -math.inf
            self._passed.clear()
            self._container.close()

    # -- finding ------------------------------------------------------------------------------

    def _seek(self, at: float) -> None:
        """Go on from a key frame at or before a time."""
        import av

        self.seeks += 1
        back = 0.0
        while at - back > 0.0 and not self._sparse:
            wanted = at - back + self._origin
            try:
                self._container.seek(int(wanted / self._time_base), stream=self._stream)
                self._restart()
                while self._decode() and not self._passed[-1][1].key_frame:
                    self._passed.clear()  # no picture of its own before the first key frame
            except av.FFmpegError:
                break
            if self._passed and self._passed[0][0] <= at:
                return
            back = max(1.0, 2.0 * back)  # some formats land behind the place that was asked for
        self._container.close()
        self._rewind()

    def _rewind(self) -> None:
        """Open the file and decode its first frame."""
        import av

        try:
            self._container = av.open(str(self.path.absolute()), metadata_errors="replace")
            if not self._container.streams.video:
                told = tr("{path}: there is no picture in this file.", path=self.path)
                raise VideoError(told)
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
                told = tr("{path}: not one frame of this video can be decoded.", path=self.path)
                raise VideoError(told)
        except FileNotFoundError:
            name, folder = self.path.name, self.path.parent
            told = tr("{name}: the video is no longer in {folder}.", name=name, folder=folder)
            raise VideoError(told) from None
        except (av.FFmpegError, OSError) as error:
            why = of_core(error.strerror) if error.strerror else tr("not a video")
            told = tr(
                "{path}: this file cannot be played as a video ({why}).", path=self.path, why=why
            )
            raise VideoError(told) from None
        start, frame = self._passed.pop()
        self._origin, self._key = start, 0.0
        self._passed.append((0.0, frame))

    def _restart(self) -> None:
        self._coming = _decoded(self._container, self._stream)
        self._passed.clear()
        self._key = math.nan  # where the last key frame of this run began

    def _decode(self) -> bool:
        """One frame more at the end of `_passed`; False at the video's end."""
        last = self._passed[-1][0] if self._passed else -math.inf
        while True:
            frame = next(self._coming, None)
            if frame is None:
                if self._passed:
                    self.end = last + self._step
                return False
            stamp = frame.dts if self._ordered else frame.pts
            if stamp is None:  # a stream without time stamps: by its rate
                start = last + self._step if self._passed else 0.0
            else:
                start = stamp * self._time_base - self._origin
            if start > last:  # a damaged stream may step back in time
                break
        if frame.key_frame:
            if start - self._key > self._gap:  # never with the NaN of a new run
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
    """Frames in the order they are shown; what is damaged is left out."""
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
        except (av.error.EOFError, IndexError):  # a damaged file grew a stream on the way
            return
