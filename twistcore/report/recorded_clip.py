"""Create the report on a clip of a batch folder from the clip's file and the manifest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from twistcore.analysis.clip_analysis import ALL_KINDS, ClipAnalysis, analyse
from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.report.document import Report
from twistcore.report.folder_numbers import nonempty_parameters
from twistcore.review import Review, read_session
from twistcore.review.replay import accepted_motion, session_chains
from twistcore.skeleton.own_words import add_user_joint_words
from twistcore.skeleton.rig import AS_FOUND, rig_from_json


def clip_report_from_batch_record(record: ClipRecord, folder: Path) -> Report:
    """Return the report on a processed clip of a batch folder.

    The report contains the decisions in the clip's session or, if there is none, those of the
    batch. Raises TwistError or OSError if the clip is missing or has changed.
    """
    if record.result is None:
        raise TwistError(f"{record.source} has no result to report; run `twistcore batch` again")
    if "://" in record.source:
        raise TwistError(
            f"{record.source} is at a URL; reports can show only clips on this computer"
        )
    clip = read_clip(record.source, fps=record.parameters.get("fps"))
    if clip.sha256 != record.sha256:
        raise TwistError(
            f"{record.source} was changed after the batch processed it; run `twistcore batch` again"
        )
    if session := record.decisions.get("session"):
        return _reviewed(record, clip, Path(session))
    return _unreviewed(record, clip, folder)


def _reviewed(record: ClipRecord, clip: Clip, path: Path) -> Report:
    session = read_session(path)
    chains = session_chains(session, clip)
    refined = accepted_motion(clip, chains, session.state)
    parameters = {**_parameters(record), "session": path.name}
    return Report(clip, chains, session.state, refined, record.name, parameters=parameters)


def _unreviewed(record: ClipRecord, clip: Clip, folder: Path) -> Report:
    result, parameters = record.result, record.parameters
    assert result is not None
    analysis = _analysed(clip, parameters)
    kinds = [Kind(kind) for kind in parameters.get("kinds") or ()] or ALL_KINDS
    tau = {k: v for k, v in result["tau_deg"].items() if k in _names(analysis)}
    found = analysis.detect(result["method"], kinds=kinds, tau_degrees=tau)
    chains, review = found.chains_and_limbs, Review.of(found)
    if result["applied"] is not None:
        least, also = parameters.get("min_confidence"), parameters.get("include_open", False)
        review.accept(least, include_open=bool(also))
    refined = accepted_motion(clip, chains, review.state)
    report = Report(
        clip,
        chains,
        review.state,
        refined,
        record.name,
        analysis=analysis,
        parameters=_parameters(record),
        left=result["left"],
    )
    if not record.corrected:
        return report
    return replace(report, written=folder / record.corrected)


def _analysed(clip: Clip, parameters: Mapping[str, Any]) -> ClipAnalysis:
    rig = AS_FOUND if (own := parameters.get("rig")) is None else rig_from_json(own)
    rig = add_user_joint_words(rig, clip.motion, parameters.get("joint_names"))
    chains, people = (list(parameters.get(key) or ()) or None for key in ("chains", "people"))
    return analyse(clip, chains, rig, people)


def _names(analysis: ClipAnalysis) -> set[str]:
    return {chain.name for chain in analysis.chains_and_limbs}


def _parameters(record: ClipRecord) -> dict[str, Any]:
    """Return the parameters to display, with the program version and the time of processing.

    Empty parameters and the detector are omitted.
    """
    return {
        **{k: v for k, v in nonempty_parameters(record.parameters).items() if k != "method"},
        "processed by": f"twistcore {record.version}",
        "processed at": record.finished_at,
    }
