"""The one table of actions: menus, toolbar and help are made from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget


@dataclass(frozen=True)
class ActionSpec:
    """One thing a person can do.

    id: also the name of the window's method that does it (without argument; a checkable one gets
    the new state); group: actions of which exactly one is checked.
    """

    id: str
    menu: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checkable: bool = False
    checked: bool = False
    group: str = ""


SEPARATOR = "-"

ACTIONS: tuple[ActionSpec | str, ...] = (
    ActionSpec("open_dialog", "File", "Open…", ("Ctrl+O",), "Open a BVH or a session"),
    ActionSpec(
        "open_folder",
        "File",
        "Open folder…",
        ("Ctrl+Shift+O",),
        "Analyse all clips of a folder, worst first",
    ),
    ActionSpec("next_clip", "File", "Next clip", ("Ctrl+N",), "The worst clip not yet decided"),
    ActionSpec("open_sample", "File", "Open the sample", (), "A walk with known twist errors"),
    ActionSpec(
        "cancel_opening", "File", "Cancel opening", ("Esc",), "Give up what is being opened"
    ),
    ActionSpec("save_session", "File", "Save session", ("Ctrl+S",), "Keep all decisions"),
    ActionSpec("save_session_as", "File", "Save session as…", ("Ctrl+Shift+S",)),
    ActionSpec("export_dialog", "File", "Export…", ("Ctrl+E",), "Write the corrected BVH"),
    SEPARATOR,
    ActionSpec(
        "open_video",
        "File",
        "Open witness video…",
        ("Ctrl+Shift+V",),
        "A video of the same take beside the 3D view",
    ),
    ActionSpec("close_video", "File", "Close the video", (), "Forget this clip's video"),
    SEPARATOR,
    ActionSpec("close", "File", "Quit", ("Ctrl+Q",)),
    ActionSpec("undo", "Edit", "Undo", ("Ctrl+Z",)),
    ActionSpec("redo", "Edit", "Redo", ("Ctrl+Shift+Z", "Ctrl+Y")),
    SEPARATOR,
    ActionSpec("accept", "Edit", "Accept", ("A",), "Accept and go to the next undecided"),
    ActionSpec("reject", "Edit", "Reject", ("R",), "Reject and go to the next undecided"),
    ActionSpec("reset", "Edit", "Reset to undecided", ("Backspace",)),
    ActionSpec(
        "accept_confident",
        "Edit",
        "Accept the sure ones…",
        ("Ctrl+Shift+A",),
        "Accept all undecided with a confidence of at least …",
    ),
    SEPARATOR,
    ActionSpec("start_here", "Edit", "Start at playhead", ("[",)),
    ActionSpec("stop_here", "Edit", "Stop at playhead", ("]",)),
    ActionSpec("insert_interval", "Edit", "New interval at playhead", ("Ins",)),
    ActionSpec("remove_interval", "Edit", "Remove hand-made interval", ("Del",)),
    ActionSpec("make_level", "Edit", "One offset in all frames", ("E",), "A level shift"),
    ActionSpec(
        "make_following",
        "Edit",
        "An offset a frame",
        ("Shift+E",),
        "The twist runs straight through the interval",
    ),
    SEPARATOR,
    ActionSpec("use_consistency", "Edit", "Detect with our detector", (), "", True, True, "method"),
    ActionSpec(
        "use_paper", "Edit", "Detect with the paper's detector", (), "", True, False, "method"
    ),
    SEPARATOR,
    ActionSpec("preferences", "Edit", "Preferences…", ("Ctrl+,",), "Reviewer, frames, keys"),
    ActionSpec("next_interval", "Go", "Next interval", ("N",)),
    ActionSpec("previous_interval", "Go", "Previous interval", ("Shift+N",)),
    ActionSpec(
        "next_faint", "Go", "Next suspicious moment", ("M",), "Faint candidates down to half of τ"
    ),
    SEPARATOR,
    ActionSpec("toggle_play", "Go", "Play or pause", ("Space",)),
    ActionSpec(
        "loop_interval",
        "Go",
        "Loop the interval",
        ("O",),
        "Play the selected interval ± 0.5 s over and over",
        True,
        False,
    ),
    ActionSpec("faster", "Go", "Faster", ("L",)),
    ActionSpec("slower", "Go", "Slower", ("J",)),
    ActionSpec("normal_speed", "Go", "Real-time speed", ("K",)),
    SEPARATOR,
    ActionSpec(
        "hold_video",
        "Go",
        "Hold the video",
        ("W",),
        "It stands still; move the playhead to the same moment and release",
        True,
        False,
    ),
    SEPARATOR,
    ActionSpec("next_frame", "Go", "Next frame", ("Right", ".")),
    ActionSpec("previous_frame", "Go", "Previous frame", ("Left", ",")),
    ActionSpec("ten_forward", "Go", "Ten frames on", ("Ctrl+Right",)),
    ActionSpec("ten_back", "Go", "Ten frames back", ("Ctrl+Left",)),
    ActionSpec("first_frame", "Go", "First frame", ("Home",)),
    ActionSpec("last_frame", "Go", "Last frame", ("End",)),
    ActionSpec("go_to_frame", "Go", "Go to frame…", ("Ctrl+J",)),
    ActionSpec("cycle_show", "View", "Before / after / both", ("B",), "Cycle what the 3D shows"),
    ActionSpec("focus_chain", "View", "Focus the chain", ("F",), "Turn the camera to the limb"),
    ActionSpec("follow_root", "View", "Follow the root", ("G",), "", True, True),
    SEPARATOR,
    ActionSpec(
        "skin", "View", "Skinned limbs", ("S",), "A striped skin that a wrong twist wrings", True
    ),
    ActionSpec(
        "side_by_side", "View", "Side by side", ("V",), "Before left, after right, one camera", True
    ),
    ActionSpec(
        "trails", "View", "Trails of hands and feet", ("T",), "A second before and after", True
    ),
    ActionSpec(
        "colour_by_offset", "View", "Colour by offset", ("Shift+C",), "Bones, from 0 to 180°", True
    ),
    ActionSpec("bone_names", "View", "Names under the mouse", ("H",), "", True, True),
    SEPARATOR,
    ActionSpec("view_iso", "View", "Three-quarter view", ("1",)),
    ActionSpec("view_front", "View", "Front", ("2",)),
    ActionSpec("view_side", "View", "Side", ("3",)),
    ActionSpec("view_back", "View", "Back", ("4",)),
    ActionSpec("view_top", "View", "Top", ("5",)),
    SEPARATOR,
    ActionSpec("zoom_to_interval", "View", "Plots: zoom to interval", ("Z",)),
    ActionSpec("show_all", "View", "Plots: show all", ("Shift+Z",)),
    ActionSpec(
        "both_detectors",
        "View",
        "Plots: both detectors",
        ("D",),
        "The other detector's strength, τ and intervals below this one's",
        True,
    ),
    SEPARATOR,
    ActionSpec("theme_system", "View", "Colours as the system", (), "", True, True, "theme"),
    ActionSpec("theme_light", "View", "Light", (), "", True, False, "theme"),
    ActionSpec("theme_dark", "View", "Dark", (), "", True, False, "theme"),
    SEPARATOR,
    ActionSpec(
        "presentation",
        "View",
        "Presentation",
        ("F5",),
        "Large type, figure and curves only; Esc ends it",
        True,
    ),
    ActionSpec("full_screen", "View", "Full screen", ("F11",), "", True, False),
    ActionSpec("show_tuning", "Tuning", "Tuning tab", ("Ctrl+T",), "What every τ costs this clip"),
    SEPARATOR,
    ActionSpec(
        "tau_for_chain",
        "Tuning",
        "Chain",
        (),
        "τ is set for the selected chain",
        True,
        True,
        "scope",
    ),
    ActionSpec(
        "tau_for_segment",
        "Tuning",
        "τ for both sides",
        (),
        "τ is set for the chain's segment, left and right",
        True,
        False,
        "scope",
    ),
    ActionSpec(
        "tau_for_all",
        "Tuning",
        "τ for all chains",
        (),
        "τ is set for all chains",
        True,
        False,
        "scope",
    ),
    ActionSpec(
        "suggest_tau",
        "Tuning",
        "Suggest τ",
        ("Ctrl+U",),
        "The τ that errors put into this clip speak for",
    ),
    SEPARATOR,
    ActionSpec("load_profile", "Tuning", "Load profile…", (), "Take the τ of a TOML file"),
    ActionSpec("save_profile", "Tuning", "Save profile…", (), "Write τ of all chains as TOML"),
    ActionSpec(
        "compare_profiles",
        "Tuning",
        "Compare profiles…",
        (),
        "One profile beside the present τ, or two side by side",
    ),
    ActionSpec(
        "take_profile",
        "Tuning",
        "Take over the compared profile",
        (),
        "Take the τ of the profile compared",
    ),
    ActionSpec("close_comparison", "Tuning", "Close comparison"),
    SEPARATOR,
    ActionSpec(
        "profile_to_folder",
        "Tuning",
        "Use τ for the folder",
        (),
        "Analyse the open folder again with the present τ",
    ),
    ActionSpec(
        "automatic_folder",
        "Tuning",
        "Automatic τ for the folder",
        (),
        "Analyse the open folder again with the automatic τ of each clip",
    ),
    ActionSpec(
        "show_quality", "Quality", "Quality tab", ("Ctrl+D",), "Jitter, jumps, speed, foot slide"
    ),
    SEPARATOR,
    ActionSpec(
        "track_joints",
        "Quality",
        "Track with QuaMo",
        (),
        "Track the joints selected in the quality tab, after the correction of their twist errors",
    ),
    ActionSpec("cancel_tracking", "Quality", "Cancel tracking", (), "Give up what is under way"),
    ActionSpec(
        "stop_tracking", "Quality", "Stop tracking", (), "Track no joint; undo takes it back"
    ),
    ActionSpec(
        "show_teaching", "Teach", "Swing and twist", ("Ctrl+L",), "The equations at the joint"
    ),
    SEPARATOR,
    ActionSpec("tour", "Teach", "Tour", (), "A guided tour of swing, twist and their errors"),
    ActionSpec("exercise", "Teach", "Exercise", (), "Find hidden errors; the program scores"),
    SEPARATOR,
    ActionSpec(
        "why_quaternions",
        "Teach",
        "Why quaternions",
        (),
        "One joint through ±180°, followed by five trackers",
    ),
    SEPARATOR,
    ActionSpec(
        "record_dialog", "Teach", "Record…", ("Ctrl+R",), "Film or picture of 3D view and curves"
    ),
    ActionSpec("command_palette", "Help", "Command palette…", ("Ctrl+K",), "Any action by name"),
    ActionSpec("show_shortcuts", "Help", "Keyboard and mouse", ("?",)),
    ActionSpec("show_about", "Help", "About Twist Inspector"),
)

MENUS = ("File", "Edit", "Go", "View", "Tuning", "Quality", "Teach", "Help")


def specs() -> tuple[ActionSpec, ...]:
    """All actions without the separators."""
    return tuple(a for a in ACTIONS if isinstance(a, ActionSpec))


def build_actions(
    window: QWidget, bar: QMenuBar
) -> tuple[Mapping[str, QAction], Mapping[str, QMenu]]:
    """QActions by id, each connected to the window's method of its name, and the menus by name."""
    menus = {name: bar.addMenu(f"&{name}") for name in MENUS}
    groups: dict[str, QActionGroup] = {}
    actions: dict[str, QAction] = {}
    menu = menus[MENUS[0]]
    for spec in ACTIONS:
        if isinstance(spec, str):
            menu.addSeparator()
            continue
        menu = menus[spec.menu]
        action = QAction(spec.text, window)
        menu.addAction(action)
        action.setObjectName(spec.id)
        action.setShortcuts([QKeySequence(k) for k in spec.keys])
        keys = f" ({spec.keys[0]})" if spec.keys else ""
        action.setToolTip(f"{spec.tip or spec.text}{keys}")
        action.setStatusTip(spec.tip)
        slot = getattr(window, spec.id)
        if spec.checkable:
            action.setCheckable(True)
            action.setChecked(spec.checked)
            action.toggled.connect(slot)
        else:
            action.triggered.connect(lambda _checked=False, do=slot: do())
        if spec.group:
            group = groups.setdefault(spec.group, QActionGroup(window))
            group.addAction(action)
        window.addAction(action)
        actions[spec.id] = action
    return actions, menus


