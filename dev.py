#!/usr/bin/env python3
"""Set up, run, test and check Twist Inspector from a checkout, on a bare machine too.

    python3 dev.py setup            make .venv, install everything that is missing
    python3 dev.py run [ARGS]       open the program; without a screen, a demonstration into out/
    python3 dev.py test             the quick tests; --all: the thorough ones, too
    python3 dev.py test ARGS        pytest, e.g. dev.py test -k chain
    python3 dev.py check            lint, format, types, import contracts
    python3 dev.py bench [NAME]     every benchmark, or the one named
    python3 dev.py shot             take the pictures of docs/ from the real window
    python3 dev.py docs [--links]   docs/ as a site in build/site; or whether links out of it work
    python3 dev.py lock [--upgrade]  the lock files after a change of pyproject.toml; or all renewed

Every command sets up first; when nothing is to do that takes a moment. ARGS go to the program
started. Only the standard library is used here, since nothing else is installed yet.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

# Nothing but the standard library there, either.
from checkout import places
from checkout.all_tests import ALL, EXAMPLES, QUICK, run_all
from checkout.environment import OLDEST_PYTHON, ensure_axe, ensure_venv, write_locks
from checkout.screens import screen
from checkout.starting import SetupError, say, start, without_driver_noise
from checkout.system_packages import ensure_system
from inspector.system_libraries import has_screen
from twistcore.files.encoding import legible
from twistcore.formats.suffixes import clip_suffix


def default_clip() -> Path:
    """The sample with injected errors: the one whose truth lies beside it."""
    clips = sorted((places.ROOT / "assets").glob("*.truth.json"))
    names = [clip.with_name(clip.name.removesuffix(".truth.json") + ".bvh") for clip in clips]
    preferred = places.ROOT / "assets/walk_injected.bvh"
    for clip in [preferred, *names]:
        if clip.exists():
            return clip
    raise SetupError("No sample clip in assets/; name a BVH file: python3 dev.py run CLIP")


def command_run(args: list[str]) -> int:
    """Open the program; where nobody can see it, let it show itself and leave the results."""
    if has_screen() or {"--demo", "--screenshot", "--help", "-h", "--version"} & set(args):
        words = args or [str(default_clip())]
        with screen() as env:
            return start([str(places.PYTHON), "-m", "inspector", *words], env, Path.cwd())
    began = time.time() - 1  # some file systems keep whole seconds
    with screen() as env:
        status = show_clip(args, env) if args else demonstrate(env)
    if status == 0:
        tell_results(began)
    return status


def demonstrate(env: dict[str, str]) -> int:
    """A review of the sample that nobody makes: everything is accepted."""
    clip = default_clip()
    say(
        f"No screen here: a demonstration with {clip.name} on a virtual one. It accepts whatever "
        "is found, though nobody has seen it."
    )
    return start_unseen([str(clip), "--demo", str(places.OUT)], env)


def show_clip(args: list[str], env: dict[str, str]) -> int:
    """A picture of somebody's own clip and what is found in it; nobody is there to decide."""
    say("No screen here: a picture is taken on a virtual one, and nothing is decided.")
    status = start_unseen([*args, "--screenshot", str(places.OUT / "inspector.png")], env)
    if status == 0 and clip_suffix(args[0]):
        say(f"Found in {legible(args[0])}:")
        status = start([str(places.PYTHON), "-m", "twistcore", "detect", args[0]], env, Path.cwd())
        # 1: there is no chain, which it has said; the picture is there all the same.
        status = 0 if status == 1 else status
        say("Nothing was decided or corrected, and the file is as it was.")
    return status


def start_unseen(words: list[str], env: dict[str, str]) -> int:
    """The program on a virtual screen."""
    with without_driver_noise() as errors:
        command = [str(places.PYTHON), "-m", "inspector", *words]
        return start(command, env, Path.cwd(), errors=errors)


