"""The table of the window's own actions, joined with those of its features: menus, keys, help."""

from __future__ import annotations

from collections.abc import Mapping

from inspector.bundled import SAMPLE
from inspector.feature import ActionRow, ActionSpec, Switch
from inspector.language import tr, tr_as
from inspector.session.open_clip import Show
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import bring_to_front
from inspector.window.actions import Menus
from inspector.window.detector_rows import detector_rows
from inspector.window.features import FEATURES, joined
from inspector.window.keyboard_page import shortcuts_markdown, show_shortcuts
from inspector.window.parts import Parts
from twistcore.review import Decision

_NEXT = {Show.BEFORE: Show.AFTER, Show.AFTER: Show.BOTH, Show.BOTH: Show.BEFORE}


def _name_bones(viewport: Viewport, on: bool) -> None:
    viewport.pointing.names = on


def _search_intervals(parts: Parts) -> None:
    bring_to_front(parts.docks["intervals"])
    parts.review_actions.intervals.search_here()


# A table, so it is laid out as one: what is shown, then what is done.
# fmt: off
_OWN: Mapping[str, tuple[ActionRow[Parts] | None, ...]] = {
    "File": (
        ActionSpec("open_dialog", tr("Open…"), ("Ctrl+O",), tr("Open a clip or a session"),
                   do=lambda p: p.files.open_dialog()),
        ActionSpec("open_folder", tr("Open folder…"), ("Ctrl+Shift+O",),
                   tr("Analyse all clips of a folder, worst first"),
                   do=lambda p: p.files.open_folder()),
        ActionSpec("next_clip", tr("Next clip"), ("Ctrl+N",), tr("The worst clip not yet decided"),
                   do=lambda p: p.files.next_clip()),
        ActionSpec("previous_clip", tr("Previous clip"), ("Ctrl+Shift+N",),
                   tr("The clip opened before"),
                   do=lambda p: p.files.previous_clip()),
        ActionSpec("open_sample", tr("Open the sample"), (), tr("A walk with known twist errors"),
                   do=lambda p: p.files.open_path(SAMPLE)),
        ActionSpec("cancel_opening", tr("Cancel opening"), ("Esc",),
                   tr("Give up what is being opened"),
                   do=lambda p: p.document.opener.cancel()),
        ActionSpec("save_session", tr("Save session"), ("Ctrl+S",), tr("Keep all decisions"),
                   needs="clip", do=lambda p: p.files.save_session()),
        ActionSpec("save_session_as", tr("Save session as…"), ("Ctrl+Shift+S",),
                   needs="clip", do=lambda p: p.files.save_session_as()),
        ActionSpec("export_dialog", tr("Export…"), ("Ctrl+E",), tr("Write the corrected clip"),
                   needs="clip", do=lambda p: p.files.export_dialog()),
        ActionSpec("export_at_once", tr("Export at once"), ("Ctrl+Shift+E",),
                   tr("As Export… would unchanged; it asks where anything is in the way"),
                   needs="clip", do=lambda p: p.files.export_dialog(at_once=True)),
        None,
        ActionSpec("close", tr("Quit"), ("Ctrl+Q",), do=lambda p: p.close()),
    ),
    "Edit": (
        ActionSpec("undo", tr("Undo"), ("Ctrl+Z",), do=lambda p: p.document.undo()),
        ActionSpec("redo", tr("Redo"), ("Ctrl+Shift+Z", "Ctrl+Y"), do=lambda p: p.document.redo()),
        None,
        ActionSpec("accept", tr("Accept"), ("A",), tr("Accept and go to the next undecided"),
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.ACCEPTED)),
        ActionSpec("reject", tr("Reject"), ("R",), tr("Reject and go to the next undecided"),
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.REJECTED)),
        ActionSpec("reject_for", tr("Reject with a reason…"), ("Q",),
                   tr("A list of reasons, of which 1 to 9 picks one, or a line for another"),
                   do=lambda p: p.review_actions.reject_for()),
        ActionSpec("reset", tr("Reset to undecided"), ("Backspace",),
                   needs="clip", do=lambda p: p.review_actions.decide(Decision.UNDECIDED)),
        ActionSpec("accept_confident", tr("Accept the sure ones…"), ("Ctrl+Shift+A",),
                   tr("All undecided with a confidence of at least …; how many is seen before"),
                   needs="clip", do=lambda p: p.review_actions.accept_confident()),
        None,
        ActionSpec("write_note", tr("Write a note"), ("I",), tr("Enter keeps it, Esc does not"),
                   do=lambda p: p.review_actions.write("note")),
        ActionSpec("write_delta", tr("Type δ"), ("Shift+D",), tr("The selected interval's"),
                   do=lambda p: p.review_actions.write("delta")),
        ActionSpec("write_start", tr("Type the start"), ("Ctrl+[",), tr("A frame number"),
                   do=lambda p: p.review_actions.write("start")),
        ActionSpec("write_stop", tr("Type the stop"), ("Ctrl+]",), tr("A frame number"),
                   do=lambda p: p.review_actions.write("stop")),
        None,
        ActionSpec("start_here", tr("Start at playhead"), ("[",),
                   needs="clip", do=lambda p: p.review_actions.move_edge(start=True)),
        ActionSpec("stop_here", tr("Stop at playhead"), ("]",),
                   needs="clip", do=lambda p: p.review_actions.move_edge(start=False)),
        ActionSpec("insert_interval", tr("New interval at playhead"), ("Ins",),
                   needs="clip", do=lambda p: p.review_actions.insert_interval()),
        ActionSpec("remove_interval", tr("Remove hand-made interval"), ("Del",),
                   needs="clip", do=lambda p: p.review_actions.remove_interval()),
        ActionSpec("make_level", tr("One offset in all frames"), ("E",), tr("A level shift"),
                   needs="clip", do=lambda p: p.review_actions.make_level()),
        ActionSpec("make_following", tr("An offset a frame"), ("Shift+E",),
                   tr("The twist runs straight through the interval"),
                   needs="clip", do=lambda p: p.review_actions.make_following()),
        ActionSpec("turn_end", tr("End kept or turned along"), ("C",),
                   tr("Of a flip: whether foot or hand keeps its rotation"),
                   needs="clip", do=lambda p: p.review_actions.turn_end()),
        None,
        *detector_rows(),
        None,
        ActionSpec("preferences", tr("Preferences…"), ("Ctrl+,",), tr("Reviewer, frames, keys"),
                   do=lambda p: p.program.preferences()),
    ),
    "Go": (
        ActionSpec("next_interval", tr("Next interval"), ("N",),
                   tr("The next to decide; once all are decided, any"),
                   needs="clip", do=lambda p: p.review_actions.step_interval(+1)),
        ActionSpec("previous_interval", tr("Previous interval"), ("Shift+N",),
                   tr("The one to decide before it; where none is, the last decided"),
                   needs="clip", do=lambda p: p.review_actions.step_interval(-1)),
        ActionSpec("next_of_all", tr("Next, decided or not"), ("Ctrl+Down",),
                   do=lambda p: p.review_actions.step_any(+1)),
        ActionSpec("previous_of_all", tr("Previous, decided or not"), ("Ctrl+Up",),
                   do=lambda p: p.review_actions.step_any(-1)),
        ActionSpec("order_chain", tr("Go through by chain"), group="order", checked=True,
                   do=lambda p: p.review_actions.set_order("chain")),
        ActionSpec("order_time", tr("Go through by time"), group="order",
                   do=lambda p: p.review_actions.set_order("time")),
        None,
        ActionSpec("next_faint", tr("Next suspicious moment"), ("M",),
                   tr("Faint candidates down to half of τ, and peaks above it without an interval"),
                   needs="clip", do=lambda p: p.review_actions.next_faint()),
        ActionSpec("why_not", tr("Why is nothing found here?"), ("Y",),
                   tr("At the playhead, or at the peak of the strength next to it"),
                   needs="clip", do=lambda p: p.review_actions.why_not()),
        None,
        ActionSpec("toggle_play", tr("Play or pause"), ("Space",), needs="clip",
                   do=lambda p: p.player.toggle()),
        Switch("loop_interval", tr("Loop the interval"), ("O",),
               tr("Play the selected interval ± 0.5 s over and over"),
               needs="clip", turn=lambda p, on: p.player.set_loop(on)),
        ActionSpec("play_edge", tr("Play over the edge"), ("P",),
                   tr("A quarter of a second to either side of the edge next to the playhead"),
                   do=lambda p: p.review_actions.play_edge()),
        ActionSpec("play_other_edge", tr("Play over the other edge"), ("Shift+P",),
                   do=lambda p: p.review_actions.play_edge(other=True)),
        ActionSpec("faster", tr("Faster"), ("L",), do=lambda p: p.player.step_speed(+1)),
        ActionSpec("slower", tr("Slower"), ("J",), do=lambda p: p.player.step_speed(-1)),
        ActionSpec("normal_speed", tr("Real-time speed"), ("K",),
                   do=lambda p: p.player.set_speed(1.0)),
        None,
        ActionSpec("next_frame", tr("Next frame"), ("Right", "."),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame + 1)),
        ActionSpec("previous_frame", tr("Previous frame"), ("Left", ","),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame - 1)),
        ActionSpec("ten_forward", tr("Ten frames on"), ("Ctrl+Right",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame + p.settings.step)),
        ActionSpec("ten_back", tr("Ten frames back"), ("Ctrl+Left",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frame - p.settings.step)),
        ActionSpec("first_frame", tr("First frame"), ("Home",), needs="clip",
                   do=lambda p: p.document.go_to(0)),
        ActionSpec("last_frame", tr("Last frame"), ("End",),
                   needs="clip", do=lambda p: p.document.go_to(p.document.frames - 1)),
        ActionSpec("search_intervals", tr("Search the intervals"), ("Ctrl+F",),
                   tr("By chain, joints, kind, note, reason; >0.9 is a confidence"),
                   do=_search_intervals),
        ActionSpec("go_to_frame", tr("Go to frame…"), ("Ctrl+J",),
                   needs="clip", do=lambda p: p.review_actions.go_to_frame()),
    ),
    "View": (
        ActionSpec("cycle_show", tr("Before / after / both"), ("B",), tr("Cycle what the 3D shows"),
                   needs="figure", do=lambda p: p.document.set_show(_NEXT[p.document.show])),
        ActionSpec("focus_chain", tr("Focus the chain"), ("F",), tr("Turn the camera to the limb"),
                   needs="figure", do=lambda p: p.viewport.focus_chain(p.settings.turn_ms)),
        Switch("follow_root", tr("Follow the root"), ("G",), checked=True,
               needs="figure", turn=lambda p, on: p.viewport.set_follow(on)),
        None,
        Switch("skin", tr("Skinned limbs"), ("S",), tr("A striped skin that a wrong twist wrings"),
               needs="figure",
               turn=lambda p, on: p.viewport.look(style=Style.SKIN if on else Style.WEDGES)),
        Switch("side_by_side", tr("Side by side"), ("V",),
               tr("Before left, after right, one camera"),
               needs="figure", turn=lambda p, on: p.viewport.look(split=on)),
        Switch("trails", tr("Trails of hands and feet"), ("T",), tr("A second before and after"),
               needs="figure", turn=lambda p, on: p.viewport.look(trails=on)),
        Switch("colour_by_offset", tr("Colour by offset"), ("Shift+C",),
               tr("Bones, from 0 to 180°"),
               needs="figure", turn=lambda p, on: p.viewport.look(by_offset=on)),
        Switch("bone_names", tr("Names under the mouse"), ("H",), checked=True,
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
               tr("N, A and R show the interval they go to with its surroundings"), checked=True,
               turn=lambda p, on: setattr(p.settings, "zoom_to_interval", on)),
        ActionSpec("fit_heights", tr("Plots: fit heights"), ("Shift+F",),
                   tr("All values in every plot again"),
                   do=lambda p: p.timeline.fit()),
        ActionSpec("one_plot", tr("Plots: one or all"), ("Ctrl+M",),
                   tr("The plot under the mouse alone, or all again"),
                   do=lambda p: p.timeline.grid.enlarge()),
        Switch("both_detectors", tr("Plots: both detectors"), ("D",),
               tr("The other detector's strength, τ and intervals below this one's"),
               needs="clip", turn=lambda p, on: p.timeline.toggles["other"].setChecked(on)),
        None,
        ActionSpec("theme_system", tr("Colours as the system"), group="theme", checked=True,
                   do=lambda p: p.program.choose_theme("system")),
        ActionSpec("theme_light", tr("Light"), group="theme",
                   do=lambda p: p.program.choose_theme("light")),
        ActionSpec("theme_dark", tr("Dark"), group="theme",
                   do=lambda p: p.program.choose_theme("dark")),
        None,
        Switch("presentation", tr("Presentation"), ("F5",),
               tr("Large type, figure and curves only; Esc ends it"),
               turn=lambda p, on: p.presentation.enter() if on else p.presentation.leave()),
        Switch("full_screen", tr("Full screen"), ("F11",),
               turn=lambda p, on: p.presentation.set_full_screen(on)),
        ActionSpec("reset_layout", tr("Reset the layout"), (), tr("Every panel in its place again"),
                   do=lambda p: p.usual_layout.reset()),
    ),
    "Help": (
        ActionSpec("show_guide", tr("Guide"), ("F1",), tr("How to work with it, with pictures"),
                   do=lambda p: p.program.show_guide()),
        ActionSpec("command_palette", tr("Command palette…"), ("Ctrl+K",),
                   tr("Any action by name or key"),
                   do=lambda p: p.program.command_palette()),
        ActionSpec("show_shortcuts", tr("Keyboard and mouse"), ("?",),
                   do=lambda p: show_shortcuts(p.program.menus, p)),
        ActionSpec("show_about", tr("About Twist Inspector"), do=lambda p: p.program.show_about()),
    ),
}
# fmt: on

MENUS: Menus = joined(_OWN)


def connect_rows(parts: Parts) -> None:
    """Let every action do from now on what its row says."""
    actions = parts.actions_by_id
    for row in (row for menu in _OWN.values() for row in menu if row is not None):
        row.connect(actions[row.id], parts)
    for feature in FEATURES:
        for row in (row for rows in feature.rows for row in rows.rows if row is not None):
            row.connect(actions[row.id], parts.part(feature))


if __name__ == "__main__":
    print(shortcuts_markdown(MENUS), end="")
