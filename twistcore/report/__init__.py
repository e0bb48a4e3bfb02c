"""What is told of clips once they are done: a page of one, and one of a whole folder."""
