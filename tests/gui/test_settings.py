"""Settings: whatever the file holds, the program starts, and what is good in it is kept."""

import json
import math
import os
import shutil
import stat
import subprocess
from copy import deepcopy
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inspector.folder.remembered_folders import (
    FOLDERS,
    NEXT_AFTER_EXPORT,
    folder_record,
    remember_folder,
)
from inspector.session.settings import (
    CHECKS,
    RECENT,
    STEPS,
    FeatureSetting,
    Settings,
    checks_by_name,
    load_settings,
    save_changes,
    save_settings,
    settings_from_json,
)
from inspector.tuning.wishes import DRAWS, POINTS, SMALLEST
from inspector.video.remembered_videos import FARTHEST_S, MOST_VIDEOS, VIDEOS, remember_video
from tests.conftest import ASSETS
from tests.gui import forked
from tests.messages import names_in_one_line

DEEP = "[" * 100_000 + "]" * 100_000
DAMAGED = {  # what is written for a field, what is left of it
    "group_errors": [("1", True), ("null", True)],
    "skin": [("1", True), ("null", True)],
    "side_by_side": [("0", True), ('"x"', True)],
    "looks_by_kind": [('{"jump": ["skin", "red"], "stretch": "skin"}', {}), ("[1]", {})],
    "theme": [('"pink"', "system"), ("null", "system"), ("3", "system")],
    "recent": [
        (json.dumps(["/a", *["/b"] * 100_000]), ["/a", *["/b"] * (RECENT - 1)]),
        ('["/a", 5, "", "/nul\\u0000", "/b"]', ["/a", "/b"]),
        ('"/a"', []),
    ],
    "reviewer": [('"\\udcfc"', ""), (json.dumps("x" * 5000), ""), ("true", "")],
    "geometry": [('"zz"', ""), ('"abc"', ""), ('"ü"', ""), ('"00ff-"', "")],
    "layout": [(json.dumps("00" * 1_000_000), ""), ("[]", "")],
    "first_frame": [("2", 0), ("true", 0), ("1.0", 0)],
    "step": [("0", 10), ("9" * 5000, 10), ("-" + "9" * 5000, 10), ("true", 10)],
    "keys": [
        ('{"accept": 5}', {}),
        ('{"accept": ["A"], "reject": [5], "undo": "U"}', {"accept": ["A"]}),
        ("[1]", {}),
    ],
    "zoom_to_interval": [("1", True), ('"no"', True)],
    "order": [('"start"', "chain"), ("1", "chain")],
    "reviewer_asked": [("1", False), ("null", False)],
    "columns": [('["delta", 5, "note"]', ["delta", "note"]), ('"delta"', []), ("{}", [])],
    "interval_sort": [("5", ""), (json.dumps("x" * 5000), "")],
    "alarm_points": [("-1", 5.0), ("NaN", 5.0), ("101", 5.0), ("true", 5.0)],
    "smallest_error": [("0", 2.0), ("181", 2.0), ('"2"', 2.0)],
    "error_draws": [("0", 3), ("2.5", 3), ("9" * 5000, 3)],
    "language": [("5", "system"), (json.dumps("d" * 30), "system")],
    "turn_ms": [("1e15", 220), ("NaN", 220), ("Infinity", 220), ("-1", 220), ("1e999", 220)],
    "look_ms": [("-1", 0), ("1e15", 0)],  # 0 in tests
    "folders": [
        (
            '{"/a": {"clip": "", "profile": "", "method": "", "tau": {"x": NaN}}, "/b": 1}',
            {"/a": {"clip": "", "profile": "", "method": "", "tau": {}}},
        ),
        ('{"/a": {"clip": "a.bvh"}, "": {}}', {}),
        ("[]", {}),
    ],
    "autosave": [("1", True), ('"no"', True)],
    "next_after_export": [("null", True)],
    "record_format": [('".avi"', ".mp4"), ("5", ".mp4")],
    "videos": [
        ('{"/a": ["/v", 1e9], "/b": ["/v", 2]}', {"/b": ("/v", 2.0)}),
        ('{"/a": ["/v", NaN], "/b": ["/v"], "": ["/v", 1], "/c": 3}', {}),
        ('{"/a": ["/v", true]}', {}),
        ("7", {}),
    ],
}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "settings.json"


