"""The built-in detectors, one in each file, which is named after it and has the constant
DETECTOR.
"""
