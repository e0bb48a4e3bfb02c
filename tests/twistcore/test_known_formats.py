"""A format is one file: what it announces is read, listed and filtered for."""

import os
import subprocess
import sys
from importlib import import_module

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from twistcore.formats import known
from twistcore.formats.suffixes import known_formats

DOTTED = '''
"""A BVH whose numbers have commas."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(
    ".comma", read=f"{__name__}:read", place=50, without_motion=f"{__name__}:is_empty"
)


def read(path, *, fps=None, tell=None):
    from pathlib import Path

    from twistcore.formats.bvh.reader import parse_bvh

    data = Path(path).read_bytes().replace(b",", b".")
    return parse_bvh(data, Path(path).with_suffix(".bvh"), fps=fps)


def is_empty(path):
    return not path.read_bytes()
'''


@pytest.mark.parametrize("suffix", [".bvh", ".npz", ".amc", ".pkl"])
def test_the_functions_that_a_format_names_are_there(suffix):
    info = known_formats()[suffix]
    for function in [info.read, info.without_motion] if info.without_motion else [info.read]:
        module, _, name = function.partition(":")
        assert callable(getattr(import_module(module), name))


def test_names_of_clips_are_known_without_numpy():
    code = "import sys, twistcore.formats.suffixes as s; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_new_format_is_one_file(tmp_path):
    """In a process of its own, as formats are listed once."""
    folder = tmp_path / "known"
    folder.mkdir()
    (folder / "comma.py").write_text(DOTTED, "utf-8")
    clip = (ASSETS / "walk.bvh").read_bytes()
    head, motion = clip.split(b"MOTION", 1)
    (tmp_path / "walk.comma").write_bytes(head.replace(b".", b",") + b"MOTION" + motion)
    (tmp_path / "empty.comma").write_bytes(b"")
    code = f"""
import sys
from pathlib import Path
from twistcore.formats import known
known.__path__.append({str(folder)!r})
import numpy as np
import twistcore as tc
from twistcore.cli import main
from twistcore.formats.reading import CLIP_PATTERNS, companion_file_prefix, is_clip_without_motion
from twistcore.formats.clip_files import clip_paths_in_folder
here = Path({str(tmp_path)!r})
clip = tc.read_clip(here / "walk.comma")
print(clip.motion.frames, companion_file_prefix("walk.comma"), CLIP_PATTERNS)
names = [path.name for path in clip_paths_in_folder(here)]
print(names, is_clip_without_motion(here / "empty.comma"))
main(["detect", str(here / "walk.comma")])
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    lines = done.stdout.splitlines()
    frames = tc.read_clip(ASSETS / "walk.bvh").motion.frames
    assert lines[0] == f"{frames} walk.comma *.bvh *.npz *.amc *.pkl *.comma"
    assert lines[1] == "['walk.comma'] True"
    assert "intervals in 10 chains" in lines[-1]


def test_every_format_has_a_place_of_its_own():
    places = [info.place for info in known_formats().values()]
    assert np.all(np.diff(places) > 0)
    assert known.__doc__
