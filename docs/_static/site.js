// A page that is read from a disk may not fetch others: excerpts of what a search finds are left out.
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
