"""A folder reviewed as a person does it: mouse and keys on a real screen, exports, a crash."""

import json
import shutil

import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import needs_real_screen, real_screen, wait_until, watched
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import clip_random_generator, draw_errors, inject

pytestmark = pytest.mark.thorough

TEXTS = (  # of the clips' list: what each row says, by the clip's name
    "(lambda m: {m.index(k, 0).data(): [str(m.index(k, c).data() or '') "
    "for c in range(2, m.columnCount())] for k in range(m.rowCount())})"
    "(window.clips.table.model())"
)
NO_BOX = "QApplication.activeModalWidget() is None"
NAME = "window.document.data.clip.path.name"


def put_errors(path, chains_hit):
    clip = read_bvh(ASSETS / "walk.bvh")
    chains = find_chains(clip.motion)
    errors = draw_errors(clip.motion, chains[:chains_hit], clip_random_generator(1, path.name))
    dirty = inject(clip.motion, chains, errors)
    path.write_bytes(create_file_patch_for_motion(clip, dirty).data)


@pytest.fixture
def takes(tmp_path):
    """A folder with a bad clip, a worse one, a clean one, one without chains, and an export."""
    folder = tmp_path / "takes"
    folder.mkdir()
    put_errors(folder / "a_bad.bvh", 2)
    put_errors(folder / "b_worse.bvh", 6)
    shutil.copy(ASSETS / "walk.bvh", folder / "c_clean.bvh")
    shutil.copy(ASSETS / "walk.bvh", folder / "c_clean_refined.bvh")
    (folder / "d_ball.bvh").write_text(
        "HIERARCHY\nROOT Ball\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 100\nFrame Time: 0.01\n" + "0 0 0\n" * 100
    )
    return folder


def kept(folder):
    """The file of settings as it is now."""
    try:
        return json.loads((folder / "settings.json").read_text())
    except (OSError, ValueError):
        return {}


@needs_real_screen
def test_a_folder_from_its_worst_clip_to_the_next(tmp_path, takes, look):
    """Opened, counted, exported, gone on with, gone back, and no box in the way."""
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, takes, settings={"reviewer": "Kim", "group_errors": False}) as p,
    ):
        p.until("window.document.data is not None")
        p.until("not window.queue.running")
        p.settle()
        if p.ask(NAME) != "b_worse.bvh":  # of those that a busy machine knew in four seconds
            screen.key("ctrl+n")
            p.until(f"{NAME} == 'b_worse.bvh'")
        texts = p.ask(TEXTS)
        assert sorted(texts) == ["a_bad", "b_worse", "c_clean", "d_ball"]
        assert (texts["c_clean"][0], texts["d_ball"][0]) == ("clean", "not checked")
        assert p.ask("window.clips.table.viewport().height()") >= 8 * p.ask(
            "window.clips.table.rowHeight(0)"
        )
        # The open clip's row follows the review.
        count = len(p.decisions())
        screen.key("n")
        for number in range(1, count + 1):  # each once its picture is there
            p.settle()
            screen.key("a")
            p.until(f"{TEXTS}['b_worse'][0] == '{number} / {count}'")
        p.until(f"{TEXTS}['b_worse'][0] == '{count} / {count}'")
        # The export: session with it, the next clip by itself, and the way back.
        screen.key("ctrl+e")
        screen.shown("Export")
        screen.key("Return")
        p.until(f"{NAME} == 'a_bad.bvh'")
        p.settle()
        assert p.ask(NO_BOX)
        status = p.ask("window.bar.label.text()")
        assert "b_worse_refined.bvh" in status
        assert "a_bad.bvh" in status
        assert (takes / "b_worse_refined.report.html").exists()
        session = json.loads((takes / "b_worse.twist.json").read_text())
        assert {i["decision"] for i in session["intervals"]} == {"accepted"}
        p.until(f"{TEXTS}['b_worse'][1] == '✓'")
        assert sorted(p.ask(TEXTS)) == ["a_bad", "b_worse", "c_clean", "d_ball"]
        status = p.ask("window.clips.status.text()")
        assert status.startswith("1 of 2 clips")
        assert status.endswith(" intervals decided; 1 clean; 1 not checked")
        # Leaving a clip half way saves it; nothing modal.
        p.press("n", "a", "ctrl+shift+n")
        p.until(f"{NAME} == 'b_worse.bvh'")
        assert p.ask(NO_BOX)
        assert (takes / "a_bad.twist.json").exists()
        # The dialog says by name what it replaces, and that it is the program's own.
        screen.key("ctrl+e")
        screen.shown("Export")
        p.settle()
        listed = p.ask("app.activeWindow().replaces.text().splitlines()")
        assert len(listed) == 6
        assert all(name.startswith("b_worse_refined.") for name in listed)
        assert all("written by this program" in name for name in listed)
        screen.key("Escape")
        wait_until(lambda: p.ask(NO_BOX))
        # By mouse: filter, then a double click.
        screen.click(p.rect("window.clips.text"))
        screen.type("a_b")
        p.until("window.clips.table.model().rowCount() == 1")
        screen.click(p.ask("row(window.clips.table, 0)"), times=2)
        p.until(f"{NAME} == 'a_bad.bvh'")
        wait_until(lambda: kept(tmp_path)["folders"][str(takes)]["clip"] == "a_bad.bvh")


@needs_real_screen
def test_after_a_crash_the_program_offers_what_was_not_saved(tmp_path, takes, look):
    """Started with nothing: it names the clip, counts the decisions, and goes on in the folder."""
    with real_screen(tmp_path, look=look) as screen:
        with watched(
            screen, tmp_path, takes, settings={"reviewer": "Kim", "group_errors": False}
        ) as p:
            p.until("window.document.data is not None")
            p.settle()
            name = p.ask(NAME)
            count = len(p.decisions())
            p.press("n", "a", "r", "a")
            p.until(
                "sum(d != 'undecided' for d in [j.decision.value for j in "
                "window.document.intervals]) == 3"
            )
            judged = p.decisions()
            wait_until(lambda: kept(tmp_path).get("recent") == [str(takes / name)])
            p.kill()
        with watched(screen, tmp_path) as p:
            p.until("window.bar.isVisible()")
            told = p.ask("window.bar.label.text()")
            assert name in told
            assert "3 decisions" in told
            screen.click(p.rect("window.bar.buttons()[0]"))
            p.until("window.document.data is not None")
            p.until(f"window.queue.folder is not None and {NAME} == {name!r}")
            wait_until(lambda: p.decisions() == judged)
            assert len(judged) == count
            p.until("not window.bar.asks")
