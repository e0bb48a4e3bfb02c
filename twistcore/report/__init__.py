"""Write reports as web pages, either on a single clip or on the results of a batch."""
