"""Export corrected clips, comparisons, markers and scripts."""
