"""In another language a person reads other words; what is kept and compared stays the same."""

import subprocess
import sys

import pytest

from twistcore.detection import Kind

# A process of its own: texts are made in the language that was chosen before.
GERMAN = """
from pathlib import Path
from PySide6.QtWidgets import QApplication
from inspector.language import use_language

use_language("de")
app = QApplication(["tested", "-platform", "offscreen"])
from inspector.folder.clip_table import clip_table
from inspector.folder.queued_clip import FAR_AWAY, ClipState, QueuedClip, reason_text
from inspector.panels.interval_filter import FilterLine
from inspector.panels.reason_palette import ReasonPalette
from inspector.panels.reject_reasons import REASONS
from inspector.panels.reject_reasons import reject_reason_in_english, translate_reject_reason
from PySide6.QtWidgets import QWidget
"""


def said_in_german(script):
    run = subprocess.run(
        [sys.executable, "-c", GERMAN + script], capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


def test_filters_ask_for_the_same_in_german():
    said = said_in_german(
        "line = FilterLine()\n"
        "before = line.list_all()\n"
        "for k in range(line.choice.count()):\n"
        "    line.choice.setCurrentIndex(k)\n"
        "    print(line.current.chosen, line.choice.currentText(), sep='|')\n"
        "line.confidence.setCurrentIndex(1)\n"
        "back = line.list_all()\n"
        "print(line.current.chosen, line.current.bounds)\n"
        "back()\n"
        "print(line.current.chosen, line.current.bounds)\n"
    )
    choices = ["All", "Undecided", "Accepted", "Rejected", "This chain"]
    choices += [kind.info.label for kind in Kind]
    assert [line.split("|")[0] for line in said[: len(choices)]] == choices
    assert said[1].split("|")[1] == "Offen"
    assert said[len(choices) :] == ["All ()", "Frozen frames (('≥', 0.95),)"]


@pytest.mark.thorough
def test_a_reason_is_read_in_german_and_kept_in_english():
    said = said_in_german(
        "for reason in REASONS:\n"
        "    print(translate_reject_reason(reason) != reason, "
        "reject_reason_in_english(translate_reject_reason(reason)) == reason)\n"
        "print(translate_reject_reason('loose strap'), reject_reason_in_english('loose strap'))\n"
        "window = QWidget()\n"
        "palette = ReasonPalette(REASONS, '', window)\n"
        "palette.chosen.connect(print)\n"
        "print(palette.list.item(0).text())\n"
        "palette._take(0)\n"
        "palette.line.setText('schnell, aber echt')\n"
        "palette._take_line()\n"
    )
    assert set(said[:4]) == {"True True"}
    assert said[4:] == [
        "loose strap loose strap", "natürliche Bewegung", "natural motion", "fast but real",
    ]  # fmt: skip


@pytest.mark.thorough
def test_the_table_of_clips_has_its_reasons_in_english():
    said = said_in_german(
        "clip = QueuedClip(Path('a.bvh'), ClipState.FAILED, reason='s3://a.bvh: ' + FAR_AWAY)\n"
        "print(reason_text(clip))\n"
        "print(clip_table([clip]))\n"
    )
    assert said[0].startswith("s3://a.bvh: der Clip liegt nicht auf diesem Rechner")
    assert said[2]
    assert "failed" in said[2]
