"""Writing a film: frames go to ffmpeg in a thread; the file appears under its name once whole."""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import subprocess
import threading
from pathlib import Path

from inspector.language import tr
from twistcore.files.atomic import destination, is_stream, move_into_place, part_name, take_part

_WAITING = 4  # frames that may wait for ffmpeg

# What ffmpeg is told, by suffix.
_CODECS: dict[str, list[str]] = {
    ".mp4": [
        *("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-preset", "fast"),
        *("-movflags", "+faststart"),
    ],
    # A palette for each frame: one for all of them would keep the whole film in memory.
    ".gif": ["-vf", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1"],
}
SUFFIXES = tuple(_CODECS)


class FilmWriter:
    """One film; `offer` frames until it is `full`, then `finish` or `cancel`."""

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        """`path`: ends in one of SUFFIXES; size: of a frame, even numbers of pixels.

        Raises OSError where no file can be: a film cannot be poured into a FIFO or a device.
        """
        if is_stream(path):
            raise OSError(errno.EINVAL, tr("is no file, and a film needs one"), str(path))
        self.path = path
        self._end = destination(path)
        # Held while ffmpeg writes into it: what nobody holds is a leftover.
        self._handle, self._part = take_part(part_name(self._end, path.suffix))
        self._frames: queue.Queue[bytes | None] = queue.Queue(_WAITING)
        self.trouble = ""
        self._taken_end = False
        self._thread = threading.Thread(
            target=self._write, args=(size, fps), name="film", daemon=True
        )
        self._thread.start()

    @property
    def full(self) -> bool:
        """Whether ffmpeg is behind: offer again later."""
        return self._frames.full()

    @property
    def ended(self) -> bool:
        """Whether the thread is through."""
        return not self._thread.is_alive()

    def offer(self, rgb: bytes) -> None:
        """A frame, rows of RGB from the top."""
        self._frames.put(rgb)

    def finish(self) -> None:
        """No more frames; the file gets its name once `ended`."""
        self._frames.put(None)

    def keep(self) -> None:
        """Once ended: rename; raises OSError with what went wrong."""
        self._thread.join()
        if self.trouble:
            self._drop()
            raise OSError(self.trouble)
        try:
            if os.name != "posix":  # Windows moves no file that is open
                self._let_go()
            move_into_place(self._part, self._end)
        except OSError:
            self._drop()
            raise
        self._let_go()

    def cancel(self) -> None:
        """Stop, and leave nothing behind."""
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
        except (OSError, RuntimeError) as error:  # RuntimeError: no ffmpeg for this system
            self.trouble = str(error)
        while not self._taken_end:
            self._take()

    def _encode(self, command: list[str]) -> str:
        """Feed ffmpeg until the end; what it complains of, or ''."""
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as ffmpeg:
            assert ffmpeg.stdin is not None
            assert ffmpeg.stderr is not None
            with contextlib.suppress(BrokenPipeError):  # ffmpeg gave up: it says why
                while (frame := self._take()) is not None:
                    ffmpeg.stdin.write(frame)
                ffmpeg.stdin.flush()
            with contextlib.suppress(BrokenPipeError):
                ffmpeg.stdin.close()
            said = ffmpeg.stderr.read().decode(errors="replace").strip()
        if ffmpeg.returncode == 0:
            return ""
        return (
            said.splitlines()[-1]
            if said
            else tr("ffmpeg ended with {code}", code=ffmpeg.returncode)
        )

    def _take(self) -> bytes | None:
        frame = self._frames.get()
        self._taken_end = frame is None
        return frame


def _command(path: Path, size: tuple[int, int], fps: float) -> list[str]:
    """What makes a film of raw frames on standard input."""
    from imageio_ffmpeg import get_ffmpeg_exe

    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps}"]
    return [
        *(get_ffmpeg_exe(), "-y", "-loglevel", "error", *raw, "-i", "-"),
        *_CODECS[path.suffix.lower()],
        str(path),
    ]
