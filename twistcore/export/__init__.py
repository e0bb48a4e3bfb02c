"""What the program exports: corrected clips, comparisons, markers and scripts."""
