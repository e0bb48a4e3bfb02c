"""Write reports as web pages, for a single clip or for a whole batch folder."""
