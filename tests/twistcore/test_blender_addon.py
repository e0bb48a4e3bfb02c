"""The add-on for Blender: with a stand-in for bpy, and in Blender on a scene of two figures."""

import importlib.util
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.blender import blender, needs_blender
from tests.twistcore.reviews import CLIP, fresh
from twistcore.cli.parser import make_parser
from twistcore.formats.reading import companion_file_prefix
from twistcore.review import write_session

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "packaging" / "blender" / "twist_inspector_addon.py"
ODD = ("Armature|walk.001", "-läuft/2", "take.bvh", "a.b", "c")


def program(path, *lines):
    """A program in Python that can import this project."""
    start = f"#!{sys.executable}\nimport sys, time\nfrom pathlib import Path\n"
    path.write_text(start + f"sys.path.insert(0, {str(ROOT)!r})\n" + "\n".join(lines) + "\n")
    path.chmod(0o755)
    return path


def real_twistcore(folder):
    return program(folder / "twistcore", "from twistcore.cli import main", "sys.exit(main())")


class Blender:
    """What the add-on asks of bpy and of the context."""

    def __init__(self, blend):
        self.reports, self.timers, self.saved, self.popup = [], [], [], []
        action = SimpleNamespace(name="walk", frame_range=(11.0, 354.0))
        data = SimpleNamespace(action=action)
        rig = SimpleNamespace(name="Hero", type="ARMATURE", animation_data=data)
        self.objects = SimpleNamespace(active=rig)
        self.paths = SimpleNamespace(twistcore="no-twistcore", inspector="no-inspector")
        self.addons = {"addon": SimpleNamespace(preferences=self.paths)}
        manager = SimpleNamespace(
            event_timer_add=self._tick,
            event_timer_remove=self.timers.remove,
            modal_handler_add=lambda _operator: None,
            popup_menu=self._popup,
        )
        self.context = SimpleNamespace(
            view_layer=SimpleNamespace(objects=self.objects),
            scene=SimpleNamespace(render=SimpleNamespace(fps=120, fps_base=1.0)),
            preferences=SimpleNamespace(addons=self.addons),
            window_manager=manager,
            window=None,
        )
        operator = type("Operator", (), {"report": lambda _, k, t: self.reports.append((*k, t))})
        self.bpy = SimpleNamespace(
            types=SimpleNamespace(Operator=operator, Panel=object, AddonPreferences=object),
            props=SimpleNamespace(BoolProperty=dict, StringProperty=dict),
            utils=SimpleNamespace(register_classes_factory=lambda _: (None, None)),
            path=SimpleNamespace(abspath=str),
            data=SimpleNamespace(filepath=str(blend)),
            app=SimpleNamespace(background=False, binary_path="/opt/blender"),
            ops=SimpleNamespace(wm=SimpleNamespace(save_as_mainfile=self._save)),
        )

    def _tick(self, seconds, window):
        self.timers.append(seconds)
        return seconds

    def _popup(self, draw, title):
        shown = SimpleNamespace(label=lambda text: self.popup.append(text))
        draw(SimpleNamespace(layout=shown), None)

    def _save(self, filepath, copy, check_existing):
        assert copy, "the person's own file is left as it is"
        Path(filepath).write_text("a copy")
        self.saved.append(filepath)


@pytest.fixture
def stand_in(monkeypatch, tmp_path):
    found = Blender(tmp_path / "two.blend")
    monkeypatch.setitem(sys.modules, "bpy", found.bpy)
    return found


@pytest.fixture
def addon(stand_in):
    spec = importlib.util.spec_from_file_location("addon", ADDON)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def decide(addon, stand_in, dry_run=True):
    operator = addon.TakeDecisions()
    operator.dry_run = dry_run
    return operator.execute(stand_in.context), stand_in.reports


def test_each_action_of_each_armature_has_a_clip_and_the_windows_session(addon):
    clips = {addon.clip_path("/x/take.bvh.blend", one, two) for one in ODD for two in ODD}
    assert len(clips) == len(ODD) ** 2
    assert len({addon.clip_path("/x/s.blend", *two) for two in (("a.b", "c"), ("a", "b.c"))}) == 2
    for clip in clips:
        assert clip.parent == Path("/x")
        assert addon.session_path(clip).name == companion_file_prefix(clip) + ".twist.json"


