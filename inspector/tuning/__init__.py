"""The tuning tab: the cost of the threshold τ, suggestions for τ, and profiles."""
