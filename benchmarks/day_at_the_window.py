"""Simulate a day of a user at the window.

    python -m benchmarks.day_at_the_window FOLDER [--clips N] [--log FILE]

A simulated user reviews copies of the folder's clips with random errors. The program starts with
new settings under a window manager, and all input comes from the keyboard and mouse of the X
server. Half of the clips are judged with the keyboard only, the other half with the mouse only.
Meanwhile the program is killed three times, another program overwrites a file, and one clip changes
on disk. The output shows keys and clicks per decision, dialogs that blocked the review, keys that
went to another widget, and whether every decision is in the sessions at the end. --log writes a
line of JSON for each event. --look chooses the theme, and whether there is a compositor.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from tests.gui.looks import LOOKS
from tests.gui.real_screen import RealScreen, WatchedProgram, real_screen, watched
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import clip_random_generator, draw_errors, inject

_CHAINS = 1  # number of chains with errors in a clip
_SIZE = (1440, 900)
# With these settings, the program does not ask for a name, and a decision is on one interval.
_NAMED = {"reviewer": "Kim", "group_errors": False}
_FOREIGN = "another program wrote this"


def with_errors(source: Path, target: Path) -> None:
    """Write a clip with seeded errors in some of its chains."""
    clip = read_bvh(source)
    chains = find_chains(clip.motion)
    rng = clip_random_generator(7, source.name)
    chosen = [chains[k] for k in rng.permutation(len(chains))[:_CHAINS]]
    dirty = inject(clip.motion, chains, draw_errors(clip.motion, chosen, rng))
    target.write_bytes(create_file_patch_for_motion(clip, dirty).data)


@dataclass
class Day:
    """The events of the day.

    Attributes
    ----------
    log
        The file to which events are written.
    rng
        The source of random numbers.
    began
        The time at which the day began, in seconds.
    keys, clicks
        Numbers of pressed keys and of clicks.
    by_keys, by_mouse
        Numbers of decisions with the keyboard and with the mouse.
    kills, exports
        Numbers of kills and exports.
    decided
        The decisions, keyed by clip.
    wrong
        Descriptions of failures.
    """

    log: IO[str]
    rng: random.Random
    began: float = field(default_factory=time.monotonic)
    keys: int = 0
    clicks: int = 0
    by_keys: int = 0
    by_mouse: int = 0
    kills: int = 0
    exports: int = 0
    decided: dict[str, list[str]] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)

    @property
    def decisions(self) -> int:
        """Return the number of decisions made so far."""
        return self.by_keys + self.by_mouse

    def tell(self, event: str, **more: object) -> None:
        """Write an event to the log."""
        line = {"s": round(time.monotonic() - self.began, 2), "event": event, **more}
        print(json.dumps(line), file=self.log, flush=True)

    def blame(self, what: str) -> None:
        """Record a failure."""
        self.wrong.append(what)
        self.tell("wrong", what=what)


@dataclass
class Person:
    """A simulated user of a running program.

    If `mouse` is True, the user works only with the mouse. If not, only with the keyboard.
    """

    screen: RealScreen
    program: WatchedProgram
    day: Day
    mouse: bool = False

    # -- input --------------------------------------------------------------------------------

    def press(self, *keys: str, counts: bool = True) -> None:
        """Press keys. `counts` is False for keys that are not part of the review."""
        self.screen.key(*keys)
        self.day.keys += len(keys) if counts else 0
        self._look(keys)

    def click(self, widget: str, *, counts: bool = True) -> None:
        """Click the middle of a widget. `counts` is as in :meth:`press`."""
        self.screen.click(self.program.rect(widget))
        self.day.clicks += 1 if counts else 0
        self._look(widget)

    def _look(self, done: object) -> None:
        """Record a failure if a dialog blocks the review or another widget has the focus."""
        name = "type(QApplication.{}()).__name__"
        box = self.program.ask(name.format("activeModalWidget"))
        if box not in ("NoneType", "ExportDialog"):
            self.day.blame(f"{box} blocked the review after {done}")
            self.screen.key("Escape")
        focus = self.program.ask(name.format("focusWidget"))
        if box == "NoneType" and focus in ("QLineEdit", "QSpinBox", "QDoubleSpinBox", "QComboBox"):
            self.day.blame(f"a {focus} had the keys after {done}")

    def answer(self, text: str) -> None:
        """Wait for a question in the message bar, and press the button with this text."""
        buttons = "[b.text() for b in window.bar.buttons()]"
        self.program.until(f"window.bar.isVisible() and {text!r} in {buttons}")
        place = self.program.ask(buttons).index(text)
        if self.mouse:
            self.click(f"window.bar.buttons()[{place}]", counts=False)
        else:
            self.press(f"alt+{place + 1}", counts=False)
        self.day.tell("answer", text=text)

    # -- state --------------------------------------------------------------------------------

    @property
    def clip(self) -> str:
        """Return the name of the open clip, or '' if none is open."""
        data = "window.document.data"
        return str(self.program.ask(f"{data}.clip.path.name if {data} else ''"))

    # -- the review ---------------------------------------------------------------------------

    def judge(self) -> bool:
        """Judge the selected interval. Return False if there is none."""
        before = self.program.decisions()
        if "undecided" not in before:
            return False
        accept = self.day.rng.random() < 0.8
        if self.mouse:
            self.click(f"list(window.detail.buttons.values())[{0 if accept else 1}]")
        else:
            self.program.until("window.viewport.has_painted_interval()")
            self.press("a" if accept else "r")
        left, clip = before.count("undecided"), self.clip
        end = time.monotonic() + 5.0
        while (now := self.program.decisions()).count("undecided") == left:
            if time.monotonic() > end:
                self.day.blame(f"{clip}: a decision was not taken")
                return False
            time.sleep(0.02)
        if sum(a != b for a, b in zip(before, now, strict=True)) != 1:
            self.day.blame(f"{clip}: more than one interval changed")
        self.day.by_mouse += self.mouse
        self.day.by_keys += not self.mouse
        self.day.decided[clip] = now
        self.day.tell("decision", clip=clip, mouse=self.mouse, accepted=accept)
        return True

    def start_export(self) -> None:
        """Start the export, with the menu or with a shortcut."""
        if self.mouse:
            self.screen.click(self.program.ask("menu('File')"))
            self.program.until("entry('export_at_once') is not None")
            self.screen.click(self.program.ask("entry('export_at_once')"))
            self.day.clicks += 2
        else:
            self.screen.key("ctrl+shift+e")
            self.day.keys += 1

    def export(self) -> str:
        """Export the clip. Return the name of the clip that opens next, or '' if there is none."""
        last = self.clip
        self.start_export()
        end = time.monotonic() + 30.0
        following = ""
        while time.monotonic() < end:
            if (now := self.clip) not in ("", last):
                following = now
                break
            if "No other clip" in self.program.ask("window.bar.label.text()"):
                break
            time.sleep(0.05)
        else:
            self.day.blame(f"{last}: no other clip opened after its export")
        self.program.settle()
        self._look("export")
        self.day.exports += 1
        self.day.tell("export", clip=last, mouse=self.mouse, next=following)
        return following


def review(day: Day, screen: RealScreen, scratch: Path, folder: Path, clips: int) -> None:
    """Review the whole folder. After each kill, start the program again."""
    accidents = {"overwrite": clips // 4, "change": 5 * clips // 8}  # numbers of exports before
    kills = [clips // 5, clips // 2, 4 * clips // 5]
    expected = ""  # the clip that was open when the program was killed
    while True:
        words = () if day.kills == 3 and expected else (folder,)
        new = None if (scratch / "settings.json").exists() else _NAMED
        with watched(screen, scratch, *words, settings=new) as program:
            person = Person(screen, program, day, mouse=day.exports >= clips // 2)
            if expected:
                take_up(person, expected, with_folder=bool(words))
            program.until("window.document.data is not None", 60.0)
            program.settle()
            expected = ""
            while True:
                judged = 0
                while person.judge():
                    judged += 1
                    if kills and day.exports >= kills[0] and judged == 2:
                        break
                else:
                    person.mouse = day.exports >= clips // 2
                    if accidents.get("overwrite") == day.exports:
                        del accidents["overwrite"]
                        overwrite(person, folder)
                    if accidents.get("change") == day.exports:
                        del accidents["change"]
                        change(person, folder)
                    if person.export():
                        continue
                    return
                kills.pop(0)
                expected = person.clip
                program.kill()
                day.kills += 1
                day.tell("kill", clip=expected, decided=day.decided[expected])
                break


def take_up(person: Person, expected: str, *, with_folder: bool) -> None:
    """Restore the review after a kill, and check that the clip has all its decisions."""
    person.answer("Restore" if with_folder else "Open and restore")
    before = person.day.decided[expected]
    person.program.until("window.document.data is not None", 60.0)
    end = time.monotonic() + 10.0
    while (now := person.program.decisions()) != before and time.monotonic() < end:
        time.sleep(0.1)
    if person.clip != expected:
        person.day.blame(f"{person.clip} is open where {expected} was")
    elif now != before:
        person.day.blame(f"{expected}: decisions were lost: {before} → {now}")
    person.day.tell("restored", clip=person.clip, decided=now)
    if person.program.ask("window.document.interval_id") is None:
        if person.mouse:
            person.click("window.tools.widgetForAction(window.actions_by_id['next_interval'])")
        else:
            person.press("n")


def overwrite(person: Person, folder: Path) -> None:
    """Let another program write a file at the export's path. It must not be replaced silently."""
    clip = person.clip
    target = folder / f"{Path(clip).stem}_refined.bvh"
    target.write_text(_FOREIGN)
    person.start_export()
    person.program.until("type(QApplication.activeModalWidget()).__name__ == 'ExportDialog'")
    if person.program.ask("QApplication.activeModalWidget().do_it.isEnabled()"):
        person.day.blame(f"{target.name}: may be replaced without a question")
    person.screen.key("Escape")
    person.program.until("QApplication.activeModalWidget() is None")
    if target.read_text() != _FOREIGN:
        person.day.blame(f"{target.name}: the other program's file was lost")
    target.unlink()
    person.day.tell("overwrite", clip=clip)


