"""Detectors and what one would otherwise try, side by side on clips with known errors."""

from twistcore.benchmark.clips import ClipResult, Settings, run_clip
from twistcore.benchmark.runner import Summary, find_clips, run_benchmark
from twistcore.benchmark.tables import benchmark_to_json, make_rows, rows_to_csv

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
