"""The tuning tab, with the cost of τ, suggestions and profiles."""
