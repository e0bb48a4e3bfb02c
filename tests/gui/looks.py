"""What a person's screen looks like: the desktop's theme, the program's own, a compositor or none.

A test by hand that asks for `look` runs in one of them, and in all if the environment asks for it.
The desktop that wants it dark is Plasma, whose settings Qt reads by itself; the other is none.
"""

import os
from dataclasses import dataclass
from pathlib import Path

EVERY = os.environ.get("TWIST_INSPECTOR_LOOKS", "") == "all"
_BREEZE_DARK = """[General]
ColorScheme=BreezeDark

[Colors:Window]
BackgroundNormal=42,46,50
ForegroundNormal=252,252,252

[Colors:View]
BackgroundNormal=27,30,32
ForegroundNormal=252,252,252

[Colors:Button]
BackgroundNormal=49,54,59
ForegroundNormal=252,252,252
"""


@dataclass(frozen=True)
class Look:
    """desktop: 'light' or 'dark'; theme: the program's option, by which 'system' is the desktop."""

    desktop: str = "light"
    theme: str = "system"
    compositor: bool = False

    def __str__(self):
        theme = f"system-{self.desktop}" if self.theme == "system" else f"option-{self.theme}"
        return f"{theme}-{'composited' if self.compositor else 'plain'}"

    @property
    def dark(self):
        """Whether the program is to be."""
        return (self.desktop if self.theme == "system" else self.theme) == "dark"

    def settings(self):
        """What a person has set who wants the program to look so; {}: nothing."""
        return {} if self.theme == "system" else {"theme": self.theme}

    def desktop_env(self, folder):
        """Of programs on such a desktop; its settings are in the folder."""
        if self.desktop == "light":
            return {}
        config = Path(folder) / "desktop"
        config.mkdir(exist_ok=True)
        (config / "kdeglobals").write_text(_BREEZE_DARK)
        return {
            "XDG_CURRENT_DESKTOP": "KDE",
            "KDE_FULL_SESSION": "true",
            "KDE_SESSION_VERSION": "5",
            "XDG_CONFIG_HOME": str(config),
        }


# The program's option is set against the desktop: only there is it seen to be followed.
_THEMES = (("light", "system"), ("dark", "system"), ("dark", "light"), ("light", "dark"))
LOOKS = tuple(Look(*theme, compositor) for compositor in (False, True) for theme in _THEMES)


def looks_of(module, test):
    """Those that a test by hand runs in: all, or one by its place.

    The modules begin with a look each and their tests go on from it, so that all are met. Where
    one program does for a module, `test` is "": all its tests are in the module's first look.
    """
    if EVERY:
        return LOOKS
    path = Path(module.__file__)
    first = sorted(path.parent.glob("test_*_by_hand.py")).index(path)
    tests = [name for name in vars(module) if name.startswith("test_")]
    return (LOOKS[(first + (tests.index(test) if test else 0)) % len(LOOKS)],)
