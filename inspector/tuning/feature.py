"""The tuning of the threshold τ, as a feature of the window."""

from __future__ import annotations

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
    Switch,
)
from inspector.folder.feature import feature as folder
from inspector.language import tr
from inspector.tuning.tuning_actions import TuningActions
from inspector.tuning.tuning_panel import Scope, TuningPanel
from inspector.tuning.verdict_evidence import VerdictEvidence
from inspector.tuning.wishes import Wishes
from inspector.widgets.building import bring_to_front
from inspector.widgets.late_panel import LatePanel


class Tuning(FeatureParts):
    """The tuning tab and its actions."""

    def __init__(self, window: HostWindow) -> None:
        document, colours, actions = window.document, window.colours, window.actions_by_id
        wishes = Wishes(window.settings, window)
        evidence = self._evidence = VerdictEvidence(document, wishes, window)
        self.tuning_area = LatePanel(
            lambda: TuningPanel(document, colours, actions, wishes, evidence)
        )

    @property
    def tuning(self) -> TuningPanel:
        """The panel of the tuning tab."""
        return self.tuning_area.build()

    def connect(self, window: HostWindow) -> None:
        """Connect the tab to the window. Costs are computed only while the tab is visible."""
        self._dock, self._visible = window.docks["tuning"], window.timeline.visible
        self._dock.visibilityChanged.connect(self.tuning_area.set_seen)
        queue = window.part(folder).queue
        self.tuning_actions = TuningActions(
            window.document, queue, window.bar, self.tuning_area.build,
            self._evidence.performers, self._dock, window,
        )  # fmt: skip

    def show(self) -> None:
        """Bring the tuning tab to the front."""
        bring_to_front(self._dock)

    def leave_out_visible(self) -> None:
        """Exclude the frames that are visible in the plots from tuning."""
        self.tuning_actions.leave_out_visible(self._visible.ends)

    def close(self) -> None:
        """Stop all computations when the window closes."""
        self.tuning_area.set_seen(False)


# fmt: off
_ROWS: tuple[ActionRow[Tuning] | None, ...] = (
    ActionSpec("show_tuning", tr("Tuning tab"), ("Ctrl+T",),
               tr("Show the cost of every τ in this clip"),
               do=lambda p: p.show()),
    None,
    ActionSpec("tau_for_chain", tr("τ for the chain"), (), tr("Set τ for the selected chain"),
               group="scope", checked=True,
               do=lambda p: p.tuning.set_scope(Scope.CHAIN)),
    ActionSpec("tau_for_segment", tr("τ for both sides"), (),
               tr("Set τ for all chains of the same body segment, left and right"),
               group="scope",
               do=lambda p: p.tuning.set_scope(Scope.SEGMENT)),
    ActionSpec("tau_for_all", tr("τ for all chains"), (), tr("Set τ for all chains"),
               group="scope",
               do=lambda p: p.tuning.set_scope(Scope.ALL)),
    ActionSpec("suggest_tau", tr("Suggest τ"), ("Ctrl+U",),
               tr("Set τ to the best value for errors injected into this clip"), ready=False,
               do=lambda p: p.tuning.suggest()),
    None,
    ActionSpec("next_bar", tr("Next bar of the histogram"), (),
               tr("Go to the next bar of the histogram and show its first frame"),
               needs="clip", do=lambda p: p.tuning.curves.next_bar()),
    ActionSpec("next_in_bar", tr("Next frame in the bar"), (),
               tr("Go to the next frame in the selected bar of the histogram"),
               needs="clip", do=lambda p: p.tuning.curves.next_in_bar()),
    ActionSpec("leave_out_interval", tr("Leave the interval out of tuning"), (),
               tr("Ignore the interval's frames: no errors are injected and no false alarms "
                  "are counted in these frames"),
               needs="clip", do=lambda p: p.tuning_actions.leave_out_interval()),
    ActionSpec("leave_out_visible", tr("Leave the visible frames out of tuning"), (),
               tr("Ignore the frames that are visible in the plots"),
               needs="clip", do=lambda p: p.leave_out_visible()),
    ActionSpec("take_all_in", tr("Use all frames for tuning"), (),
               tr("Use all frames except transitions at the ends of the clip"),
               needs="clip", do=lambda p: p.tuning_actions.take_all_in()),
    None,
    ActionSpec("load_profile", tr("Load profile…"), (), tr("Use the τ values from a TOML file"),
               needs="clip", do=lambda p: p.tuning_actions.load_profile()),
    ActionSpec("save_profile", tr("Save profile…"), (),
               tr("Write the τ values of all chains to a TOML file"),
               needs="clip", do=lambda p: p.tuning_actions.save_profile()),
    ActionSpec("compare_profiles", tr("Compare profiles…"), (),
               tr("Compare a profile with the current τ values, or compare two profiles"),
               needs="clip", do=lambda p: p.tuning_actions.compare_profiles()),
    ActionSpec("take_profile", tr("Use the compared profile"), (),
               tr("Use the τ values from the compared profile"), ready=False,
               do=lambda p: p.tuning_actions.take_profile()),
    ActionSpec("close_comparison", tr("Close comparison"), ready=False,
               do=lambda p: p.tuning.profiles.set_compared(())),
    Switch("both_costs", tr("Costs of both detectors"), (),
           tr("Compare the detectors, each at its suggested and its automatic τ"),
           needs="clip", turn=lambda p, on: p.tuning.profiles.show_both(on)),
    None,
    ActionSpec("profile_to_folder", tr("Use τ for the folder"), (),
               tr("Analyse the open folder again with the current τ values"),
               do=lambda p: p.tuning_actions.profile_to_folder()),
    ActionSpec("automatic_folder", tr("Automatic τ for the folder"), (),
               tr("Analyse the open folder again, each clip with its automatic τ"),
               do=lambda p: p.tuning_actions.automatic_folder()),
)
# fmt: on

feature = Feature(
    "tuning",
    Tuning,
    rows=(MenuRows("Tuning", _ROWS),),
    panels=(
        DockPanel(
            "tuning", tr("Tuning"), Area.RightDockWidgetArea, lambda p: p.tuning_area, tab=True
        ),
    ),
)
