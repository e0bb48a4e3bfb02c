"""The built-in detectors. Each file is named after the detector and contains it as `DETECTOR`."""
