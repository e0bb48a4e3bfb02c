"""Write reports as web pages, on a clip (with a figure that plays) or on a batch folder."""