def change(person: Person, folder: Path) -> None:
    """Let another program change the clip. Its decisions must still apply afterwards."""
    clip, before = person.clip, person.program.decisions()
    path = folder / clip
    path.write_bytes(path.read_bytes() + b"\n")
    person.press("ctrl+s", counts=False)  # checks the file
    person.answer("Open the new version")
    person.answer("Carry over decisions")
    end = time.monotonic() + 10.0
    while (now := person.program.decisions()) != before and time.monotonic() < end:
        time.sleep(0.1)
    if now != before:
        person.day.blame(f"{clip}: not carried over: {before} → {now}")
    person.day.tell("change", clip=clip, decided=now)


def kept(folder: Path, day: Day) -> int:
    """Return the number of decisions in the sessions on disk. Record missing ones as failures."""
    count = 0
    for clip, decisions in day.decided.items():
        session = json.loads((folder / f"{Path(clip).stem}.twist.json").read_text())
        found = [i["decision"] for i in session["intervals"]]
        count += len(found)
        if found != decisions:
            day.blame(f"{clip}: {decisions} were decided, {found} is in the session")
    return count


def main() -> int:
    """Simulate the day and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--log", type=Path)
    looks = {str(look): look for look in LOOKS}
    parser.add_argument("--look", choices=looks, default=str(LOOKS[0]))
    arguments = parser.parse_args()
    with contextlib.ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        log = stack.enter_context((arguments.log or scratch / "log.jsonl").open("w"))
        folder = scratch / "clips"
        folder.mkdir()
        sources = clip_paths_in_folder(arguments.folder, suffixes=BVH)[: arguments.clips]
        for source in sources:
            with_errors(source, folder / source.name)
        day = Day(log, random.Random(arguments.seed))
        screen = stack.enter_context(real_screen(scratch, size=_SIZE, look=looks[arguments.look]))
        review(day, screen, scratch, folder, len(sources))
        held = kept(folder, day)
        day.tell("end")
    print(f"clips exported        {day.exports} of {len(sources)}")
    print(f"decisions             {day.by_keys} by keys, {day.by_mouse} by the mouse; {held} kept")
    print(f"a decision            {day.keys / max(day.by_keys, 1):.2f} keys")
    print(f"                      {day.clicks / max(day.by_mouse, 1):.2f} clicks")
    print(f"kills                 {day.kills}")
    print(f"went wrong            {len(day.wrong)}")
    for what in day.wrong:
        print(f"  {what}")
    return 1 if day.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
