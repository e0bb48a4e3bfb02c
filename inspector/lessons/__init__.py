"""The guided tour, lessons, exercises, and exercises for a class with scores."""
