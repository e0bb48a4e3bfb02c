"""Read and write clips. Each file format has a subpackage."""