@pytest.mark.parametrize(
    ("name", "written", "left"),
    [(name, *case) for name, cases in DAMAGED.items() for case in cases],
    ids=lambda value: str(value)[:20],
)
def test_a_damaged_field_takes_no_other_with_it(path, name, written, left):
    good = {"theme": '"dark"', "recent": '["/clip"]', "step": "7", "newer": '{"a": null}'}
    fields = {**good, name: written}
    path.write_text("{" + ", ".join(f'"{k}": {v}' for k, v in fields.items()) + "}", "utf-8")
    before = path.read_bytes()
    settings, said = load_settings(path)
    wanted = Settings(theme="dark", recent=["/clip"], step=7, of_others={"newer": {"a": None}})
    wanted.put(name, left)
    assert settings == wanted
    assert names_in_one_line(said, f" {name} ", f"{path}.damaged")
    assert (path.parent / "settings.json.damaged").read_bytes() == before
    assert save_settings(path, settings) == ""
    assert load_settings(path) == (settings, "")


def test_every_field_has_its_bounds_and_a_default_within():
    kept = asdict(Settings())
    del kept["of_others"], kept["of_features"]
    assert kept.keys() == CHECKS.keys()
    every = checks_by_name()
    assert every.keys() == DAMAGED.keys()
    defaults = {name: Settings().value(name) for name in every}
    assert {name: check(defaults[name]) for name, check in every.items()} == defaults


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{",
        b"[]",
        b"null",
        b"\xff\xfe{\x00}\x00",
        DEEP.encode(),
        b'{"keys": ' + DEEP.encode() + b"}",
        b"\x00" * 100,
    ],
    ids=range(8),
)
def test_a_file_that_is_no_object_is_all_defaults(path, data):
    path.write_bytes(data)
    settings, said = load_settings(path)
    assert settings == Settings()
    assert names_in_one_line(said, f"{path}.damaged")


def test_nothing_set_aside_is_overwritten(path):
    for k, data in enumerate((b"1", b"2", b"1", b"3")):
        path.write_bytes(data)
        said = load_settings(path)[1]
        name = ("", "-2", "", "-3")[k]
        assert said.rstrip(".").endswith(f"settings.json.damaged{name}")
    kept = sorted(p.name for p in path.parent.iterdir())
    assert kept == [f"settings.json{end}" for end in ("", ".damaged", ".damaged-2", ".damaged-3")]
    assert (path.parent / "settings.json.damaged").read_bytes() == b"1"


def test_a_byte_order_mark_and_bytes_that_are_not_utf8_in_a_path_are_no_damage(path):
    path.write_bytes(b'\xef\xbb\xbf{"recent": ["/m\xfcller.bvh"]}')
    settings, said = load_settings(path)
    assert (settings.recent, said) == (["/m\udcfcller.bvh"], "")


def test_a_path_that_is_not_utf8_is_kept(path, tmp_path):
    settings = Settings()
    settings.remember(tmp_path / "m\udcfcller.bvh")
    remember_video(settings, "/m\udcfc", Path("/v\udc80"), 1.5)
    assert save_settings(path, settings) == ""
    assert path.read_bytes().isascii()
    assert load_settings(path) == (settings, "")


def test_what_cannot_be_read_is_a_sentence_and_is_not_written_over(path):
    path.mkdir()
    settings, said = load_settings(path)
    assert settings == Settings()
    assert names_in_one_line(said, str(path))
    assert save_settings(path, settings)
    assert path.is_dir()
    inside = path / "x" / "settings.json"
    (path / "x").write_text("a file in the way")
    assert load_settings(inside)[1]
    assert save_settings(inside, settings)


