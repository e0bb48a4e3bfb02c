"""BVH in UTF-16 and UTF-32: read as its UTF-8 is, and written back in the same encoding."""

import codecs

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.twistcore import amc_files
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.cli import main
from twistcore.errors import AmcError, BvhError
from twistcore.export.exported_clips import find_exports_and_their_sources
from twistcore.files.kinds import BVH, detect_file_kind
from twistcore.files.wide_text import decode_utf16_or_utf32, utf16_or_utf32_codec
from twistcore.formats.amc import read_amc
from twistcore.formats.bvh import decimated, parse_bvh, read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains

MARKS = {
    "utf-16-le": codecs.BOM_UTF16_LE,
    "utf-16-be": codecs.BOM_UTF16_BE,
    "utf-32-le": codecs.BOM_UTF32_LE,
    "utf-32-be": codecs.BOM_UTF32_BE,
}
CODECS = pytest.mark.parametrize("codec", MARKS)
MARKED = pytest.mark.parametrize("marked", [True, False], ids=["mark", "no mark"])
# A right-to-left mark, Japanese, a letter beyond 16 bits; CRLF, as a shell's redirect writes it.
NAMES = {b"LeftArm": "左腕", b"RightArm": "Über\u200farm_R", b"Hips": "H\U0001f9cdips"}


def walk():
    """Forty frames of the walk with names that are no ASCII, as UTF-8."""
    data = (ASSETS / "walk_injected.bvh").read_bytes()
    lines = data.replace(b"Frames: 344", b"Frames: 40").split(b"\n")
    for name, other in NAMES.items():
        lines = [line.replace(b" " + name, b" " + other.encode()) for line in lines]
    start = next(k for k, line in enumerate(lines) if line.startswith(b"Frame Time"))
    return b"\r\n".join(line.rstrip(b"\r") for line in lines[: start + 41]) + b"\r\n"


def encoded(data, codec, marked):
    return (MARKS[codec] if marked else b"") + data.decode("utf-8").encode(codec)


def turned(clip):
    """A chain of it turned in some frames."""
    chains = find_chains(clip.motion)
    offset = np.zeros(clip.frames)
    offset[20:30] = 0.5
    return remove_twist(clip.motion, chains, {chains[-1].name: offset})


@CODECS
@MARKED
def test_it_means_the_same_and_only_what_is_corrected_is_other(codec, marked):
    plain, data = parse_bvh(walk()), encoded(walk(), codec, marked)
    clip = parse_bvh(data)
    assert clip.skeleton.names == plain.skeleton.names
    assert {*NAMES.values()} <= {*clip.skeleton.names}
    np.testing.assert_array_equal(clip.values, plain.values)
    assert clip.data == data
    [warning] = clip.warnings
    assert names_in_one_line(str(warning), codec[:6].upper(), "UTF-8")
    assert create_file_patch_for_motion(clip, clip.motion).data == data
    written = create_file_patch_for_motion(clip, turned(clip)).data
    assert written != data
    assert written == encoded(
        create_file_patch_for_motion(plain, turned(plain)).data, codec, marked
    )


@CODECS
@MARKED
def test_an_error_is_at_the_line_and_column_that_an_editor_shows(codec, marked):
    data = walk().replace(b"Frames: 40", b"Frames: many")
    with pytest.raises(BvhError) as plain:
        parse_bvh(data)
    with pytest.raises(BvhError) as wide:
        parse_bvh(encoded(data, codec, marked))
    assert (wide.value.line, wide.value.column) == (plain.value.line, plain.value.column)
    with refused(BvhError, "HIERARCHY"):
        parse_bvh(encoded(b"  \n\n\n", codec, marked))


@CODECS
def test_a_part_of_a_character_at_the_end_is_kept(codec):
    data = encoded(walk(), codec, True) + b"\n"
    clip = parse_bvh(data)
    assert clip.frames == 40
    assert create_file_patch_for_motion(clip, clip.motion).data == data
    assert create_file_patch_for_motion(clip, turned(clip)).data.endswith(b"\n")


@given(
    st.binary(max_size=60),
    st.sampled_from([*MARKS]),
    st.booleans(),
    st.sampled_from([b"", b"HIER"]),
)
@example(b"\x00\xd8\x41\x00", "utf-16-le", True, b"")  # half of a pair
@example(b"\x00\xd8\x00\x00", "utf-32-le", True, b"")
def test_any_bytes_come_back(rest, codec, marked, begin):
    data = (MARKS[codec] if marked else b"") + begin.decode().encode(codec) + rest
    try:
        wide = decode_utf16_or_utf32(data)
    except UnicodeDecodeError:
        assert codec.startswith("utf-32") or utf16_or_utf32_codec(data).startswith("utf-32")
        return
    if wide is not None:
        assert wide.encoded(wide.text) == data


def test_what_is_no_wide_text_is_left_alone():
    for data in (b"", b"H\x00", b"HIERARCHY\n", walk(), b"\x00\x00\x00\x18ftypmp42isom", bytes(64)):
        assert utf16_or_utf32_codec(data) is None


def test_numbers_that_are_no_characters_are_refused_in_a_sentence():
    with refused(BvhError, "UTF-32", "byte 4"):
        parse_bvh(codecs.BOM_UTF32_LE + b"\xff\xff\xff\xff" + "HIERARCHY".encode("utf-32-le"))


@CODECS
def test_a_bvh_of_another_name_is_recognised(codec):
    assert detect_file_kind(encoded(walk(), codec, True)[:512]) is BVH
    assert detect_file_kind(encoded(walk(), codec, False)[:511]) is BVH


def test_fewer_frames_of_it_are_a_clip_again():
    clip = parse_bvh(encoded(walk(), "utf-16-le", True))
    np.testing.assert_array_equal(decimated(clip, 4).values, clip.values[::4])


def test_commands_keep_the_encoding(tmp_path, capsys):
    path, out = tmp_path / "walk.bvh", tmp_path / "out.bvh"
    path.write_bytes(encoded(walk(), "utf-16-le", True))
    assert main(["refine", str(path), "-o", str(out), "--report", str(tmp_path / "r")]) == 0
    assert capsys.readouterr().err.count("UTF-16") == 1
    assert out.read_bytes().startswith(codecs.BOM_UTF16_LE)
    again = read_bvh(out)
    assert again.skeleton.names == read_bvh(path).skeleton.names
    [page] = (tmp_path / "r").glob("*.html")
    assert page.read_text("utf-8")


@CODECS
def test_an_export_is_told_from_a_clip_by_what_is_before_its_motion(codec, tmp_path):
    source, export = tmp_path / "walk.bvh", tmp_path / "walk_refined.bvh"
    source.write_bytes(encoded(walk(), codec, True))
    clip = read_bvh(source)
    export.write_bytes(create_file_patch_for_motion(clip, turned(clip)).data)
    assert find_exports_and_their_sources([source, export]) == {export: source.name}


@CODECS
def test_other_formats_name_the_encoding(codec, tmp_path):
    path = amc_files.written(tmp_path, True)
    skeleton = next(tmp_path.glob("*.asf"))
    for file in (path, skeleton):
        before = file.read_bytes()
        file.write_bytes(encoded(before, codec, True))
        with pytest.raises(AmcError, match=f"{codec[:6].upper()}.* UTF-8"):
            read_amc(path)
        file.write_bytes(before)
