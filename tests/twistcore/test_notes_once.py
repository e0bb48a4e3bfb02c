"""What is assumed of a clip is printed once a command, however many chains share it."""

import json
import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.cli import main
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.chain import chain_warnings, find_chains


@pytest.fixture(scope="module")
def shifted(tmp_path_factory):
    """A clip whose joints have position channels next to zero, so that OFFSETs are the bones."""
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion.sliced(0, 60)
    joints = len(motion.skeleton)
    positions = np.zeros((60, joints, 3))
    positions[:, 0] = motion.positions[:, 0]
    positions[:, 1:] += 1e-4 * (2.0 + np.sin(np.arange(60)))[:, None, None]
    path = tmp_path_factory.mktemp("shifted") / "shifted.bvh"
    write_motion(replace(motion, positioned=tuple(range(joints)), positions=positions), path)
    return path


def test_chains_that_share_a_joint_share_its_sentence(shifted):
    chains = find_chains(read_bvh(shifted).motion)
    every = [warning for chain in chains for warning in chain.warnings]
    assert len(every) > len({*every}) > 0
    assert chain_warnings(chains) == tuple(dict.fromkeys(every))


@pytest.mark.parametrize(
    "words",
    [
        ("info", "{clip}"),
        ("detect", "{clip}"),
        ("detect", "{clip}", "--explain"),
        ("refine", "{clip}", "-o", "{out}.bvh", "--report", "{out}-report"),
        ("signals", "{clip}", "--csv", "{out}.csv"),
    ],
    ids=" ".join,
)
@pytest.mark.usefixtures("batch_here")
def test_no_sentence_is_printed_twice(words, shifted, tmp_path, capsys):
    # A header that claims more, UTF-16 and a joint without OFFSET: each is a note of the clip.
    text = shifted.read_text("utf-8").replace("Frames: 60", "Frames: 75")
    text = re.sub(r"OFFSET [-.0-9 ]+", "", text, count=1)
    path = tmp_path / "clip.bvh"
    path.write_text(text, "utf-16")
    main([word.format(clip=path, out=tmp_path / "out") for word in words])
    printed, errors = capsys.readouterr()
    lines = [*printed.splitlines(), *errors.splitlines()]
    notes = Counter(line.rpartition("note: ")[2] for line in lines if "note: " in line)
    for part in ("UTF-16", "15 are missing", "OFFSET"):
        assert any(part in note for note in notes), part
    assert not [note for note, count in notes.items() if count > 1]


@pytest.mark.usefixtures("batch_here")
def test_documents_list_each_once(shifted, tmp_path, capsys):
    main(["info", str(shifted), "--json"])
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert len(warnings) == len({*warnings}) > 0
    out = tmp_path / "lines.jsonl"
    main(
        ["batch", str(shifted), "-o", str(tmp_path / "out"), "--jsonl", str(out), "--workers", "1"]
    )
    warnings = json.loads(out.read_text("utf-8"))["warnings"]
    assert len(warnings) == len({*warnings}) > 0
