"""Folders of clips with errors, for tests of what is done with them."""

from inspector.session.settings import Settings
from tests.conftest import ASSETS
from twistcore.analysis.clip_severity import severity_of_intervals
from twistcore.detection import Interval
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import clip_random_generator, draw_errors, inject


def put_errors(path, chains_hit, seed=1):
    """The walk with errors in a number of chains; returns its true severity."""
    clip = read_bvh(ASSETS / "walk.bvh")
    chains = find_chains(clip.motion)
    errors = draw_errors(clip.motion, chains[:chains_hit], clip_random_generator(seed, path.name))
    dirty = inject(clip.motion, chains, errors)
    path.write_bytes(create_file_patch_for_motion(clip, dirty).data)
    by_name = {c.name: c for c in chains}
    found = [(Interval(e.chain, e.start, e.stop, e.offset), by_name[e.chain]) for e in errors]
    return severity_of_intervals(found, clip.motion.frames, clip.motion.fps)


def two_takes(qtbot, show_window, folder, **known):
    """A folder of two clips, the worse one open, both analysed."""
    for name, seed in (("a.bvh", 1), ("b.bvh", 2)):
        put_errors(folder / name, 3, seed)
    window = show_window(Settings(theme="light", turn_ms=0, **known))
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(folder)
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    return window
