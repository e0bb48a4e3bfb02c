"""What leads a person through the program: the tour, lessons, the exercise."""
