"""Write reports as web pages: on a clip, with an animated figure, or on the results of a batch."""
