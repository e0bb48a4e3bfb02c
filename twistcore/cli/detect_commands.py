"""`twistcore info | detect | signals`: what is in a clip and what is wrong with it."""

from __future__ import annotations

import argparse
import csv
import io
import math
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from twistcore.analysis import ClipAnalysis, Detection, analyse
from twistcore.atomic import write_atomically
from twistcore.chain import Chain, uncorrectable_joints
from twistcore.cli.output import by_kind, print_json, refuse_overwrite, tell_no_chain
from twistcore.clip import Clip
from twistcore.detection import Interval, Kind
from twistcore.detection.cuts import border_notes, leading_frames, trailing_frames
from twistcore.encoding import encoded
from twistcore.errors import TwistError
from twistcore.formats import read_clip
