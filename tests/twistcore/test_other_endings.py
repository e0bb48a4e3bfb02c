"""A name of a scene's format is refused before anything is read, by every command that writes."""

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from twistcore.cli import main
from twistcore.cli.arguments.argument_types import parse_clip_output_path
from twistcore.cli.parser import command_parsers, make_parser
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.formats.suffixes import CLIP_SUFFIXES, unsupported_format_name

SCENES = ("out.fbx", "out.GLB", "out.usda", "out.blend", "out.c3d", "out.asf")


def writers():
    """Words of every command whose output is one clip, with an input that is not there."""
    return {
        "refine": ["refine", "none.bvh"],
        "apply": ["apply", "none.twist.json", "none.bvh"],
        "inject": ["inject", "none.bvh", "--truth", "truth.json"],
        "quamo refine": ["quamo", "refine", "none.bvh"],
        "quamo noise": ["quamo", "noise", "none.bvh"],
        "convert": ["convert", "none.fbx"],
        "clean": ["clean", "none.bvh", "--unroll"],
    }


def test_no_command_is_forgotten():
    writing = {
        name
        for name, leaf in command_parsers(make_parser())
        for action in leaf._actions
        if action.type is parse_clip_output_path
    }
    assert writing == {*writers()} - {"convert"}  # which writes BVH alone


@pytest.mark.parametrize("output", SCENES)
@pytest.mark.parametrize("command", writers())
def test_it_is_refused_before_the_clip_is_looked_for(command, output, tmp_path, capsys):
    words = [*writers()[command], "-o", str(tmp_path / output)]
    try:
        code = main(words)
    except SystemExit as stop:
        code = stop.code
    assert code == 2
    errors = capsys.readouterr().err
    assert names_in_one_line(errors, " .bvh")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("output", SCENES)
def test_the_library_refuses_it_too(output, tmp_path):
    clip = read_bvh(ASSETS / "walk.bvh")
    with pytest.raises(TwistError, match=r" \.bvh"):
        write_clip(clip, clip.motion, tmp_path / output)
    assert not list(tmp_path.iterdir())


def test_other_names_are_as_they_were(tmp_path):
    clip = read_bvh(ASSETS / "walk.bvh")
    for name in ("out", "out.bvh", "out.BVH", "out.txt", "fbx", "out.fbx.bvh"):
        write_clip(clip, clip.motion, tmp_path / name)
        assert (tmp_path / name).read_bytes() == clip.data
    assert not any(unsupported_format_name(f"a{suffix}") for suffix in CLIP_SUFFIXES)
