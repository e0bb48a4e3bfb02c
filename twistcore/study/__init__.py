"""What shows how good the methods are; nobody needs it to review a clip."""
