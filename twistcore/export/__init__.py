"""Export corrected clips, comparisons of clips, timeline markers and scripts for other programs."""
