"""The built-in detectors: one file per detector, named after it, with the constant DETECTOR."""
