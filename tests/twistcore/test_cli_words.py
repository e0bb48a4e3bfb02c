"""The words of every command: examples that hold, limits, completion, and a quick start."""

import io
import os
import shlex
import shutil
import subprocess
import sys
from importlib import import_module

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from tests.twistcore.test_cli import run
from twistcore.analysis.clip_analysis import ALL_KINDS
from twistcore.analysis.correction.twist_removal import SURE_ENOUGH
from twistcore.cli.arguments.argument_types import KINDS, parse_error_kinds
from twistcore.cli.arguments.command_help import COMMANDS as HELP
from twistcore.cli.parser import PROGRAMS, SHELLS, command_parsers, make_parser
from twistcore.detection import DETECTORS
from twistcore.export import scene_script
from twistcore.synthesis import PROTOCOLS

COMMANDS = dict(command_parsers(make_parser()))
EXAMPLES = {name: HELP[name].examples for name in COMMANDS}
LINES = [line for lines in EXAMPLES.values() for line in lines]
WALK = ASSETS / "walk.bvh"
CHEAP = [  # without a shell, below two seconds
    line
    for name in ("info", "signals", "diff", "inject", "completion")
    for line in EXAMPLES[name]
    if "|" not in line and "delivery" not in line
]


def words_of(line):
    """The words of each command of a line, without what is the shell's."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="<>|")
    lexer.whitespace_split = True
    commands, ends = [[]], False
    for word in lexer:
        if word == "|":
            commands.append([])
            ends = False
        elif word in "<>":
            ends = True
        elif not ends:
            commands[-1].append(word)
    return commands


def test_every_command_says_what_it_does_and_has_examples():
    assert set(HELP) - set(COMMANDS) == {"quamo"}
    for name, parser in COMMANDS.items():
        told = parser.format_help()
        begin = " ".join(told.partition("\n\n")[2].split())
        assert begin.startswith(HELP[name].summary[1:], 1)
        assert told.endswith("".join(f"\n  {line}" for line in EXAMPLES[name]) + "\n")
        assert EXAMPLES[name]
        assert all(f"twistcore {name} " in f"{line} " for line in EXAMPLES[name])
        assert "--quiet" in told
        assert "--verbose" in told


def test_every_argument_is_explained_with_its_default():
    for name, parser in COMMANDS.items():
        told = " ".join(parser.format_help().split())
        for action in parser._actions:
            where = (name, action.dest)
            assert len((action.help or "").split()) > 1, where
            if action.option_strings and not action.required and action.nargs != 0:
                assert "default" in action.help, where
                if isinstance(action.default, str):
                    assert f"default: {action.default}" in told, where


@pytest.mark.parametrize(
    ("words", "same"),
    [
        ("", "--help"),
        ("help", "--help"),
        ("help detect", "detect --help"),
        ("quamo", "quamo --help"),
        ("help quamo refine", "quamo refine -h"),
    ],
)
def test_help_is_a_command_and_is_there_without_one(capsys, words, same):
    asked = run(capsys, *words.split())
    assert asked == run(capsys, *same.split())
    assert (asked[0], asked[2]) == (0, "")


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ("detec w.bvh", ("'detec'", "detect", "`twistcore --help`")),
        ("help detec", ("'detec'", "detect", "`twistcore --help`")),
        ("frobnicate", ("'frobnicate'", "info", "quamo", "`twistcore --help`")),
        ("quamo refne a", ("'refne'", "refine", "`twistcore quamo --help`")),
        ("detect w.bvh --explian", ("--explian", "--explain", "`twistcore detect --help`")),
        ("detect w.bvh --kindz=all", ("--kindz", "--kinds", "`twistcore detect --help`")),
        ("--json detect w.bvh", ("--json", "`twistcore --help`")),
        ("detect w.bvh --method papr", ("--method", "'papr'", "paper", "detect --help`")),
        ("refine w.bvh v.bvh -o o.bvh", ("'v.bvh'", "`twistcore refine --help`")),
        ("detect", ("CLIP", "`twistcore detect --help`")),
    ],
)
def test_a_wrong_word_is_answered_with_a_near_one_and_where_help_is(capsys, words, facts):
    code, out, err = run(capsys, *words.split())
    assert (code, out) == (2, "")
    assert names_in_one_line(err, *facts)


@pytest.mark.parametrize("line", LINES)
def test_every_example_is_understood(line, capsys):
    for first, *words in words_of(line):
        assert first == "twistcore"
        assert callable(make_parser(words).parse_args(words).run)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_parser_of_one_command_line_knows_the_command_as_the_whole_one_does(name):
    some = dict(command_parsers(make_parser([*name.split(), "a.bvh"])))
    assert some[name].format_help() == COMMANDS[name].format_help()
    other = next(word for word in COMMANDS if word.split()[0] != name.split()[0])
    assert other.split()[0] in some  # refused and listed by its name, but without arguments
    assert make_parser([*name.split()]).format_help() == make_parser().format_help()


@pytest.mark.parametrize("line", CHEAP)
def test_cheap_examples_run(line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(WALK, tmp_path / "walk.bvh")
    shutil.copy(WALK, tmp_path / "run.bvh")
    for name in ("ada", "ben") if ".twist.json" in line else ():
        run(capsys, "refine", "walk.bvh", "-o", "out.bvh", "--session", f"{name}.twist.json")
    stdin = io.TextIOWrapper(io.BytesIO(WALK.read_bytes()))
    monkeypatch.setattr(sys, "stdin", stdin)
    code, out, _ = run(capsys, *words_of(line)[0][1:])
    assert (code, bool(out) or "--csv" in line) == (0, True)


def test_what_is_named_without_loading_it_is_what_there_is():
    assert "--method {consistency,paper}" in COMMANDS["detect"].format_help()
    assert [d.info.name for d in DETECTORS.values()] == list(DETECTORS)
    assert parse_error_kinds(",".join(KINDS)) == ALL_KINDS
    assert tuple(sorted(scene_script.PROGRAMS)) == PROGRAMS
    assert f"default: {SURE_ENOUGH:g}" in COMMANDS["refine"].format_help()
    told = " ".join(COMMANDS["inject"].format_help().split())
    assert all(f"{name}: {p.text[:9].strip()}" in told for name, p in PROTOCOLS.items())


def test_what_carries_a_command_out_is_there():
    for parser in COMMANDS.values():
        cells = parser.get_default("run").__closure__
        if cells:  # of `deferred`, its free names in order of the alphabet
            module, name = (cell.cell_contents for cell in cells)
            assert callable(getattr(import_module(f"twistcore.cli.{module}"), name))


@parametrize(
    "words",
    ["--version", "--help", "", "help", "detect --help", "help refine", "quamo -h"],
    quick=2,
)
def test_help_and_version_load_no_numpy(words):
    code = f"""
