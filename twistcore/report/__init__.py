"""Reports: a page for a clip, and pages for a whole folder."""
