"""What lay over the window is gone when it closes, also where nothing remembers what it covered."""

import signal

import pytest

from tests.gui.real_screen import differing, needs_real_screen, program, real_screen, wait_until

LARGE = 5_000  # pixels: more than a pointer or a button that is lit


@needs_real_screen
def test_nothing_stays_of_menu_palette_and_dialog(tmp_path):
    with real_screen(tmp_path) as screen, program(screen.env, tmp_path) as process:
        window = screen.shown("^Twist Inspector$")
        screen.use("mousemove", 1900, 1070)
        before = screen.steady_picture()
        assert differing(before, before[0, 0]) > LARGE, "the window is not to be seen"
        for opening in (
            ("mousemove", "--window", window, 15, 9, "click", 1),
            ("key", "alt+v"),
            ("key", "ctrl+k"),
            ("key", "ctrl+o"),
        ):
            screen.use(*opening)
            wait_until(lambda: differing(screen.picture(), before) > LARGE)
            screen.steady_picture()
            screen.use("mousemove", 1900, 1070, "key", "Escape")
            try:
                wait_until(
                    lambda: not differing(screen.picture(), before),
                    seconds=5.0,
                    meanwhile=lambda: screen.use("key", "Escape"),
                )
            except AssertionError:
                left = differing(screen.picture(), before)
                pytest.fail(f"{left} pixels are left after {opening}")
        process.send_signal(signal.SIGTERM)
        process.wait(10)
