"""A day at the window in small: keys, mouse, kills, another program's files; nothing is lost."""

import sys

import pytest

from benchmarks.day_at_the_window import main
from tests.conftest import ASSETS
from tests.gui.real_screen import needs_real_screen

pytestmark = pytest.mark.thorough


@needs_real_screen
def test_a_folder_by_keys_and_by_mouse_through_three_kills(tmp_path, look, monkeypatch, capsys):
    log = tmp_path / "log.jsonl"
    words = ["day", str(ASSETS), "--clips", "5", "--log", str(log), "--look", str(look)]
    monkeypatch.setattr(sys, "argv", words)
    wrong = main()
    told = capsys.readouterr().out
    assert not wrong, told
    assert "5 of 5" in told
    events = log.read_text()
    for event in ("kill", "restored", "overwrite", "change"):
        assert f'"event": "{event}"' in events
