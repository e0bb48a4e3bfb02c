"""Detectors and what one would otherwise try, side by side on clips with known errors."""