MOUSE = (
    ("Plots: wheel", "zoom at the cursor"),
    ("Plots: Shift+wheel", "pan"),
    ("Plots: drag an edge or the body of an interval", "resize or move it"),
    ("Plots: drag the τ line, double click on the strength", "set τ"),
    ("Tuning: drag the τ line, double click in a plot", "set τ"),
    ("Plots: right button", "menu; it never deletes"),
    ("3D: drag · Shift+drag · wheel", "orbit · pan · zoom"),
    ("3D: click a bone", "select its chain"),
    ("Teaching: click a symbol", "light it up in the list, in 3D and in the plots"),
)


def shortcuts_markdown() -> str:
    """The table of keys and mouse for the help window and docs/shortcuts.md."""
    lines = ["# Keyboard and mouse", ""]
    for menu in MENUS:
        rows = [s for s in specs() if s.menu == menu and s.keys]
        if rows:
            lines += [f"## {menu}", "", "| key | does |", "|---|---|"]
            lines += [f"| {' or '.join(f'`{k}`' for k in s.keys)} | {_does(s)} |" for s in rows]
            lines.append("")
    lines += ["## Mouse", "", "| where | does |", "|---|---|"]
    lines += [f"| {where} | {does} |" for where, does in MOUSE]
    return "\n".join(lines) + "\n"


def _does(spec: ActionSpec) -> str:
    return f"{spec.text}: {spec.tip}" if spec.tip else spec.text


if __name__ == "__main__":
    print(shortcuts_markdown(), end="")
