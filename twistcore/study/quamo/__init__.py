"""QuaMo measured and trained: noise, errors, tables, networks [Le26 §4]."""
