"""Output of the program: corrected clips, comparisons, markers and scripts."""
