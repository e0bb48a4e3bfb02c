"""Quality measures of a motion that need no ground truth. A high value is not in itself an
error.
"""
