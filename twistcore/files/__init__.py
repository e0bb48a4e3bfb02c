"""Read and write files safely: file kinds, encodings, documents, locks and checksums."""
