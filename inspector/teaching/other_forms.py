"""The parent's rotation in other forms: twist before swing, −q, and the file's Euler angles."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QToolButton, QWidget

from inspector.language import tr
from inspector.teaching.equation_table import OTHER_FORMS
from inspector.teaching.equations import RightSide
from inspector.teaching.section_head import SectionHead
from inspector.teaching.taught_frame import TaughtFrame, degree_text, padded_vector_text
from inspector.widgets.building import tool_button, use_secondary_text_colour
from inspector.widgets.theme import figures_font
from inspector.widgets.typeset import Typesetter
from twistcore.analysis.decomposition import (
    Decomposition,
    EulerChannels,
    decompose_into_euler_channels,
    double_cover_twist_angle,
    frame_motion_with_user_changes,
    twist_times_swing_factors,
)
from twistcore.skeleton.rotation import wrap

ROWS = ("order", "minus_q", "euler")  # names of the rows, which a lesson may list
_UNDEFINED = tr("undefined: w points opposite to a")
_TIPS = {
    "order": tr(
        "Whether the twist or the swing comes first, the twist about a and the swing angle α are "
        "the same; only the swing axis differs. n′ is n turned back by the twist."
    ),
    "minus_q": tr(
        "q and −q are the same rotation. Before wrapping, the θp of q and the θp of −q differ by "
        "a full turn."
    ),
    "euler": tr(
        "The file's rotation channels in degrees, in the file's order. The first axis is not "
        "turned by the other two rotations; the last axis is turned by both of them. When the "
        "middle angle is near ±90°, the first and the last axis coincide."
    ),
}


class OtherForms(QWidget):
    """The section of the teaching tab with other forms of the parent's rotation.

    The section is folded initially, and updates its numbers only while it is unfolded.
    """

    def __init__(self, taught: TaughtFrame, typesetter: Typesetter) -> None:
        super().__init__()
        self._taught = taught
        self.head = SectionHead(tr("The same rotation in other forms"), folded=True)
        self.values: dict[str, QLabel] = {}
        self._rows: dict[str, list[QWidget]] = {name: [] for name in ROWS}
        self._rights: list[RightSide] = []
        self.minus = tool_button("−q", tr("Write the same pose with −q"), flat=False)
        self.minus.setCheckable(True)
        grid = QGridLayout(self)
        grid.setContentsMargins(4, 0, 6, 4)
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(0)
        grid.addWidget(self.head, 0, 0, 1, 3)
        self._plus_and_minus = tuple(
            self._formula(OTHER_FORMS[name], typesetter) for name in ("as it is", "negative")
        )
        self._add(grid, 1, "order", "n", self._formula(OTHER_FORMS["swing first"], typesetter))
        self._add(
            grid, 2, "order", "n_after", self._formula(OTHER_FORMS["twist first"], typesetter)
        )
        self._add(
            grid,
            3,
            "order",
            "both",
            use_secondary_text_colour(QLabel(tr("the same in both orders"))),
        )
        self._add(grid, 4, "minus_q", "q", *self._plus_and_minus, self.minus)
        self._add(
            grid, 5, "minus_q", "theta_p", use_secondary_text_colour(QLabel(tr("θp → wrapped")))
        )
        self._add(grid, 6, "euler", "parent", use_secondary_text_colour(QLabel()))
        self._add(grid, 7, "euler", "child", use_secondary_text_colour(QLabel()))
        self._add(grid, 8, "euler", "lock", QLabel())
        grid.setColumnStretch(2, 1)
        self.head.toggled.connect(self._arrange)
        self.minus.toggled.connect(self.refresh)
        typesetter.ready.connect(self._measured)
        taught.rows_changed.connect(self._arrange)
        self._arrange()

    def _formula(self, tex: str, typesetter: Typesetter) -> RightSide:
        self._rights.append(RightSide(tex, typesetter))
        return self._rights[-1]

    def _add(self, grid: QGridLayout, row: int, name: str, key: str, *before: QWidget) -> None:
        value = QLabel(textInteractionFlags=Qt.TextInteractionFlag.TextSelectableByMouse)
        value.setFont(figures_font(9.0))
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        grid.addWidget(before[0], row, 0)
        for more in before[1:]:
            column = 1 if isinstance(more, QToolButton) else 0
            grid.addWidget(more, row, column)
        grid.addWidget(value, row, 2)
        for widget in (*before, value):
            widget.setToolTip(widget.toolTip() or _TIPS[name])
        self.values[key] = value
        self._rows[name] += [*before, value]

    @property
    def open(self) -> bool:
        """True if the section is unfolded or if a lesson lists some of its rows."""
        return any(self._lists(name) for name in ROWS)

    def _lists(self, name: str) -> bool:
        rows = self._taught.rows
        return name in rows if rows else not self.head.folded

    def _arrange(self) -> None:
        rows = self._taught.rows
        self.setVisible(not rows or self.open)
        self.head.setEnabled(not rows)
        for name, widgets in self._rows.items():
            for widget in widgets:
                widget.setVisible(self._lists(name))
        self.refresh()

    def refresh(self) -> None:
        """Update the numbers if they are visible."""
        numbers_now = self._taught.numbers if self._taught.active and self.open else None
        for label in self.values.values():
            label.clear()
        if numbers_now is None:
            return
        d = numbers_now.frame
        self._show_order(d)
        self._show_sign(d)
        self._show_channels(d)

    def _show_order(self, d: Decomposition) -> None:
        if not d.swing_is_one:
            for key in ("n", "n_after", "both"):
                self.values[key].setText(_UNDEFINED)
            return
        _, after = twist_times_swing_factors(d.q, d.a)
        length = float(np.linalg.norm(after[1:]))
        none = tr("n undefined: no swing")
        self.values["n"].setText(f"n  {padded_vector_text(d.n)}" if d.n_is_defined else none)
        self.values["n_after"].setText(
            f"n′ {padded_vector_text(after[1:] / length)}" if d.n_is_defined else none
        )
        alpha = degree_text(d.alpha).removeprefix("+")
        self.values["both"].setText(f"θp {degree_text(d.theta_p)}, α {alpha}")

    def _show_sign(self, d: Decomposition) -> None:
        negative = self.minus.isChecked()
        q = -d.q if negative else d.q
        for formula, on in zip(self._plus_and_minus, (not negative, negative), strict=True):
            formula.setVisible(on and self._lists("minus_q"))
        self.values["q"].setText(padded_vector_text(q))
        if not d.swing_is_one:
            self.values["theta_p"].setText(_UNDEFINED)
            return
        theta = double_cover_twist_angle(q, d.a)
        self.values["theta_p"].setText(f"{degree_text(theta)} → {degree_text(float(wrap(theta)))}")

    def _show_channels(self, d: Decomposition) -> None:
        chain, joints = self._taught.chain, self._taught.joints
        data = self._taught.document.data
        assert chain is not None
        assert data is not None
        locks, file = [], data.clip.format.upper()
        for key, joint, letter in (("parent", chain.parent, "P"), ("child", chain.child, "C")):
            before = self._rows["euler"][0 if key == "parent" else 2]
            assert isinstance(before, QLabel)
            before.setText(f"{file}: {joints[letter]}")
            found = self._channels(joint)
            if found is None:
                self.values[key].setText(tr("the file does not have three Euler angles"))
                continue
            turned = zip(found.order, found.angles, strict=True)
            self.values[key].setText("  ".join(f"{axis} {degree_text(x)}" for axis, x in turned))
            if found.locked:
                locks.append(f"{letter}: {_lock(found)}")
        self.values["lock"].setText("; ".join(locks))
        self.values["lock"].setVisible(bool(locks) and self._lists("euler"))

    def _channels(self, joint: int) -> EulerChannels | None:
        """Return a joint's Euler angles from the file.

        For an edited pose, return the Euler angles of the edited rotation that are closest to those
        in the file.
        """
        data, taught, frame = self._taught.document.data, self._taught, self._taught.document.frame
        chain, found = taught.chain, taught.numbers
        assert data is not None
        assert chain is not None
        assert found is not None
        if (channels := data.clip.euler(joint)) is None:
            return None
        order, written = channels
        q = data.motion.rotations[frame, joint]
        if taught.what_if.changes or taught.stage is not None:
            off = found.correction.whole
            one = frame_motion_with_user_changes(
                data.motion, chain, frame, taught.what_if, offset=off, stage=taught.stage
            )
            q = one.rotations[0, joint]
        return decompose_into_euler_channels(order, data.clip.as_written(joint, q), written[frame])

    def _measured(self) -> None:
        for right in self._rights:
            right.updateGeometry()
            right.update()


def _lock(found: EulerChannels) -> str:
    """Return a note about gimbal lock, if the first and last rotation axes are nearly parallel.

    If they are not, return ''.
    """
    first, middle, last = tuple(found.order)
    at = degree_text(float(wrap(found.angles[1])))
    apart = degree_text(found.between).removeprefix("+")
    return tr(
        "gimbal lock at {middle} {at}: the axes {first} and {last} are {apart} apart",
        middle=middle, at=at, first=first, last=last, apart=apart,
    )  # fmt: skip