def test_an_unreadable_file_stays(path, monkeypatch):
    path.write_text('{"theme": "dark"}')
    monkeypatch.setattr("os.access", lambda *_: False)  # root could read all
    assert "Permission denied" in load_settings(path)[1]
    assert save_settings(path, Settings())
    assert json.loads(path.read_text()) == {"theme": "dark"}


@pytest.mark.skipif(os.name != "posix", reason="no FIFOs")
def test_a_fifo_does_not_hang(path):
    os.mkfifo(path)
    settings, said = load_settings(path)
    assert settings == Settings()
    assert said
    assert save_settings(path, settings)
    assert stat.S_ISFIFO(path.stat().st_mode)


def test_a_folder_in_which_nothing_can_be_set_aside(path, monkeypatch):
    path.write_text('{"theme": "pink"}')

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("inspector.session.settings.write_atomically", full)
    data = path.stat()
    settings, said = load_settings(path)
    assert settings == Settings()
    assert "No space left on device" in said
    assert path.stat() == data


def test_a_layout_with_one_wrong_digit_never_reaches_qt(path):
    """With such bytes QMainWindow.restoreState may crash: it did in a trial."""
    layout = bytes(range(256)).hex()
    save_settings(path, Settings(layout=layout, geometry="00ff"))
    text = path.read_text()
    assert load_settings(path) == (Settings(layout=layout, geometry="00ff"), "")
    path.write_text(text.replace("7f80", "7f81"))
    settings, said = load_settings(path)
    assert (settings, " layout " in said) == (Settings(geometry="00ff"), True)
    path.write_text(json.dumps({"layout": layout}))  # an earlier version's
    assert load_settings(path) == (Settings(layout=layout), "")


def test_a_link_to_the_settings_stays(path):
    real = path.with_name("real.json")
    path.symlink_to("real.json")
    assert save_settings(path, Settings(theme="dark")) == ""
    assert path.is_symlink()
    assert json.loads(real.read_text())["theme"] == "dark"


def test_what_a_newer_version_keeps_survives(path):
    path.write_text('{"theme": "dark", "of_others": 1, "later": {"deep": [1, null, "x"]}}')
    settings, said = load_settings(path)
    assert said == ""
    save_settings(path, settings)
    document = json.loads(path.read_text())
    assert (document["later"], document["of_others"]) == ({"deep": [1, None, "x"]}, 1)
    path.write_text('{"theme": "dark", "later": ' + "[" * 100 + "]" * 100 + "}")
    settings, said = load_settings(path)
    assert settings == Settings(theme="dark")
    assert said


def test_what_the_window_remembers_is_within_the_bounds(path):
    settings = Settings()
    for k in range(MOST_VIDEOS + 5):
        settings.remember(Path(f"/{k}.bvh"))
        remember_video(settings, f"/{k}.bvh", Path("/v.mp4"), 1e12 if k % 2 else -1e12)
    assert save_settings(path, settings) == ""
    assert load_settings(path) == (settings, "")


texts = st.text(st.characters(exclude_categories=()), max_size=20)  # halves of pairs, too
leaves = st.none() | st.booleans() | st.integers() | st.floats() | texts
anything = st.recursive(
    leaves, lambda inner: st.lists(inner) | st.dictionaries(texts, inner), max_leaves=20
)
near = (
    anything
    | st.sampled_from(["light", "00ff", [], {}])
    | st.dictionaries(texts, st.lists(texts, max_size=3), max_size=3)
    | st.dictionaries(texts, st.tuples(texts, st.floats(-1e5, 1e5) | st.integers()), max_size=3)
)


