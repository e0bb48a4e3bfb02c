"""Write reports as web pages on a clip (with a figure that plays) or on the results of a batch."""
