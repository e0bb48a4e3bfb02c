"""The teaching tab, which explains section 3 of the paper at the selected joint."""
