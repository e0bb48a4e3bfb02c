"""Exceptions cross from a worker process to the window or the command: every one is pickled."""

import importlib
import pickle
import pkgutil
from pathlib import Path

import pytest

import inspector
import twistcore

# An example of each: the arguments, and those by name.
EXAMPLES = {
    "twistcore.errors.TwistError": (("one sentence",), {}),
    "twistcore.errors.ClipError": (("a.bvh", "expected OFFSET"), {"line": 3}),
    "twistcore.errors.BvhError": (("a.bvh", "expected OFFSET"), {"line": 3, "column": 7}),
    "twistcore.errors.NpzError": (("a.npz: expected an .npz of numpy",), {}),
    "twistcore.errors.AmcError": (("a.asf", "expected :root"), {"line": 1}),
    "twistcore.errors.ClipMismatchError": (("other joints",), {}),
    "twistcore.errors.FormatError": (("a.json: expected JSON",), {}),
    "twistcore.formats.bvh.numbers.BadNumberError": ((17, b"1.0.0"), {}),
    "twistcore.formats.npz.pickled_arrays.LimitError": (("the pickle is too deep",), {}),
    "twistcore.skeleton.joint_vocabulary._WordsError": (("expected a list", "mine", "hand"), {}),
    "twistcore.formats.smpl.pose_files.PosesError": (("a.npz: expected poses",), {}),
    "twistcore.quamo.stability.UnstableGainsError": (("κP is too large",), {}),
    "inspector.session.opening.ClipMissingError": ((Path("a.twist.json"), "a.bvh"), {}),
    "twistcore.work.progress.Cancelled": ((), {}),
    "twistcore.cli.command_line._EndedError": ((15,), {}),
    "twistcore.work.processes.ProcessEndedError": (("its process ended",), {}),
    "twistcore.work.processes.ProcessTimeError": ((60.0,), {}),
    "inspector.video.video_reader.VideoError": (("a.mp4: no video",), {}),
}
EXTRAS = {"torch", "av"}  # a module that needs an extra may not be importable


def exceptions():
    """Every exception class of both packages, by its full name."""
    for package in (twistcore, inspector):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            try:
                importlib.import_module(module.name)
            except ImportError as error:
                if (error.name or "").partition(".")[0] not in EXTRAS:
                    raise
    found, todo = {}, [BaseException]
    while todo:
        for kind in todo.pop().__subclasses__():
            todo.append(kind)
            if kind.__module__.partition(".")[0] in ("twistcore", "inspector"):
                found[f"{kind.__module__}.{kind.__qualname__}"] = kind
    return found


@pytest.mark.thorough
def test_every_exception_comes_out_of_a_process_as_it_went_in():
    found = exceptions()
    assert found.keys() == EXAMPLES.keys(), "a new exception needs an example here"
    for name, kind in found.items():
        words, named = EXAMPLES[name]
        error = kind(*words, **named)
        error.add_note("said later")
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            back = pickle.loads(pickle.dumps(error, protocol))
            assert type(back) is kind
            assert (str(back), back.args, vars(back)) == (str(error), error.args, vars(error))


def test_a_damaged_bvh_is_told_by_file_line_and_column():
    error = twistcore.errors.BvhError("a.bvh", "expected OFFSET", line=3, column=7)
    back = pickle.loads(pickle.dumps(error))
    assert str(back) == "a.bvh, line 3, column 7: expected OFFSET"
    assert (back.path, back.expected, back.line, back.column) == (
        "a.bvh",
        "expected OFFSET",
        3,
        7,
    )
    with pytest.raises(twistcore.errors.TwistError):
        raise back
