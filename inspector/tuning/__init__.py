"""The tuning tab: the cost of τ, suggestions for τ, and profiles."""