@given(st.dictionaries(st.sampled_from(list(checks_by_name())) | texts, near, max_size=8))
def test_any_json_gives_settings_within_bounds_that_come_back(document):
    settings, damaged = settings_from_json(json.dumps(document).encode("ascii"))
    assert settings.theme in ("system", "light", "dark")
    assert settings.first_frame in (0, 1)
    assert STEPS[0] <= settings.step <= STEPS[1]
    assert 0 <= settings.turn_ms <= 10_000
    assert type(settings.step) is type(settings.turn_ms) is int
    assert len(settings.recent) <= RECENT
    assert all(abs(offset) <= FARTHEST_S for _, offset in VIDEOS.of(settings).values())
    for name in [
        *settings.recent,
        *VIDEOS.of(settings),
        *(v for v, _ in VIDEOS.of(settings).values()),
    ]:
        assert os.fsencode(name)
        assert "\0" not in name
    assert all(isinstance(k, str) for keys in settings.keys.values() for k in keys)
    assert all(v == v and v != math.inf for v in settings.of_others.values())
    kept = asdict(settings)
    written = {**kept.pop("of_others"), **kept.pop("of_features"), **kept}
    again = settings_from_json(json.dumps(written).encode("ascii"))
    assert again == (settings, ())
    assert set(damaged) <= {*checks_by_name(), "unknown to this version"}


@given(st.binary(max_size=200))
def test_any_bytes_give_settings(data):
    settings, damaged = settings_from_json(data)
    assert settings.of_others or settings == Settings() or damaged == ()


@pytest.mark.thorough
@pytest.mark.parametrize("damage", ["field", "deep", "fifo"])
def test_the_program_starts(tmp_path, damage):
    path, picture = tmp_path / "settings.json", tmp_path / "window.png"
    if damage == "fifo":
        if os.name != "posix":
            pytest.skip("no FIFOs")
        os.mkfifo(path)
    elif damage == "field":
        bad = {name: json.loads(cases[0][0]) for name, cases in DAMAGED.items()}
        path.write_text(json.dumps({**bad, "theme": "dark"}))
    else:
        path.write_text(DEEP)
    clip = Path(shutil.copy(ASSETS / "walk.bvh", tmp_path))
    words = ["-m", "inspector", clip, "--screenshot", picture]
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "TWIST_INSPECTOR_SETTINGS": str(path),
    }
    code, said = forked.run(words, environment, errors=subprocess.STDOUT)
    assert (code, "Traceback" in said) == (0, False), said
    assert "settings" in said
    assert picture.stat().st_size > 10_000
    if damage == "fifo":
        assert path.is_fifo()
    else:
        settings, said = load_settings(path)
        assert said == ""
        assert settings.theme == ("dark" if damage == "field" else "system")
        assert settings.layout
        assert (tmp_path / "settings.json.damaged").exists()


def test_two_programs_keep_each_others_settings(path):
    """Each writes what it changed; the other's stays, in lists and objects entry by entry."""
    before = Settings(theme="dark", recent=["/a", "/b"], keys={"accept": ["A"]}, step=7)
    save_settings(path, before)
    one, two = deepcopy(before), deepcopy(before)
    one.remember(Path("/one"))
    one.step = 20
    remember_folder(one, Path("/takes"), clip="1.bvh")
    two.remember(Path("/b"))
    two.keys["reject"] = ["X"]
    remember_folder(two, Path("/takes2"), clip="2.bvh")
    assert save_changes(path, one, before) == ""
    assert save_changes(path, two, before) == ""
    now, _ = load_settings(path)
    assert (now.theme, now.step) == ("dark", 20)
    assert now.recent == ["/b", "/one", "/a"]
    assert now.keys == {"accept": ["A"], "reject": ["X"]}
    assert [folder_record(now, Path(f))["clip"] for f in ("/takes", "/takes2")] == [
        "1.bvh",
        "2.bvh",
    ]
    del two.keys["accept"]
    changed = deepcopy(two)
    two.keys["accept"] = ["A"]
    assert save_changes(path, changed, two) == ""
    assert load_settings(path)[0].keys == {"reject": ["X"]}


