"""Safe reading and writing of files: file kinds, encodings, documents, locks and checksums."""