import sys
from twistcore.cli import main
try:
    main({words.split()!r})
except SystemExit:
    pass
sys.exit(any(name in sys.modules for name in ("numpy", "scipy", "tqdm", "shtab")))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ("detect w.bvh --tau 200", ("auto", "180", "'200'")),
        ("detect w.bvh --tau 0", ("180", "'0'")),
        ("detect w.bvh --tau nan", ("180", "'nan'")),
        ("batch w.bvh -o out --tau 181", ("180", "'181'")),
        ("tune w.bvh -o p.toml --smallest 181", ("180", "'181'")),
        ("detect w.bvh --fps 0", ("10000", "'0'")),
        ("info w.bvh --fps 1e9", ("10000", "'1e9'")),
        ("refine w.bvh -o o.bvh --min-confidence 2", ("0 to 1", "'2'")),
        ("refine w.bvh -o o.bvh --min-confidence nan", ("0 to 1", "'nan'")),
        ("batch w.bvh -o out --min-confidence -1", ("0 to 1", "'-1'")),
        ("detect w.bvh --fail-over -1", ("0", "'-1'")),
        ("tune w.bvh -o p.toml --seeds -1", ("0", "'-1'")),
        ("tune w.bvh -o p.toml --workers -2", ("1", "'-2'")),
        ("diff a b --workers 5000", ("1,024", "'5000'")),
        ("benchmark f --seeds 1000001", ("1,000,000", "'1000001'")),
        ("benchmark f --seed x", ("18", "'x'")),
        ("quamo refine w.bvh -o o.bvh --kp inf", ("'inf'",)),
        ("quamo noise w.bvh -o o.bvh --bursts -1", ("0", "'-1'")),
        ("export s w.bvh --script maya -o k.py --fps -5", ("'-5'",)),
    ],
)
def test_a_number_beyond_its_limits_is_refused_in_one_sentence(capsys, words, facts):
    code, out, err = run(capsys, *words.split())
    assert (code, out) == (2, "")
    assert names_in_one_line(err, *facts)


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_s_completion_names_commands_and_options(capsys, shell):
    code, out, err = run(capsys, "completion", shell)
    assert (code, err) == (0, "")
    for word in ("detect", "quamo", "min-confidence", "root-position"):
        assert word in out


@pytest.mark.skipif(os.name != "posix" or not shutil.which("bash"), reason="no bash")
def test_bash_completes(capsys, tmp_path):
    script = tmp_path / "complete.bash"
    script.write_text(run(capsys, "completion", "bash")[1])
    ask = (
        f"source {script}; COMP_WORDS=(twistcore quamo no); COMP_CWORD=2; "
        "_shtab_twistcore; echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout == "noise\n"
