"""The words of the `twistcore` command, which are a contract."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from twistcore.analysis import ALL_KINDS
from twistcore.cli import correct_commands, detect_commands, study_commands, tune_command
from twistcore.cli.argument_types import (
    Parser,
    count,
    folder,
    kinds,
    not_negative,
    number,
    positive,
    seed,
    target,
    tau,
)
from twistcore.cli.convert_command import add_convert
from twistcore.cli.export_command import add_export
