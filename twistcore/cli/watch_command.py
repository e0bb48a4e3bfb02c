"""Run `twistcore watch`, which processes the clips of a folder as they arrive.

The folder is listed again and again, because a network share reports no file events, and because no
event shows that a copy is complete.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from twistcore.batch.inputs import Inputs, Source, find_input_clips
from twistcore.cli.batch_command import permanent_local_output_folder, prepare_batch_processing
from twistcore.cli.output import (
    Voice,
    count_with_noun,
    print_note,
    print_problem,
    print_progress,
    use_output_voice,
)
from twistcore.errors import TwistError
from twistcore.work.frozen import dataclass

_SHARE = 9.0  # minimum pause after listing the folder, as a multiple of the time that this took


def watch_command(arguments: argparse.Namespace) -> int:
    """Process clips as they arrive, and return the exit code of the latest results."""
    return _Watch(arguments).run()


@dataclass(frozen=True)
class Look:
    """The changes in a folder since it was last listed.

    Parameters
    ----------
    still
        Clips that have not changed since the folder was last listed.
    growing
        Clips that are new or have changed since the folder was last listed.
    gone
        Processed clips that no longer exist.
    news
        True if a clip in `still` is new or has changed since it was processed.
    """

    still: tuple[Source, ...]
    growing: tuple[Source, ...]
    gone: tuple[Source, ...]
    news: bool


def compare_watched_clips(
    found: Iterable[Source], before: Mapping[str, str], done: Mapping[str, Source]
) -> Look:
    """Compare the clips in a folder with those listed before and with the processed clips.

    Parameters
    ----------
    found
        The clips that are in the folder now.
    before
        The signatures of the clips listed before, keyed by path.
    done
        The clips as they were processed, keyed by path.
    """
    now = {source.path: source for source in found}
    still = [s for path, s in now.items() if before.get(path) == s.signature]
    news = any(s.path not in done or done[s.path].signature != s.signature for s in still)
    growing = [s for path, s in now.items() if before.get(path) != s.signature]
    gone = [source for path, source in done.items() if path not in now]
    return Look(tuple(still), tuple(growing), tuple(gone), news)


class _Watch:
    """The state of a watched folder, between two listings."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.process: Callable[..., tuple[int, bool]] = prepare_batch_processing(arguments)
        self.before: dict[str, str] = {}
        self.done: dict[str, Source] = {}
        self.listed: frozenset[str] = frozenset()  # problems and notes since the latest results
        self.code, self.looks, self.rounds, self.pause = 0, 0, 0, 0.0
        self.active = time.monotonic()

    def run(self) -> int:
        once, idle = self.arguments.once, self.arguments.idle
        if not once:
            print_progress(f"watching {self.arguments.folder}; stop with Ctrl+C")
        while self.looks < 2 or idle is None or time.monotonic() - self.active < idle:
            try:
                time.sleep(self.pause)
                inputs, look = self._looked()
            except KeyboardInterrupt:  # the usual end of a watch
                return self.code
            except TwistError as error:  # such as a share that is no longer connected
                self._tell(error, self.looks)
                continue
            last = once and self.looks > 1
            if look.news or look.gone or look.growing:
                self.active = time.monotonic()
            if (look.news or look.gone or last) and self._ended_in_round(inputs, look):
                return self.code
            if last:
                for source in look.growing:
                    print_problem(
                        f"{source.name}: still being written, so it was left for the next run"
                    )
                return max(self.code, int(bool(look.growing)))
        return self.code

    def _looked(self) -> tuple[Inputs, Look]:
        begin, self.pause = time.monotonic(), self.arguments.every
        folder = self.arguments.folder.absolute()
        if not folder.is_dir():
            raise TwistError(f"{self.arguments.folder}: expected a folder")
        inputs = find_input_clips(
            [str(folder)], without=permanent_local_output_folder(self.arguments), may_be_none=True
        )
        look = compare_watched_clips(inputs.sources, self.before, self.done)
        self.before = {source.path: source.signature for source in inputs.sources}
        self.looks += 1
        self.pause = max(self.pause, _SHARE * (time.monotonic() - begin))
        return inputs, look

    def _ended_in_round(self, inputs: Inputs, look: Look) -> bool:
        """Process new and changed clips, and update the results. Return True if it ended early."""
        voice = self._voice()
        try:
            with use_output_voice(voice):
                if look.gone:
                    gone = (
                        f"{count_with_noun(len(look.gone), 'clip')} removed, such as "
                        f"{look.gone[0].name}"
                    )
                    print_note(f"{gone}; the results are kept")
                found = replace(inputs, sources=look.still, problems=())
                code, ended = self.process(found, all_pages=not self.rounds)
        except TwistError as error:  # such as another run that writes into the same folder
            self._tell(error, self.rounds)
            return False
        sys.stdout.flush()
        self.listed, self.active = frozenset(voice.listed), time.monotonic()
        self.done = {source.path: source for source in look.still}
        self.code, self.rounds = code if code == 130 else min(code, 1), self.rounds + 1
        return ended

    def _tell(self, error: TwistError, later: int) -> None:
        """Print an error, unless it was printed before, or raise it.

        It is raised with the option --once, or if `later`, the number of earlier attempts that
        succeeded, is 0.
        """
        if self.arguments.once or not later:
            raise error
        voice = self._voice()
        with use_output_voice(voice):
            print_problem(" ".join(str(error).splitlines()))
        self.listed |= voice.listed

    def _voice(self) -> Voice:
        return Voice(self.arguments.quiet, self.arguments.verbose, known=self.listed)
