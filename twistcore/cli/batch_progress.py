"""Show the progress of a batch with its rate and remaining time, as a bar or as lines."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from twistcore.batch.inputs import Source
from twistcore.batch.run_plan import Plan
from twistcore.cli.output import count_with_noun, is_quiet, print_progress

_EVERY_S = 10.0  # longest time between two lines; a line is also printed after each 5 % of clips


class Progress:
    """The progress of a run. The remaining time is estimated from the sizes of the clips."""

    def __init__(self, plan: Plan) -> None:
        self.total, self.done, self.failed = len(plan.todo), 0, 0
        self.bytes, self.bytes_done = sum(max(s.size, 1) for s in plan.todo), 0
        self.begin = self.said = time.monotonic()
        self.bar: Any = None
        if plan.known or plan.failed:
            bad = f", {len(plan.failed)} known failures" if plan.failed else ""
            known = count_with_noun(plan.known, "clip")
            print_progress(f"{known} already done{bad}, {self.total} left to do")
        if sys.stderr.isatty() and not is_quiet():
            from tqdm import tqdm

            self.bar = tqdm(total=self.total, unit="clip", file=sys.stderr)

    def tell(self, source: Source, fine: bool) -> None:
        """Count a finished clip and update the display. `fine` is False if the clip failed."""
        self.done += 1
        self.failed += not fine
        self.bytes_done += max(source.size, 1)
        if self.bar is not None:
            self.bar.set_postfix_str(f"{self.left()} left, {self.failed} failed", refresh=False)
            self.bar.update()
            if self.done == self.total:
                self.bar.close()
            return
        now = time.monotonic()
        twentieth = self.done % max(1, self.total // 20) == 0 and now - self.said > 0.2
        if self.done == self.total or twentieth or now - self.said > _EVERY_S:
            self.said = now
            rate = self.done / max(now - self.begin, 1e-9)
            print_progress(
                f"{self.done}/{self.total} {source.name}, {rate:.3g} clips/s, {self.left()} left"
            )

    def left(self) -> str:
        """Return the estimated remaining time, such as '0:12:07'."""
        passed = time.monotonic() - self.begin
        seconds = round(passed / self.bytes_done * (self.bytes - self.bytes_done))
        return f"{seconds // 3600}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


def show_batch_progress(plan: Plan) -> Callable[[Source, bool], None]:
    """Show the progress of a plan, and return a function to call for each finished clip."""
    return Progress(plan).tell
