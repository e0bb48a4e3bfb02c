"""Detectors and what one would otherwise try, side by side on clips with known errors."""

from twistcore.study.benchmark.benchmark_tables import benchmark_to_json, make_rows, rows_to_csv
from twistcore.study.benchmark.clip_run import ClipResult, Settings, run_clip
from twistcore.study.benchmark.runner import Summary, find_clips, run_benchmark

__all__ = [
    "ClipResult",
    "Settings",
    "Summary",
    "benchmark_to_json",
    "find_clips",
    "make_rows",
    "rows_to_csv",
    "run_benchmark",
    "run_clip",
]
