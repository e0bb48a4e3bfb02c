"""Reports: a page for one clip, and a page for a whole folder."""
