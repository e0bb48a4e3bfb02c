"""The teaching tab: section 3 of the paper, explained at the selected joint."""
