"""The teaching tab: the paper's section 3 at the selected joint."""
