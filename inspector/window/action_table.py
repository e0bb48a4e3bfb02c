"""The table of all actions: their menus, keyboard shortcuts, help texts and functions."""

from __future__ import annotations

from collections.abc import Mapping

from inspector.feature import ActionRow, ActionSpec, Switch, Tool
from inspector.language import tr, tr_as
from inspector.session.open_clip import Show
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import bring_to_front
from inspector.window.actions import Menus, rows
from inspector.window.detector_rows import detector_rows
from inspector.window.features import FEATURES, insert_feature_rows
from inspector.window.keyboard_page import shortcuts_markdown, show_shortcuts
from inspector.window.parts import Parts
from inspector.window.sample import open_sample
from inspector.window.verdict_key_filter import VerdictKeyFilter
from twistcore.review import Decision

_NEXT = {Show.BEFORE: Show.AFTER, Show.AFTER: Show.BOTH, Show.BOTH: Show.BEFORE}


def _name_bones(viewport: Viewport, on: bool) -> None:
    viewport.pointing.names = on


def _search_intervals(parts: Parts) -> None:
    bring_to_front(parts.docks["intervals"])
    parts.review_actions.intervals.search_here()


# Laid out as a table: each row has the texts first, then the function of the action.
# fmt: off
_OWN: Mapping[str, tuple[ActionRow[Parts] | None, ...]] = {
    "File": (
        ActionSpec("open_dialog", tr("Open…"), ("Ctrl+O",), tr("Open a clip or a session"),
                   tool=Tool(tr_as("tool", "Open"), 10, 1),
                   do=lambda p: p.files.open_dialog()),
        ActionSpec("open_folder", tr("Open folder…"), ("Ctrl+Shift+O",),
                   tr("Analyse all clips in a folder and list the worst first"),
                   tool=Tool(tr_as("tool", "Folder"), 11, 1),
                   do=lambda p: p.files.open_folder()),
        ActionSpec("next_clip", tr("Next clip"), ("Ctrl+N",),
                   tr("Open the worst clip that has undecided intervals"),
                   do=lambda p: p.files.next_clip()),
        ActionSpec("previous_clip", tr("Previous clip"), ("Ctrl+Shift+N",),
                   tr("Open the clip that was open before"),
                   do=lambda p: p.files.previous_clip()),
        ActionSpec("open_sample", tr("Open the sample"), (),
                   tr("Open your own copy of a walk with known twist errors"),
                   do=lambda p: open_sample(p)),
        ActionSpec("cancel_opening", tr("Cancel opening"), ("Esc",),
                   tr("Stop opening the file"),
                   do=lambda p: p.document.opener.cancel()),
        ActionSpec("save_session", tr("Save session"), ("Ctrl+S",), tr("Save all decisions"),
                   needs="clip", do=lambda p: p.files.save_session()),
        ActionSpec("save_session_as", tr("Save session as…"), ("Ctrl+Shift+S",),
                   needs="clip", do=lambda p: p.files.save_session_as()),
        ActionSpec("export_dialog", tr("Export…"), ("Ctrl+E",), tr("Write the corrected clip"),
                   tool=Tool(tr_as("tool", "Export"), 12),
                   needs="clip", do=lambda p: p.files.export_dialog()),
        ActionSpec("export_at_once", tr("Export now"), ("Ctrl+Shift+E",),
                   tr("Export with the usual options; ask before replacing files from other "
                      "programs"),
                   needs="clip", do=lambda p: p.files.export_dialog(at_once=True)),
        None,
        ActionSpec("close", tr("Quit"), ("Ctrl+Q",), do=lambda p: p.close()),
    ),
    "Edit": (
        ActionSpec("undo", tr("Undo"), ("Ctrl+Z",),
                   tool=Tool(tr_as("tool", "Undo"), 20, 1),
                   do=lambda p: p.review_actions.undo()),
        ActionSpec("redo", tr("Redo"), ("Ctrl+Shift+Z", "Ctrl+Y"),
                   tool=Tool(tr_as("tool", "Redo"), 21, 1),
                   do=lambda p: p.review_actions.redo()),
        None,
        ActionSpec("accept", tr("Accept"), ("A",),
                   tr("Accept the interval, or the group after showing its errors, and go to the "
                      "next undecided one"),
                   tool=Tool(tr_as("tool", "Accept"), 32), verdict=True,
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.ACCEPTED)),
        ActionSpec("reject", tr("Reject"), ("R",),
                   tr("Reject the interval, or the group after showing its errors, and go to the "
                      "next undecided one"),
                   tool=Tool(tr_as("tool", "Reject"), 33), verdict=True,
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.REJECTED)),
        ActionSpec("reject_for", tr("Reject with a reason…"), ("Q",),
                   tr("Choose a reason with the keys 1 to 9, or type one"), verdict=True,
                   do=lambda p: p.review_actions.reject_for()),
        ActionSpec("reset", tr("Reset to undecided"), ("Backspace",),
                   tool=Tool(tr_as("tool", "Undecided"), 34), verdict=True,
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.UNDECIDED)),
        ActionSpec("accept_confident", tr("Accept confident intervals…"), ("Ctrl+Shift+A",),
                   tr("Accept all undecided intervals above a confidence that you choose"),
                   needs="clip", do=lambda p: p.review_actions.accept_confident()),
        None,
        ActionSpec("write_note", tr("Write a note"), ("I",),
                   tr("Press Enter to keep the note, or Esc to discard it"),
                   do=lambda p: p.review_actions.focus_field("note")),
        ActionSpec("write_delta", tr("Enter δ"), ("Shift+D",),
                   tr("Type the offset of the selected interval"),
                   do=lambda p: p.review_actions.focus_field("delta")),
        ActionSpec("write_start", tr("Type the start"), ("Ctrl+[",),
                   tr("Type the first frame of the selected interval"),
                   do=lambda p: p.review_actions.focus_field("start")),
        ActionSpec("write_stop", tr("Type the stop"), ("Ctrl+]",),
                   tr("Type the first frame after the selected interval"),
                   do=lambda p: p.review_actions.focus_field("stop")),
        None,
        ActionSpec("start_here", tr("Start at playhead"), ("[",),
                   needs="clip", do=lambda p: p.review_actions.move_edge(start=True)),
        ActionSpec("stop_here", tr("Stop at playhead"), ("]",),
                   needs="clip", do=lambda p: p.review_actions.move_edge(start=False)),
        ActionSpec("insert_interval", tr("New interval at playhead"), ("Ins",),
                   needs="clip", do=lambda p: p.review_actions.insert_interval()),
        ActionSpec("remove_interval", tr("Remove hand-made interval"), ("Del",),
                   needs="clip", do=lambda p: p.review_actions.remove_interval()),
        ActionSpec("make_level", tr("Constant offset"), ("E",),
                   tr("Use the same offset in all frames of the interval"),
                   needs="clip", do=lambda p: p.review_actions.make_level()),
        ActionSpec("make_following", tr("Separate offset per frame"), ("Shift+E",),
                   tr("Make the corrected twist linear over the interval"),
                   needs="clip", do=lambda p: p.review_actions.make_following()),
        ActionSpec("turn_end", tr("Keep the foot or hand, or turn it with the limb"), ("C",),
                   tr("For a flip or a stretch, choose whether the joints below keep their "
                      "rotation"),
                   needs="clip", do=lambda p: p.review_actions.turn_end()),
        None,
        *detector_rows(),
        None,
        ActionSpec("preferences", tr("Preferences…"), ("Ctrl+,",),
                   tr("Reviewer, frame numbers and keys"),
                   do=lambda p: p.program.preferences()),
    ),
    "Go": (
        ActionSpec("next_interval", tr("Next interval"), ("N",),
                   tr("Go to the next undecided interval; when all are decided, "
                      "to the next interval"),
                   tool=Tool(tr_as("tool", "Next"), 31),
                   needs="clip", do=lambda p: p.review_actions.step_interval(+1)),
        ActionSpec("previous_interval", tr("Previous interval"), ("Shift+N",),
                   tr(
                       "Go to the previous undecided interval; if there is none, to the previous "
                       "interval"
                   ),
                   tool=Tool(tr_as("tool", "Previous"), 30),
                   needs="clip", do=lambda p: p.review_actions.step_interval(-1)),
        ActionSpec("next_of_all", tr("Next interval, decided or not"), ("Ctrl+Down",),
                   do=lambda p: p.review_actions.step_any(+1)),
        ActionSpec("previous_of_all", tr("Previous interval, decided or not"), ("Ctrl+Up",),
                   do=lambda p: p.review_actions.step_any(-1)),
        ActionSpec("order_worst", tr("Go through the intervals, worst first"), group="order",
                   checked=True,
                   do=lambda p: p.review_actions.set_order("worst")),
        ActionSpec("order_chain", tr("Go through intervals chain by chain"), group="order",
                   do=lambda p: p.review_actions.set_order("chain")),
        ActionSpec("order_time", tr("Go through intervals in time order"), group="order",
                   do=lambda p: p.review_actions.set_order("time")),
        Switch("group_errors", tr("Group related errors"), (),
               tr("List related errors as one group; A, R and N then act on the whole group"),
               checked=True, turn=lambda p, on: p.review_actions.group_errors(on)),
        None,
        ActionSpec("next_faint", tr("Next suspicious moment"), ("M",),
                   tr(
                       "Go to weak candidates down to half of τ, and to peaks above τ without "
                       "an interval"),
                   needs="clip", do=lambda p: p.review_actions.next_faint()),
        ActionSpec("why_not", tr("Why is nothing found here?"), ("Y",),
                   tr("Explain the current frame, or the nearest peak of the strength"),
                   needs="clip", do=lambda p: p.review_actions.why_not()),
        None,
        ActionSpec("toggle_play", tr("Play or pause"), ("Space",), needs="clip",
                   do=lambda p: p.player.toggle()),
        Switch("loop_interval", tr("Loop the interval"), ("O",),
               tr("Repeat the selected interval, with 0.5 s before and after it"),
               tool=Tool(tr_as("tool", "Loop"), 40),
               needs="clip", turn=lambda p, on: p.player.set_loop(on)),
        ActionSpec("play_edge", tr("Play across the edge"), ("P",),
                   tr("Play from 0.25 s before to 0.25 s after the edge nearest to the playhead"),
                   do=lambda p: p.review_actions.play_edge()),
        ActionSpec("play_other_edge", tr("Play across the other edge"), ("Shift+P",),
                   do=lambda p: p.review_actions.play_edge(other=True)),
        ActionSpec("faster", tr("Faster"), ("L",), do=lambda p: p.player.step_speed(+1)),
        ActionSpec("slower", tr("Slower"), ("J",), do=lambda p: p.player.step_speed(-1)),
        ActionSpec("normal_speed", tr("Real-time speed"), ("K",),
                   do=lambda p: p.player.set_speed(1.0)),
        None,
        ActionSpec("next_frame", tr("Next frame"), ("Right", "."),
                   tr("If a group of errors is selected, Right first expands it"),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame + 1)),
        ActionSpec("previous_frame", tr("Previous frame"), ("Left", ","),
                   tr("If a group of errors is selected, Left first collapses it"),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame - 1)),
        ActionSpec("ten_forward", tr("Ten frames forward"), ("Ctrl+Right",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame + p.settings.step)),
        ActionSpec("ten_back", tr("Ten frames back"), ("Ctrl+Left",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame - p.settings.step)),
        ActionSpec("first_frame", tr("First frame"), ("Home",), needs="clip",
                   do=lambda p: p.document.go_to(0)),
        ActionSpec("last_frame", tr("Last frame"), ("End",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frames - 1)),
        ActionSpec("search_intervals", tr("Search the intervals"), ("Ctrl+F",),
                   tr(
                       "Search by chain, joint, kind, note or reason, or by confidence, such as "
                       ">0.9"
                   ),
                   do=_search_intervals),
        ActionSpec("go_to_frame", tr("Go to frame…"), ("Ctrl+J",),
                   needs="clip", do=lambda p: p.review_actions.go_to_frame()),
    ),
    "View": (
        ActionSpec("cycle_show", tr("Before / after / both"), ("B",),
                   tr("Switch between the captured and the corrected figure"),
                   tool=Tool(tr_as("tool", "Before/after"), 41, 2),
                   needs="figure", do=lambda p: p.document.set_show(_NEXT[p.document.show])),
        ActionSpec("focus_chain", tr("Focus the chain"), ("F",),
                   tr("Turn the camera to the selected limb"),
                   tool=Tool(tr_as("tool", "Focus"), 44, 2),
                   needs="figure", do=lambda p: p.viewport.focus_chain(p.settings.turn_ms)),
        Switch("follow_root", tr("Follow the root"), ("G",), checked=True,
               needs="figure", turn=lambda p, on: p.viewport.set_follow(on)),
        None,
        Switch("skin", tr("Skinned limbs"), ("S",),
                   tr("Show a striped skin, which makes a wrong twist visible"),
               tool=Tool(tr_as("tool", "Skin"), 42, 2), needs="figure",
               turn=lambda p, on: p.viewport.look(style=Style.SKIN if on else Style.WEDGES)),
        Switch("side_by_side", tr("Side by side"), ("V",),
               tr("Show before and after next to each other, with the same camera"),
               tool=Tool(tr_as("tool", "Side by side"), 43, 2),
               needs="figure", turn=lambda p, on: p.viewport.look(split=on)),
        Switch("trails", tr("Trails of hands and feet"), ("T",),
                   tr("Show the paths of the hands and feet for one second before and after "
                      "the current frame"),
               needs="figure", turn=lambda p, on: p.viewport.look(trails=on)),
        Switch("colour_by_offset", tr("Colour by offset"), ("Shift+C",),
               tr("Colour bones by the offset removed, from 0° to 180°"),
               needs="figure", turn=lambda p, on: p.viewport.look(by_offset=on)),
        Switch("bone_names", tr("Bone names under the pointer"), ("H",), checked=True,
               needs="figure", turn=lambda p, on: _name_bones(p.viewport, on)),
        None,
        ActionSpec("view_iso", tr("Three-quarter view"), ("1",),
                   needs="figure", do=lambda p: p.viewport.set_view("iso")),
        ActionSpec("view_front", tr_as("view", "Front"), ("2",),
                   needs="figure", do=lambda p: p.viewport.set_view("front")),
        ActionSpec("view_side", tr_as("view", "Side"), ("3",),
                   needs="figure", do=lambda p: p.viewport.set_view("side")),
        ActionSpec("view_back", tr_as("view", "Back"), ("4",),
                   needs="figure", do=lambda p: p.viewport.set_view("back")),
        ActionSpec("view_top", tr_as("view", "Top"), ("5",),
                   needs="figure", do=lambda p: p.viewport.set_view("top")),
        None,
        ActionSpec("zoom_to_interval", tr("Plots: zoom to interval"), ("Z",),
                   needs="clip", do=lambda p: p.timeline.visible.zoom_to_interval()),
        ActionSpec("show_all", tr("Plots: show all"), ("Shift+Z",),
                   needs="clip", do=lambda p: p.timeline.visible.show_all()),
        Switch("zoom_each", tr("Plots: zoom to every interval"), (),
               tr("Zoom to the interval after you press N, A or R or click its row"), checked=True,
               turn=lambda p, on: setattr(p.settings, "zoom_to_interval", on)),
        ActionSpec("fit_heights", tr("Plots: fit heights"), ("Shift+F",),
                   tr("Show all values in every plot"),
                   do=lambda p: p.timeline.fit()),
        ActionSpec("one_plot", tr("Plots: one or all"), ("Ctrl+M",),
                   tr("Show only the plot under the mouse, or all plots"),
                   do=lambda p: p.timeline.grid.enlarge()),
        Switch("both_detectors", tr("Plots: both detectors"), ("D",),
               tr("Show the other detector's strength, τ and intervals below "
                      "the plots of this detector"),
               needs="clip", turn=lambda p, on: p.timeline.toggles["other"].setChecked(on)),
        None,
        ActionSpec("theme_system", tr("System colours"), group="theme", checked=True,
                   do=lambda p: p.program.choose_theme("system")),
        ActionSpec("theme_light", tr("Light"), group="theme",
                   do=lambda p: p.program.choose_theme("light")),
        ActionSpec("theme_dark", tr("Dark"), group="theme",
                   do=lambda p: p.program.choose_theme("dark")),
        None,
        Switch("presentation", tr("Presentation"), ("F5",),
               tr(
                       "Enlarge the figure, the curves and a running lesson for an audience; "
                       "press Esc to leave"
               ),
               turn=lambda p, on: p.presentation.enter() if on else p.presentation.leave()),
        Switch("full_screen", tr("Full screen"), ("F11",),
               turn=lambda p, on: p.presentation.set_full_screen(on)),
        ActionSpec("reset_layout", tr("Reset the layout"), (),
                   tr("Put every panel back in its place"),
                   do=lambda p: p.usual_layout.reset()),
    ),
    "Help": (
        ActionSpec("show_guide", tr("Guide"), ("F1",),
                   tr("How to use the program, with pictures"),
                   do=lambda p: p.program.show_guide()),
        ActionSpec("command_palette", tr("Command palette…"), ("Ctrl+K",),
                   tr("Find any action by its name or key"),
                   do=lambda p: p.program.command_palette()),
        ActionSpec("show_shortcuts", tr("Keyboard and mouse"), ("?",),
                   do=lambda p: show_shortcuts(p.program.menus, p)),
        ActionSpec("show_about", tr("About Twist Inspector"), do=lambda p: p.program.show_about()),
    ),
}
# fmt: on

MENUS: Menus = insert_feature_rows(_OWN)


def connect_rows(parts: Parts) -> None:
    """Connect every action with the function in its row of the table.

    `parts` is the window, whose attributes the functions use.
    """
    actions = parts.actions_by_id
    for row in (row for menu in _OWN.values() for row in menu if row is not None):
        row.connect(actions[row.id], parts)
    verdicts = [actions[row.id] for row in rows(MENUS) if row.verdict]
    VerdictKeyFilter(verdicts, parts.viewport.has_painted_interval, parts)
    for feature in FEATURES:
        for row in (row for menu in feature.rows for row in menu.rows if row is not None):
            row.connect(actions[row.id], parts.part(feature))


if __name__ == "__main__":
    print(shortcuts_markdown(MENUS), end="")
