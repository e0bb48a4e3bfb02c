"""The teaching tab: section 3 of the paper at the selected joint."""