@pytest.mark.parametrize("known", [False, True])
def test_two_programs_in_one_folder_keep_each_other_s_record_of_it(path, known):
    """Where one stopped and its τ, each by itself; a profile's name never with another one's τ."""
    folder, before = Path("/takes"), Settings()
    if known:
        remember_folder(before, folder, clip="0.bvh", profile="old", method="paper", tau={"A": 1.0})
    save_settings(path, before)
    one, two = deepcopy(before), deepcopy(before)
    remember_folder(one, folder, profile="own", method="paper", tau={"A": 2.0})
    remember_folder(two, folder, clip="2.bvh")
    assert save_changes(path, one, before) == ""
    assert save_changes(path, two, before) == ""
    taken = {"clip": "2.bvh", "profile": "own", "method": "paper", "tau": {"A": 2.0}}
    assert folder_record(load_settings(path)[0], folder) == taken
    since, third = deepcopy(two), deepcopy(two)
    remember_folder(third, folder, profile="other", method="paper", tau={"B": 0.5})
    remember_folder(two, folder, clip="3.bvh")
    assert save_changes(path, third, since) == ""
    assert save_changes(path, two, since) == ""
    taken = {"clip": "3.bvh", "profile": "other", "method": "paper", "tau": {"B": 0.5}}
    assert folder_record(load_settings(path)[0], folder) == taken
    gone = deepcopy(one)
    FOLDERS.put(gone, {})
    assert save_changes(path, gone, one) == ""
    assert FOLDERS.of(load_settings(path)[0]) == {}


def test_what_was_damaged_meanwhile_is_written_anew(path):
    path.write_text("{")
    before = Settings(theme="dark")
    assert save_changes(path, replace(before, step=5), before) == ""
    assert load_settings(path) == (Settings(theme="dark", step=5), "")


def test_what_changes_in_the_window_is_soon_on_disk(qtbot, show_window, path):
    window = show_window(Settings(turn_ms=0), path)
    qtbot.waitUntil(lambda: path.exists() and load_settings(path)[0].layout != "", timeout=3000)
    before = load_settings(path)[0]
    window.docks["curves"].hide()
    window.settings.step = 33
    qtbot.waitUntil(lambda: load_settings(path)[0].step == 33)
    now = load_settings(path)[0]
    assert now.layout != before.layout
    other = replace(now, theme="dark")
    save_settings(path, other)  # another program's
    window.settings.first_frame = 1
    qtbot.waitUntil(lambda: load_settings(path)[0].first_frame == 1)
    assert load_settings(path)[0] == replace(other, first_frame=1)


@pytest.mark.parametrize("name", ["x" * 2000, "half \ud800"])
def test_what_no_file_can_hold_is_left_out(tmp_path, name):
    """Nothing is raised, at every look: the rest is written."""
    path = tmp_path / "settings.json"
    assert save_changes(path, Settings(reviewer=name, step=20), Settings()) == ""
    assert load_settings(path) == (Settings(step=20), "")


def test_a_setting_of_a_feature_is_in_the_file_from_the_start(path):
    """As when all settings were fields: the file has each by its name, with its default."""
    save_settings(path, Settings())
    document = json.loads(path.read_text())
    assert document.keys() == checks_by_name().keys()
    for setting in (NEXT_AFTER_EXPORT, FOLDERS, VIDEOS, POINTS, SMALLEST, DRAWS):
        assert document[setting.name] == setting.default == setting.of(Settings())
    path.write_text(json.dumps(document | {"error_draws": 7}))
    settings, said = load_settings(path)
    assert (DRAWS.of(settings), POINTS.of(settings), said) == (7, 5.0, "")


def test_two_settings_of_a_name_are_refused():
    for name in ("theme", "videos"):
        with pytest.raises(ValueError, match=name):
            FeatureSetting(name, 0, CHECKS["step"])
