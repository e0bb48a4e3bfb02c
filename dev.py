#!/usr/bin/env python3
"""Set up, run, test and check Twist Inspector from a checkout, even on a bare machine.

    python3 dev.py setup            create .venv and install everything that is missing;
                                    --unlocked: the newest versions, where the locked are missing
    python3 dev.py run [ARGS]       open the program; without a screen, a demonstration into out/
    python3 dev.py test             run the quick tests; --all: the thorough ones, too
    python3 dev.py test ARGS        run pytest, e.g. dev.py test -k chain
    python3 dev.py check            check lint, format, types and import contracts
    python3 dev.py bench [NAME]     run every benchmark, or only one
    python3 dev.py shot             take the pictures of docs/ from the real window
    python3 dev.py docs [--links]   build docs/ as a site in build/site; --links: check its links
    python3 dev.py lock [--upgrade] update the lock files after a change of pyproject.toml; or all

Every command sets up first, which takes a moment if nothing is missing. ARGS are passed to the
program. Only the standard library is used here, since nothing else is installed yet.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time
from pathlib import Path

# These modules also use only the standard library.
from checkout import places
from checkout.all_tests import ALL, EXAMPLES, QUICK, run_all
from checkout.environment import OLDEST_PYTHON, UNLOCKED, ensure_axe, ensure_venv, write_locks
from checkout.screens import screen
from checkout.starting import SetupError, say, start, without_driver_noise
from checkout.system_packages import ensure_system
from inspector.system_libraries import has_screen
from twistcore.files.encoding import escape_control_characters
from twistcore.formats.suffixes import clip_suffix


def default_clip() -> Path:
    """Return the path of the sample clip, which has injected errors and known ground truth."""
    clips = sorted((places.ROOT / "assets").glob("*.truth.json"))
    names = [clip.with_name(clip.name.removesuffix(".truth.json") + ".bvh") for clip in clips]
    preferred = places.ROOT / "assets/walk_injected.bvh"
    for clip in [preferred, *names]:
        if clip.exists():
            return clip
    raise SetupError("There is no sample clip in assets/. Name a BVH file: python3 dev.py run CLIP")


def copy_in_out(clip: Path) -> Path:
    """Return a copy of a clip in out/, so that the program writes nothing into assets/."""
    copy = places.OUT / clip.name
    if not copy.exists():
        copy.parent.mkdir(exist_ok=True)
        shutil.copyfile(clip, copy)
    return copy


def command_run(args: list[str]) -> int:
    """Open the program. Without a screen, run a demonstration and list its results."""
    if has_screen() or {"--demo", "--screenshot", "--help", "-h", "--version"} & set(args):
        words = args or [str(copy_in_out(default_clip()))]
        with screen() as env:
            return start([str(places.PYTHON), "-m", "inspector", *words], env, Path.cwd())
    began = time.time() - 1  # some file systems store whole seconds
    with screen() as env:
        status = show_clip(args, env) if args else demonstrate(env)
    if status == 0:
        list_results(began)
    return status


def demonstrate(env: dict[str, str]) -> int:
    """Run a demonstration that accepts all intervals of the sample clip."""
    clip = default_clip()
    say(
        f"There is no screen, so a demonstration with {clip.name} runs on a virtual one. It "
        "accepts everything that is found, though nobody has seen it."
    )
    return start_unseen([str(clip), "--demo", str(places.OUT)], env)


def show_clip(args: list[str], env: dict[str, str]) -> int:
    """Take a picture of a clip and list its errors, without any decisions."""
    say("There is no screen, so a picture is taken on a virtual one. Nothing is decided.")
    status = start_unseen([*args, "--screenshot", str(places.OUT / "inspector.png")], env)
    if status == 0 and clip_suffix(args[0]):
        say(f"Found in {escape_control_characters(args[0])}:")
        status = start([str(places.PYTHON), "-m", "twistcore", "detect", args[0]], env, Path.cwd())
        # 1: no chain was found, which `detect` has reported; the picture is fine.
        status = 0 if status == 1 else status
        say("Nothing was decided or corrected, and the file is unchanged.")
    return status


def start_unseen(words: list[str], env: dict[str, str]) -> int:
    """Run the program on a virtual screen."""
    with without_driver_noise() as errors:
        command = [str(places.PYTHON), "-m", "inspector", *words]
        return start(command, env, Path.cwd(), errors=errors)


def list_results(began: float) -> None:
    """List the new files in out/ with their kinds. `began` is the time since which they are new."""
    kinds = {
        ".png": "picture of the window",
        ".bvh": "corrected motion: only accepted intervals have changed",
        ".html": "report, for a browser",
        ".csv": "report as a table",
        ".replay.json": "session: repeats the export, and opens in the window",
        ".json": "report, for programs",
        ".py": "markers of the intervals, for an animation program",
        ".srt": "subtitles",
        ".webm": "film",
        ".mp4": "film",
    }
    say(f"Results in {places.OUT}:")
    files = [f for f in sorted(places.OUT.rglob("*")) if f.is_file() and f.stat().st_mtime >= began]
    names = [escape_control_characters(file.relative_to(places.OUT).as_posix()) for file in files]
    width = max(map(len, names), default=0)
    for file, name in zip(files, names, strict=True):
        kind = next((kinds[k] for k in kinds if file.name.lower().endswith(k)), "")
        say(f"  {name:<{width}}  {kind}".rstrip())
    say("With a screen, the same command opens the window.")


def command_test(args: list[str]) -> int:
    """Run the quick tests, all tests with --all, or the tests selected by pytest's arguments.

    Thorough tests run with --all, or if a file or a mark is named.
    """
    words = [word for word in args if word != "--all"]
    everything = words != args
    if not words:
        status = run_all(everything=everything)
        warn_of_missing_translations()
        return status
    named = any(w.startswith("-m") or Path(w.split("::")[0]).exists() for w in words)
    if not everything and not named:
        say("Selecting from the quick tests; --all selects from all tests.")
        words = [*QUICK.words, *words]
    with screen() as env:
        examples = (ALL if everything else QUICK).examples
        return start([str(places.PYTHON), "-m", "pytest", *words], {EXAMPLES: examples, **env})


def warn_of_missing_translations() -> int:
    """List texts without a translation. Return the exit status, which is 0 unless CI is set."""
    status = start([str(places.PYTHON), "-m", "tests.gui.untranslated"], dict(os.environ))
    return status if os.environ.get("CI") else 0


def command_check(args: list[str]) -> int:
    """Run every check, even if one fails, so that one run shows all problems."""
    if args:
        raise SetupError(
            f"check takes no arguments, but got: {escape_control_characters(' '.join(args))}"
        )
    python = str(places.PYTHON)
    # Not the script lint-imports, whose first line has a path that breaks if the checkout moves.
    lint_imports = "from importlinter.cli import lint_imports_command as lint; lint()"
    checks = {
        "ruff check": [python, "-m", "ruff", "check"],
        "ruff format": [python, "-m", "ruff", "format", "--check"],
        "mypy": [python, "-m", "mypy"],
        "import contracts": [python, "-c", lint_imports],
    }
    failed = []
    for name, command in checks.items():
        say(f"--- {name}")
        if start(command, dict(os.environ)):
            failed.append(name)
    say("--- translations")
    if warn_of_missing_translations():
        failed.append("translations")
    say(f"Failed: {', '.join(failed)}." if failed else "All checks passed.")
    return 1 if failed else 0


def command_bench(args: list[str]) -> int:
    """Run all benchmarks or the named one, and pass the remaining arguments on."""
    names = sorted(file.stem for file in (places.ROOT / "benchmarks").glob("[!_]*.py"))
    if args and not args[0].startswith("-"):
        if args[0] not in names:
            raise SetupError(
                f"There is no benchmark {args[0]!a}. Choose from: {', '.join(names) or 'none'}."
            )
        names, args = args[:1], args[1:]
    status = 0
    with screen() as env:
        for name in names:
            say(f"--- {name}")
            status |= start([str(places.PYTHON), "-m", f"benchmarks.{name}", *args], env)
    return status


def command_shot(args: list[str]) -> int:
    """Take the pictures of the documentation from the real window."""
    with screen() as env:
        return start([str(places.PYTHON), "-m", "inspector.shots", *args], env)


def command_docs(args: list[str]) -> int:
    """Build the site, with warnings as errors. With --links, check its external links instead."""
    if args not in ([], ["--links"]):
        raise SetupError(
            f"docs takes --links or nothing, but got: {escape_control_characters(' '.join(args))}"
        )
    way, where = ("linkcheck", "build/links") if args else ("html", "build/site")
    # -E reads all pages, since a page's warnings appear only when it is read.
    words = ["-m", "sphinx", "-q", "-E", "-W", "--keep-going", "-n", "-b", way, "docs", where]
    status = start([str(places.PYTHON), *words], dict(os.environ))
    if status == 0:
        say("All external links work." if args else f"{places.ROOT / where / 'index.html'}")
    return status


def command_lock(args: list[str]) -> int:
    """Update the lock files. Versions that still fit are kept."""
    if args not in ([], ["--upgrade"]):
        raise SetupError(f"lock takes --upgrade or nothing, but got: {' '.join(args)}")
    return write_locks(args)


def unlocked_wanted(args: list[str]) -> bool:
    """True if setup may install versions that are not in the lock file."""
    if args not in ([], [UNLOCKED]):
        raise SetupError(
            f"setup takes {UNLOCKED} or nothing, but got: "
            f"{escape_control_characters(' '.join(args))}"
        )
    return bool(args)


COMMANDS = {
    "run": command_run,
    "test": command_test,
    "check": command_check,
    "bench": command_bench,
    "shot": command_shot,
    "docs": command_docs,
    "lock": command_lock,
}


def main(argv: list[str]) -> int:
    """Set up what is missing, then run the command.

    Return the exit status, which is 2 if the user must do something first.
    """
    if sys.version_info < OLDEST_PYTHON:
        say("Twist Inspector needs Python 3.11 or newer; this is Python " + sys.version.split()[0])
        return 2
    name = argv[0] if argv else "--help"
    if name in {"-h", "--help", "help"}:
        say(__doc__.strip())
        return 0
    if name != "setup" and name not in COMMANDS:
        say(f"There is no command {name!a}. Choose from: setup, {', '.join(COMMANDS)}.")
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the virtual screen is closed
    try:
        ensure_system(windows=name not in {"check", "docs", "lock"}, tests=name == "test")
        ensure_venv(unlocked=name == "setup" and unlocked_wanted(argv[1:]))
        if name == "test":
            ensure_axe()
            # Tests start hundreds of programs, so let Python cache compiled modules.
            os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        if name == "setup":
            say(
                f"Ready. Everything is installed in {places.PYTHON.parent}; try: python3 dev.py run"
            )
            return 0
        return COMMANDS[name](argv[1:])
    except SetupError as error:
        say(str(error))
    except KeyboardInterrupt:
        say("Interrupted.")
        return 130
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
