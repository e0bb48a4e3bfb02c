"""Files read and written safely: kinds, text, documents, locks, and who wrote them."""
