"""The tuning tab: the cost of τ, suggestions and profiles."""
