"""Write reports as web pages, for a clip (with a figure that plays) or for a batch folder."""