def tell_results(began: float) -> None:
    """Say in plain words what was left in out/, in its folders too."""
    kinds = {
        ".png": "picture of the window",
        ".bvh": "corrected motion: only what was accepted has changed",
        ".html": "report, to be opened in a browser",
        ".csv": "report as a table",
        ".json": "report or session, for programs",
        ".py": "marks of the intervals, for a program of animation",
        ".srt": "subtitles",
        ".webm": "film",
        ".mp4": "film",
    }
    say(f"Left in {places.OUT}:")
    files = [f for f in sorted(places.OUT.rglob("*")) if f.is_file() and f.stat().st_mtime >= began]
    names = [legible(file.relative_to(places.OUT).as_posix()) for file in files]
    width = max(map(len, names), default=0)
    for file, name in zip(files, names, strict=True):
        say(f"  {name:<{width}}  {kinds.get(file.suffix.lower(), '')}".rstrip())
    say("With a screen, the same command opens the window.")


def command_test(args: list[str]) -> int:
    """Run the quick tests, all tests with --all, or the tests that pytest arguments select.

    Thorough tests are run where a file or a mark is named, or with --all.
    """
    words = [word for word in args if word != "--all"]
    everything = words != args
    if not words:
        status = run_all(everything=everything)
        warn_of_missing_translations()
        return status
    named = any(w.startswith("-m") or Path(w.split("::")[0]).exists() for w in words)
    if not everything and not named:
        say("Of the quick tests; of all with --all.")
        words = [*QUICK.words, *words]
    with screen() as env:
        examples = (ALL if everything else QUICK).examples
        return start([str(places.PYTHON), "-m", "pytest", *words], {EXAMPLES: examples, **env})


def warn_of_missing_translations() -> int:
    """List texts that wait for a translation; the exit status, 0 unless CI is set."""
    status = start([str(places.PYTHON), "-m", "tests.gui.untranslated"], dict(os.environ))
    return status if os.environ.get("CI") else 0


def command_check(args: list[str]) -> int:
    """Run every check, also after one failed, so that one run shows all that is wrong."""
    if args:
        raise SetupError(f"check takes no arguments, but got: {legible(' '.join(args))}")
    python = str(places.PYTHON)
    # Not the script lint-imports: its first line names a path that goes stale in a moved checkout.
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
    """Run every benchmark, or the one named, with the remaining arguments."""
    names = sorted(file.stem for file in (places.ROOT / "benchmarks").glob("[!_]*.py"))
    if args and not args[0].startswith("-"):
        if args[0] not in names:
            raise SetupError(f"No benchmark {args[0]!a}; there are: {', '.join(names) or 'none'}.")
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
    """Build the site, where every warning is an error; with --links ask for what it links to."""
    if args not in ([], ["--links"]):
        raise SetupError(f"docs takes --links or nothing, but got: {legible(' '.join(args))}")
    way, where = ("linkcheck", "build/links") if args else ("html", "build/site")
    # Warnings of a page are said when it is read: all are.
    words = ["-m", "sphinx", "-q", "-E", "-W", "--keep-going", "-n", "-b", way, "docs", where]
    status = start([str(places.PYTHON), *words], dict(os.environ))
    if status == 0:
        say("Every link out of docs/ works." if args else f"{places.ROOT / where / 'index.html'}")
    return status


def command_lock(args: list[str]) -> int:
    """Write the lock files anew; what they name stays as it is where it still fits."""
    if args not in ([], ["--upgrade"]):
        raise SetupError(f"lock takes --upgrade or nothing, but got: {' '.join(args)}")
    return write_locks(args)


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
    """Set up what is missing, then do what was asked. Exit 2 where a person has to act."""
    if sys.version_info < OLDEST_PYTHON:
        say("Twist Inspector needs Python 3.11 or newer; this is Python " + sys.version.split()[0])
        return 2
    name = argv[0] if argv else "--help"
    if name in {"-h", "--help", "help"}:
        say(__doc__.strip())
        return 0
    if name != "setup" and name not in COMMANDS:
        say(f"No command {name!a}. There are: setup, {', '.join(COMMANDS)}.")
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the screen is put away
    try:
        ensure_system(windows=name not in {"check", "docs", "lock"}, tests=name == "test")
        ensure_venv()
        if name == "test":
            ensure_axe()
            # Tests start hundreds of programs, and pytest rewrites every module of tests: once.
            os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        if name == "setup":
            say(f"Ready. {places.PYTHON.parent} has everything; try: python3 dev.py run")
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
