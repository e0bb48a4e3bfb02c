"""Many clips: what is in each, and what comes out of a run over them."""

from twistcore.batch.clip_survey import ClipSurvey, severity, survey, survey_folder

__all__ = ["ClipSurvey", "severity", "survey", "survey_folder"]
