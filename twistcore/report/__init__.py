"""Reports: a page for a single clip, or pages for a whole folder."""
