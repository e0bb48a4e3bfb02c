"""Tables and forms around the document."""
