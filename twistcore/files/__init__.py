"""Read and write files safely: encodings, documents, locks, checksums and remote files."""