@pytest.mark.parametrize("name", ODD)
def test_the_commands_are_what_twistcore_understands(addon, name):
    take = addon.Take(name, name, Path("/x/c.bvh"), -5.5, 23.976)
    _, *words = addon.convert_command("twistcore", "/x/s.blend", take, "/opt/blender")
    found = make_parser(words).parse_args(words)
    assert (found.armature, found.take, found.blender) == (name, name, "/opt/blender")
    assert (found.scene, found.output) == (Path("/x/s.blend"), Path("/x/c.bvh"))
    for dry_run in (True, False):
        _, *words = addon.export_command("twistcore", take, Path("/x/k.py"), dry_run)
        found = make_parser(words).parse_args(words)
        assert (found.take, found.start, found.fps) == (name, -5.5, 23.976)
        assert (found.script, found.dry_run) == ("blender", dry_run)
        assert (found.session, found.clip) == (Path("/x/c.twist.json"), Path("/x/c.bvh"))


def no_armature(stand_in):
    stand_in.objects.active.type = "MESH"


def nothing_active(stand_in):
    stand_in.objects.active = None


def no_animation(stand_in):
    stand_in.objects.active.animation_data = None


def no_action(stand_in):
    stand_in.objects.active.animation_data.action = None


def no_file(stand_in):
    stand_in.bpy.data.filepath = ""


def nothing(stand_in):
    pass


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (no_armature, ("not an armature",)),
        (nothing_active, ("not an armature",)),
        (no_animation, ("Hero has no action",)),
        (no_action, ("Hero has no action",)),
        (no_file, ("Save the .blend",)),
        (nothing, ("no-", "not found", "preferences")),
    ],
)
def test_each_obstacle_is_one_sentence(addon, stand_in, change, words):
    change(stand_in)
    for operator in (addon.OpenTake(), addon.TakeDecisions()):
        operator.dry_run = True
        assert operator.execute(stand_in.context) == {"CANCELLED"}
        ((kind, text),) = stand_in.reports
        assert kind == "ERROR"
        assert all(word in text for word in words), text
        stand_in.reports.clear()


def test_decisions_need_a_clip_a_session_and_something_accepted(addon, stand_in, tmp_path):
    stand_in.paths.twistcore = str(real_twistcore(tmp_path))
    take = addon.active_take(stand_in.context)
    assert (take.start, take.fps) == (11.0, 120.0)
    assert decide(addon, stand_in)[1].pop()[1].startswith(f"There is no {take.clip.name}")
    take.clip.write_bytes(Path(CLIP.path).read_bytes())
    session = addon.session_path(take.clip)
    assert decide(addon, stand_in)[1].pop()[1].startswith(f"There is no {session.name}")
    write_session(CLIP, fresh().state, session)
    result, reports = decide(addon, stand_in)
    assert result == {"CANCELLED"}
    ((kind, text),) = reports
    assert kind == "ERROR"
    assert text.startswith(f"{session}: ")
    assert "accepted" in text


SCRIPT = """print("note: two")
print("one")
if {refused}:
    raise RuntimeError("c.bvh: another scene; nothing was keyed")"""


def test_a_dry_run_is_the_default(addon):
    assert addon.TakeDecisions.__annotations__["dry_run"]["default"] is True


@pytest.mark.parametrize("refused", [False, True])
def test_the_scripts_messages_are_reported(addon, stand_in, tmp_path, refused, capsys):
    """A script that is written with exit code 1 is run, too."""
    out = 'Path(sys.argv[sys.argv.index("-o") + 1])'
    stand_in.paths.twistcore = str(
        program(
            tmp_path / "twistcore",
            f"{out}.write_text({SCRIPT.format(refused=refused)!r})",
            f'print({out}, ": 1 interval; run it in Blender", sep="")',
            'print("positions are not keyed", flush=True)',
            "sys.exit(1)",
        )
    )
    take = addon.active_take(stand_in.context)
    for file in (take.clip, addon.session_path(take.clip)):
        file.touch()
    result, reports = decide(addon, stand_in)
    expected = [("WARNING", "positions are not keyed"), ("WARNING", "note: two"), ("INFO", "one")]
    expected += [("ERROR", "c.bvh: another scene; nothing was keyed")] * refused
    assert reports == expected
    assert result == ({"CANCELLED"} if refused else {"FINISHED"})
    assert capsys.readouterr().out == ""


def converting(tmp_path):
    """A twistcore that takes its time, for a copy that must still be there."""
    return program(
        tmp_path / "twistcore",
        "time.sleep(0.3)",
        'Path(sys.argv[sys.argv.index("-o") + 1]).write_text(Path(sys.argv[2]).read_text())',
        'print("31 joints")',
    )


def clicked(operator, stand_in):
    """Click a button and let the timer tick; the result, and how many steps it took."""
    tick, mouse = SimpleNamespace(type="TIMER"), SimpleNamespace(type="MOUSEMOVE")
    result, steps = operator.invoke(stand_in.context, mouse), 1
    if result == {"RUNNING_MODAL"}:  # on a busy machine, the program may have ended already
        assert stand_in.timers
        result = {"PASS_THROUGH"}
    while result == {"PASS_THROUGH"}:
        time.sleep(0.02)
        assert operator.modal(stand_in.context, mouse) == {"PASS_THROUGH"}
        result = operator.modal(stand_in.context, tick)
        steps += 1
    assert not stand_in.timers
    return result, steps


