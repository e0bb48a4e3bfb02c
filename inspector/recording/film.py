"""Write a film with ffmpeg in a thread. The file gets its final name when it is complete."""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import subprocess
import threading
from pathlib import Path

from inspector.language import tr
from twistcore.files.atomic import (
    is_stream,
    move_into_place,
    open_temporary,
    resolve_write_path,
    temporary_file_path,
)

_WAITING = 4  # maximum number of frames that wait for ffmpeg

# Options for ffmpeg, keyed by suffix.
_CODECS: dict[str, list[str]] = {
    ".mp4": [
        *("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-preset", "fast"),
        *("-movflags", "+faststart"),
    ],
    # A palette per image, because a common palette would keep the whole film in memory.
    ".gif": ["-vf", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1"],
}
SUFFIXES = tuple(_CODECS)


class FilmWriter:
    """Writes one film to a file.

    Call `offer` with each image, but only while the writer is not `full`. Call `finish` after the
    last image.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        """Start writing a film. Raises OSError if the path is a FIFO or a device.

        `path` ends with one of SUFFIXES. `size` is the width and height of an image in pixels,
        which must be even numbers.
        """
        if is_stream(path):
            raise OSError(
                errno.EINVAL, tr("a video can only be written to a regular file"), str(path)
            )
        self.path = path
        self._end = resolve_write_path(path)
        # Keep the file open while ffmpeg writes to it: an unfinished file that no program has open
        # may be deleted as a leftover.
        self._handle, self._part = open_temporary(temporary_file_path(self._end, path.suffix))
        self._frames: queue.Queue[bytes | None] = queue.Queue(_WAITING)
        self.trouble = ""
        self._taken_end = False
        self._thread = threading.Thread(
            target=self._write, args=(size, fps), name="film", daemon=True
        )
        self._thread.start()

    @property
    def full(self) -> bool:
        """True while the queue of images for ffmpeg is full."""
        return self._frames.full()

    @property
    def ended(self) -> bool:
        """True if the writing thread has ended."""
        return not self._thread.is_alive()

    def offer(self, rgb: bytes) -> None:
        """Add an image as RGB bytes, in rows from top to bottom."""
        self._frames.put(rgb)

    def finish(self) -> None:
        """Mark the film as complete. As soon as the writer has `ended`, call `keep`."""
        self._frames.put(None)

    def keep(self) -> None:
        """Give the finished film its final name. Raises OSError if writing has failed."""
        self._thread.join()
        if self.trouble:
            self._drop()
            raise OSError(self.trouble)
        try:
            if os.name != "posix":  # Windows cannot move an open file
                self._let_go()
            move_into_place(self._part, self._end)
        except OSError:
            self._drop()
            raise
        self._let_go()

    def cancel(self) -> None:
        """Stop writing, and delete the unfinished file."""
        while not self._frames.empty():
            with contextlib.suppress(queue.Empty):
                self._frames.get_nowait()
        self._frames.put(None)
        self._thread.join()
        self._drop()

    def _let_go(self) -> None:
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1

    def _drop(self) -> None:
        if os.name != "posix":
            self._let_go()
        self._part.unlink(missing_ok=True)
        self._let_go()

    def _write(self, size: tuple[int, int], fps: float) -> None:
        try:
            self.trouble = self._encode(_command(self._part, size, fps))
        except (OSError, RuntimeError) as error:  # a RuntimeError means: no ffmpeg
            self.trouble = str(error)
        while not self._taken_end:
            self._take()

    def _encode(self, command: list[str]) -> str:
        """Send all images to ffmpeg. Return its error message, or '' on success."""
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as ffmpeg:
            assert ffmpeg.stdin is not None
            assert ffmpeg.stderr is not None
            # If ffmpeg has stopped, its message is read below
            with contextlib.suppress(BrokenPipeError):
                while (frame := self._take()) is not None:
                    ffmpeg.stdin.write(frame)
                ffmpeg.stdin.flush()
            with contextlib.suppress(BrokenPipeError):
                ffmpeg.stdin.close()
            errors = ffmpeg.stderr.read().decode(errors="replace").strip()
        if ffmpeg.returncode == 0:
            return ""
        return (
            errors.splitlines()[-1]
            if errors
            else tr("ffmpeg ended with exit code {code}", code=ffmpeg.returncode)
        )

    def _take(self) -> bytes | None:
        frame = self._frames.get()
        self._taken_end = frame is None
        return frame


def _command(path: Path, size: tuple[int, int], fps: float) -> list[str]:
    """Return the ffmpeg command that makes a film from raw images on standard input."""
    from imageio_ffmpeg import get_ffmpeg_exe

    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps}"]
    return [
        *(get_ffmpeg_exe(), "-y", "-loglevel", "error", *raw, "-i", "-"),
        *_CODECS[path.suffix.lower()],
        str(path),
    ]
