"""One detector a file; the folder is the list."""