def test_blender_does_not_wait_and_a_clip_is_never_replaced(addon, stand_in, tmp_path):
    opened = tmp_path / "opened"
    stand_in.paths.twistcore = str(converting(tmp_path))
    stand_in.paths.inspector = str(
        program(tmp_path / "inspector", f"Path({str(opened)!r}).write_text(sys.argv[1])")
    )
    clip = addon.active_take(stand_in.context).clip
    result, steps = clicked(addon.OpenTake(), stand_in)
    assert result == {"FINISHED"}
    assert steps > 5
    assert clip.read_text() == "a copy"
    assert opened.read_text() == str(clip)
    assert [kind for kind, _ in stand_in.reports] == ["INFO", "INFO"]
    assert stand_in.popup == [text for _, text in stand_in.reports]
    assert not Path(stand_in.saved[0]).exists()
    clip.write_text("reviewed")
    assert clicked(addon.OpenTake(), stand_in)[0] == {"FINISHED"}
    assert clip.read_text() == "reviewed"
    assert "delete it" in stand_in.reports[2][1]


def test_a_program_that_fails_is_reported_by_its_last_line(addon, stand_in, tmp_path):
    fails = program(tmp_path / "fails", 'sys.exit("first\\nthere is no screen")')
    stand_in.paths.twistcore, stand_in.paths.inspector = str(fails), str(fails)
    assert clicked(addon.OpenTake(), stand_in)[0] == {"CANCELLED"}
    addon.active_take(stand_in.context).clip.touch()
    assert clicked(addon.OpenTake(), stand_in)[0] == {"CANCELLED"}
    errors = [text for kind, text in stand_in.reports if kind == "ERROR"]
    assert errors == ["there is no screen"] * 2


@needs_blender
def test_a_scene_of_two_figures_in_blender(tmp_path, monkeypatch):
    """The second figure, later in the scene, is reviewed and keyed; the first stays as it is."""
    monkeypatch.setenv("BLENDER_USER_SCRIPTS", str(tmp_path / "scripts"))
    clip = tmp_path / "two.walk_injected%2e001.walk_injected%2e001.bvh"
    session = clip.with_suffix(".twist.json")
    core = real_twistcore(tmp_path)
    refine = [str(core), "refine", str(clip), "-o", str(tmp_path / "r.bvh")]
    reviewer = program(  # the person in the window, who accepts everything
        tmp_path / "inspector",
        f"assert sys.argv[1:] == [{str(clip)!r}]",
        f"import subprocess; subprocess.run({[*refine, '--session', str(session)]!r}, check=True)",
    )
    paths = {"twistcore": str(core), "inspector": str(reviewer)}
    first, second = "walk_injected", "walk_injected.001"
    frames = CLIP.motion.frames
    out = blender(
        tmp_path,
        ["empty"],
        ["bvh", ASSETS / "walk_injected.bvh"],
        ["bvh", ASSETS / "walk_injected.bvh", "QUATERNION", 0.01, 21],
        ["save", tmp_path / "two.blend"],
        ["addon", ADDON, paths],
        ["click", "take_decisions"],
        ["click", "open_take"],
        ["wait", session],
        ["look", tmp_path / "0.npz", frames, 21],
        ["click", "take_decisions"],
        ["look", tmp_path / "1.npz", frames, 21],
        ["activate", first],
        ["look", tmp_path / "2.npz", frames],
        ["click", "take_decisions"],
        ["activate", second],
        ["click", "take_decisions", {"dry_run": False}],
        ["look", tmp_path / "3.npz", frames, 21],
        ["click", "take_decisions", {"dry_run": False}],
        ["activate", first],
        ["look", tmp_path / "4.npz", frames],
    )
    poses = [np.load(tmp_path / f"{k}.npz")["poses"] for k in range(5)]
    assert f"There is no {clip.name}: click Open in Twist Inspector" in out
    assert "There is no two.walk_injected.walk_injected.bvh" in out
    assert f"{clip.name} was opened" in out
    assert "dry run: 152 keys would be set" in out
    assert "152 keys were set" in out
    assert "152 keys are already correct" in out
    assert np.array_equal(poses[0], poses[1])
    assert np.array_equal(poses[2], poses[4])
    assert np.abs(poses[3] - poses[0])[..., :3, :3].max() > 1.0
    assert np.abs(poses[3] - poses[0])[..., :3, 3].max() < 1e-6 * CLIP.motion.skeleton.height
