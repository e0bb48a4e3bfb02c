"""General widgets, which know nothing about twist."""
